"""Which objectives may be chosen, and how one is named on any metric and window."""

from collections.abc import Mapping

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.metrics.quantities import QUANTITIES
from drakesep.case_file.objectives import case_objectives, choose_objectives
from drakesep.systems.checks import InputError


WINDOWS: Mapping[str, str] = {
    "": "the whole run",
    "since_release": "since release",
    "after_separation": "after separation",
    "until_separation": "until separation",
    "at_release": "at release",
    "at_separation": "at separation",
    "at_end": "at the end",
    "from": "from ... to ... s",
}
EXTREMES: Mapping[str, str] = {
    "": "usual",
    "max": "largest",
    "min": "smallest",
    "magnitude_min": "smallest magnitude",
    "value": "value",
}
AXES = ("", "x", "y", "z", "roll", "pitch", "yaw")
SENSES = ("highest", "lowest")


def own_objectives(case: AnalysisCase) -> list[str]:
    """Return the names of a case's own: what leads out of its requirements."""
    return [*case_objectives(case)]


def quantities() -> dict[str, str]:
    """Return what a metric may be of, by name, in words."""
    return {name: name.replace("_", " ") for name in sorted(QUANTITIES)}


def objective_name(
    case: AnalysisCase,
    *,
    sense: str,
    quantity: str,
    extreme: str,
    window: str,
    start: float | None,
    end: float | None,
    axis: str,
) -> str:
    """Return the name of an objective on a metric.

    Args:
        case: that must have it.
        sense: ``highest`` or ``lowest``.
        quantity: one of `quantities`.
        extreme: one of `EXTREMES`.
        window: one of `WINDOWS`.
        start: of a window by times, s.
        end: of a window by times, s.
        axis: one of `AXES`.

    Raises:
        ValueError: there is no such metric.
    """
    when = window
    if window == "from":
        if start is None or end is None or not 0.0 <= start < end:
            raise InputError(
                f"from ... to: must be two rising times, got {start} and {end}"
            )
        when = f"from_{start:.10g}_to_{end:.10g}_s"
    parts = (sense, quantity, extreme, when, axis)
    name = "_".join(filter(None, parts))
    choose_objectives(case, [name])
    return name
