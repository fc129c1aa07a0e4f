"""Enclosures hold the motion: of an independent simulation, and of free tops."""

import dataclasses
import itertools
from typing import NamedTuple

import free_bodies
import numpy as np
import oracle
import pytest
from separations import generic_pair
from turned_stack import OF_EACH_KIND, TURNED
from turned_stack import TOLERANCES as OF_TURNED

from drakesep.analysis.bounds.box import Boxes
from drakesep.analysis.bounds.branch_and_bound import Prover
from drakesep.analysis.bounds.claims import claim_of
from drakesep.analysis.bounds.gravity import disturbance
from drakesep.analysis.bounds.grid import make_grid, pieces_between
from drakesep.analysis.bounds.motion import Enclosure
from drakesep.analysis.bounds.problem import BoundProblem, problem_of
from drakesep.analysis.bounds.pushes import NominalKernels
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.systems.model.orbit import Orbit
from drakesep.systems.model.parameters import with_values
from drakesep.systems.model.separation import Separation


TOLERANCES = {
    "upper.mass": 20.0,
    "upper.cg_x": 0.02,
    "upper.cg_y": 0.01,
    "upper.cg_z": 0.01,
    "upper.inertia_xx": 30.0,
    "upper.inertia_yy": 30.0,
    "upper.inertia_xy": 15.0,
    "upper.inertia_yz": 15.0,
    "before_separation.rate_x": 0.01,
    "before_separation.rate_y": 0.004,
    "before_separation.rate_z": 0.02,
    "lower.mass": 10.0,
    "lower.cg_y": 0.01,
    "lower.inertia_zz": 20.0,
    "lower.inertia_xz": 10.0,
    "spring_1.force_max": 20.0,
    "spring_2.stroke": 0.002,
    "spring_3.design_mass": 2.0,
    "attachment_2.position_y": 0.005,
    "attachment_3.position_x": 0.01,
}
PAIR = generic_pair(orbit=Orbit(radius=7.0e6), duration=0.8)


class Varied(NamedTuple):
    """A separation, what of it varies, and by what derivatives are looked at."""

    separation: Separation
    box: ToleranceBox
    looked_at: tuple[str, ...]

    @property
    def times(self) -> np.ndarray:
        return np.linspace(0.0, self.separation.duration, 33)

    @property
    def problem(self) -> BoundProblem:
        return problem_of(self.separation, self.box)

    def flown(self, s: np.ndarray) -> oracle.LabelledRun:
        return oracle.fly(with_values(self.separation, self.box.values(s)), self.times)


CASES = {
    "plain": Varied(
        PAIR, ToleranceBox.around(PAIR, TOLERANCES), tuple(TOLERANCES)[::3]
    ),
    "turned": Varied(TURNED, ToleranceBox.around(TURNED, OF_TURNED), OF_EACH_KIND),
}
N = len(TOLERANCES)
assert len(OF_TURNED) == N
each_case = pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())


def enclosed(problem: BoundProblem, grid, lower, upper, slopes=()) -> dict:
    """Signals over boxes, (1 + n, boxes, pieces) each, three components."""
    e = Enclosure(
        Boxes(problem, lower, upper, slopes),
        grid,
        NominalKernels(problem, grid),
        disturbance(problem),
    )
    assert e.proven.all()
    return {
        "rate": e.rates(e.state)[1],
        "relative_rate": e.relative_rate(e.state, e.changes(e.state), 0),
        "relative_velocity": e.velocity(e.state, 0),
    }


ERROR = 1e-8
"""Of the oracle, in SI, above that of its integration."""


def boxes_around(rng, count: int):
    middle = rng.uniform(-0.9, 0.9, (count, N))
    half = 10.0 ** rng.uniform(-3.0, -0.5, (count, 1)) * rng.uniform(0, 1, (count, N))
    return np.clip(middle - half, -1, 1), np.clip(middle + half, -1, 1)


@each_case
def test_enclosures_hold_runs_of_their_boxes(case):
    rng = np.random.default_rng(5)
    lower, upper = boxes_around(rng, 8)
    grid = make_grid(case.problem, 12, 4)
    found = enclosed(case.problem, grid, lower, upper)
    for b in range(len(lower)):
        run = case.flown(lower[b] + (upper[b] - lower[b]) * rng.integers(0, 2, N))
        for n, t in enumerate(case.times):
            first, last = pieces_between(grid, t, t)
            for name, c in itertools.product(found, range(3)):
                x, value = found[name][c], getattr(run, name)[n, c]
                for piece in {first, last}:
                    assert x.lo[0, b, piece] - ERROR <= value, (name, c, t)
                    assert value <= x.hi[0, b, piece] + ERROR, (name, c, t)


@each_case
def test_enclosures_hold_derivatives(case):
    s, h = np.full(N, 0.3), 1e-3
    grid = make_grid(case.problem, 12, 4)
    found = enclosed(case.problem, grid, s[None] - h, s[None] + h, range(N))
    for i in map(case.box.names.index, case.looked_at):
        step = h * (np.arange(N) == i)
        ahead, behind = case.flown(s + step), case.flown(s - step)
        for n, t in enumerate(case.times[::8]):
            piece = pieces_between(grid, t, t)[0]
            for name, c in itertools.product(found, range(3)):
                x = found[name][c]
                ends = (getattr(run, name)[8 * n, c] for run in (ahead, behind))
                slope = np.subtract(*ends) / (2.0 * h)
                # By the mean value theorem it is a derivative in between.
                assert x.lo[1 + i, 0, piece] - ERROR / h <= slope, (name, c, i, t)
                assert slope <= x.hi[1 + i, 0, piece] + ERROR / h, (name, c, i, t)


@each_case
def test_enclosures_of_points_close_with_the_pieces_of_time(case):
    s = np.zeros((1, N))
    run = case.flown(s[0])
    coarse, fine = (
        enclosed(case.problem, make_grid(case.problem, push, push // 4), s, s)
        for push in (12, 48)
    )
    for name, c in itertools.product(fine, range(3)):
        widths = [(x.hi - x.lo)[0, 0, -1] for x in (coarse[name][c], fine[name][c])]
        assert widths[1] < 0.3 * widths[0]  # of first order: a quarter
        middle = 0.5 * (fine[name][c].hi + fine[name][c].lo)[0, 0, -1]
        assert abs(middle - getattr(run, name)[-1, c]) < 0.5 * widths[1]


FREE = free_bodies.separation()
FREE = dataclasses.replace(
    FREE,
    attachments=tuple(
        dataclasses.replace(a, release_time=0.0) for a in FREE.attachments
    ),
)
FREE_PROBLEM = problem_of(FREE, ToleranceBox.around(FREE, {}))
ASKED = (
    *(f"{name}_at_0.8_s" for name in ("rate_modulus", "spin_rate_value")),
    *(f"{name}_at_0.8_s" for name in ("transverse_rate", "speed")),
    *(f"{name}_at_0.8_s" for name in ("longitudinal_speed", "lateral_speed")),
    *(f"{name}_at_0.8_s" for name in ("longitudinal_displacement", "displacement")),
    *(f"angle_at_0.8_s_{axis}" for axis in ("roll", "pitch", "yaw")),
    *(f"rate_value_at_0.8_s_{axis}" for axis in "xyz"),
    *(f"relative_rate_value_at_0.8_s_{axis}" for axis in "xyz"),
)


@pytest.mark.parametrize("name", ASKED)
def test_quantities_of_free_tops_are_held(name):
    """In a stack of turned bodies, about a generic direction: every field and law."""
    grid = make_grid(FREE_PROBLEM, 0, 60, [0.8])
    prover = Prover(FREE_PROBLEM, grid)
    point = np.zeros((1, 0))
    stem, _, axis = name.partition("_at_0.8_s")
    exact = free_bodies.signals(np.array([0.8]))[stem.removesuffix("_value")][0]
    value = exact["xyz".find(axis[1:])] if axis[1:] in "xyz" and axis else exact[0]
    if stem == "angle":
        value = exact[("roll", "pitch", "yaw").index(axis[1:])]
    ends = {}
    for side in ("highest", "lowest"):
        claim = claim_of(FREE, FREE_PROBLEM, grid, name, side)
        look = prover.look(claim.quantity, point, point, np.zeros(0, dtype=bool))
        assert look.proven.all()
        ends[side] = claim.value(float(look.options.value.hi.max()))
    # Closed forms err by round-off; enclosures, of values up to 0.5, by how much these
    # change in pieces of 13 ms, at half a radian a second.
    assert ends["lowest"] - 1e-12 <= value <= ends["highest"] + 1e-12
    assert ends["highest"] - ends["lowest"] < 0.05
