"""An independent simulation of two bodies that let go at t = 0.

Written against the paper, not against drakesep: the states are those of the CGs,
rotations are scipy's, the plain inverse-square field is differenced, and scipy's
DOP853 integrates, up to the end of the last stroke and on from there.
"""

import itertools
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from drakesep.systems.model.separation import Body, Separation
from drakesep.systems.model.springs import Spring


_PARTS = [3, 6, 10, 13, 16, 19, 23, 26, 29]


class LabelledRun(NamedTuple):
    time: np.ndarray
    rate: np.ndarray
    relative_rate: np.ndarray
    angle: np.ndarray
    relative_velocity: np.ndarray
    linear_momentum_change: np.ndarray
    angular_momentum_change: np.ndarray


def fly(separation: Separation, times: np.ndarray) -> LabelledRun:
    A, B = (separation.body(name) for name in (separation.A, separation.B))
    y = _integrate(separation, A, B, times)
    x_A, v_A, q_A, w_A, x_B, v_B, q_B, w_B, p, L = np.split(y, _PARTS, 1)
    R_A, R_B = Rotation.from_quat(q_A), Rotation.from_quat(q_B)
    w_A_W = R_A.apply(w_A)
    seen_from_A = v_B - v_A - np.cross(w_A_W, x_B - x_A)
    return LabelledRun(
        times,
        w_B,
        w_B - R_B.apply(w_A_W, inverse=True),
        R_B.as_euler("xyz"),
        R_A.apply(seen_from_A, inverse=True),
        p,
        L,
    )


def _integrate(
    separation: Separation, A: Body, B: Body, times: np.ndarray
) -> np.ndarray:
    springs = [a.spring for a in separation.attachments]
    F, L, m = (
        np.array([getattr(s, name) for s in springs])
        for name in ("force_max", "stroke", "design_mass")
    )
    w = np.sqrt(F / (m * L))
    ends = np.arccos([s.lost_stroke for s in springs]) / w
    axes = [_axis(s) for s in springs]
    pads = np.array([a.p_AoPad_A for a in separation.attachments])
    R_AB = Rotation.from_euler("xyz", B.rpy_AB)
    R_AB = R_AB * Rotation.from_euler("xyz", B.mated_misalignment)
    p_ABo = np.array(B.p_ABo) + B.mated_offset
    pads_B = R_AB.apply(pads - p_ABo, inverse=True)
    c_A, c_B = np.array(A.p_BoBcm_B), np.array(B.p_BoBcm_B)
    I_A, I_B = _matrix(A), _matrix(B)
    orbit = separation.orbit
    assert orbit is None or orbit.horizontal_speed is None  # a circle

    def gravity(t, x, R, inertia):
        if orbit is None:
            return np.zeros(3), np.zeros(3)
        angle = t * np.sqrt(orbit.mu / orbit.radius**3)
        origin = orbit.radius * np.array([np.sin(angle), 0.0, -np.cos(angle)])
        r = origin + x
        distance = np.linalg.norm(r)
        field = -orbit.mu * (r / distance**3 - origin / orbit.radius**3)
        r_body = R.T @ r
        return field, 3 * orbit.mu / distance**5 * np.cross(r_body, inertia @ r_body)

    def derivative(t, y, pushing):
        x_A, v_A, q_A, w_A, x_B, v_B, q_B, w_B, _, _ = np.split(y, _PARTS)
        R_A = Rotation.from_quat(q_A).as_matrix()
        R_B = Rotation.from_quat(q_B).as_matrix()
        a_A, T_A = gravity(t, x_A, R_A, I_A)
        a_B, T_B = gravity(t, x_B, R_B, I_B)
        dp, dL = np.zeros(3), np.zeros(3)
        for i in pushing:
            force = F[i] * np.cos(w[i] * t) * R_A @ axes[i]
            pad = x_B + R_B @ (pads_B[i] - c_B)
            a_A, a_B = a_A - force / A.mass, a_B + force / B.mass
            T_A = T_A + R_A.T @ np.cross(pad - x_A, -force)
            T_B = T_B + R_B.T @ np.cross(pad - x_B, force)
            dp = dp + R_B.T @ force
            dL = dL + np.cross(pads_B[i] - c_B, R_B.T @ force)
        dw_A = np.linalg.solve(I_A, T_A - np.cross(w_A, I_A @ w_A))
        dw_B = np.linalg.solve(I_B, T_B - np.cross(w_B, I_B @ w_B))
        return np.concatenate(
            [v_A, a_A, _qdot(q_A, w_A), dw_A, v_B, a_B, _qdot(q_B, w_B), dw_B, dp, dL]
        )

    R0 = Rotation.from_euler("xyz", separation.initial.rpy_WA)
    rate = np.array(separation.initial.w_WA_A)
    cg_B = p_ABo + R_AB.apply(c_B)  # in A
    spin = B.spin * np.array(separation.attachments[0].joint.x_axis_A)
    v_B = np.cross(rate, cg_B - c_A) + np.cross(spin, cg_B - pads[0])
    w_B = R_AB.apply(rate + spin, inverse=True)
    x_A, x_B, v_B = (R0.apply(x) for x in (c_A, cg_B, v_B))
    q_A, q_B = R0.as_quat(), (R0 * R_AB).as_quat()
    y = np.concatenate([x_A, np.zeros(3), q_A, rate, x_B, v_B, q_B, w_B, np.zeros(6)])
    # Each end of a push is a kink or a jump: a new start for the integrator.
    stops = [0.0, *sorted(set(ends)), times[-1]]
    rows = []
    for t0, t1 in itertools.pairwise(stops):
        inside = times[(times >= t0) & (times < t1)]
        solution = solve_ivp(
            derivative,
            (t0, t1),
            y,
            args=(np.flatnonzero(ends > t0),),
            method="DOP853",
            rtol=1e-12,
            atol=1e-14,
            t_eval=np.append(inside, t1),
        )
        rows.append(solution.y.T[:-1])
        y = solution.y[:, -1]
    return np.concatenate([*rows, y[None]])


def _axis(spring: Spring) -> np.ndarray:
    """The axis in A, its design turned about y and z where x is turned into it."""
    x, design = np.array([1.0, 0.0, 0.0]), np.array(spring.axis_A)
    normal = np.cross(x, design)
    sine = np.linalg.norm(normal)
    turn = normal / sine * np.arctan2(sine, x @ design) if sine else np.zeros(3)
    tilt = Rotation.from_euler("yz", [spring.tilt_y, spring.tilt_z])
    return Rotation.from_rotvec(turn).apply(tilt.apply(x))


def _matrix(body: Body) -> np.ndarray:
    xx, yy, zz, xy, xz, yz = body.I_BBcm_B
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _qdot(q, w):
    # scipy's order: x, y, z, w
    return 0.5 * np.append(q[3] * w + np.cross(q[:3], w), -q[:3] @ w)
