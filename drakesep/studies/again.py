"""A study done again, as its folder says that it was asked."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from drakesep.results.catalogue.names import (
    CAMPAIGN,
    CLEARANCE,
    PROVE,
    RARE_EVENTS,
    SENSITIVITY,
    SIMULATE,
    SWEEP,
    VERIFY,
    WORST_CASE,
)
from drakesep.results.reading import Results
from drakesep.results.study_record import Ended
from drakesep.studies.campaign.procedure import campaign
from drakesep.studies.clearance import clearance
from drakesep.studies.prove import prove
from drakesep.studies.rare_events import rare_events
from drakesep.studies.sensitivity import sensitivity
from drakesep.studies.simulate import simulate
from drakesep.studies.sweep import sweep
from drakesep.studies.verification import verify
from drakesep.studies.worst_case.procedure import worst_case
from drakesep.systems.checks import InputError


_STUDIES: dict[str, Callable[..., Any]] = {
    SIMULATE: simulate,
    SWEEP: sweep,
    CLEARANCE: clearance,
    WORST_CASE: worst_case,
    VERIFY: verify,
    CAMPAIGN: campaign,
    SENSITIVITY: sensitivity,
    RARE_EVENTS: rare_events,
    PROVE: prove,
}


def check_can_be_done_again(results: Results) -> None:
    """Raise InputError if a study did not come to its end, or was asked with functions.

    Args:
        results: of the study.
    """
    record = results.record
    if record.ended is not Ended.COMPLETED:
        raise InputError(
            f"{results.folder}: must be of a study that came to its end, to be done "
            f"again; got one that is {record.ended.value}"
        )
    if record.again is None:
        raise InputError(
            f"{results.folder}: must be of a study that was asked with names and "
            "numbers, to be done again; got functions or objects"
        )


def do_again(results: Results, output: Path) -> None:
    """Do a study again, with the same case, arguments, plan and seed.

    Args:
        results: of the study.
        output: folder that receives those of the new one.

    Raises:
        ValueError: the study did not come to its end, or was asked with functions.
        RuntimeError: a run fails.
    """
    check_can_be_done_again(results)
    record = results.record
    seed = {} if record.seed is None else {"seed": record.seed}
    asked = {**record.arguments, **record.plan, **seed}
    _STUDIES[record.study](results.case, **asked, output=output)
