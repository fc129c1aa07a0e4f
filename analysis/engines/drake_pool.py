"""Many runs of one separation, over worker processes."""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import TracebackType
from typing import Self

from drakesep.analysis.engines.processes import start_processes
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError
from drakesep.systems.equations.springs import PUSHERS, PusherKind
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.run import Run
from drakesep.systems.model.separation import Separation
from drakesep.systems.simulation.shared_simulation import shared_simulation
from drakesep.systems.simulation.simulation import Simulation


WORKERS_START = 4.0
"""What workers must save to be worth their start, s."""


@typed
class DrakePool:
    """Flies variations of one separation, spread over processes.

    A run is the same wherever it is flown: results do not depend on the number of
    workers. A context manager; leaving it ends the workers.
    """

    def __init__(
        self,
        separation: Separation,
        integration: Integration | None = None,
        *,
        workers: int | None = None,
    ):
        """Start the workers, which build their simulation while the caller goes on.

        Args:
            separation: to be flown and varied.
            integration: how; the default of `Simulation` if None.
            workers: number of processes; 1 flies in this one; None: one per core.

        Raises:
            ValueError: fewer than one worker.
        """
        workers = os.cpu_count() or 1 if workers is None else workers
        if workers < 1:
            raise InputError(f"workers must be >= 1, got {workers}")
        self._flown_here = separation, integration
        shared_simulation(separation, integration)  # built, and refused if it is wrong
        self._pool = None
        if workers > 1:
            self._pool = start_processes(
                workers, _prepare, separation, integration, dict(PUSHERS)
            )

    @typed
    def fly(
        self,
        variations: Sequence[Mapping[str, float]],
        on_progress: Callable[[int, int], None] = lambda *_: None,
    ) -> list[Run]:
        """Fly each variation; those that are equal, once.

        Args:
            variations: new values by parameter name, in SI, for each run.
            on_progress: told how many different ones are done, and of how many.

        Returns:
            The runs in the same order; those that failed say so.

        Raises:
            ValueError: a parameter is unknown, or its value is not physical.
        """
        # As they are written: what is wrong with them is not told here.
        keys = [repr(sorted(values.items(), key=repr)) for values in variations]
        different = dict(zip(keys, variations, strict=True))
        runs: dict[str, Run] = {}
        flown = self._flown([*different.values()])
        for key, run in zip(different, flown, strict=True):
            runs[key] = run
            on_progress(len(runs), len(different))
        return [runs[key] for key in keys]

    def _flown(self, variations: Sequence[Mapping[str, float]]) -> Iterator[Run]:
        if self._pool is None or len(variations) == 1:
            return map(shared_simulation(*self._flown_here).run, variations)
        # Not with map(): interrupted, it cancels what the workers are about to return.
        futures = [self._pool.submit(_fly, dict(values)) for values in variations]
        return (future.result() for future in futures)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=True, kill_workers=error is not None)


_simulation: Simulation | None = None
"""Of a worker process: built once, since each build leaks (see drake #22515)."""


def _prepare(
    separation: Separation,
    integration: Integration | None,
    pushers: Mapping[str, PusherKind],
) -> None:
    global _simulation
    PUSHERS.update(pushers)  # those that the caller has registered
    _simulation = Simulation(separation, integration)


def _fly(values: Mapping[str, float]) -> Run:
    assert _simulation is not None  # set by the initializer
    return _simulation.run(values)
