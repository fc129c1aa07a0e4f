"""Where the panels of a figure of the motion stand, with titles that are never cut."""

import math
from collections.abc import Sequence
from typing import Any, Literal, TypeAlias

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, ScalarFormatter

from drakesep.plots.style import columns_of_legend, wrapped


_COLUMNS = 3
# In inches.
_WIDTH = 16.5
_LEFT, _GAP, _RIGHT = 0.8, 0.58, 0.2
"""Beside the two panels of a signal, and between them."""
_TOP, _FOOT = 0.2, 0.3
"""Above all, and below all."""
_TITLE, _TEXT, _POWER = 0.26, 0.16, 0.14
"""Above a panel: of a line of its title, of a text, and of the power of its ticks."""
_PANEL, _TICKS = 1.7, 0.34
"""Of a panel, and below it."""
_ENTRY = 0.22
"""Of a line of the legend."""
_PUSH = 0.42
"""Share that the push has."""
_LETTERS, _OF_TITLE, _OF_TEXT, _OF_LEGEND = 13, 11, 8, 10
"""Sizes of the figure's title, of a signal's, of what stands below that, and of the
legend, points."""
Entry: TypeAlias = tuple[str, Sequence[Line2D]]
"""Of a legend: a label, and lines that stand beside each other."""


def draw_legend(
    figure: Figure,
    labels: Sequence[str],
    lines: Sequence[Sequence[Line2D]],
    *,
    loc: Literal["lower center", "outside lower center"],
    size: float,
    columns: int,
) -> None:
    """Draw the legend of a figure, an entry's lines beside each other.

    Args:
        figure: that has the lines.
        labels: of the entries.
        lines: of each entry.
        loc: where it stands, as matplotlib has it.
        size: of its letters, points.
        columns: into how many it is set.
    """
    handles: list[Any] = [tuple(several) for several in lines]
    figure.legend(
        handles,
        labels,
        handler_map={tuple: HandlerTuple(ndivide=None)},
        handlelength=2.5,
        loc=loc,
        fontsize=size,
        ncols=columns,
        frameon=False,
    )


class Layout:
    """A figure of signals in rows of three, each in two panels: the push, and all.

    Attributes:
        figure: with its title and legend.
    """

    def __init__(
        self,
        title: str,
        texts: Sequence[Sequence[str]],
        legend: Sequence[Entry],
    ):
        """Make the figure.

        Args:
            title: of the figure.
            texts: that stand above each signal.
            legend: its entries.
        """
        title = wrapped(title, _WIDTH - 2.0 * _RIGHT, _LETTERS)
        _, width = self._across(0)
        self._texts = [
            [wrapped(text, width, _OF_TEXT) for text in each] for each in texts
        ]
        lines = [sum(map(_lines, each)) for each in self._texts]
        self._heads = [
            _TITLE + _TEXT * max(lines[k : k + _COLUMNS]) + _POWER
            for k in range(0, len(lines), _COLUMNS)
        ]
        most = _WIDTH - 2.0
        labels = [wrapped(label, most - 1.0, _OF_LEGEND) for label, _ in legend]
        columns = columns_of_legend(labels, most, _OF_LEGEND)
        entries = math.ceil(len(legend) / columns) * max(map(_lines, labels))
        self._foot = _FOOT + _ENTRY * entries
        rows = sum(self._heads) + len(self._heads) * (_PANEL + _TICKS)
        self._height = _TOP + _TITLE * _lines(title) + rows + self._foot
        self.figure = Figure(figsize=(_WIDTH, self._height))
        self.figure.suptitle(
            title, y=1.0 - 0.5 * _TOP / self._height, fontsize=_LETTERS
        )
        lines_of = [entry_lines for _, entry_lines in legend]
        draw_legend(
            self.figure,
            labels,
            lines_of,
            loc="lower center",
            size=_OF_LEGEND,
            columns=columns,
        )

    def panels(self, k: int, title: str, unit: str) -> tuple[Axes, Axes]:
        """Return the panels of a signal: of the push, and of the whole run.

        Args:
            k: number of the signal.
            title: of it.
            unit: of its values.
        """
        left, width = self._across(k)
        push = _PUSH * (width - _GAP)
        whole = self._axes(k, left + push + _GAP, width - push - _GAP)
        first = self._axes(k, left, push)
        for axes, label, most in ((first, "push", 3), (whole, "whole run", 6)):
            axes.set_label(f"{title}: {label}")
            axes.grid(alpha=0.3)
            axes.xaxis.set_major_locator(MaxNLocator(most))
            axes.tick_params(labelsize=8)
            if k + _COLUMNS >= len(self._texts):  # nothing is below
                axes.set_xlabel(f"time (s), {label}", fontsize=9)
            axes.yaxis.set_major_formatter(_PowersApart())
            axes.yaxis.get_offset_text().set_fontsize(7)
        first.set_ylabel(unit, fontsize=9)
        self._write(k, self._top(k) + _TITLE, title, fontsize=_OF_TITLE)
        return first, whole

    def write(self, k: int, colours: Sequence[str]) -> None:
        """Write what stands above a signal, each text in its colour."""
        top = self._top(k)
        for text, colour in zip(self._texts[k], colours, strict=True):
            self._write(k, top, text, color=colour, fontsize=_OF_TEXT)
            top -= _TEXT * _lines(text)

    def _top(self, k: int) -> float:
        """Return where the texts above a signal begin, below its title."""
        texts = _TEXT * sum(map(_lines, self._texts[k]))
        return self._bottom(k) + _PANEL + _POWER + texts

    def _write(self, k: int, top: float, text: str, **style: Any) -> None:
        """Write a text across the panels of a signal."""
        left, width = self._across(k)
        self.figure.text(
            (left + 0.5 * width) / _WIDTH,
            top / self._height,
            text,
            ha="center",
            va="top",
            **style,
        )

    def _across(self, k: int) -> tuple[float, float]:
        """Return where the panels of a signal begin, and how wide they are."""
        cell = _WIDTH / _COLUMNS
        return cell * (k % _COLUMNS) + _LEFT, cell - _LEFT - _RIGHT

    def _bottom(self, k: int) -> float:
        rows_below = len(self._heads) - 1 - k // _COLUMNS
        heads = sum(self._heads[k // _COLUMNS + 1 :])
        return self._foot + _TICKS + heads + rows_below * (_PANEL + _TICKS)

    def _axes(self, k: int, left: float, width: float) -> Axes:
        place = (left / _WIDTH, self._bottom(k) / self._height)
        size = (width / _WIDTH, _PANEL / self._height)
        return self.figure.add_axes((*place, *size))


def _lines(text: str) -> int:
    return text.count("\n") + 1


class _PowersApart(ScalarFormatter):
    """Writes numbers short: powers of ten of many digits stand above."""

    def __init__(self) -> None:
        # Not as mathematics: to read that takes half of the time of a drawing.
        super().__init__(useOffset=False, useMathText=False)
        self.set_powerlimits((-2, 3))

    def get_offset(self) -> str:
        power = super().get_offset().removeprefix("1e")
        return (
            f"\N{MULTIPLICATION SIGN}10{power.translate(_SUPERSCRIPTS)}"
            if power
            else ""
        )


_SUPERSCRIPTS = str.maketrans("0123456789-\N{MINUS SIGN}", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁻")
