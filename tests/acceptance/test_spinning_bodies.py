"""A body that spins while mated, about the direction that its joint leaves free."""

import dataclasses
import math

import numpy as np
import pytest
from conserved import of_all_bodies
from scipy.spatial.transform import Rotation
from separations import FREE, GENERIC, STIFF, generic_pair, on_axis

from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.systems.model.inertia import inertia_matrix
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.parameters import parameters, with_values
from drakesep.systems.model.separation import Attachment, InitialMotion
from drakesep.systems.model.springs import DisplacementSpring
from drakesep.systems.simulation.simulation import Simulation


ACCURATE = Integration(accuracy=1e-9)
SPIN = 9.0
TURNS = Joint(type="revolute", rigid=True)
SOFT = Joint(type="revolute", K_F=1e6, D_F=2e3, K_T=1e6, D_T=2e3)


def cluster(*, joint=TURNS, spin=SPIN, balanced=True, release=0.1, **changes):
    """A cluster on a bearing, and a spring on its axis."""
    pair = generic_pair(release_times=(release,), initial=InitialMotion(), duration=0.6)
    lower, upper = on_axis(pair) if balanced else pair.bodies
    spring = DisplacementSpring(name="spring", force_max=3000.0, stroke=0.06)
    [bearing] = pair.attachments
    bearing = dataclasses.replace(
        bearing, p_AoPad_A=(0.0, 0.0, 0.0), joint=joint, spring=spring
    )
    upper = dataclasses.replace(upper, spin=spin)
    return dataclasses.replace(
        pair, bodies=(lower, upper), attachments=(bearing,), **changes
    )


@pytest.mark.parametrize("joint", [TURNS, SOFT])
@pytest.mark.parametrize("spin", [SPIN, -25.0 * math.pi])  # and 750 rpm
def test_only_the_cluster_spins(joint, spin):
    """It keeps its spin, the booster has none; v = sqrt(2 E / mu)."""
    pair = cluster(joint=joint, spin=spin)
    run = Simulation(pair, ACCURATE).run()
    steady = np.tile([spin, 0.0, 0.0], (len(run.motion.time), 1))
    assert run.motion.rate == pytest.approx(steady, abs=1e-8)
    assert run.motion.relative_rate == pytest.approx(steady, abs=1e-8)
    mu = 1.0 / sum(1.0 / body.mass for body in pair.bodies)
    speed = metrics_of_run(run, (math.inf,) * 3)["longitudinal_speed_max"]
    assert speed == pytest.approx(math.sqrt(3000.0 * 0.06 / mu), rel=1e-7)


def test_momentum_is_that_of_its_spin_and_stays():
    """Unbalanced, about an axis beside its CG, on a stack that turns itself."""
    pair = cluster(balanced=False, initial=GENERIC)
    run = Simulation(pair, ACCURATE).run()
    R_WA = Rotation.from_euler("xyz", GENERIC.rpy_WA)
    lower, upper = pair.bodies
    w_A, spin = np.array(GENERIC.w_WA_A), np.array([SPIN, 0.0, 0.0])
    w_B = w_A + spin
    c_A, c_B = np.array(lower.p_BoBcm_B), np.array(upper.p_BoBcm_B)
    # A's CG is at rest; B turns with A, and about the bearing, at A's origin.
    v_B = np.cross(w_A, c_B - c_A) + np.cross(spin, c_B)
    momentum = upper.mass * v_B
    angular = np.cross(c_B, momentum)
    for body, w in ((lower, w_A), (upper, w_B)):
        angular = angular + inertia_matrix(body.I_BBcm_B) @ w
    whole = of_all_bodies(run)
    n = len(run.motion.time)
    expected = np.tile(R_WA.apply(momentum), (n, 1))
    # Of 100 N s and 2000 N m s, at an accuracy of 1e-9.
    assert whole.momentum == pytest.approx(expected, abs=1e-5)
    about = np.tile(R_WA.apply(angular), (n, 1))
    assert whole.angular == pytest.approx(about, abs=1e-4)
    assert run.motion.rate[0] == pytest.approx(w_B)
    held = run.motion.time < 0.1
    # About the axis nothing holds it; across, it moves with A.
    assert abs(run.motion.relative_rate[held, 1:]).max() < 1e-6


def test_mirrored():
    """In the plane of x and z: what turns about x and z turns the other way."""
    pair = cluster(balanced=False)
    flip = np.array([1.0, -1.0, 1.0])

    def mirrored(body):
        xx, yy, zz, xy, xz, yz = body.I_BBcm_B
        return dataclasses.replace(
            body,
            p_BoBcm_B=tuple(flip * body.p_BoBcm_B),
            I_BBcm_B=(xx, yy, zz, -xy, xz, -yz),
            spin=-body.spin,
        )

    other = dataclasses.replace(pair, bodies=tuple(map(mirrored, pair.bodies)))
    runs = [Simulation(each, ACCURATE).run() for each in (pair, other)]
    rate, same = (run.motion.rate[-1] for run in runs)
    assert same == pytest.approx(-flip * rate, abs=1e-7)


def test_where_the_axis_is():
    """In the joint's frame, of a body that stands turned in the stack."""
    axes = {"x_axis_A": (0.6, 0.0, 0.8), "y_axis_A": (0.0, 1.0, 0.0)}
    pair = cluster(joint=dataclasses.replace(SOFT, **axes))
    lower, upper = pair.bodies
    upper = dataclasses.replace(upper, rpy_AB=(0.3, -0.2, 0.9), p_ABo=(0.2, 0.1, 0.0))
    pair = dataclasses.replace(pair, bodies=(lower, upper))
    run = Simulation(pair, ACCURATE).run()
    R_AB = Rotation.from_euler("xyz", upper.rpy_AB)
    expected = R_AB.apply(SPIN * np.array(axes["x_axis_A"]), inverse=True)
    assert run.motion.rate[0] == pytest.approx(expected)
    pad = run.trajectory.of("upper")[0]
    at_pad = pad[10:] + np.cross(pad[7:10], -np.array(upper.p_ABo))
    assert at_pad == pytest.approx(np.zeros(3), abs=1e-12)


def test_a_parameter_of_bodies_that_can():
    pair = cluster()
    assert parameters(pair)["upper.spin"] == SPIN
    assert "lower.spin" not in parameters(pair)
    assert with_values(pair, {"upper.spin": 1.0}).body("upper").spin == 1.0
    assert not any(name.endswith(".spin") for name in parameters(generic_pair()))


def beside(joint, place):
    """A second attachment."""
    return Attachment(name="more", A="lower", B="upper", p_AoPad_A=place, joint=joint)


@pytest.mark.parametrize(
    "more",
    [
        beside(STIFF, (0.0, 0.0, 0.0)),
        beside(TURNS, (0.0, 0.1, 0.0)),
        beside(
            dataclasses.replace(SOFT, x_axis_A=(0.8, 0.6, 0), y_axis_A=(0, 0, 1)),
            (0, 0, 0),
        ),
        dataclasses.replace(beside(SOFT, (0.0, 0.0, 0.0)), A="upper", B="lower"),
    ],
)
def test_joints_that_do_not_let_it(more):
    pair = cluster()
    with pytest.raises(ValueError, match="upper: spin must be 0, unless it is held by"):
        dataclasses.replace(pair, attachments=(*pair.attachments, more))


@pytest.mark.parametrize(
    "more",
    [
        beside(FREE, (0.0, 0.4, 0.0)),
        beside(dataclasses.replace(SOFT, type="cylindrical"), (0.3, 0.0, 0.0)),
    ],
)
def test_joints_that_let_it(more):
    pair = cluster(joint=SOFT)
    pair = dataclasses.replace(pair, attachments=(*pair.attachments, more))
    assert pair.spins_on(pair.body("upper")) == pair.attachments[0]


def test_the_launcher_does_not():
    pair = cluster()
    lower, upper = pair.bodies
    with pytest.raises(ValueError, match="lower: spin must be 0"):
        dataclasses.replace(pair, bodies=(dataclasses.replace(lower, spin=1.0), upper))


@pytest.mark.slow
def test_both_engines():
    pair = cluster(joint=SOFT, balanced=False, initial=GENERIC)
    names = ["upper.spin", "attachment_1.position_y", "upper.mated_misalignment_yaw"]
    rows = np.array([[SPIN, 0.0, 0.0], [4.0, 0.01, 0.02]])
    result = Batch(pair, names).run(rows)
    assert not result.failures
    for row, told in zip(rows, result.metrics.to_dict("records"), strict=True):
        run = Simulation(pair, ACCURATE).run(dict(zip(names, row, strict=True)))
        metrics = metrics_of_run(run, (math.inf,) * 3)
        for name, value in told.items():
            # 1e-8 of states that ring; speeds of points that turn at 9 rad/s.
            assert metrics[name] == pytest.approx(value, abs=3e-7, rel=1e-7), name
