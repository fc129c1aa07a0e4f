"""The search, on functions of the parameters whose constrained maxima are known."""

import math

import numpy as np
import pytest
from runs import fly_nothing, of_parameters
from separations import generic_pair, vega

from drakesep.analysis.dispersions import Box
from drakesep.analysis.physical_set import PhysicalSet
from drakesep.analysis.worst_case import SearchStatus, find_worst_case
from drakesep.systems.parameters import parameters
from drakesep.systems.run import Run, RunStatus


PAIR = generic_pair()
NAMES = ("upper.cg_x", "upper.cg_y", "upper.cg_z", "spring_1.stroke")
TOLERANCES = dict(zip(NAMES, (0.02, 0.01, 0.005, 0.001), strict=True))
BOX = Box.around(PAIR, TOLERANCES)


def search(function, separation=PAIR, box=BOX, **options):
    return find_worst_case(
        of_parameters(function),
        box,
        PhysicalSet(separation, box),
        fly_nothing(separation),
        **options,
    )


def scaled(values):
    return BOX.scaled({name: values[name] for name in NAMES})


def test_linear_function_ends_in_its_corner():
    slopes = np.array([3.0, -1.0, 0.2, -0.5])
    worst = search(lambda p: 7.0 + slopes @ scaled(p))
    assert worst.u == pytest.approx(np.sign(slopes), abs=1e-12)
    assert worst.value == pytest.approx(7.0 + 4.7, rel=1e-12)
    assert worst.status is SearchStatus.CONVERGED
    assert worst.iterations <= 6


def test_maximum_inside_the_box():
    inside = np.array([0.3, -0.6, 0.0, 0.5])
    worst = search(lambda p: 2.0 - ((scaled(p) - inside) ** 2).sum())
    # one-sided differences shift the maximum by half a step, 1e-3 / 2
    assert worst.u == pytest.approx(inside, abs=1e-3)


def test_maximum_on_the_boundary_of_the_physical_inertias():
    """Drives the largest moment up: the triangle inequality stops it, not the box."""
    names = ("payload.inertia_xx", "payload.inertia_yy", "payload.inertia_zz")
    box = Box.around(vega(), dict(zip(names, (70.0, 320.0, 330.0), strict=True)))
    flown = []

    def function(p):
        flown.append(p)
        return p[names[2]] - p[names[1]]

    worst = search(function, vega(), box)
    # zz - yy <= xx <= 739, by the triangle inequality
    assert worst.value == pytest.approx(739.0, rel=1e-4)
    assert worst.values[names[0]] == pytest.approx(739.0, rel=1e-4)


def test_every_run_is_counted_and_every_iterate_logged():
    calls = []
    seen = []

    def function(p):
        calls.append(p)
        return scaled(p).sum() - (scaled(p) ** 2).sum()

    worst = search(function, on_iteration=seen.append)
    assert worst.evaluations == len(calls)
    assert list(worst.history) == seen
    assert [i.number for i in seen] == list(range(len(seen)))
    assert seen[0].u == (0.0,) * 4
    assert worst.iterations == seen[-1].number
    assert worst.value >= seen[-1].value
    assert worst.value == function(parameters(worst.run.separation))


def test_points_stay_in_the_box():
    def function(p):
        assert (np.abs(scaled(p)) <= 1.0 + 1e-11).all()
        return (scaled(p) ** 2).sum() + scaled(p)[0]

    assert search(function, start=np.full(4, 0.9)).value == pytest.approx(5.0)


def test_iteration_limit_is_told():
    worst = search(
        lambda p: -((scaled(p) - 0.31) ** 4).sum() + scaled(p)[0] * scaled(p)[1],
        max_iterations=2,
    )
    assert worst.status is SearchStatus.ITERATION_LIMIT


def fly_until(limit, separation=PAIR):
    """Runs fail from the limit-th on."""
    count = 0

    def fly(variations):
        nonlocal count
        runs = fly_nothing(separation)(variations)
        for i, run in enumerate(runs):
            count += 1
            if count >= limit:
                runs[i] = Run(
                    separation=run.separation, status=RunStatus.FAILED, message="boom"
                )
        return runs

    return fly


def test_failed_run_ends_the_search_with_what_was_found():
    objective = of_parameters(lambda p: 1.0 + scaled(p).sum())
    worst = find_worst_case(
        objective, BOX, PhysicalSet(PAIR, BOX), fly_until(6), start=np.zeros(4)
    )
    assert worst.status is SearchStatus.FAILED
    assert "boom" in worst.message
    assert worst.value == 1.0


def test_failed_start_is_an_error():
    objective = of_parameters(lambda p: 1.0)
    with pytest.raises(RuntimeError, match="start of the search: a run failed: boom"):
        find_worst_case(objective, BOX, PhysicalSet(PAIR, BOX), fly_until(1))


def test_objective_without_a_number_is_told():
    with pytest.raises(RuntimeError, match="objective must be finite, got nan"):
        search(lambda p: math.nan)


@pytest.mark.parametrize("start", [np.full(4, 1.5), np.full(4, math.nan)])
def test_start_outside_the_box(start):
    with pytest.raises(ValueError, match="start must be in the box"):
        search(lambda p: 1.0, start=start)
