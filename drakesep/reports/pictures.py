"""Pictures of a report: vector graphics that stand in the page itself."""

import base64
import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

import pandas as pd

from drakesep.reports.studies import Study
from drakesep.systems.model.separation import Separation
from drakesep.tables.roles import Changed, Nominal


if TYPE_CHECKING:  # half a second to import, where something is drawn
    from matplotlib.figure import Figure

T = TypeVar("T")
ACROSS, CELL = 2, 3.5
"""Panels beside each other, and the width of each, in: so that letters are legible on
paper."""
HEIGHT = 9.3
"""That a picture may have on paper, in."""
_TITLE = 0.6
"""Of that for titles, in."""
_PANELS = 6
"""Of tornados in a picture: more take more than a page."""


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture with its words."""

    source: str
    """The picture itself, as the address of an image."""
    alternative: str
    """What it shows, for those who do not see it."""
    caption: str


def picture_of(figure: "Figure", alternative: str, caption: str) -> Picture:
    """Return a figure as a vector graphic, the same to the last byte each time."""
    import matplotlib

    drawn = io.BytesIO()
    same: Any = {"svg.hashsalt": "drakesep", "svg.fonttype": "none"}
    with matplotlib.rc_context(same):
        figure.savefig(drawn, format="svg", metadata={"Date": None, "Creator": None})
    text = base64.b64encode(drawn.getvalue()).decode("ascii")
    return Picture(f"data:image/svg+xml;base64,{text}", alternative, caption)


def panels_in_height(row: float, title: float = _TITLE) -> int:
    """Return how many panels a picture of a page has: a row of them at least.

    Args:
        row: height of a row of them, in.
        title: what titles take, in.
    """
    return ACROSS * max(1, int((HEIGHT - title) / row))


def parts(whole: Sequence[T], most: int) -> Iterator[Sequence[T]]:
    """Yield what one picture after another shows of a whole."""
    for k in range(0, len(whole), most):
        yield whole[k : k + most]


def table_of_study(study: Study, file: str, *words: str) -> pd.DataFrame:
    """Return a table of a study, with no word where none is in some columns.

    Args:
        study: that has it.
        file: its name.
        words: the columns.
    """
    table = study.results.table(file)
    return table.astype(dict.fromkeys(words, object)).fillna(dict.fromkeys(words, ""))


def stack_picture(separation: Separation) -> Picture:
    """Return the mated stack."""
    from drakesep.plots.stack import stack_figure

    names = ", ".join(body.name for body in separation.bodies)
    return picture_of(
        stack_figure(separation),
        f"Two views of the mated stack along y and z: the parts of {names}, the "
        "attachments between them, and the centres of mass.",
        f"The mated stack in the frame of {separation.A}, seen along y and along z.",
    )


def motion_pictures(study: Study) -> Iterator[Picture]:
    """Yield the motion of each body that leaves; none of a study that keeps no run."""
    from drakesep.plots.motion_overview import overview_figure
    from drakesep.plots.shown_runs import ShownRuns

    results = study.results
    kept = [k for k, r in results.roles.items() if isinstance(r, Nominal | Changed)]
    if not any(results.run(label).run.motion is not None for label in kept):
        return
    shown = ShownRuns.of(results.runs, results.case)
    for pair in shown.run.separation.pairs:
        decided = [d.run.label for d in shown.decided if d.run is not shown.reference]
        yield picture_of(
            overview_figure(shown, pair, ACROSS * CELL),
            f"Over time, rates, angles and relative velocity of {pair.B}, and what is "
            f"required of it: in the run {shown.reference.label}, in worst cases, and "
            "in those that decide, with limits while they hold. These are "
            f"{', '.join(dict.fromkeys(decided)) or 'none'}.",
            f"Motion of {pair.B}: dashed red the limit while it holds, with a dot "
            "where a run decides.",
        )


def proof_pictures(study: Study) -> Iterator[Picture]:
    """Yield proven bounds beside the worst found and the limits."""
    from drakesep.plots.proofs import proofs_figure

    words = ("requirement", "axis", "pair", "id", "objective", "unit", "reason")
    table = table_of_study(study, "proofs.csv", *words)
    yield picture_of(
        proofs_figure(table, width=ACROSS * CELL),
        "A row for each requirement and objective: the worst found, the proven bound "
        "and the limit, as shares of the limit, as in the table of proven bounds.",
        "Proven bounds (bars) beside the worst found (dots) and limits (dashed).",
    )


def failure_pictures(study: Study) -> Iterator[Picture]:
    """Yield what is required in failure cases beside the design, a page at a time."""
    from drakesep.plots import failure_cases as plots

    table = table_of_study(study, "failure_requirements.csv", "axis", "pair", "id")
    most = panels_in_height(plots.row_height(table), title=plots.TITLE)
    for some in parts(plots.panels_of(table), most):
        yield picture_of(
            plots.failure_figure(pd.concat(some), most_across=ACROSS, cell=CELL),
            "A panel for each requirement, with a row for the design and each failure "
            "case: nominal, worst and limit, as in the table of failure cases.",
            "Failure cases against each limit.",
        )


def tornado_pictures(study: Study, objectives: Sequence[str]) -> Iterator[Picture]:
    """Yield what each tolerance does to some objectives, a page at a time."""
    from drakesep.plots.tornado import tornado_figure

    table = table_of_study(study, "sensitivities.csv", "at_worst")
    there = [name for name in objectives if (table["objective"] == name).any()]
    for mine in parts(there, _PANELS):
        some = table[table["objective"].isin(mine)]
        yield picture_of(
            tornado_figure(some, most_across=ACROSS, cell=CELL),
            "Bars of what a whole side of each tolerance changes, at the nominal and "
            f"at the worst case, for {', '.join(mine)}.",
            "What each tolerance does, to first order: wide bars at the worst case, "
            "narrow ones at the nominal.",
        )


def clearance_picture(study: Study) -> Picture:
    """Return how near the nearest parts are over the distance of separation."""
    from drakesep.plots.clearance_plots import distances_figure

    summary = study.results.table("clearance_summary.csv")
    return picture_of(
        distances_figure(study.results.table("clearance.csv"), summary),
        "Distances of the nearest pairs of parts over the distance of separation; a "
        "dot where each is smallest, a cross at contact.",
        "Distances of the pairs that come nearest; dots: smallest, crosses: contact.",
    )
