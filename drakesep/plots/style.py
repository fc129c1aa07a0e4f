"""How plots look, and how they are saved."""

import textwrap
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from drakesep.files import written


if TYPE_CHECKING:  # half a second to import, where something is drawn
    from matplotlib.figure import Figure


# Okabe and Ito's colours, told apart by the colour-blind; dashes tell apart curves
# that coincide. Published runs stay in the background.
COLOURS = ("#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00")
DASHES = ((0, ()), (0, (6, 2)), (0, (2, 2)), (0, (6, 2, 1, 2)), (0, (1, 1)))
_HANDLE = 0.65
"""What a line of a legend takes, with its gaps, in."""


def save_plot(figure: "Figure", file: Path, *, dpi: float = 130) -> None:
    """Write a figure into a file, whole or not at all."""
    with written(file) as beside:
        figure.savefig(beside, dpi=dpi)


def wrapped(text: str, width: float, size: float) -> str:
    """Return a text in lines that are not cut, however long its words.

    Args:
        text: to be written.
        width: that it may take, in.
        size: of its letters, points.
    """
    text = text.replace("$", r"\$")  # not as mathematics
    characters = len(text)
    while _widest(lines := textwrap.wrap(text, characters), size) > width:
        characters -= max(characters // 20, 1)
    return "\n".join(lines)


def columns_of_legend(labels: Sequence[str], width: float, size: float = 10.0) -> int:
    """Return in how many columns labels stand beside each other, none of them cut.

    Args:
        labels: of the legend.
        width: that it may take, in.
        size: of its letters, points.
    """
    lines = [line for label in labels for line in label.split("\n")]
    return min(len(labels), 6, max(1, int(width / (_widest(lines, size) + _HANDLE))))


def _widest(lines: Iterable[str], size: float) -> float:
    """Return the width of the widest line, in."""
    # Half a second, where something is drawn.
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    font = FontProperties(size=size)
    widths = (
        text_to_path.get_text_width_height_descent(line, font, ismath=False)[0]
        for line in lines
    )
    return max(widths, default=0.0) / 72.0
