"""The study of a campaign: plan, fly, merge, confirm in Drake, write down."""

import time
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path
from typing import Unpack

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.campaigns.flights import CampaignFlights
from drakesep.analysis.campaigns.gathering import kept
from drakesep.analysis.engines.drake_pool import WORKERS_START, DrakePool
from drakesep.case_file.case import Case
from drakesep.results.asked import Asked
from drakesep.results.campaign_files import (
    RecordedPlan,
    merged,
    read_chunk,
    write_chunk,
)
from drakesep.results.catalogue.names import CAMPAIGN
from drakesep.results.folder import Output, results_folder
from drakesep.results.parts import parts_folder
from drakesep.studies.campaign.confirmation import chosen, confirmed
from drakesep.studies.campaign.executors import flown_on_all_cores
from drakesep.studies.campaign.flight import ChunksUnderWay, home_of, shown
from drakesep.studies.campaign.measuring import seconds_after, with_measured
from drakesep.studies.campaign.progress import OnProgress, Telling
from drakesep.studies.campaign.result import Campaign
from drakesep.studies.campaign.settings import RUNS, CampaignOptions, CampaignSettings
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError
from drakesep.systems.simulation.shared_simulation import shared_simulation


@typed
def campaign(
    case: Case | AnalysisCase | str | Path,
    runs: int = RUNS,
    *,
    executor: Executor | None = None,
    output: Output | None = None,
    resume: bool = False,
    workers: int | None = None,
    on_progress: OnProgress | None = None,
    **settings: Unpack[CampaignOptions],
) -> Campaign:
    """Fly many independent draws, and tell what share meets the requirements.

    Args:
        case: a case, in SI or as a file holds it, a case file, or the name of a
            built-in case.
        runs: draws; their number is fixed beforehand, or their confidence is void.
        executor: of `concurrent.futures`, whose workers fly; None: this process does,
            on all its cores.
        output: folder that receives tables and plots, and chunks as they are flown.
        resume: whether to go on from the chunks that the same campaign has left there.
        workers: number of processes that fly Drake; one per core if None.
        on_progress: called as it goes on.
        settings: `seed` of the draws; `share` of launches that must meet each
            requirement that names none, and `confidence` at which that is to be shown,
            0.9 if not given; `metrics`, `chunk` and `keep` of `CampaignSettings`.

    Raises:
        ValueError: the case or an argument is wrong, the batch engine cannot fly the
            case, so few runs can show nothing, or the folder cannot be written, or has
            another study to resume.
        RuntimeError: a chunk could not be flown.
    """
    asked, flights = _asked(case, runs, settings)
    if resume and output is None:
        raise InputError("output: must be the folder of a campaign to resume, got None")
    plan = flights.plan
    with results_folder(output, CAMPAIGN) as folder, home_of(folder) as home:
        recorded = RecordedPlan.of(plan)
        if folder is not None:
            if resume:
                folder.resume(asked)
            folder.begin(asked)
            recorded.write(folder.path)
        flight = ChunksUnderWay(recorded, flights, home)
        telling = Telling(on_progress, plan.runs, plan.runs - flight.left)
        each = _seconds_in_drake(plan.case)
        measuring, confirming = seconds_after(flights, each)
        telling.plan(flight.seconds(), measuring, confirming)
        flown = with_measured(
            flights,
            flight.flown(executor, telling.flown, telling.chunk_flown),
            recorded,
            home,
            executor=executor,
            workers=workers,
            on_progress=telling.measured,
        )
        study = shown(asked, recorded, flights, flown)
        study = _confirmed(study, workers, each, telling)
        if folder is not None:
            study.write(folder)
    return study


@typed
def plan_campaign(
    case: Case | AnalysisCase | str | Path,
    runs: int = RUNS,
    *,
    output: Output,
    **settings: Unpack[CampaignOptions],
) -> RecordedPlan:
    """Write the plan of a campaign, whose chunks others fly.

    Args:
        case: as `campaign` takes it.
        runs: draws.
        output: folder of the campaign.
        settings: as `campaign` takes them.

    Raises:
        ValueError: as `campaign` does.
    """
    # What cannot be flown is refused now.
    asked, flights = _asked(case, runs, settings)
    with results_folder(output, CAMPAIGN) as folder:
        assert folder is not None
        folder.begin(asked)
        recorded = RecordedPlan.of(flights.plan)
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
    flights = flown_on_all_cores(recorded.text, str(folder))
    write_chunk(folder, recorded, number, kept(recorded.plan, flights.chunk(number)))
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
            telling.plan(0.0, *seconds_after(flights, each))
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
        study = shown(folder.asked, recorded, flights, flown)
        study = _confirmed(study, workers, each, telling)
        study.write(folder)
    return study


def _asked(
    case: Case | AnalysisCase | str | Path, runs: int, options: CampaignOptions
) -> tuple[Asked, CampaignFlights]:
    """Return what is asked of a campaign, and what flies its plan."""
    settings = CampaignSettings(runs=runs, **options)
    asked = settings.asked(case)
    return asked, CampaignFlights(settings.plan(asked.case)).with_spans()


def _confirmed(
    study: Campaign, workers: int | None, each: float, telling: Telling
) -> Campaign:
    """Return a campaign that is over, with what Drake says of draws that decide.

    Args:
        study: with all draws.
        workers: processes that fly Drake; if None, as many as are worth it.
        each: what a run in Drake takes, s.
        telling: told how far it is.
    """
    case, draws = study.case, chosen(study)
    if workers is None and each * len(draws) < WORKERS_START:
        workers = 1
    with DrakePool(case.separation, case.integration, workers=workers) as pool:
        study = confirmed(study, draws, pool, telling.confirmed)
    return replace(study, asked=study.asked.over())


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
