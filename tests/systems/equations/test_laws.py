"""The equations against closed forms and brute force."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.spatial.transform import Rotation

from drakesep.systems import vectors
from drakesep.systems.equations import gravity as gravity_laws
from drakesep.systems.equations import joints as joint_laws
from drakesep.systems.equations import relative_motion as motion_laws
from drakesep.systems.equations.pushers import push_wrenches, time_to_go
from drakesep.systems.equations.springs import law_of
from drakesep.systems.model.orbit import EARTH_MU
from drakesep.systems.model.springs import Spring


RADIUS = 7.078137e6


def state(rng):
    """A body in generic motion."""
    q = rng.normal(size=4)
    return motion_laws.BodyState(
        tuple(q),
        vectors.rotation_matrix(tuple(q)),
        tuple(rng.normal(size=3)),
        tuple(rng.normal(size=3)),
        tuple(rng.normal(size=3)),
    )


def test_spring_impulse_and_end():
    """The force ends at zero; its impulse is F_max / w, Eq. 5's integral."""
    force_max, frequency = 1485.0, 9.58
    # Eq. 5: frequency^2 = force_max / (design_mass stroke)
    spring = Spring(
        name="s", force_max=force_max, stroke=0.1, design_mass=14850.0 / frequency**2
    )
    law = law_of(spring)
    end = law.end(spring, math)
    assert end == pytest.approx(0.5 * math.pi / frequency, rel=1e-14)

    def force(t):
        return law.force(spring, t, 0.0, (), math)

    assert force(0.0) == force_max
    assert abs(force(end)) < 1e-12 * force_max
    assert quad(force, 0.0, end)[0] == pytest.approx(force_max / frequency, rel=1e-13)


def test_springs_of_a_pair_are_the_sum_of_each():
    """Against forces at points, moments by numpy; two push along axes of their own."""
    rng = np.random.default_rng(3)
    A, B = state(rng), state(rng)
    pads = rng.normal(size=(4, 3))
    forces = rng.uniform(0.0, 1500.0, size=4)
    axes = [None, (0.0, 0.6, 0.8), None, (0.8, 0.0, -0.6)]
    on_A, on_B = push_wrenches(A, B, list(zip(forces, pads, axes, strict=True)))

    R_A, R_B = (np.reshape(body.R_WB, (3, 3)) for body in (A, B))
    points = np.array(B.p_WBo) + pads @ R_B.T
    axes_A = np.array([axis or (1.0, 0.0, 0.0) for axis in axes])
    vectors_W = forces[:, None] * (axes_A @ R_A.T)
    for body, wrench, sign in ((A, on_A, -1.0), (B, on_B, 1.0)):
        moment = np.cross(points - np.array(body.p_WBo), vectors_W).sum(axis=0)
        scale = 1e-12 * np.abs(forces).sum() * 5.0  # round-off of forces times arms
        assert wrench.force == pytest.approx(sign * vectors_W.sum(axis=0), abs=scale)
        assert wrench.torque == pytest.approx(sign * moment, abs=scale)


@given(st.floats(1e-6, 1e2), st.floats(0.0, 50.0), st.floats(-5.0, 50.0))
def test_time_until_a_way_is_gone(t, speed, acceleration):
    """Of v t + a t^2 / 2, as long as it goes that way."""
    left = speed * t + 0.5 * acceleration * t * t
    if speed + acceleration * t > 1e-3 * (speed + 1.0):  # turns back after that
        # round-off of the square root, by how much of the speed is left
        assert time_to_go(left, speed, acceleration) == pytest.approx(t, rel=1e-6)


@pytest.mark.parametrize(
    ("left", "speed", "acceleration", "time"),
    [
        (0.0, 1.0, 0.0, 0.0),
        (-0.1, 1.0, 0.0, 0.0),
        (1.0, 0.0, 0.0, math.inf),
        (1.0, -1.0, 0.0, math.inf),
        (1.0, 1.0, -0.6, math.inf),  # it turns back at 0.83
        (1.0, 0.0, 2.0, 1.0),
        (1.0, -1.0, 4.0, 1.0),  # back and forth
    ],
)
def test_a_way_that_is_gone_or_never(left, speed, acceleration, time):
    assert time_to_go(left, speed, acceleration) == time


def test_joint_feels_the_deviation_and_its_rate():
    """The deviation's rates are its time derivatives, seen from A."""
    rng = np.random.default_rng(4)
    A, B = state(rng), state(rng)
    p_A, p_B = (0.1, 0.2, 0.3), (-0.2, 0.1, 0.5)
    q_AB = vectors.quaternion((0.3, -0.2, 0.4), math)

    def moved(body, dt):
        R = Rotation.from_rotvec(dt * np.array(body.w_WB))
        w, x, y, z = body.q_WB
        x, y, z, w = (R * Rotation.from_quat([x, y, z, w])).as_quat()
        p = np.array(body.p_WBo) + dt * np.array(body.v_WBo)
        q = (w, x, y, z)
        return body._replace(
            q_WB=q, R_WB=vectors.rotation_matrix(q), p_WBo=tuple(p.tolist())
        )

    def deviations(A, B):
        pair = motion_laws.pair_state(A, B)
        turn = joint_laws.rotation_deviation(A, B, q_AB, pair.w_AB, math)
        return (
            joint_laws.translation_deviation(pair, p_A, p_B)[0],
            joint_laws.Deviation(turn.theta, turn.rate),
        )

    dt = 1e-6
    for now, before, after in zip(
        deviations(A, B),
        *(deviations(moved(A, s), moved(B, s)) for s in (-dt, dt)),
        strict=True,
    ):
        change = np.subtract(after.value, before.value) / (2 * dt)
        # central differences: dt^2 of truncation, eps / dt of round-off
        assert change == pytest.approx(now.rate, abs=1e-8)


def test_constraint_force_is_equations_3_and_4():
    force, energy = joint_laws.constraint_force(
        (1, 2, 3), (4, 5, 6), (2.0, 3.0, 0.0), (5.0, 7.0, 0.0)
    )
    assert force == (-2 - 20, -6 - 35, 0)
    assert energy == 0.5 * (2 + 12)


def test_both_bodies_feel_a_joint_at_the_same_point():
    rng = np.random.default_rng(5)
    A, B = state(rng), state(rng)
    pair = motion_laws.pair_state(A, B)
    on_A, on_B = motion_laws.wrenches_at_origin(A, pair.p_AoBo, (1, 2, 3), (4, 5, 6))
    R_A = np.reshape(A.R_WB, (3, 3))
    force, torque = R_A @ [1, 2, 3], R_A @ [4, 5, 6]
    assert on_B.force == pytest.approx(force)
    assert on_B.torque == pytest.approx(torque)
    assert on_A.force == pytest.approx(-force)
    arm = np.subtract(B.p_WBo, A.p_WBo)
    assert on_A.torque == pytest.approx(-torque - np.cross(arm, force))


nanometres = st.integers(-(10**11), 10**11).map(lambda n: n * 1e-9)


@given(d=st.tuples(nanometres, nanometres, nanometres), angle=st.floats(0.0, 6.3))
def test_differential_gravity_keeps_its_digits(d, angle):
    """Against the plain difference in 64 digits."""
    from decimal import Decimal, getcontext

    getcontext().prec = 64
    r_W = (RADIUS * math.sin(angle), 0.0, -RADIUS * math.cos(angle))
    r = [Decimal(a) + Decimal(b) for a, b in zip(r_W, d, strict=True)]

    def field(v):
        distance = sum(c * c for c in v).sqrt()
        return [-Decimal(EARTH_MU) * c / distance**3 for c in v]

    origin = field([Decimal(c) for c in r_W])
    exact = [float(a - b) for a, b in zip(field(r), origin, strict=True)]
    scale = EARTH_MU / RADIUS**3 * max(map(abs, d))
    result = gravity_laws.differential_gravity(d, r_W, EARTH_MU, math)
    assert result == pytest.approx(exact, abs=32 * np.finfo(float).eps * scale)


def test_gravity_gradient_torque_on_point_masses():
    """The torque of the field on a cloud of points, which has it to O(size / r)."""
    rng = np.random.default_rng(6)
    points = rng.normal(size=(6, 3))
    points -= points.mean(axis=0)
    r = RADIUS * np.array([0.5, -0.3, math.sqrt(1 - 0.34)])
    at = r + points
    # The field less that at the centre, which has no moment: fewer digits cancel.
    weights = np.linalg.norm(at, axis=1, keepdims=True) ** -3 - RADIUS**-3
    brute = np.cross(points, -EARTH_MU * weights * at).sum(axis=0)
    second = points.T @ points
    I = np.trace(second) * np.eye(3) - second  # noqa: E741
    entries = (I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2])
    torque = gravity_laws.gravity_gradient_torque(tuple(r), entries, EARTH_MU, math)
    # 1e-7 is size / r; the difference of cubes keeps 9 digits
    assert torque == pytest.approx(brute, abs=1e-6 * np.abs(brute).max())


def test_lanes_give_what_floats_give():
    """A trajectory's samples run through the lines that integrate."""
    rng = np.random.default_rng(7)
    x = rng.normal(size=(26, 4))
    lanes = [motion_laws.body_state(x, 0, 14), motion_laws.body_state(x, 7, 20)]
    together = motion_laws.relative_motion(*lanes, (1.0, 2.0, 3.0), (3.0, 2.0, 1.0), np)
    for k in range(4):
        column = x[:, k].tolist()
        bodies = [
            motion_laws.body_state(column, 0, 14),
            motion_laws.body_state(column, 7, 20),
        ]
        alone = motion_laws.relative_motion(
            *bodies, (1.0, 2.0, 3.0), (3.0, 2.0, 1.0), math
        )
        for lane, one in zip(together, alone, strict=True):
            assert [c[k] for c in lane] == pytest.approx(one, rel=1e-13, abs=1e-13)
