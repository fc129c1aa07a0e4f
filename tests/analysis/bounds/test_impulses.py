"""Impulses of Eq. 5 and their derivatives are held, against Arb and differences."""

import flint
import numpy as np
import pytest
from flint import arb

from drakesep.analysis.bounds.impulses import Law, impulse, summed_impulse
from drakesep.analysis.bounds.intervals import Interval


@pytest.fixture(autouse=True)
def precise():
    """Arb's precision is the process's: whoever uses it says it."""
    with flint.ctx.workprec(300):
        yield


RNG = np.random.default_rng(2)
F, L, M = 1485.0, 0.121, 133.6
NOT_STUCK = (0.0, 0.0)


def exact(F, L, m, lost, t) -> arb:
    """The impulse: sqrt(F m L) sin(min(w t, arccos lost)), w = sqrt(F / (m L))."""
    phase = (F / (m * L)).sqrt() * t
    end = lost.acos()
    return (F * m * L).sqrt() * (phase if phase < end else end).sin()


def law(*ends: tuple[float, float]) -> Law:
    return Law(*(Interval(np.array([[a]]), np.array([[b]])) for a, b in ends))


@pytest.mark.parametrize("lost", [0.0, 0.1, 0.3, 0.8])
def test_an_impulse_is_held_with_its_derivatives(lost):
    step = arb(2) ** -60
    for _ in range(60):
        shares = RNG.uniform(0.97, 1.03, (4, 2))
        shares.sort(axis=1)
        numbers = (F, L, M, lost)
        ends = [(v * a, v * b) for v, (a, b) in zip(numbers, shares, strict=True)]
        times = np.sort(RNG.uniform(0.0, 0.2, 2))
        found = impulse(law(*ends), Interval(times[:1], times[1:]))
        x = [arb(RNG.uniform(*end)) for end in ends]
        t = arb(RNG.uniform(*times))
        value = exact(*x, t)
        assert arb(found.value.lo[0, 0]) <= value <= arb(found.value.hi[0, 0])
        for i, by in enumerate(found.by if lost else found.by[:3]):
            moved = [
                [v + k * step * (i == j) for j, v in enumerate(x)] for k in (1, -1)
            ]
            slope = (exact(*moved[0], t) - exact(*moved[1], t)) / (2 * step)
            # The difference errs by step^2, and by step where the stroke ends; across
            # the kink of a stuck spring it is between the derivatives of both sides.
            assert arb(by.lo[0, 0]) - 1e-12 <= slope <= arb(by.hi[0, 0]) + 1e-12


def test_a_point_is_held_sharply():
    found = impulse(law((F, F), (L, L), (M, M), NOT_STUCK), Interval(np.array([0.1])))
    for part in (found.value, *found.by):
        width = part.hi - part.lo
        assert (width <= 5e-14 * np.abs(part.hi)).all()  # some tens of roundings


@pytest.mark.parametrize("lost", [0.0, 0.4])
def test_the_integral_of_an_impulse_is_held(lost):
    times = np.linspace(0.0, 0.3, 31)
    found = summed_impulse(law((F, F), (L, L), (M, M), (lost, lost)), times)
    for n, t in enumerate(times):
        fine = np.linspace(0.0, t, 4001)
        phase = np.minimum(np.sqrt(F / (M * L)) * fine, np.arccos(lost))
        area = np.trapezoid(np.sqrt(F * L * M) * np.sin(phase), fine)
        assert abs(found.lo[0, n] - area) < 1e-6  # the trapezoids' own error
        assert 0.0 <= found.hi[0, n] - found.lo[0, n] < 1e-12
