"""Who flies the chunks of a campaign: this process, or any executor's workers."""

import contextlib
import functools
import itertools
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from pathlib import Path
from typing import Any

import numpy as np

from drakesep.analysis.campaigns.flights import CampaignFlights
from drakesep.analysis.campaigns.gathering import KeptDraws, kept
from drakesep.analysis.engines.processes import end_processes, start_processes
from drakesep.analysis.engines.registered import Registered
from drakesep.results.campaign_files import RecordedPlan
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError


_IN_HAND = 2
"""Chunks for each worker that are flown or wait: so many results may lie in memory."""


def flown_here(
    flights: CampaignFlights,
    numbers: Sequence[int],
    on_progress: Callable[[int], None] = lambda _: None,
) -> Iterator[tuple[int, KeptDraws]]:
    """Yield chunks flown in this process, on all its cores, by their numbers.

    Args:
        flights: of the campaign.
        numbers: of the chunks.
        on_progress: told how many draws are done.
    """
    done = 0

    def tell(part: int, _: int) -> None:
        on_progress(done + part)

    for number in numbers:
        flown = kept(flights.plan, flights.chunk(number, tell))
        done += len(flown)
        yield number, flown


def flown_by(
    executor: Executor,
    recorded: RecordedPlan,
    folder: Path,
    numbers: Sequence[int],
    on_progress: Callable[[int], None] = lambda _: None,
) -> Iterator[tuple[int, KeptDraws]]:
    """Yield chunks flown by an executor, in whichever order they come.

    Its workers are told the plan as a text, and what is registered beside drakesep's
    own; they bring back what they have flown, and need no disk of ours. What has been
    flown is yielded, whatever becomes of the rest.

    Args:
        executor: any of `concurrent.futures`.
        recorded: the plan.
        folder: of the campaign.
        numbers: of the chunks.
        on_progress: told how many draws are done.
    """
    ahead, done = iter(numbers), 0
    plan = recorded.text, str(folder), Registered.here().as_bytes()
    under_way: dict[Future[KeptDraws], int] = {}

    def submit(count: int) -> None:
        for number in itertools.islice(ahead, count):
            task = executor.submit(fly_chunk, *plan, number)
            under_way[task] = number

    submit(_IN_HAND * _workers(executor))
    try:
        while under_way:
            ended = wait(under_way, return_when=FIRST_COMPLETED).done
            # What came is told before what did not.
            for task in sorted(ended, key=lambda one: one.exception() is not None):
                flown = task.result()
                number = under_way.pop(task)
                submit(1)
                done += len(flown)
                on_progress(done)
                yield number, flown
    finally:
        for task in under_way:
            task.cancel()


def measured_by(
    executor: Executor,
    recorded: RecordedPlan,
    folder: Path,
    name: str,
    draws: Mapping[int, float],
) -> Array:
    """Return (n,) how near parts come in draws, measured by an executor, m.

    Args:
        executor: any of `concurrent.futures`.
        recorded: the plan.
        folder: of the campaign.
        name: of a clearance of the plan.
        draws: what is known of each at least, m, by its number.
    """
    every = min(_IN_HAND * _workers(executor), len(draws))
    known = [*draws.items()]
    where = recorded.text, str(folder), Registered.here().as_bytes()
    # The worst take longest: each worker has some of them.
    tasks = [
        executor.submit(measure_draws, *where, name, dict(known[k::every]))
        for k in range(every)
    ]
    values = np.empty(len(known))
    for k, task in enumerate(tasks):
        values[k::every] = task.result()
    return values


def _workers(executor: Executor) -> int:
    """Return how many chunks an executor flies at once, as far as it tells."""
    client: Any = getattr(executor, "_client", None)
    if client is not None:  # of Dask
        threads: int = sum(client.nthreads().values())
        return max(1, threads)
    told: int | None = getattr(executor, "_max_workers", None)
    return told or os.cpu_count() or 1


def fly_chunk(text: str, folder: str, registered: bytes, number: int) -> KeptDraws:
    """Return a chunk of a plan, flown in this process on one core.

    Args:
        text: of the plan.
        folder: of the campaign, whose meshes a case may name.
        registered: metrics and pushers that are not drakesep's own.
        number: of the chunk.

    Raises:
        ValueError: this is another version than that of the plan, or what is
            registered cannot be imported here.
    """
    flights = _flights(text, folder, registered)
    return kept(flights.plan, flights.chunk(number))


def measure_draws(
    text: str, folder: str, registered: bytes, name: str, draws: Mapping[int, float]
) -> Array:
    """Return how near parts come in draws of a plan, m.

    Args:
        text: of the plan.
        folder: of the campaign, whose meshes a case may name.
        registered: as `fly_chunk` takes it.
        name: of a clearance of the plan.
        draws: what is known of each at least, m, by its number.

    Raises:
        ValueError: this is another version than that of the plan.
    """
    return _flights(text, folder, registered).measured(name, draws)


@functools.lru_cache(maxsize=1)
def flown_on_all_cores(text: str, folder: str) -> CampaignFlights:
    """Return what flies chunk after chunk of a plan: its programs are made once.

    Args:
        text: of the plan.
        folder: of the campaign, whose meshes a case may name.
    """
    return CampaignFlights(RecordedPlan.parsed(text, Path(folder)).plan)


@functools.lru_cache(maxsize=1)
def _flights(text: str, folder: str, registered: bytes) -> CampaignFlights:
    """Return what flies a plan: a worker's programs are made once."""
    Registered.known_from(registered)
    recorded = RecordedPlan.parsed(text, Path(folder))
    return CampaignFlights(recorded.plan, workers=1)


@contextlib.contextmanager
def own_processes(count: int) -> Iterator[Executor]:
    """Give so many processes of this machine, spawned, that end with the block."""
    pool = start_processes(count, _nothing)
    try:
        yield pool
    finally:
        end_processes(pool)


def _nothing() -> None:
    """Prepare nothing: a worker learns what it flies with its first chunk."""


@contextlib.contextmanager
def dask_cluster(address: str) -> Iterator[Executor]:
    """Give the workers of a Dask cluster.

    Args:
        address: of its scheduler.

    Raises:
        ValueError: Dask is not installed, or nobody answers there.
    """
    try:
        import distributed
    except ImportError as error:
        raise InputError(
            "dask: needs distributed, which `pip install drakesep[cluster]` installs"
        ) from error
    dask: Any = distributed  # which says nothing of its types
    try:
        client = dask.Client(address, timeout=_ANSWER)
    except (OSError, ValueError) as error:
        raise InputError(
            f"dask: must be the address of a scheduler, got {address!r} ({error})"
        ) from error
    with client:
        # Results are files' content: to fly a chunk twice is no fault.
        yield client.get_executor(pure=True)


_ANSWER = 10.0
"""For which a scheduler is waited for, s."""
