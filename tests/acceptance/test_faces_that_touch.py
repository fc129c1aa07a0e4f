"""Contact over lines and faces: by symmetry, and against planar integrations."""

import copy

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from trade import JOINT

import drakesep
from drakesep.case_file.case import Case


DEG = np.degrees(1.0)
STIFFNESS = 2e4
RAILS = {
    "name": "cubesat_rails",
    "pair": {"A": "pod", "B": "cube"},
    "bodies": {
        "pod": {
            "mass_kg": 1000.0,
            "cg_mm": [-500.0, 0.0, 0.0],
            "inertia_kg_m2": {"xx": 100.0, "yy": 100.0, "zz": 100.0},
            "geometry": {
                name: {
                    "box": {"size_mm": [340.0, *size]},
                    "position_mm": [170.0, *place],
                }
                for name, size, place in (
                    ("left", (10.0, 130.0), (56.0, 0.0)),
                    ("right", (10.0, 130.0), (-56.0, 0.0)),
                    ("upper", (100.0, 10.0), (0.0, 56.0)),
                    ("lower", (100.0, 10.0), (0.0, -56.0)),
                )
            },
        },
        "cube": {
            "mass_kg": 1.8,
            "cg_mm": [120.0, -20.0, 0.0],
            "inertia_kg_m2": {"xx": 0.003, "yy": 0.01884, "zz": 0.01884},
            "geometry": {
                "hull": {
                    "box": {"size_mm": [340.0, 100.0, 100.0]},
                    "position_mm": [170.0, 0.0, 0.0],
                }
            },
        },
    },
    "attachments": {
        "door": {
            "A": "pod",
            "B": "cube",
            "position_mm": [0.0, 0.0, 0.0],
            "joint": JOINT,
            "spring": {
                "name": "push",
                "law": "table",
                "displacements_mm": [0.0, 339.0],
                "forces_N": [10.0, 5.0],
            },
            "release_time_s": 0.0,
        }
    },
    "recontact": {"stiffness_N_m": STIFFNESS, "dissipation_s_m": 1.0},
    "run": {"duration_s": 0.45, "accuracy": 1e-5, "max_step_s": 0.002},
}
BUMP = {
    "name": "bump",
    "pair": {"A": "stage", "B": "sat"},
    "bodies": {
        "stage": {
            "mass_kg": 1500.0,
            "cg_mm": [-1000.0, 0.0, 0.0],
            "inertia_kg_m2": {"xx": 1500.0, "yy": 3000.0, "zz": 3000.0},
            "geometry": {
                "deck": {
                    "box": {"size_mm": [100.0, 600.0, 600.0]},
                    "position_mm": [-50.0, 0.0, 0.0],
                }
            },
        },
        "sat": {
            "mass_kg": 130.0,
            "cg_mm": [300.0, 0.0, 0.0],
            "inertia_kg_m2": {"xx": 12.0, "yy": 10.0, "zz": 10.0},
            "geometry": {
                "base": {
                    "box": {"size_mm": [400.0, 300.0, 300.0]},
                    "position_mm": [210.0, 0.0, 0.0],
                }
            },
        },
    },
    "attachments": {
        "r": {
            "A": "stage",
            "B": "sat",
            "position_mm": [0.0, 0.0, 0.0],
            "joint": JOINT,
            "spring": {
                "name": "s",
                "law": "displacement",
                "force_max_N": 650.0,
                "stroke_mm": 100.0,
            },
            "release_time_s": 0.0,
        }
    },
    "loads": {
        "vent": {
            "body": "stage",
            "position_mm": [-1000.0, 0.0, 0.0],
            "direction": [1.0, 0.0, 0.0],
            "times_s": [0.5, 0.51, 1.5, 1.51],
            "thrusts_N": [0.0, 1500.0, 1500.0, 0.0],
        }
    },
    "recontact": {"stiffness_N_m": 1e5, "dissipation_s_m": 0.2},
    "run": {"duration_s": 4.0, "accuracy": 1e-6, "max_step_s": 0.002},
}


def fly(data, cg=None, **recontact):
    """Return the rate and the relative velocity at the end, deg/s and m/s."""
    data = copy.deepcopy(data)
    data["recontact"] |= recontact
    if cg is not None:
        data["bodies"][data["pair"]["B"]]["cg_mm"][1:] = cg
        if data["name"] == "bump":  # pushed without a turn, before
            data["attachments"]["r"]["position_mm"][1:] = cg
    run = drakesep.simulate(Case.model_validate(data)).run
    assert run.contacts
    return DEG * run.motion.rate[-1], run.motion.relative_velocity[-1]


def planar_rails(stiffness, dissipation):
    """Rate in deg/s and velocity of the cube as it leaves its pod, in their plane.

    An elastic foundation: pressure over depth, over the cube's width. Each of two
    boxes takes half of the depth, but near its end no more than it is far from there.
    """
    # By the smallest piece, a quarter of the surface of a wall.
    kappa = stiffness / (0.25 * 2.0 * (0.34 * 0.1 + 0.34 * 0.01 + 0.1 * 0.01))
    nodes, weights = np.polynomial.legendre.leggauss(24)
    mass, inertia = np.array([1000.0, 1.8]), np.array([100.0, 0.01884])
    cg = np.array([[-0.5, 0.0], [0.12, -0.02]])
    length, half, width, gap = 0.34, 0.05, 0.1, 0.051

    def turned(a):
        return np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])

    def within(at_0, slope, low, high):
        """Where at_0 + slope u >= 0."""
        if slope > 0.0:
            return max(low, -at_0 / slope), high
        if slope < 0.0:
            return low, min(high, -at_0 / slope)
        return (low, high) if at_0 > 0.0 else (low, low)

    def rates(_, state):
        p, a, v, w = state[:4].reshape(2, 2), state[4:6], state[6:10], state[10:]
        v = v.reshape(2, 2)
        R = [turned(angle) for angle in a]
        origin = [p[i] - R[i] @ cg[i] for i in range(2)]
        force, torque = np.zeros((2, 2)), np.zeros(2)

        def push(points, forces):
            for i, side in ((0, -1.0), (1, 1.0)):
                arm = points - p[i]
                force[i] += side * forces.sum(axis=0)
                torque[i] += side * np.sum(arm[:, 0] * forces[:, 1])
                torque[i] -= side * np.sum(arm[:, 1] * forces[:, 0])

        o, R_AB = R[0].T @ (origin[1] - origin[0]), R[0].T @ R[1]
        if o[0] < 0.339:
            spring = R[0] @ np.array([10.0 - 5.0 * o[0] / 0.339, 0.0])
            push(origin[1][None], spring[None])
        for side in (1.0, -1.0):
            start, along = o + R_AB @ [0.0, side * half], R_AB[:, 0]
            low, high = within(length - start[0], -along[0], 0.0, length)
            low, high = within(start[0], along[0], low, high)
            low, high = within(side * start[1] - gap, side * along[1], low, high)
            if high <= low:
                continue
            u = 0.5 * (high + low) + 0.5 * (high - low) * nodes
            depth = side * (start[1] + along[1] * u) - gap
            places = start + along * u[:, None]
            to_ends = np.minimum(u, length - places[:, 0])
            places[:, 1] -= 0.5 * side * depth
            points = origin[0] + places @ R[0].T
            normal = R[0] @ [0.0, side]
            speeds = [
                v[i]
                + w[i] * np.stack([-(points - p[i])[:, 1], (points - p[i])[:, 0]], 1)
                for i in range(2)
            ]
            closing = (speeds[1] - speeds[0]) @ normal
            deep = np.minimum(depth, 2.0 * to_ends)
            pressure = kappa * deep * np.maximum(0.0, 1.0 + dissipation * closing)
            line = 0.5 * (high - low) * weights * width * pressure
            push(points, -line[:, None] * normal)
        return np.concatenate(
            [v.ravel(), w, (force / mass[:, None]).ravel(), torque / inertia]
        )

    start = np.concatenate([cg.ravel(), np.zeros(8)])
    done = solve_ivp(rates, (0.0, 0.45), start, rtol=1e-6, atol=1e-9, max_step=2e-3)
    return DEG * done.y[11, -1], done.y[8:10, -1] - done.y[6:8, -1]


@pytest.mark.parametrize("dissipation", [0.0, 1.0])
def test_a_cubesat_leaves_its_rails_without_roll(dissipation):
    rate, velocity = fly(RAILS, dissipation_s_m=dissipation)
    expected, v = planar_rails(STIFFNESS, dissipation)
    # Pressure on the ends themselves is left out: of half the depth, over a contact
    # that is as long as the depth over some degrees.
    assert rate[2] == pytest.approx(expected, rel=0.015)
    assert velocity[0] == pytest.approx(v[0], rel=3e-3)
    assert abs(rate[2]) < 0.2 * 365.0  # that without rails
    # By symmetry, to the quadrature of dissipation over triangles of Drake's.
    assert np.abs(rate[:2]).max() < (2e-3 if dissipation else 1e-9)
    assert abs(velocity[2]) < 1e-9


def test_rails_mirrored_and_turned():
    rate, velocity = fly(RAILS)
    mirrored, back = fly(RAILS, cg=[20.0, 0.0])
    assert mirrored == pytest.approx(rate * [-1.0, -1.0, -1.0], abs=3e-3)
    assert back == pytest.approx(velocity * [1.0, -1.0, 1.0], abs=1e-5)
    # Turned by 90 deg about x: y becomes z, but for walls just as wide as the cube.
    turned, aside = fly(RAILS, cg=[0.0, -20.0])
    assert turned == pytest.approx([rate[0], -rate[2], rate[1]], rel=3e-4, abs=3e-3)
    assert aside == pytest.approx([velocity[0], velocity[2], velocity[1]], abs=1e-5)


def test_a_square_bump_does_not_turn():
    """Face on face: an elastic foundation, in one dimension."""
    rate, velocity = fly(BUMP)
    assert np.abs(rate).max() < 1e-9
    assert np.abs(velocity[1:]).max() < 1e-9
    # By the smallest piece, a quarter of the surface of the base.
    stiffness = 1e5 * 0.3 * 0.3 / (0.25 * 2.0 * (2.0 * 0.4 * 0.3 + 0.3 * 0.3))

    def rates(t, state):
        x, v = state
        spring = 650.0 * (1.0 - x / 0.1) if 0.0 <= x < 0.1 and t < 0.5 else 0.0
        deep = max(-0.01 - x, 0.0)
        force = spring + stiffness * deep * max(0.0, 1.0 - 0.2 * v)
        thrust = np.interp(t, [0.5, 0.51, 1.5, 1.51], [0.0, 1500.0, 1500.0, 0.0])
        return v, force / 130.0 + force / 1500.0 - thrust / 1500.0

    done = solve_ivp(rates, (0.0, 4.0), (0.0, 0.0), rtol=1e-9, max_step=1e-3)
    assert velocity[0] == pytest.approx(done.y[1, -1], rel=1e-3)  # within steps
    assert velocity[0] > 0.0


def test_a_bump_off_the_cg_turns_in_its_plane_alone():
    """Mirrored and turned, the rates are too."""
    rate, velocity = fly(BUMP, cg=[0.0, 40.0])
    assert abs(rate[1]) > 0.1
    mirrored, _ = fly(BUMP, cg=[0.0, -40.0])
    turned, aside = fly(BUMP, cg=[-40.0, 0.0])
    # To what a step finds of onset and end of a contact, of its 2 ms.
    assert mirrored == pytest.approx(-rate, abs=1e-4)
    assert turned == pytest.approx([rate[0], -rate[2], rate[1]], abs=1e-4)
    assert aside == pytest.approx([velocity[0], -velocity[2], velocity[1]], abs=1e-6)
    for out_of_plane in (rate[0], rate[2], turned[0], turned[1]):
        assert abs(out_of_plane) < 1e-5 * abs(rate[1])
