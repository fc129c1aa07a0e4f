"""Intervals hold what they stand for: against Arb balls, of a thousand bits."""

import flint
import numpy as np
import pytest
from flint import arb

from drakesep.analysis.bounds import intervals
from drakesep.analysis.bounds.intervals import Interval, down, up
from drakesep.analysis.bounds.jets import Jet, integrals


@pytest.fixture(autouse=True)
def precise():
    """Arb's precision is the process's: whoever uses it says it."""
    with flint.ctx.workprec(1000):
        yield


RNG = np.random.default_rng(1)
SIZES = np.concatenate([[0.0], 10.0 ** RNG.uniform(-140, 140, 60)])
NUMBERS = np.concatenate([SIZES, -SIZES, RNG.uniform(-2.0, 2.0, 80)])


def holds(found: Interval, exact) -> bool:
    return all(
        arb(lo) <= value <= arb(hi)
        for lo, hi, value in zip(found.lo, found.hi, exact, strict=True)
    )


def test_a_step_outward_is_beyond_the_next_double():
    tiny = np.array([0.0, 5e-324, -5e-324, 1e-310, -1e-305])
    x = np.concatenate([NUMBERS, tiny, np.nextafter(2.0 ** np.arange(-9, 9), 0.0)])
    assert (down(x) <= np.nextafter(x, -np.inf)).all()
    assert (up(x) >= np.nextafter(x, np.inf)).all()


OPERATIONS = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
}


@pytest.mark.parametrize("name", OPERATIONS)
def test_operations_hold_the_exact_result(name):
    operation = OPERATIONS[name]
    a, b = RNG.choice(NUMBERS, 400), RNG.choice(NUMBERS[NUMBERS != 0.0], 400)
    exact = [operation(arb(x), arb(y)) for x, y in zip(a, b, strict=True)]
    assert holds(operation(Interval(a), Interval(b)), exact)


def test_wide_intervals_hold_every_product():
    ends = RNG.uniform(-1.0, 1.0, (4, 200))
    a = Interval(np.minimum(*ends[:2]), np.maximum(*ends[:2]))
    b = Interval(np.minimum(*ends[2:]), np.maximum(*ends[2:]))
    for share in RNG.uniform(0.0, 1.0, (20, 2)):
        x = a.lo + share[0] * (a.hi - a.lo)
        y = b.lo + share[1] * (b.hi - b.lo)
        x, y = np.clip(x, a.lo, a.hi), np.clip(y, b.lo, b.hi)
        exact = [arb(p) * arb(q) for p, q in zip(x, y, strict=True)]
        assert holds(a * b, exact)
        assert holds(a.square(), [arb(p) * arb(p) for p in x])
        assert holds(a.abs(), [abs(arb(p)) for p in x])


def test_elementary_functions_hold_the_exact_result():
    x = np.concatenate([[0.0, np.pi / 2, 1e-100], RNG.uniform(0.0, np.pi / 2, 300)])
    assert holds(intervals.sin(Interval(x)), [arb(v).sin() for v in x])
    assert holds(intervals.cos(Interval(x)), [arb(v).cos() for v in x])
    assert holds(Interval(x).sqrt(), [arb(v).sqrt() for v in x])
    y = RNG.uniform(-1.0, 1.0, len(x))
    assert holds(intervals.arcsin(Interval(y)), [arb(v).asin() for v in y])
    right = x + 1e-3
    exact = [arb.atan2(arb(b), arb(a)) for a, b in zip(right, y, strict=True)]
    assert holds(intervals.arctan2(Interval(y), Interval(right)), exact)


def test_half_pi_is_held():
    assert arb(float(intervals.HALF_PI.lo)) < arb.pi() / 2
    assert arb(float(intervals.HALF_PI.hi)) > arb.pi() / 2


def test_what_may_divide_by_zero_is_not_a_number():
    assert np.isnan(Interval(np.array([-1.0]), np.array([1.0])).inverse().hi).all()


def test_integrals_hold_the_exact_sums():
    lengths = RNG.uniform(0.0, 0.1, 50)
    x = RNG.uniform(-1.0, 1.0, (1, 1, 50))
    found = integrals(Jet(x, x), lengths)
    total = arb(0)
    for n, (value, length) in enumerate(zip(x[0, 0], lengths, strict=True)):
        for part in (0.0, 0.3, 1.0):
            there = total + arb(value) * arb(length) * arb(part)
            assert arb(found.lo[0, 0, n]) <= there <= arb(found.hi[0, 0, n])
        total += arb(value) * arb(length)


def test_a_product_of_jets_holds_the_exact_derivatives():
    a, b = RNG.uniform(-1.0, 1.0, (2, 4, 1, 9))
    found = Jet(a, a) * Jet(b, b)
    for i in range(1, 4):
        exact = [
            arb(p) * arb(y) + arb(x) * arb(q)
            for x, y, p, q in zip(a[0, 0], b[0, 0], a[i, 0], b[i, 0], strict=True)
        ]
        assert holds(Interval(found.lo[i, 0], found.hi[i, 0]), exact)
