"""The motion of bodies that leave: nominal, and in worst cases."""

from collections.abc import Sequence
from typing import NamedTuple

from drakesep.reports.pictures import Picture, motion_pictures
from drakesep.reports.studies import Studies, Study


class Motion(NamedTuple):
    """Of one study."""

    study: Study
    pictures: Sequence[Picture]


def of(studies: Studies) -> list[Motion]:
    """Return what a report shows of motion over time; nothing if no run is kept."""
    flown = studies.of("verify", "worst-case", "simulate")
    each = [Motion(study, [*motion_pictures(study)]) for study in flown]
    return [one for one in each if one.pictures]
