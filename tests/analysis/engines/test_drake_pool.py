"""Runs over processes are the runs of one process."""

import numpy as np
import pytest
from separations import generic_pair

from drakesep.analysis.engines.drake_pool import DrakePool
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.run import RunStatus
from drakesep.systems.simulation.simulation import Simulation


VARIATIONS = [{"upper.mass": 1200.0 + 10.0 * i} for i in range(5)]


def test_same_runs_whatever_the_number_of_workers():
    results = []
    for workers in (1, 2):
        with DrakePool(generic_pair(), workers=workers) as pool:
            results.append(pool.fly(VARIATIONS))
    for alone, together in zip(*results, strict=True):
        assert alone.separation == together.separation
        assert together.status is RunStatus.COMPLETED
        assert np.array_equal(alone.motion.rate, together.motion.rate)
        assert np.array_equal(alone.motion.acceleration, together.motion.acceleration)


@pytest.mark.parametrize("wrong", [[1200.0], True, "heavy", None])
def test_what_is_no_number_is_refused(wrong):
    with (
        DrakePool(generic_pair(), workers=1) as pool,
        pytest.raises(ValueError, match=r"upper.mass must be a number, got "),
    ):
        pool.fly([{"upper.mass": 1.0}, {"upper.mass": wrong}])


def test_order_does_not_matter():
    with DrakePool(generic_pair(), workers=1) as pool:
        forwards = pool.fly(VARIATIONS)
        backwards = pool.fly(VARIATIONS[::-1])
    for a, b in zip(forwards, backwards[::-1], strict=True):
        assert np.array_equal(a.motion.rate, b.motion.rate)


def test_equal_variations_are_flown_once():
    told = []
    with DrakePool(generic_pair(), workers=1) as pool:
        first, other, again = pool.fly(
            [VARIATIONS[0], VARIATIONS[1], dict(VARIATIONS[0])],
            lambda *done: told.append(done),
        )
    assert again is first
    assert other.separation != first.separation
    assert told == [(1, 2), (2, 2)]


def test_bad_values_reach_the_caller():
    with (
        DrakePool(generic_pair(), workers=2) as pool,
        pytest.raises(ValueError, match="upper: mass must be > 0, got -1"),
    ):
        pool.fly([{}, {"upper.mass": -1.0}])


def test_at_least_one_worker():
    with pytest.raises(ValueError, match="workers must be >= 1, got 0"):
        DrakePool(generic_pair(), workers=0)


def test_workers_integrate_as_they_are_told():
    integration = Integration(scheme="bogacki_shampine3", accuracy=1e-4, max_step=0.02)
    with DrakePool(generic_pair(), integration, workers=2) as pool:
        runs = pool.fly(VARIATIONS[:2])
    here, by_default = (
        Simulation(generic_pair(), how) for how in (integration, Integration())
    )
    for run, values in zip(runs, VARIATIONS, strict=False):
        told = run.steps, run.evaluations
        alone = here.run(values)
        assert told == (alone.steps, alone.evaluations)
        usual = by_default.run(values)
        assert told != (usual.steps, usual.evaluations)
