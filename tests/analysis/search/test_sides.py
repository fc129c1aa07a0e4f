"""The searches, where nominal values are not the middle of their tolerances."""

import itertools

import numpy as np
import pytest
from runs import evaluator_of
from separations import generic_pair

from drakesep.analysis.engines.run_evaluator import RunEvaluator
from drakesep.analysis.metrics.objectives import LargestOfParts, Needs
from drakesep.analysis.search.effort import SearchSettings
from drakesep.analysis.search.judge import find_worst_cases
from drakesep.analysis.search.linearised_corners import linearised_corners
from drakesep.analysis.search.optimality import optimality
from drakesep.analysis.search.problem import Problem
from drakesep.analysis.search.registry import SEARCHES
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.analysis.tolerances.sides import Sides
from drakesep.analysis.tolerances.tolerance_set import ToleranceSet
from drakesep.systems.model.parameters import parameters, with_values
from drakesep.systems.model.run import Run, RunStatus


PAIR = generic_pair()
TOLERANCES = {
    "upper.cg_x": Sides(minus=0.02, plus=0.008),
    "upper.cg_y": Sides(minus=0.001, plus=0.01),
    "upper.cg_z": 0.005,
    "upper.mass": Sides(minus=0.0, plus=10.0),
}
BOX = ToleranceBox.around(PAIR, TOLERANCES)
SET = ToleranceSet(PAIR, BOX)
LOWER, UPPER = np.array([-1.0, -0.1, -1.0, 0.0]), np.array([0.4, 1.0, 1.0, 1.0])
CORNERS = np.array([*itertools.product(*zip(LOWER, UPPER, strict=True))])
QUICK = SearchSettings(starts=6, samples=300, generations=30)
CLOSE = 1e-8
"""Points are scaled back from values of 1200 with tolerances of 10, and the optimiser
ends where its bounds are to round-off."""


def saddle(u):
    """Largest in one corner, next to it in another; the nominal does not see which."""
    return 1.5 * u[0] * u[1] - 0.3 * u[2] + 0.2 * u[3] * u[0] + 0.05 * u[3]


def linear(u):
    return -u[0] - 2.0 * u[1] + u[2] - 0.5 * u[3]


def search(name, function):
    evaluator = evaluator_of(function, tolerances=SET)
    problem = Problem(tolerances=SET, evaluator=evaluator)
    return SEARCHES[name](problem, QUICK, (), lambda _: None)


@pytest.mark.parametrize("function", [saddle, linear])
@pytest.mark.parametrize(
    ("name", "close"),
    [
        *(("vertices", CLOSE), ("corners", CLOSE)),
        *(("multistart", 1e-6), ("evolution", 0.02)),
    ],
)
def test_worst_corner(name, close, function):
    found = search(name, function).best(0)
    assert SET.contains(found.u)
    assert found.value == pytest.approx(max(map(function, CORNERS)), abs=close)


def test_ascent_ends_at_the_bounds():
    found = search("sqp", linear).best(0)
    assert found.u == pytest.approx([-1.0, -0.1, 1.0, 0.0], abs=1e-6)


def test_vertices_are_those_of_the_box():
    flown = []

    def function(u):
        flown.append(tuple(np.round(u, 9) + 0.0))
        return u[0]

    searched = search("vertices", function)
    assert set(flown) == {tuple(corner) for corner in CORNERS.tolist()}
    assert searched.note == "all 16 vertices"  # none of them drawn back


def test_marks_and_multipliers():
    found = optimality(SET, np.array([-1.0, -0.1, 0.2, 0.0]), np.array([-1, -2, 0, -3]))
    assert found.active == ("m", "m", "", "m")
    assert found.multipliers == pytest.approx((1.0, 2.0, 0.0, 3.0))
    assert found.residual == pytest.approx(0.0, abs=1e-15)


def test_evidence_of_a_worst_case():
    evaluator = evaluator_of(linear, tolerances=SET)
    problem = Problem(tolerances=SET, evaluator=evaluator)
    [case] = find_worst_cases(problem, ("samples", "vertices", "sqp"), QUICK)
    assert case.value == pytest.approx(1.0 + 0.2 + 1.0, abs=CLOSE)
    assert case.evidence.optimality.active == ("m", "m", "M", "m")
    assert case.evidence.optimality.slopes == pytest.approx((-1.0, -2.0, 1.0, -0.5))
    lower = {name: PAIR_VALUES[name] - side for name, side in MINUS.items()}
    assert {name: case.values[name] for name in lower} == pytest.approx(lower)


PAIR_VALUES = parameters(PAIR)
MINUS = {"upper.cg_x": 0.02, "upper.cg_y": 0.001, "upper.mass": 0.0}


class Largest(LargestOfParts):
    """The largest of two functions of the point, as a clearance is one of distances."""

    name = "largest"
    needs = Needs.MEASUREMENT

    @staticmethod
    def parts(run):
        values = parameters(run.separation)
        u = BOX.scaled({name: values[name] for name in BOX.names})
        return np.array([1.0 + 0.1 * u[2], linear(u), u[0] + u[1] + u[3]])

    def of_run(self, run, limits):
        return float(self.parts(run).max())

    def about(self, run, limits, at_least=-np.inf):
        return super().about(run, limits)

    def linearised_parts(self, run, around, reach=None):
        values = self.parts(run)
        changes = np.array([[self.parts(one) - values] for one in around])
        return values[:, None], changes.transpose(2, 1, 0)


def test_linearised_corners_are_those_that_slopes_point_to():
    def fly(rows):
        return [
            Run(
                separation=with_values(PAIR, dict(zip(BOX.names, row, strict=True))),
                status=RunStatus.COMPLETED,
            )
            for row in rows
        ]

    evaluator = RunEvaluator(fly, BOX.names, [Largest()])
    found = linearised_corners(Problem(tolerances=SET, evaluator=evaluator), 0)
    # Parts rise to 1.1, 2.2 and 2.4; the worst is first.
    expected = [[0.4, 1.0, 0.0, 1.0], [-1.0, -0.1, 1.0, 0.0], [0.0, 0.0, 1.0, 0.0]]
    assert np.array(found) == pytest.approx(np.array(expected))
