"""The study of a campaign: plan, fly, merge, confirm in Drake, write down."""

import contextlib
import math
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.campaigns.flights import CampaignFlights, FlownDraws
from drakesep.analysis.campaigns.plan import CHUNK, CampaignPlan
from drakesep.analysis.campaigns.shares import (
    of_launches,
    share_findings,
    size_of,
)
from drakesep.analysis.engines.drake_pool import WORKERS_START, DrakePool
from drakesep.case_file.case import Case
from drakesep.results.asked import Asked
from drakesep.results.campaign_files import (
    RecordedPlan,
    merged,
    missing_chunks,
    read_chunk,
    write_chunk,
)
from drakesep.results.catalogue import CAMPAIGN
from drakesep.results.folder import Output, ResultsFolder, results_folder
from drakesep.results.parts import parts_folder
from drakesep.studies.campaign.confirmation import (
    MOST,
    chosen,
    confirmed_draws,
    most_confirmed,
)
from drakesep.studies.campaign.executors import flown_by, flown_here
from drakesep.studies.campaign.measuring import with_measured
from drakesep.studies.campaign.progress import OnProgress, Telling
from drakesep.studies.campaign.result import Campaign, check_size, with_confirmed
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError
from drakesep.systems.simulation.shared_simulation import shared_simulation


RUNS = 100_000
"""Draws, if nothing is said: a design that is good hardly fails by chance."""


@typed
def campaign(
    case: Case | AnalysisCase | str | Path,
    runs: int = RUNS,
    *,
    seed: int = 0,
    share: float | None = None,
    confidence: float | None = None,
    metrics: Sequence[str] = (),
    chunk: int = CHUNK,
    executor: Executor | None = None,
    output: Output | None = None,
    resume: bool = False,
    workers: int | None = None,
    on_progress: OnProgress | None = None,
) -> Campaign:
    """Fly many independent draws, and tell what share meets the requirements.

    Args:
        case: a case, in SI or as a file holds it, a case file, or the name of a
            built-in case.
        runs: draws; their number is fixed beforehand, or their confidence is void.
        seed: of the draws.
        share: of launches that must meet each requirement that says nothing of that;
            None: every run must, which a campaign may disprove and never shows.
        confidence: at which that is to be shown.
        metrics: names of metrics that are kept beside those of the requirements.
        chunk: draws that are flown, written and lost together.
        executor: of `concurrent.futures`, whose workers fly; None: this process does,
            on all its cores.
        output: folder that receives tables and plots, and chunks as they are flown.
        resume: whether to go on from the chunks that the same campaign has left there.
        workers: number of processes that fly Drake; one per core if None.
        on_progress: called as it goes on.

    Raises:
        ValueError: the case or an argument is wrong, the batch engine cannot fly the
            case, so few runs can show nothing, or the folder cannot be written, or has
            another study to resume.
        RuntimeError: a chunk could not be flown.
    """
    asked = asked_for(
        case,
        runs,
        seed=seed,
        share=share,
        confidence=confidence,
        metrics=metrics,
        chunk=chunk,
    )
    plan = checked_plan(asked)
    if resume and output is None:
        raise InputError("output: must be the folder of a campaign to resume, got None")
    flights = CampaignFlights(plan)
    with results_folder(output, CAMPAIGN) as folder, _home(folder) as home:
        recorded = RecordedPlan.of(plan)
        if folder is not None:
            if resume:
                folder.resume(asked)
            folder.begin(asked)
            recorded.write(folder.path)
        parts_folder(home).mkdir(exist_ok=True)
        missing = missing_chunks(home, recorded)
        left = sum(len(plan.indices(number)) for number in missing)
        telling = Telling(on_progress, plan.runs, plan.runs - left)
        each = _seconds_in_drake(plan.case)
        measuring, confirming = _seconds_after(flights, each)
        telling.plan(_seconds(flights, left), measuring, confirming)
        flown = (
            flown_here(flights, missing, telling.flown)
            if executor is None
            else flown_by(executor, recorded, home, missing, telling.flown)
        )
        for number, draws in flown:
            write_chunk(home, recorded, number, draws)
        all_draws = with_measured(
            flights,
            merged(home, recorded),
            recorded,
            home,
            executor=executor,
            workers=workers,
            on_progress=telling.measured,
        )
        study = _judged(asked, recorded, flights, all_draws, workers, each, telling)
        if folder is not None:
            study.write(folder)
    return study


@typed
def plan_campaign(
    case: Case | AnalysisCase | str | Path,
    runs: int = RUNS,
    *,
    output: Output,
    seed: int = 0,
    share: float | None = None,
    confidence: float | None = None,
    metrics: Sequence[str] = (),
    chunk: int = CHUNK,
) -> RecordedPlan:
    """Write the plan of a campaign, whose chunks others fly.

    Args:
        case: as `campaign` takes it, and what follows, too.
        runs: draws.
        output: folder of the campaign.
        seed: of the draws.
        share: as `campaign` takes it.
        confidence: as `campaign` takes it.
        metrics: that are kept beside those of the requirements.
        chunk: draws that are flown together.

    Raises:
        ValueError: as `campaign` does.
    """
    asked = asked_for(
        case,
        runs,
        seed=seed,
        share=share,
        confidence=confidence,
        metrics=metrics,
        chunk=chunk,
    )
    plan = checked_plan(asked)
    CampaignFlights(plan)  # what cannot be flown is refused now
    with results_folder(output, CAMPAIGN) as folder:
        assert folder is not None
        folder.begin(asked)
        recorded = RecordedPlan.of(plan)
        recorded.write(folder.path)
        parts_folder(folder.path).mkdir(exist_ok=True)
        folder.hand_over()
    return recorded


@typed
def run_chunk(directory: str | Path, number: int, *, again: bool = False) -> bool:
    """Fly a chunk of a campaign that is planned, unless it is there.

    Any number of processes may, on any machine that sees the folder.

    Args:
        directory: of the campaign.
        number: of the chunk, from 0.
        again: whether to fly it although it is there.

    Returns:
        Whether it was flown.

    Raises:
        ValueError: there is no such plan or chunk, or what flies is of other versions.
    """
    folder = Path(directory)
    recorded = RecordedPlan.read(folder)
    recorded.plan.indices(number)
    if not again and read_chunk(folder, recorded, number) is not None:
        return False
    write_chunk(folder, recorded, number, CampaignFlights(recorded.plan).chunk(number))
    return True


@typed
def merge_campaign(
    directory: Output,
    *,
    workers: int | None = None,
    on_progress: OnProgress | None = None,
) -> Campaign:
    """Tell what came of a campaign whose chunks have been flown.

    Args:
        directory: of the campaign.
        workers: number of processes that fly Drake; one per core if None.
        on_progress: called as it goes on.

    Raises:
        ValueError: there is no such plan, or a chunk is of another.
        RuntimeError: chunks are not there, or damaged; it says which.
    """
    with results_folder(directory, CAMPAIGN) as folder:
        assert folder is not None
        folder.go_on()
        try:
            recorded = RecordedPlan.read(folder.path)
            flown = merged(folder.path, recorded)
            flights = CampaignFlights(recorded.plan)
            telling = Telling(on_progress, len(flown), len(flown))
            each = _seconds_in_drake(recorded.plan.case)
            telling.plan(0.0, *_seconds_after(flights, each))
            flown = with_measured(
                flights,
                flown,
                recorded,
                folder.path,
                workers=workers,
                on_progress=telling.measured,
            )
        except BaseException:  # it stays under way, for whoever goes on
            folder.hand_over()
            raise
        study = _judged(folder.asked, recorded, flights, flown, workers, each, telling)
        study.write(folder)
    return study


def asked_for(
    case: Case | AnalysisCase | str | Path,
    runs: int,
    *,
    seed: int,
    share: float | None,
    confidence: float | None,
    metrics: Sequence[str],
    chunk: int,
) -> Asked:
    """Return what is asked of a campaign, as `campaign` takes it.

    Its requirements that say nothing of a share have what is given.
    """
    arguments = {
        "runs": runs,
        "seed": seed,
        "share": share,
        "confidence": confidence,
        "metrics": list(metrics),
        "chunk": chunk if chunk != CHUNK else None,
    }
    asked = Asked.of(CAMPAIGN, case, arguments, seed=seed)
    required = tuple(
        one if one.statistical else replace(one, share=share, confidence=confidence)
        for one in asked.case.requirements
    )
    return replace(asked, case=replace(asked.case, requirements=required))


def checked_plan(asked: Asked) -> CampaignPlan:
    """Return the plan of what is asked.

    Raises:
        ValueError: an argument is wrong, or so few runs can show nothing.
    """
    given = asked.arguments
    plan = CampaignPlan.of(
        asked.case,
        given["runs"],
        seed=given["seed"],
        also=tuple(given.get("metrics", ())),
        chunk=given.get("chunk", CHUNK),
    )
    if not plan.metrics and not plan.clearances:
        raise InputError(
            "requirements: a campaign needs one that runs tell, or a metric to keep, "
            "got none"
        )
    check_size(plan)
    return plan


@contextlib.contextmanager
def _home(folder: ResultsFolder | None) -> Iterator[Path]:
    """Give the folder that has the chunks; one for a while, if none is written."""
    if folder is not None:
        yield folder.path
    else:
        with tempfile.TemporaryDirectory(prefix="drakesep-") as scratch:
            yield Path(scratch)


def _seconds(flights: CampaignFlights, left: int) -> float:
    """Return what draws that are left will take, s; programs are compiled."""
    if not left:
        return 0.0
    few = flights.plan.indices(0)[: flights.together]
    flights.fly(few)
    began = time.perf_counter()
    flights.fly(few)
    return (time.perf_counter() - began) * left / len(few)


def _seconds_in_drake(case: AnalysisCase) -> float:
    """Return what a run in Drake takes, s.

    Raises:
        RuntimeError: the nominal run fails.
    """
    simulation = shared_simulation(case.separation, case.integration)
    began = time.perf_counter()
    nominal = simulation.run({})
    each = time.perf_counter() - began
    if nominal.motion is None:
        raise RuntimeError(f"the nominal run failed: {nominal.message}")
    return each


def _seconds_after(flights: CampaignFlights, each: float) -> tuple[float, float]:
    """Return what is measured, and what is flown in Drake, will take, s.

    Args:
        flights: of the campaign.
        each: what a run in Drake takes, s.
    """
    plan, measuring = flights.plan, 0.0
    confirming = each * most_confirmed(plan)
    for name in plan.clearances:
        flights.measured(name, {0: -math.inf})  # parts are looked into
        began = time.perf_counter()
        flights.measured(name, {0: -math.inf})
        once = time.perf_counter() - began
        limits = [one for one in plan.case.requirements if one.metric == name]
        sizes = [size_of(of_launches(one, limits), plan.runs) for one in limits]
        measuring += once * _LOOKED_AT * max(size.rank or 1 for size in sizes)
        confirming += once * MOST * len(limits)
    return measuring, confirming


_LOOKED_AT = 2.0
"""Draws that are measured for each of those that may be beyond, about."""


def _judged(
    asked: Asked,
    recorded: RecordedPlan,
    flights: CampaignFlights,
    flown: FlownDraws,
    workers: int | None,
    each: float,
    telling: Telling,
) -> Campaign:
    """Return what the draws show, with what Drake says of those that decide.

    Args:
        asked: of the study.
        recorded: its plan.
        flights: that can fly any draw again.
        flown: all draws.
        workers: processes that fly Drake; if None, as many as are worth it.
        each: what a run in Drake takes, s.
        telling: told how far it is.
    """
    plan, case = recorded.plan, recorded.plan.case
    study = Campaign(
        asked=asked,
        recorded=recorded,
        flights=flights,
        flown=flown,
        findings=tuple(
            share_findings(plan, flown.metrics, [*flown.reasons], flown.clearances)
        ),
    )
    draws = chosen(study)
    if workers is None and each * len(draws) < WORKERS_START:
        workers = 1
    with DrakePool(case.separation, case.integration, workers=workers) as pool:
        confirmed = confirmed_draws(study, draws, pool, telling.confirmed)
    return with_confirmed(replace(study, asked=asked.over()), confirmed)
