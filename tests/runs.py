"""Runs made up for tests, without a simulation."""

import dataclasses

import numpy as np
from separations import generic_pair

from drakesep.analysis.engines.run_evaluator import RunEvaluator
from drakesep.analysis.metrics.objectives import of_run
from drakesep.analysis.tolerances.tolerance_set import ToleranceSet
from drakesep.systems.model.parameters import parameters, with_values
from drakesep.systems.model.run import Motion, Run, RunStatus
from drakesep.systems.model.separation import Separation
from drakesep.systems.sampling import find_breaks, sample_times


def made_up_run(separation: Separation | None = None, **columns) -> Run:
    """A run whose motion is given as functions of time, (n,) -> (n, 3)."""
    separation = separation or generic_pair(duration=3.0)
    releases = separation.scheduled_releases
    ends = separation.timed_stroke_ends(releases)
    time = sample_times(separation, releases, ends)
    motion = {
        field.name: np.zeros((len(time), 3)) for field in dataclasses.fields(Motion)
    }
    for name, function in columns.items():
        motion[name] = np.stack(np.broadcast_arrays(*function(time)), axis=1)
    motion["time"] = time
    return Run(
        separation=separation,
        status=RunStatus.COMPLETED,
        motion=Motion(**motion),
        breaks=find_breaks(separation, releases, ends),
        releases=releases,
        stroke_ends=ends,
    )


def fly_nothing(separation: Separation):
    """Fly variations without simulating them: the run carries its parameters."""

    def fly(variations):
        return [
            Run(separation=with_values(separation, v), status=RunStatus.COMPLETED)
            for v in variations
        ]

    return fly


def evaluator_of(*functions, tolerances: ToleranceSet) -> RunEvaluator:
    """Tells functions of the scaled point, without simulating anything."""
    fly, box = fly_nothing(tolerances.separation), tolerances.box
    objectives = [
        of_run(
            lambda run, f=f: f(
                box.scaled(
                    {name: parameters(run.separation)[name] for name in box.names}
                )
            ),
            name=f"objective_{k}",
        )
        for k, f in enumerate(functions)
    ]
    return RunEvaluator(
        lambda rows: fly([dict(zip(box.names, row, strict=True)) for row in rows]),
        box.names,
        objectives,
    )
