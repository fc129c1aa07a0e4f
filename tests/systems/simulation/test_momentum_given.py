"""The momentum that springs give, summed after a run (Eq. 6 and 7)."""

import dataclasses
import itertools
import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from separations import FREE, GENERIC, by_displacement, coaxial, generic_pair

from drakesep.systems.model.integration import Integration
from drakesep.systems.model.run import Run
from drakesep.systems.model.separation import Attachment, Body, Pair, Separation
from drakesep.systems.simulation.simulation import Simulation
from drakesep.systems.vectors import rotation_matrix


TABLE = ((0.0, 0.7), (0.1, 1.0), (0.6, 0.4), (1.0, 0.2))
STAGED = (0.0, 0.03, 0.031, 0.2)


def test_impulse_of_equation_5():
    """The area below a quarter of a cosine is F / w, of every spring."""
    separation = coaxial(generic_pair(release_times=(0.04,) * 4))
    run = Simulation(separation).run()
    impulse = sum(
        math.sqrt(s.force_max * s.design_mass * s.stroke) for s in separation.springs
    )
    given = run.motion.linear_momentum_change[-1]
    # Gauss's quadrature of a cosine, in 64 intervals and more: to round-off. Across, by
    # what B turns while joints hold it: a stack at rest, to the integration's 1e-7 rad.
    assert given == pytest.approx([impulse, 0.0, 0.0], rel=1e-12, abs=1e-7 * impulse)


@pytest.mark.parametrize("law", ["time", "linear", "table", "damped"])
def test_momentum_given_is_that_which_bodies_have(law):
    """In B's turning axes, where d p / dt = F - w x p: for all springs on a body.

    Of three bodies the middle one is pushed from one side, and pushes on the other.
    """
    options = {
        "linear": {},
        "table": {"profile": TABLE},
        # So much that springs lift off.
        "damped": {"profile": TABLE, "damping": 3000.0},
    }
    separation = chain()
    if law != "time":
        separation = by_displacement(separation, **options[law])
    run = Simulation(separation, Integration(accuracy=1e-8)).run()
    for name in ("middle", "upper"):
        motion = run.motion_of(name)
        given = np.hstack(
            [motion.linear_momentum_change, motion.angular_momentum_change]
        )
        # 1e-8 m/s and rad/s a step, of a ton and a ton m^2, in 200 steps; splines
        # through the samples integrate the turning to less.
        assert given == pytest.approx(gained(run, name), abs=1e-4)
        assert np.abs(given).max() > 50.0


def chain() -> Separation:
    """Three free bodies in a row that turn, springs between them, in stages."""
    pair = generic_pair(
        release_times=STAGED,
        joint=FREE,
        initial=dataclasses.replace(GENERIC, w_WA_A=(0.4, -0.3, 0.5)),
    )
    lower, middle = (
        dataclasses.replace(body, name=name)
        for body, name in zip(pair.bodies, ("lower", "middle"), strict=True)
    )
    upper = dataclasses.replace(
        lower, name="upper", p_ABo=(2.0, 0.1, -0.1), p_BoBcm_B=(0.5, 0.1, 0.0)
    )
    first = [dataclasses.replace(a, B="middle") for a in pair.attachments]
    second = [_between_upper(a) for a in first]
    return dataclasses.replace(
        pair,
        bodies=(lower, middle, upper),
        attachments=(*first, *second),
        A="lower",
        B="middle",
        others=(Pair(A="middle", B="upper"),),
    )


def _between_upper(attachment: Attachment) -> Attachment:
    spring = attachment.spring
    return dataclasses.replace(
        attachment,
        name=f"{attachment.name}_above",
        A="middle",
        B="upper",
        p_AoPad_A=(2.0, *attachment.p_AoPad_A[1:]),
        spring=dataclasses.replace(spring, name=f"{spring.name}_above", tilt_y=0.2),
        release_time=attachment.release_time + 0.05,
    )


def gained(run: Run, name: str) -> np.ndarray:
    """(n, 6): what a body's momenta in its axes have gained, but for its turning."""
    body = run.separation.body(name)
    states = run.completed_trajectory.of(name)
    R = np.array([rotation_matrix(tuple(q)) for q in states[:, :4]]).reshape(-1, 3, 3)
    w, v = (np.einsum("nij,ni->nj", R, states[:, i : i + 3]) for i in (7, 10))
    p = body.mass * (v + np.cross(w, body.p_BoBcm_B))
    L = w @ inertia(body)
    momenta = np.hstack([p, L])
    turning = np.hstack([np.cross(w, p), np.cross(w, L)])
    return momenta - momenta[0] + integral(run, turning)


def integral(run: Run, rates: np.ndarray) -> np.ndarray:
    """By a spline between each two kinks: the springs' profiles have theirs besides."""
    t = run.completed_trajectory.time
    total = np.zeros_like(rates)
    for i, j in itertools.pairwise(np.searchsorted(t, run.breaks)):
        spline = CubicSpline(t[i : j + 1], rates[i : j + 1]).antiderivative()
        total[i : j + 1] = total[i] + spline(t[i : j + 1])
    return total


def inertia(body: Body) -> np.ndarray:
    xx, yy, zz, xy, xz, yz = body.I_BBcm_B
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
