"""What is known of a case before it flies: what `verify` refuses or cannot tell."""

from collections.abc import Sequence

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.metrics.of_run import metric_named
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.case_file.case import Case
from drakesep.results.asked import Asked
from drakesep.results.catalogue.names import VERIFY
from drakesep.studies.verification import planned
from drakesep.studies.worst_case.searches import DRAKE
from drakesep.studies.worst_case.session import checked_batch
from drakesep.systems.checks import InputError
from drakesep.units import unit_of, with_unit


def refusal(case: Case | AnalysisCase, searches: Sequence[str] | None = None) -> str:
    """Return why `verify` refuses a case; empty if it does not.

    Nothing is flown: it does what `verify` does until it flies.

    Args:
        case: with requirements.
        searches: as `verify` takes them.
    """
    try:
        checked_batch(planned(Asked.of(VERIFY, case), searches=searches))
    except InputError as error:
        return str(error)
    return ""


def check_verifiable(case: Case) -> list[str]:
    """Return what should be known of a case, in sentences, before it is verified.

    A case that is not to be verified has no requirements, and nothing is wrong with it.

    Raises:
        ValueError: `verify` refuses it, whatever its options; with the same message.
    """
    if not case.limits:
        return ["There is no requirement: `verify` refuses it until there is one."]
    why = refusal(case)
    if why and refusal(case, [DRAKE]):
        raise InputError(why)
    notes = [f"`verify` flies it with --search drake alone. {why}"] if why else []
    if case.recontact is not None:
        notes.append(
            "Parts push each other where they touch (recontact), which Drake alone "
            "knows: it flies all, run by run, and searches by SQP from the nominal."
        )
    record = case.in_si()
    return notes + _never_judged(record) + _of_shares(record) + _left_out(case)


def _of_shares(case: AnalysisCase) -> list[str]:
    """Return that a campaign alone tells of some requirements, if so."""
    count = sum(one.statistical for one in case.requirements)
    if not count:
        return []
    return [
        f"{count} of {len(case.requirements)} requirements are of a share of launches: "
        "`verify` tells how bad they get, and whether they are met with --campaign."
    ]


def _never_judged(case: AnalysisCase) -> list[str]:
    """Return of which requirements no run tells, and why."""
    return [
        f"Of {with_unit(r.metric)} {r.sense} {unit_of(r.metric).from_si(r.limit):g} "
        f"there is no verdict: {_why_not(case, r)}."
        for r in case.requirements
        if not r.measured_apart and not case.tells(r)
    ]


def _why_not(case: AnalysisCase, requirement: Requirement) -> str:
    duration, metric = case.separation.duration, metric_named(requirement.judged_by)
    if not metric.reached(duration):
        return f"it looks beyond the end of the run, {duration:g} s"
    if not metric.comes_about(case.separation):
        held = [a.name for a in case.separation.attachments if not a.lets_go]
        return f"{', '.join(held)} never lets go"
    return "joints ring for more periods than samples of a run follow"


def _left_out(case: Case) -> list[str]:
    """Return what is not looked at, because the case does not ask for it."""
    notes = []
    if not case.dispersions:
        notes.append(
            "There are no dispersions: `verify` holds the nominal run alone against "
            "the requirements."
        )
    if case.has_clearance and not any(r.measured_apart for r in case.limits):
        notes.append(
            "There is geometry, and no requirement of clearance_mm: whether anything "
            "touches is not looked at."
        )
    return notes
