"""The draws of a campaign whose clearance must be measured, measured."""

import contextlib
import math
import os
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path

from drakesep.analysis.campaigns.flights import CampaignFlights, FlownDraws
from drakesep.analysis.campaigns.gathering import KeptDraws
from drakesep.analysis.campaigns.measuring import MOST, next_draws
from drakesep.analysis.campaigns.screens import DrawnClearances
from drakesep.analysis.campaigns.shares import nearest_of_draws, of_launches, size_of
from drakesep.analysis.engines.drake_pool import WORKERS_START
from drakesep.results.campaign_files import (
    RecordedPlan,
    measured_file,
    read_measured,
    write_measured,
)
from drakesep.studies.campaign.confirmation import MOST as MOST_IN_DRAKE
from drakesep.studies.campaign.confirmation import most_confirmed
from drakesep.studies.campaign.executors import measured_by, own_processes
from drakesep.systems.arrays import Array


def with_measured(
    flights: CampaignFlights,
    flown: KeptDraws,
    recorded: RecordedPlan,
    folder: Path,
    *,
    executor: Executor | None = None,
    workers: int | None = None,
    on_progress: Callable[[int, int], None] = lambda *_: None,
) -> KeptDraws:
    """Return draws with their clearances measured where these decide.

    What has been measured stays in the folder: whoever goes on has it.

    Args:
        flights: of the campaign.
        flown: what is kept of all draws.
        recorded: the plan.
        folder: of the campaign.
        executor: whose workers measure; None: this process, or some of this machine.
        workers: number of these; one per core if None.
        on_progress: told how many draws are measured, and of how many about.
    """
    plan = recorded.plan
    if not isinstance(flown, FlownDraws) or flown.clearances is None:
        return flown
    count = workers or os.cpu_count() or 1
    at_least = flown.clearances.at_least.copy()
    measured = flown.clearances.measured.copy()
    done = 0
    with contextlib.ExitStack() as stack:
        for i, name in enumerate(plan.clearances):
            required = [one for one in plan.case.requirements if one.metric == name]
            number = 0
            while True:
                known = DrawnClearances(at_least=at_least, measured=measured)
                nearest = [nearest_of_draws(plan, one, known) for one in required]
                draws = next_draws(nearest)
                if not len(draws):
                    break
                left = max(one.left for one in nearest)
                left = max(min(left, MOST - int(measured[:, i].sum())), len(draws))
                on_progress(done, done + left)
                file = measured_file(folder, i, number)
                values = read_measured(file, recorded, draws.tolist())
                if values is None:
                    asked = dict(zip(draws.tolist(), at_least[draws, i], strict=True))
                    began = time.perf_counter()
                    values = _measured(flights, recorded, folder, executor, name, asked)
                    write_measured(file, recorded, draws.tolist(), values)
                    slow = time.perf_counter() - began > WORKERS_START
                    if executor is None and count > 1 and slow and left > len(draws):
                        # Worth the start of others.
                        executor = stack.enter_context(own_processes(count))
                at_least[draws, i], measured[draws, i] = values, True
                done, number = done + len(draws), number + 1
    if done:
        on_progress(done, done)
    return replace(
        flown, clearances=DrawnClearances(at_least=at_least, measured=measured)
    )


def _measured(
    flights: CampaignFlights,
    recorded: RecordedPlan,
    folder: Path,
    executor: Executor | None,
    name: str,
    draws: Mapping[int, float],
) -> Array:
    if executor is None:
        return flights.measured(name, draws)
    return measured_by(executor, recorded, folder, name, draws)


def seconds_after(flights: CampaignFlights, each: float) -> tuple[float, float]:
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
        confirming += once * MOST_IN_DRAKE * len(limits)
    return measuring, confirming


_LOOKED_AT = 2.0
"""Draws that are measured for each of those that may be beyond, about."""
