"""Which points a search flies depends on its own settings, and on no others."""

import dataclasses

import numpy as np
import pytest
from runs import evaluator_of
from separations import generic_pair

from drakesep.analysis.margins.tolerance_margins import Limit, grow
from drakesep.analysis.search.effort import Effort, SearchSettings
from drakesep.analysis.search.problem import Problem
from drakesep.analysis.search.registry import SEARCHES
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.analysis.tolerances.tolerance_set import ToleranceSet


PAIR = generic_pair()
NAMES = ("upper.cg_x", "upper.cg_y", "upper.cg_z")
SET = ToleranceSet(PAIR, ToleranceBox.around(PAIR, dict.fromkeys(NAMES, 0.01)))
BASE = SearchSettings(
    starts=7, samples=40, vertices=8, generations=3, corners=32, seed=1
)
OTHER = {
    "starts": 9,
    "samples": 60,
    "vertices": 7,
    "generations": 5,
    "corners": 48,
    "flips": 1,
    "seed": 2,
}
FELT = {
    "sqp": set(),
    "multistart": {"starts", "seed"},
    "vertices": {"vertices"},  # one more than there are, or one less
    "samples": {"samples", "seed"},
    "evolution": {"generations", "seed"},
    "best": set(),
    # Of three parameters it sees all corners at once, unless flips are few.
    "corners": {"seed", "flips"},
}
"""By which settings the points of each search differ."""


def wavy(u):
    """Neither linear nor with one maximum, so that no search ends at once."""
    return float(
        np.sin(5.0 * u[0] + 1.0) * np.cos(4.0 * u[1]) + 0.3 * u[2] * (u[0] + u[2])
    )


def flown(search, settings):
    """The points that a search flies, in their order."""
    evaluator = evaluator_of(wavy, tolerances=SET)
    rows, fly = [], evaluator._fly

    def noted(points):
        rows.append(points)
        return fly(points)

    evaluator._fly = noted
    search(Problem(tolerances=SET, evaluator=evaluator), settings)
    return np.concatenate(rows)


def by_name(name):
    return lambda problem, settings: SEARCHES[name](
        problem, settings, (), lambda _: None
    )


def growing(problem, settings):
    limit = Limit(objective=0, value=2.0, u=(0.5, -0.5, 1.0))
    grow(problem, [limit], corners=settings.corners, seed=settings.seed)


def assert_felt(search, felt):
    reference = flown(search, BASE)
    assert np.array_equal(flown(search, BASE), reference)  # the same again
    for setting, value in OTHER.items():
        try:
            points = flown(search, dataclasses.replace(BASE, **{setting: value}))
        except ValueError:
            assert setting in felt  # not affordable any more
            continue
        assert np.array_equal(points, reference) == (setting not in felt), setting


@pytest.mark.parametrize("name", SEARCHES)
def test_search(name):
    assert_felt(by_name(name), FELT[name])


def test_growth():
    assert_felt(growing, {"corners", "seed"})


def test_vertices_that_cannot_be_afforded_are_told_from_drawn_points():
    """By slopes there: another seed looks at others."""
    few = dataclasses.replace(BASE, vertices=4)

    def slanted(problem, settings):
        SEARCHES["vertices"](problem, settings, (), lambda _: None)

    evaluator = evaluator_of(lambda u: 3.0 * u[0] + u[1] + u[2] ** 2, tolerances=SET)
    asked, fly = [], evaluator._fly
    evaluator._fly = lambda rows: asked.append(rows) or fly(rows)
    points = []
    for seed in (1, 2):
        asked.clear()
        problem = Problem(tolerances=SET, evaluator=evaluator)
        slanted(problem, dataclasses.replace(few, seed=seed))
        points.append(np.concatenate(asked))
    assert not np.array_equal(*points)


def test_every_setting_is_here():
    assert set(OTHER) == set(Effort.__annotations__)
    elsewhere = {"corners", "flips"}  # above, and in test_corners
    assert set().union(*FELT.values()) | elsewhere == set(OTHER)
