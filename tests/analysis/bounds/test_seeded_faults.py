"""Faults seeded into the prover: the checker refuses what it then certifies.

VEGA's rate about x over three parameters, by a tree that cuts and collapses boxes; and
the speed of two bodies that a spring pushes through their CGs, to round-off. Faults in
certificates are seeded in roof/test_check_proof.py.
"""

import dataclasses
import math

import pytest
from separations import generic_pair, pushed_on_axis, vega

from drakesep.analysis import AnalysisCase
from drakesep.analysis.bounds import branch_and_bound, intervals
from drakesep.analysis.bounds.box import Boxes
from drakesep.analysis.bounds.certificate import certificate
from drakesep.analysis.bounds.intervals import Interval
from drakesep.analysis.bounds.jets import Affine
from drakesep.analysis.bounds.motion import Enclosure
from drakesep.analysis.bounds.proving import ProofSettings, prove_bounds
from drakesep.check_proof.certificate import certificate as as_read
from drakesep.check_proof.checking import outcomes
from drakesep.systems.model.separation import InitialMotion


SETTINGS = ProofSettings(gap=0.002, seconds=20.0, push=16, coast=2)
OF_VEGA = AnalysisCase(
    separation=dataclasses.replace(vega(), duration=0.3, orbit=None),
    tolerances={
        "payload.cg_y": 0.026,
        "payload.inertia_xy": 130.0,
        "payload.inertia_xz": 130.0,
    },
)
RATE = ("rate_at_end_x", "highest")
LEFT_OUT = 1
"""The axis that is left out: the rate about x comes of products of inertia."""


def certified(case, asked, settings):
    """The bound that is claimed, and the certificate of it, as it is read."""
    bounds = prove_bounds(case, [asked], settings)
    [(name, bound)] = bounds.proven.items()
    assert bounds.problem is not None and bounds.grid is not None
    record = certificate(bounds.problem, bounds.grid, {name: bound.proof})
    return bound.proof.bound, record


def failure(record) -> str:
    """Why the checker refuses a certificate; empty: it is verified."""
    [outcome] = outcomes(as_read(record), [0])
    return outcome.failure or ""


def kinds(record) -> set[str]:
    return {node[0] for node in record["claims"][0]["tree"]}


@pytest.fixture(scope="module")
def sound():
    """The bound without a fault."""
    bound, record = certified(OF_VEGA, RATE, SETTINGS)
    assert kinds(record) >= {"leaf", "collapse", "cut"}
    assert failure(record) == ""
    return bound


def halved(x):
    middle, half = 0.5 * (x.lo + x.hi), 0.25 * (x.hi - x.lo)
    return type(x)(middle - half, middle + half)


def enclosure_halved(patch):
    """Rates, with their derivatives, over every box."""
    enclosed = Enclosure.rates

    def narrow(enclosure, state):
        return [[halved(x) for x in rate] for rate in enclosed(enclosure, state)]

    patch.setattr(Enclosure, "rates", narrow)


def axis_lost_of_the_box(patch):
    """The tree is of a box in which one parameter is as it is nominally."""
    whole = branch_and_bound.whole_box

    def flat(problem):
        box = whole(problem)
        lower, upper = box.lower.copy(), box.upper.copy()
        lower[:, LEFT_OUT] = upper[:, LEFT_OUT] = 0.0
        return Boxes(problem, lower, upper)

    patch.setattr(branch_and_bound, "whole_box", flat)


def axis_lost_of_derivatives(patch):
    """The parameter varies, and is nobody's derivative."""
    affine = Boxes.affine

    def flat(boxes, number):
        found = affine(boxes, number)
        left_out = number.parameter == LEFT_OUT
        return Affine(found.value, {}) if left_out else found

    patch.setattr(Boxes, "affine", flat)


def box_forgotten(patch):
    """The upper half of each box that is cut is never looked at."""
    cut, search = branch_and_bound._Search._cut, branch_and_bound._Search

    def half(mine, node, effect):
        cut(mine, node, effect)
        mine._queue = [e for e in mine._queue if e[2] is not node.children[1]]

    patch.setattr(search, "_cut", half)


def box_left_out_of_the_tree(patch):
    cut, search = branch_and_bound._Search._cut, branch_and_bound._Search

    def half(mine, node, effect):
        cut(mine, node, effect)
        lost = node.children.pop()
        mine._queue = [e for e in mine._queue if e[2] is not lost]

    patch.setattr(search, "_cut", half)


def sign_taken_for_constant(patch):
    hull = branch_and_bound._hull

    def middle(slopes, live):
        found = hull(slopes, live)
        return Interval(0.5 * (found.lo + found.hi))

    patch.setattr(branch_and_bound, "_hull", middle)


ABOVE, NO_SIGN = "its bound is", "the quantity may not grow"
FAULTS = {
    enclosure_halved: ABOVE,
    axis_lost_of_the_box: ABOVE,
    axis_lost_of_derivatives: ABOVE,
    box_forgotten: ABOVE,
    box_left_out_of_the_tree: "a node is missing",
    sign_taken_for_constant: NO_SIGN,
}


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.__name__)
def test_a_fault_of_the_prover_is_refused(fault, sound, monkeypatch):
    with monkeypatch.context() as patch:
        fault(patch)
        bound, record = certified(OF_VEGA, RATE, SETTINGS)
    why = failure(record)
    assert FAULTS[fault] in why, (why, bound / sound - 1.0)


@pytest.mark.parametrize("outward", [1.0, -1000.0])
def test_rounding_inward_is_refused(outward, monkeypatch):
    """With nothing to spare, a claim is told from a false one at its last digits.

    A thousand units inward, since entries of rotations, which no double is, are widened
    by a few in the checker. A millionth to spare, as claims have, hides them all.
    """
    pair = pushed_on_axis(generic_pair(initial=InitialMotion()))
    tolerances = {"spring_1.force_max": 60.0, "upper.mass": 50.0}
    case = AnalysisCase(separation=pair, tolerances=tolerances)
    step, settings = intervals._step, ProofSettings(gap=1e-15, push=4, coast=2)
    with monkeypatch.context() as patch:
        patch.setattr(branch_and_bound, "SLACK", 0.0)
        patch.setattr(intervals, "_step", lambda *of: outward * step(*of))
        asked = ("longitudinal_speed_at_end", "highest")
        bound, record = certified(case, asked, settings)
    exact = math.sqrt(1260.0 * 0.1 * 110.0) * (1.0 / 1150.0 + 1.0 / 700.0)
    # Ten operations or so, of which each is a thousand units off.
    assert bound == pytest.approx(exact, rel=1e-11)
    why = failure(record)
    refused = "is not reached at its point" in why or ABOVE in why
    assert refused == (outward < 0.0), why
