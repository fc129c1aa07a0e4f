"""The worst cases against the requirements, and the room that tolerances leave."""

import contextlib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Unpack

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.bounds.proving import ProofSettings
from drakesep.analysis.metrics.functions import FunctionRequirement
from drakesep.analysis.search.effort import Effort, SearchSettings
from drakesep.case_file.case import Case
from drakesep.case_file.objectives import (
    Wanted,
    case_objectives,
    choose_objectives,
    clearances_of,
    listed,
)
from drakesep.plots.pictures import OfFailures
from drakesep.results.asked import Asked
from drakesep.results.catalogue.names import VERIFY
from drakesep.results.folder import Output, results_folder
from drakesep.studies.background_process import BackgroundProcess
from drakesep.studies.campaign.settings import CampaignSettings
from drakesep.studies.campaign_beside import CampaignBeside
from drakesep.studies.failure_cases import failure_cases_verified
from drakesep.studies.proof_beside import planned_with_proofs, with_proofs
from drakesep.studies.prove import proof_settings
from drakesep.studies.tolerance_growth import find_growths
from drakesep.studies.verified import Verification
from drakesep.studies.worst_case.plan import OnProgress, StudyPlan
from drakesep.studies.worst_case.procedure import carried_out, ended
from drakesep.studies.worst_case.searches import WantedSearches
from drakesep.studies.worst_case.session import session
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError, named
from drakesep.tables.run_tables import is_column_of_runs


@typed
def verify(
    case: Case | AnalysisCase | str | Path,
    *,
    requirements: Sequence[FunctionRequirement] = (),
    objectives: Wanted = (),
    searches: Sequence[str] | None = None,
    growth: bool | None = None,
    output: Output | None = None,
    workers: int | None = None,
    on_progress: OnProgress | None = None,
    background: BackgroundProcess | None = None,
    minutes: float | None = None,
    resume: bool = False,
    failures: bool = False,
    campaign: int | None = None,
    share: float | None = None,
    confidence: float | None = None,
    prove: bool = False,
    proof_seconds: float | None = None,
    **effort: Unpack[Effort],
) -> Verification:
    """Find the worst cases of a case and hold them against its requirements.

    What leads out of each requirement is searched, and the paper's objectives if the
    case says so.

    Args:
        case: a case, in SI or as a file holds it, a case file, or the name of a
            built-in case.
        requirements: on functions of a run, beside the case's.
        objectives: that are searched beside these, as `worst_case` takes them.
        searches: as `worst_case` takes them.
        growth: whether to find how far tolerances may grow; None: unless Drake flies
            alone, or a study with it takes longer than it may.
        output: folder that receives tables and plots, tables as the study goes on.
        workers: number of processes that fly Drake; one per core if None; with 1, the
            caller's does all.
        on_progress: called as the study goes on.
        background: a process that is under way, to measure and draw in; one of its own
            if None.
        minutes: as `worst_case` takes them.
        resume: as `worst_case` takes it.
        failures: whether to verify the case's failure cases, too: each over the
            tolerances of all that has not failed.
        campaign: how many launches are drawn beside the worst cases; they decide what
            is required of a share of launches, and the worst cases the rest. None:
            there is none.
        share: as `campaign` takes it; with a campaign, and only with it.
        confidence: as `campaign` takes it.
        prove: whether to prove, beside the worst found, what nothing within the
            tolerances is beyond; what no bound covers is named.
        proof_seconds: as `prove` takes it; with `prove`, and only with it.
        effort: `starts`, `samples`, `vertices`, `flips`, `generations`, `corners` and
            `seed` of `SearchSettings`; the speed of runs, as it is measured, decides
            what is left out: see `Verification.effort`.

    Raises:
        ValueError: the case is wrong or nothing is required, a search is wrong, a
            function gives no finite number, it takes longer than it may, the folder
            cannot be written, or has another study to resume.
        RuntimeError: the nominal run fails.
    """
    settings = SearchSettings(**effort)
    wanted = _campaign(campaign, settings.seed, share, confidence)
    settled = _proofs(prove, proof_seconds)
    asked = Asked.of(
        VERIFY,
        case,
        {
            "requirements": requirements,
            "objectives": objectives,
            "searches": searches,
            "growth": growth,
            "minutes": minutes,
            "failures": failures or None,
            "campaign": campaign,
            "share": share,
            "confidence": confidence,
            "prove": prove or None,
            "proof_seconds": proof_seconds,
            **effort,
        },
        seed=settings.seed,
    )
    if wanted is not None:
        asked = replace(asked, case=wanted.of_shares(asked.case))
    plan = planned(asked, objectives, searches, requirements, failures=failures)
    if settled is not None:
        plan = planned_with_proofs(plan, settled, requirements)
    beside = None if wanted is None else CampaignBeside.of(wanted, asked)
    plan = plan if beside is None else beside.planned(plan)
    with contextlib.ExitStack() as stack:
        folder = stack.enter_context(results_folder(output, VERIFY))
        plan = replace(
            plan,
            effort=effort,
            growth=growth,
            minutes=minutes,
            workers=workers,
            resume=resume,
            folder=folder,
        )
        study = Verification(
            asked=asked,
            objectives=plan.objectives,
            functions=tuple(requirements),
            clearances=plan.clearances,
        )
        if background is None:
            own = BackgroundProcess(workers if plan.on_batch_engine else 1)
            background = stack.enter_context(own)
        with session(plan, background, on_progress) as under_way:
            study = carried_out(study, under_way)
            if study.effort is not None and study.effort.growth:
                growths, single_growths = find_growths(
                    study.worst, under_way, study.functions
                )
                study = replace(study, growths=growths, single_growths=single_growths)
            under_way.write_down(study)
            study = with_proofs(study, under_way)
            if study.proofs is not None:
                under_way.write_down(study, Verification.write_proofs)
                under_way.draw(study.proofs.picture.save)
            if beside is not None:
                study = beside.flown(study, under_way)
                under_way.write_down(study, Verification.write_campaign)
                assert study.campaign is not None
                under_way.draw(study.campaign.picture.save)
            study = failure_cases_verified(study, under_way)
            if study.failed_cases:
                under_way.draw(OfFailures(study.failure_requirements).save)
        return ended(study, folder)


def _campaign(
    runs: int | None, seed: int, share: float | None, confidence: float | None
) -> CampaignSettings | None:
    """Return the settings of the campaign beside worst cases; None: there is none."""
    if runs is not None:
        return CampaignSettings(
            runs=runs, seed=seed, share=share, confidence=confidence
        )
    for name, value in (("share", share), ("confidence", confidence)):
        if value is not None:
            raise InputError(f"{name}: must stand with a campaign, got none")
    return None


def _proofs(wanted: bool, seconds: float | None) -> ProofSettings | None:
    """Return how hard bounds are proven beside worst cases; None: there are none."""
    if wanted:
        return proof_settings(proof_seconds=seconds)
    if seconds is not None:
        raise InputError("proof_seconds: must stand with prove, got none")
    return None


def planned(
    asked: Asked,
    objectives: Wanted = (),
    searches: Sequence[str] | None = None,
    requirements: Sequence[FunctionRequirement] = (),
    *,
    failures: bool = False,
) -> StudyPlan:
    """Return what is asked of a study that verifies a case.

    Args:
        asked: the study.
        objectives: as `verify` takes them.
        searches: as `verify` takes them.
        requirements: on functions of a run, as `verify` takes them.
        failures: whether failure cases are verified, too.

    Raises:
        ValueError: nothing is required, there is no failure case to verify, or an
            objective, a search or a function is wrong.
    """
    case = asked.case
    _check_functions(requirements)
    if not case.requirements and not requirements:
        raise InputError("requirements: a case to verify must have some, got none")
    if failures and not case.failure_cases:
        raise InputError(
            "failure_cases: a case whose failure cases are verified must have some, "
            "got none; 'failure_cases: standard' are the usual"
        )
    failed = {}  # what cannot be is told before anything is flown
    for failure in case.failure_cases if failures else ():
        with named(f"failure_cases: {failure.name}"):
            failed[failure] = case.in_failure(failure)
    of_functions = [o for function in requirements for o in function.objectives]
    also = [*listed(objectives), *of_functions]
    # Nothing leads out of requirements of which no run tells.
    leads = bool(also or case_objectives(case))
    chosen = choose_objectives(case, None, also) if leads else ()
    return StudyPlan(
        asked=asked,
        # Without dispersions, or objectives, there are the nominal and published runs.
        objectives=chosen if case.tolerances else (),
        searches=WantedSearches.named(searches, case.separation),
        failures=failed,
        clearances=clearances_of(chosen),
    )


def _check_functions(requirements: Sequence[FunctionRequirement]) -> None:
    """Raise InputError unless each has a name and a column of its own."""
    for required in requirements:
        if is_column_of_runs(required.column):
            raise InputError(
                f"requirements: {required.name!r} would be the column "
                f"{required.column!r} of tables, which is another's: give it another "
                "name"
            )
    names = [required.name for required in requirements]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"requirements: {name!r} must stand once")
