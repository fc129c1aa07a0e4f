"""A spring with a damper whose pad lifts off and is met again, in both engines.

Two bodies on one axis: B's pad is pushed with F (1 - s / L) - D s' while that is above
zero. A load hurries B away faster than the spring follows, and another holds it back:
the pad lifts off, and is met. Each phase has a solution of its own, two exponentials
or a parabola; where one ends is a root of it.
"""

import dataclasses
import math

import numpy as np
import pytest
from scipy.optimize import brentq
from separations import coaxial, generic_pair

from drakesep.analysis.engines.jax.batch import Batch
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.loads import Load
from drakesep.systems.model.run import RunStatus
from drakesep.systems.model.springs import DisplacementSpring
from drakesep.systems.simulation.simulation import Simulation


FORCE, STROKE, DAMPING = 900.0, 0.2, 2200.0
LOADS = ((0.0, 0.15, 2500.0), (0.15, 0.25, -3000.0))
"""On B: from when to when, s, and how much, N."""
DURATION = 1.2


def separation(damping=DAMPING):
    """One spring on the axis of both bodies, and the load."""
    pair = coaxial(generic_pair())
    [attachment, *_] = pair.attachments
    spring = DisplacementSpring(
        name="spring", force_max=FORCE, stroke=STROKE, damping=damping
    )
    attachment = dataclasses.replace(
        attachment, p_AoPad_A=(0.0, 0.0, 0.0), spring=spring
    )
    loads = tuple(
        Load(
            name=f"load_{i}",
            body="upper",
            p_BoQ_B=pair.body("upper").p_BoBcm_B,
            times=(start, end),
            forces=((force, 0.0, 0.0),) * 2,
        )
        for i, (start, end, force) in enumerate(LOADS)
    )
    return dataclasses.replace(
        pair, attachments=(attachment,), loads=loads, duration=DURATION
    )


class Phases:
    """Displacement and speed of the pad over time, phase by phase in closed form."""

    def __init__(self, damping=DAMPING):
        lower, upper = (body.mass for body in separation().bodies)
        self._lightness = 1.0 / lower + 1.0 / upper
        self._upper, self._damping = upper, damping
        self.events = []
        """Times at which the pad lifts off, is met, or the stroke ends, s."""
        self._pieces = []
        t, y = 0.0, np.zeros(2)
        pushing, spent = True, False
        while t < DURATION:
            end = min([stop for _, stop, _ in LOADS if stop > t], default=DURATION)
            move = self._motion(t, y, pushing)
            crossings = [] if spent else [lambda y: y[0] - STROKE, self._force]
            first, which = end, None
            for k, quantity in enumerate(crossings):
                found = self._first(lambda x, q=quantity, m=move: q(m(x)), t, end)
                if found < first:
                    first, which = found, k
            self._pieces.append((t, first, move))
            t, y = first, move(first)
            if which is not None:
                self.events.append(t)
                spent = spent or which == 0
                pushing = not spent and not pushing

    def _force(self, y):
        return FORCE * (1.0 - y[0] / STROKE) - self._damping * y[1]

    def _motion(self, t0, y0, pushing):
        """(2, ...) displacement and speed at times (...), of x'' = k (X - x) - d x'."""
        x0, v0 = y0
        a = sum(f for t, stop, f in LOADS if t <= t0 < stop) / self._upper
        if not pushing:
            return lambda t: np.array(
                [x0 + (t - t0) * (v0 + 0.5 * a * (t - t0)), v0 + a * (t - t0)]
            )
        k, d = self._lightness * FORCE / STROKE, self._lightness * self._damping
        X = STROKE + a / k
        root = np.sqrt(complex(0.25 * d * d - k))
        r1, r2 = -0.5 * d + root, -0.5 * d - root
        c1 = (v0 - r2 * (x0 - X)) / (r1 - r2)
        c2 = x0 - X - c1

        def move(t):
            e1, e2 = c1 * np.exp(r1 * (t - t0)), c2 * np.exp(r2 * (t - t0))
            return np.array([X + (e1 + e2).real, (r1 * e1 + r2 * e2).real])

        return move

    def _first(self, quantity, t, end):
        """The first root after a time, of a quantity that may begin at zero there."""
        grid = np.linspace(t, end, 1000)[1:]
        values = quantity(grid)
        turned = np.flatnonzero(values[:-1] * values[1:] < 0.0)
        if not len(turned):
            return math.inf
        return brentq(quantity, *grid[turned[0] : turned[0] + 2], xtol=1e-14)

    def at(self, times):
        """(n, 2) displacement, m, and speed, m/s."""
        return np.array(
            [next(m for a, b, m in reversed(self._pieces) if a <= t)(t) for t in times]
        )


def test_the_pad_lifts_off_and_is_met_before_the_stroke_ends():
    """Once held back no more, it is off again: the damper is too strong to follow."""
    off, met, off_again, end = Phases().events
    assert 0.0 < off < LOADS[1][0] < met < LOADS[1][1] < off_again < end < DURATION
    assert Phases().at([end])[0, 0] == pytest.approx(STROKE, abs=1e-12)
    # In between it moves by centimetres, which a spring that pulled would not allow.
    assert np.ptp(Phases().at([off, met])[:, 0]) > 0.03


def check(run, phases):
    assert run.status is RunStatus.COMPLETED, run.message
    *_, end = phases.events
    assert run.stroke_ends["spring"] == pytest.approx(end, abs=1e-8)
    motion = run.motion
    expected = phases.at(motion.time)
    # What both engines promise; samples between are cubics of Drake's steps.
    assert motion.relative_position[:, 0] == pytest.approx(expected[:, 0], abs=2e-8)
    assert motion.relative_velocity[:, 0] == pytest.approx(expected[:, 1], abs=2e-7)
    # The impulse that the spring has given: no pull is in it.
    force = phases._force(expected.T)
    assert np.diff(motion.linear_momentum_change[:, 0]).min() > -1e-6
    pushes = np.maximum(force, 0.0) * (motion.time < end)
    impulse = np.trapezoid(pushes, motion.time)
    # Of a trapezoid over some hundred samples with two kinks.
    assert motion.linear_momentum_change[-1, 0] == pytest.approx(impulse, rel=2e-3)


def test_drake():
    run = Simulation(separation(), Integration(accuracy=1e-10)).run()
    check(run, Phases())


@pytest.fixture(scope="module")
def batch():
    return Batch(separation(), ["spring.damping"], tolerance=1e-9, chunk=2)


def test_batch(batch):
    """And another damper, beside it, which lifts off at another time."""
    dampings = [DAMPING, 1800.0]
    for run, damping in zip(batch.runs([[d] for d in dampings]), dampings, strict=True):
        check(run, Phases(damping))


@pytest.mark.slow
def test_what_the_damper_does_to_the_end_of_the_stroke(batch):
    """Its slope, through four events whose times all move, by differences."""
    step = 1.0
    after, before = (Phases(DAMPING + d).events[-1] for d in (step, -step))
    slope = (after - before) / (2.0 * step)
    result = batch.jacobian([[DAMPING]])
    column = list(result.metrics).index("separation_end")
    # Of differences over a two-thousandth of the damping: its square.
    assert result.jacobian[0, column, 0] == pytest.approx(slope, rel=1e-5)
