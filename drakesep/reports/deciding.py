"""What decides a requirement: the value that its margin is of, and why it decides."""

import math
from typing import NamedTuple

from drakesep.analysis.metrics.requirements import Verdict
from drakesep.reports.cells import EMPTY, Cell, Row


WORST_FOUND, WORST_DRAW, BOUND, SINGLE_RUN = (
    *("the worst found", "the worst draw", "the statistical bound", "a single run"),
)
_NOT_MET = Verdict.NOT_MET.value


class Deciding(NamedTuple):
    """The value that decides a requirement."""

    by: str = ""
    """Which of the values beside each other it is; empty: there is none."""
    value: Cell = EMPTY
    margin: Cell = EMPTY
    """Of the value."""
    why: str = ""
    """What else makes the requirement not met, if the margin alone does not."""


def deciding_of(
    searched: Row | None, drawn: Row | None, flown: Row | None, share: Cell
) -> Deciding:
    """Return what decides a requirement.

    Of a share of launches the bound that a campaign tells; of every run the worst that
    was found, or the worst draw, if that alone is beyond the limit.

    Args:
        searched: of requirements.csv, if there is one.
        drawn: of campaign.csv, likewise.
        flown: of requirements_of_run.csv, likewise.
        share: of launches that is required; empty: every run must.
    """
    if drawn and share and drawn["share"].value == share.value and _tells(drawn):
        return _by_bound(drawn)
    found_beyond = searched is not None and _is_beyond(searched, "margin")
    if drawn and disproves(drawn, share) and not found_beyond:
        return _by_draw(drawn)
    if searched and searched["worst"]:
        worst = searched["worst"].told_from(searched["limit"])
        return Deciding(WORST_FOUND, worst, searched["margin"])
    if drawn and drawn["worst"]:
        return _by_draw(drawn)
    if flown:
        return Deciding(SINGLE_RUN, flown["value"], flown["margin"])
    return Deciding()


def disproves(drawn: Row, share: Cell) -> bool:
    """Return whether draws show that a share of launches is not kept.

    That fewer are within than the campaign was asked for says nothing of a smaller
    share.

    Args:
        drawn: of campaign.csv.
        share: that is required; empty: every run must.
    """
    asked = drawn.get("share", 1.0)
    is_broken = drawn.get("verdict") == _NOT_MET
    return bool(is_broken and asked <= (share.value if share else 1.0))


def _is_beyond(row: Row, column: str) -> bool:
    """Return whether a margin tells that a limit is not kept."""
    margin = float(row.get(column, math.inf))
    return margin < 0.0 or (margin == 0.0 and row.get("sense") in ("<", ">"))


def _tells(drawn: Row) -> bool:
    return bool(drawn["bound"]) or drawn.get("verdict") == _NOT_MET


def _by_bound(drawn: Row) -> Deciding:
    why = ""
    if drawn.get("verdict") == _NOT_MET and not _is_beyond(drawn, "margin"):
        why = "more draws are beyond than may be"
        if drawn.get("sides") == "two":
            why += ", of both limits together"
        if drawn.get("failed", 0):
            why += ", those that failed among them"
    bound = drawn["bound"].told_from(drawn["limit"])
    return Deciding(BOUND, bound, drawn["margin"], why)


def _by_draw(drawn: Row) -> Deciding:
    why = ""
    if drawn.get("verdict") == _NOT_MET and not _is_beyond(drawn, "worst_margin"):
        why = "draws failed, which count as beyond the limit"
    worst = drawn["worst"].told_from(drawn["limit"])
    return Deciding(WORST_DRAW, worst, drawn["worst_margin"], why)
