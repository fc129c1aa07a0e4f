"""Rails and pins: joints that slide, and let go after a travel."""

import dataclasses
import math

import numpy as np
import pytest
from conserved import of_all_bodies
from flying import simulator_of
from scipy.spatial.transform import Rotation
from separations import generic_pair, on_axis

from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.systems.diagram.separation_system import SeparationSystem
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.loads import Load
from drakesep.systems.model.run import RunStatus
from drakesep.systems.model.separation import InitialMotion, Separation
from drakesep.systems.model.springs import DisplacementSpring
from drakesep.systems.simulation.simulation import Simulation


ACCURATE = Integration(accuracy=1e-9)
FORCE, STROKE, TRAVEL = 900.0, 0.12, 0.25
GAINS = {"K_F": 1e6, "D_F": 5e3, "K_T": 1e6, "D_T": 5e3}
PRISM = Joint(type="prismatic", rigid=True)


def dispenser(*, joint: Joint = PRISM, coaxial: bool = True, **held) -> Separation:
    """A door with a spring, and a rail along which the payload slides out."""
    pair = generic_pair(release_times=(0.0, 0.0), initial=InitialMotion(), duration=1.0)
    door, rail = pair.attachments
    spring = DisplacementSpring(name="spring", force_max=FORCE, stroke=STROKE)
    door = dataclasses.replace(
        door, name="door", p_AoPad_A=(0.0, 0.0, 0.0), spring=spring
    )
    held = {"release_time": math.inf, "release_travel": TRAVEL} | held
    rail = dataclasses.replace(
        rail, name="rail", joint=joint, spring=None, p_AoPad_A=(0.1, 0.2, 0.1), **held
    )
    bodies = on_axis(pair) if coaxial else pair.bodies
    return dataclasses.replace(pair, bodies=bodies, attachments=(door, rail))


def time_of_release() -> float:
    """x = L (1 - cos w t) over the stroke, and then at the speed w L."""
    pair = dispenser()
    mu = 1.0 / sum(1.0 / body.mass for body in pair.bodies)
    frequency = math.sqrt(FORCE / STROKE / mu)
    return 0.5 * math.pi / frequency + (TRAVEL - STROKE) / (frequency * STROKE)


@pytest.mark.parametrize(
    "joint",
    [PRISM, Joint(type="prismatic", **GAINS), Joint(type="cylindrical", **GAINS)],
)
def test_when_it_lets_go(joint):
    run = Simulation(dispenser(joint=joint), ACCURATE).run()
    assert run.releases["rail"] == pytest.approx(time_of_release(), abs=1e-7)
    assert run.releases["rail"] in run.breaks
    assert run.end_of("upper") == run.releases["rail"]


def test_its_time_is_foreseen():
    """One that is searched by bisection within a long step takes hundreds of steps."""
    by_travel = Simulation(dispenser()).run()
    by_time = dispenser(release_time=time_of_release(), release_travel=math.inf)
    assert by_travel.steps <= Simulation(by_time).run().steps + 40


def test_it_leads_until_then():
    """A CG beside the push turns both bodies as one, and free ones apart."""
    pair = dispenser(coaxial=False)
    run = Simulation(pair, ACCURATE).run()
    led = run.motion.time <= run.releases["rail"]
    # What the joint drifts is of the steps' accuracy.
    assert abs(run.motion.relative_rate[led]).max() < 1e-7
    assert abs(run.motion.rate[led]).max() > 1e-3
    free = Simulation(dispenser(coaxial=False, release_time=0.0), ACCURATE).run()
    assert abs(free.motion.relative_rate[-1]).max() > 0.01
    whole = of_all_bodies(run)
    assert abs(whole.momentum).max() < 1e-6 and abs(whole.angular).max() < 1e-6
    assert whole.kinetic[-1] == pytest.approx(0.5 * FORCE * STROKE, rel=1e-7)


def test_turned_it_is_the_same():
    """All that is fixed in A turned about it by a third of a turn: x to y to z."""
    pair = dispenser(coaxial=False)
    R = Rotation.from_matrix([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])

    def turned(vector):
        return tuple(R.apply(vector))

    bodies = []
    for body in pair.bodies:
        xx, yy, zz, xy, xz, yz = body.I_BBcm_B
        M = R.as_matrix()
        N = M @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ M.T
        inertia = N[0, 0], N[1, 1], N[2, 2], N[0, 1], N[0, 2], N[1, 2]
        cg = turned(body.p_BoBcm_B)
        bodies.append(dataclasses.replace(body, p_BoBcm_B=cg, I_BBcm_B=inertia))
    axes = {"x_axis_A": turned((1.0, 0.0, 0.0)), "y_axis_A": turned((0.0, 1.0, 0.0))}
    attachments = [
        dataclasses.replace(
            a,
            p_AoPad_A=turned(a.p_AoPad_A),
            joint=dataclasses.replace(a.joint, **axes),
            spring=a.spring and dataclasses.replace(a.spring, axis_A=axes["x_axis_A"]),
        )
        for a in pair.attachments
    ]
    other = dataclasses.replace(
        pair,
        bodies=tuple(bodies),
        attachments=tuple(attachments),
        direction=axes["x_axis_A"],
    )
    run, same = (Simulation(p, ACCURATE).run() for p in (pair, other))
    # Of steps that see other round-off.
    assert same.releases["rail"] == pytest.approx(run.releases["rail"], abs=1e-9)
    assert same.motion.rate[-1] == pytest.approx(R.apply(run.motion.rate[-1]), abs=1e-8)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_it_may_slide_either_way(way):
    """Pulled by 500 N: s = a t^2 / 2."""
    pair = dispenser()
    pull = Load(
        name="pull",
        body="upper",
        p_BoQ_B=(1.1, 0.0, 0.0),
        times=(0.0, 1.2),
        forces=((way * 500.0, 0.0, 0.0),) * 2,
    )
    door = dataclasses.replace(pair.attachments[0], spring=None)
    pair = dataclasses.replace(
        pair, attachments=(door, pair.attachments[1]), loads=(pull,), duration=1.2
    )
    run = Simulation(pair, ACCURATE).run()
    released = math.sqrt(2.0 * TRAVEL * 1200.0 / 500.0)
    # The launcher stays: A feels nothing along its rail.
    assert run.releases["rail"] == pytest.approx(released, abs=1e-7)


def test_under_a_parent_it_lets_go_at_the_same_time():
    pair = dispenser()
    system = SeparationSystem(pair)
    context = system.CreateDefaultContext()
    system.set_separation(context, pair)
    simulator_of(system, context, 1e-8).AdvanceTo(pair.duration)
    released = system.GetOutputPort("released").Eval(context)
    assert released[1] == pytest.approx(time_of_release(), abs=1e-6)


def test_a_travel_that_is_not_reached_is_a_result():
    run = Simulation(dispenser(release_travel=3.0)).run()
    assert run.status is RunStatus.COMPLETED
    why = "rail has not let go: its joint has not slid by 3000 mm"
    assert run.not_separated == why
    angle = {"joint": Joint(type="cylindrical", **GAINS), "release_angle": 1.0}
    run = Simulation(dispenser(release_travel=3.0, **angle)).run()
    assert "turned by 57.2958 deg or slid by 3000 mm" in run.not_separated


@pytest.mark.parametrize("joint", ["fixed", "revolute", "spherical", "planar"])
def test_a_joint_that_does_not_slide_along_x(joint):
    with pytest.raises(ValueError, match=f"slides along its x axis alone, got {joint}"):
        dispenser(joint=Joint(type=joint, **GAINS))


def test_a_travel_is_above_zero():
    with pytest.raises(ValueError, match="rail: release travel must be > 0, got 0"):
        dispenser(release_travel=0.0)


@pytest.mark.slow
def test_both_engines():
    joint = Joint(type="cylindrical", **GAINS)
    pair = dispenser(joint=joint, coaxial=False)
    names = ["rail.release_travel", "upper.mass"]
    rows = np.array([[0.25, 1200.0], [0.11, 1150.0]])
    result = Batch(pair, names).run(rows)
    assert not result.failures
    for row, told in zip(rows, result.metrics.to_dict("records"), strict=True):
        run = Simulation(pair, ACCURATE).run(dict(zip(names, row, strict=True)))
        metrics = metrics_of_run(run, (math.inf,) * 3)
        for name, value in told.items():
            # 1e-8 of states that ring, of which integrals add up some.
            assert metrics[name] == pytest.approx(value, abs=1e-7), name
