"""What the model does not cover: of every case, and of this one."""

from typing import NamedTuple

from drakesep.reports.studies import Studies
from drakesep.systems.model.separation import Separation


class NotCovered(NamedTuple):
    """What decides what is left out."""

    separation: Separation
    has_parts: bool
    dispersed: bool
    failures: bool


def of(studies: Studies) -> NotCovered:
    """Return what a case and its studies leave out."""
    separation = studies.case.separation
    return NotCovered(
        separation,
        any(body.parts for body in separation.bodies),
        bool(studies.case.tolerance_set.box.dispersions),
        bool(studies.rows("failure_cases.csv")),
    )
