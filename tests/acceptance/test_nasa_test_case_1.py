"""NASA/TP-2016-219326, test case 1: two bodies on a fixed joint, then released.

Pamadi, Toniolo, Tartabini, Roithmayr, Albertson and Karlgaard, 2016 (NTRS 20160010566).
The displacement of a fixed joint is ideally zero. Masses and inertias are theirs, in
slug and slug ft^2; the text at hand gives no initial motion, so the motion is ours.
Before the release the pair is held against the composite body; at the release momentum
and energy must be continuous, and after it conserved.
"""

import numpy as np
import pytest
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from drakesep.systems.diagram.separation_system import SeparationSystem
from drakesep.systems.model.inertia import inertia_matrix
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.separation import (
    Attachment,
    Body,
    InitialMotion,
    Separation,
)


SLUG, FOOT = 14.593903, 0.3048
SLUG_FT2 = SLUG * FOOT**2
RELEASE, END = 0.8, 2.0
INITIAL = InitialMotion(rpy_WA=(0.5, -0.4, 1.1), w_WA_A=(0.3, 0.2, -0.25))
# Stiff against the bodies' 20 kg: what the joint gives stays below a micrometre.
JOINT = Joint(K_F=1e6, D_F=4e3, K_T=1e6, D_T=2e3)


def body(name, mass, moments, x):
    return Body(
        name=name,
        mass=mass * SLUG,
        p_BoBcm_B=(0.0, 0.0, 0.0),
        I_BBcm_B=(*(float(m * SLUG_FT2) for m in moments), 0.0, 0.0, 0.0),
        p_ABo=(x * FOOT, 0.0, 0.0),
    )


# Boxes of 5 x 2 x 1 ft and 2 x 2 x 1 ft have these inertias; they touch end to end.
A = body("A", 1.0, (5 / 12, 26 / 12, 29 / 12), 0.0)
B = body("B", 0.4, (1 / 6, 1 / 6, 4 / 15), 3.5)
CASE = Separation(
    bodies=(A, B),
    attachments=(
        Attachment(
            name="joint",
            A="A",
            B="B",
            p_AoPad_A=(2.5 * FOOT, 0.0, 0.0),
            joint=JOINT,
            release_time=RELEASE,
        ),
    ),
    A="A",
    B="B",
    initial=INITIAL,
    duration=END,
)


@pytest.fixture(scope="module")
def flown():
    """Time, pose and velocity of both bodies, momentum and energy."""
    system = SeparationSystem(CASE)
    context = system.CreateDefaultContext()
    system.set_separation(context, CASE)
    context.SetAccuracy(1e-9)
    simulator = Simulator(system, context)
    config = SimulatorConfig(integration_scheme="runge_kutta3", accuracy=1e-9)
    ApplySimulatorConfig(config, simulator)
    plant, inner = system.plant, system.plant.GetMyContextFromRoot(context)
    rows = []
    for t in [*np.linspace(0.0, RELEASE, 9), RELEASE + 1e-6, 1.4, END]:
        simulator.AdvanceTo(t)
        momentum = plant.CalcSpatialMomentumInWorldAboutPoint(inner, np.zeros(3))
        [elastic] = system.GetOutputPort("joint_energy").Eval(context)
        rows.append(
            {
                "time": t,
                "X_WA": plant.EvalBodyPoseInWorld(inner, plant.GetBodyByName("A")),
                "X_WB": plant.EvalBodyPoseInWorld(inner, plant.GetBodyByName("B")),
                "p": momentum.translational(),
                "H": momentum.rotational(),
                "kinetic": plant.CalcKineticEnergy(inner),
                "elastic": elastic,
            }
        )
    return rows


def test_joint_displacement_is_ideally_zero(flown):
    for row in flown:
        if row["time"] <= RELEASE:
            X_AB = row["X_WA"].inverse() @ row["X_WB"]
            place = X_AB.translation() - [3.5 * FOOT, 0.0, 0.0]
            assert np.linalg.norm(place) < 2e-6
            turn = Rotation.from_matrix(X_AB.rotation().matrix()).magnitude()
            assert turn < 2e-6


def test_mated_motion_is_the_composite_bodys(flown):
    M = A.mass + B.mass
    c_A = np.array([0.0, 0.0, 0.0])
    c_B = np.array(B.p_ABo)
    c = (A.mass * c_A + B.mass * c_B) / M
    inertia = np.zeros((3, 3))
    for part, r in ((A, c_A - c), (B, c_B - c)):
        inertia += inertia_matrix(part.I_BBcm_B)
        inertia += part.mass * (r @ r * np.eye(3) - np.outer(r, r))

    def derivative(_, y):
        q, w = y[:4], y[4:]
        qdot = 0.5 * np.append(q[3] * w + np.cross(q[:3], w), -q[:3] @ w)
        return np.append(qdot, np.linalg.solve(inertia, -np.cross(w, inertia @ w)))

    mated = [row for row in flown if row["time"] <= RELEASE]
    R0 = Rotation.from_euler("xyz", INITIAL.rpy_WA)
    w0 = np.array(INITIAL.w_WA_A)
    y = solve_ivp(
        derivative,
        (0.0, RELEASE),
        np.append(R0.as_quat(), w0),
        t_eval=[row["time"] for row in mated],
        method="DOP853",
        rtol=1e-11,
        atol=1e-13,
    ).y
    for row, R in zip(mated, Rotation.from_quat(y[:4].T).as_matrix(), strict=True):
        turn = Rotation.from_matrix(R.T @ row["X_WA"].rotation().matrix()).magnitude()
        assert turn < 3e-6  # what the joint gives
        origin = R0.apply(c) + R0.apply(np.cross(w0, c)) * row["time"] - R @ c
        assert row["X_WA"].translation() == pytest.approx(origin, abs=3e-6)


def test_momentum_and_energy_are_continuous_at_the_release(flown):
    before = next(row for row in flown if row["time"] == RELEASE)
    after = next(row for row in flown if row["time"] > RELEASE)
    for name in ("p", "H"):
        assert after[name] == pytest.approx(before[name], abs=1e-8)
    assert after["kinetic"] == pytest.approx(before["kinetic"], rel=1e-6)
    assert after["elastic"] == 0.0


def test_momentum_and_energy_are_conserved(flown):
    first = flown[0]
    for row in flown:
        assert row["p"] == pytest.approx(first["p"], abs=1e-7)
        assert row["H"] == pytest.approx(first["H"], abs=1e-7)
    # The joint swings in, from rest, and its damper takes what it swings with.
    assert flown[-1]["kinetic"] == pytest.approx(first["kinetic"], rel=1e-5)
