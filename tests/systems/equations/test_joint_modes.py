"""How bodies ring on a joint, against closed forms of two bodies."""

import dataclasses
import math

import pytest

from drakesep.systems.equations.joint_modes import joint_modes
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.separation import Attachment, Body, Separation


MASSES, INERTIA, K, K_T = (300.0, 100.0), 20.0, 4e5, 3e4
REDUCED = MASSES[0] * MASSES[1] / sum(MASSES)


def two_bodies(joint: Joint, pad=(0.0, 0.0, 0.0)) -> Separation:
    """Bodies whose CGs fall together, B turned in A, on one joint."""
    A, B = (
        Body(
            name=name,
            mass=mass,
            p_BoBcm_B=(0.0, 0.0, 0.0),
            I_BBcm_B=(INERTIA, INERTIA, INERTIA, 0.0, 0.0, 0.0),
        )
        for name, mass in zip("AB", MASSES, strict=True)
    )
    B = dataclasses.replace(B, rpy_AB=(0.3, -0.8, 1.1))
    held = Attachment(
        name="held", A="A", B="B", p_AoPad_A=pad, joint=joint, release_time=0.5
    )
    return Separation(bodies=(A, B), attachments=(held,), A="A", B="B", duration=1.0)


def periods(joint: Joint, pad=(0.0, 0.0, 0.0)) -> list[float]:
    return sorted(joint_modes(two_bodies(joint, pad), {"held"}).periods)


def test_periods_are_those_of_the_reduced_mass_and_inertia():
    joint = Joint(K_F=(K, 0.0, 0.0), D_F=0.0, K_T=(0.0, 0.0, K_T), D_T=0.0)
    along = 2.0 * math.pi * math.sqrt(REDUCED / K)
    about = 2.0 * math.pi * math.sqrt(0.5 * INERTIA / K_T)
    assert periods(joint) == pytest.approx(sorted([along, about]), rel=1e-9)


def test_a_pad_off_the_cgs_moves_with_rotations_too():
    """Along the axes' y at an x of 0.7 m, a force finds 1 / m + r^2 / I."""
    joint = Joint(
        K_F=(K, 0.0, 0.0), D_F=0.0, K_T=0.0, D_T=0.0,
        x_axis_A=(0.0, 1.0, 0.0), y_axis_A=(-1.0, 0.0, 0.0),
    )  # fmt: skip
    mobility = 1.0 / REDUCED + 0.7**2 * 2.0 / INERTIA
    expected = 2.0 * math.pi / math.sqrt(K * mobility)
    assert periods(joint, (0.7, 0.0, 0.0)) == pytest.approx([expected], rel=1e-9)


@pytest.mark.parametrize(("ratio", "rings"), [(0.0, True), (0.6, True), (1.2, False)])
def test_damping_slows_and_ends_it(ratio, rings):
    rate = math.sqrt(K / REDUCED)
    joint = Joint(K_F=(K, 0.0, 0.0), D_F=2.0 * ratio * rate * REDUCED, K_T=0.0, D_T=0.0)
    modes = joint_modes(two_bodies(joint), {"held"})
    assert len(modes.periods) == rings
    if rings:
        damped = rate * math.sqrt(1.0 - ratio**2)
        assert modes.periods == pytest.approx([2.0 * math.pi / damped], rel=1e-9)
        assert modes.decays == pytest.approx([ratio * rate], rel=1e-9, abs=1e-12)


def test_nothing_rings_where_no_joint_holds():
    assert not len(
        joint_modes(two_bodies(Joint(K_F=K, D_F=0, K_T=0, D_T=0)), ()).periods
    )


def test_what_is_known_of_other_gains_or_masses_is_not_taken():
    """Modes are kept for runs that differ elsewhere alone: each number matters."""
    stiff, soft = (Joint(K_F=k, D_F=0.0, K_T=0.0, D_T=0.0) for k in (K, 0.25 * K))
    period = 2.0 * math.pi * math.sqrt(REDUCED / K)
    for _ in range(2):
        assert periods(stiff)[-1] == pytest.approx(period, rel=1e-9)
        assert periods(soft)[-1] == pytest.approx(2.0 * period, rel=1e-9)
    pair = two_bodies(stiff)
    heavy = dataclasses.replace(
        pair,
        bodies=tuple(dataclasses.replace(b, mass=4.0 * b.mass) for b in pair.bodies),
    )
    [*_, longest] = sorted(joint_modes(heavy, {"held"}).periods)
    assert longest == pytest.approx(2.0 * period, rel=1e-9)
