"""One of four locks never opens: the payload stays, hinges on it, and says so."""

import dataclasses
import math

import numpy as np
import pytest
from conserved import of_all_bodies
from trade import symmetric_design

import drakesep
from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.analysis.metrics.registry import find_metric
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.cli.options import parse_changes
from drakesep.results.reading import read_results
from drakesep.studies.before_flight import check_verifiable
from drakesep.studies.remarks import remarks
from drakesep.systems.batch.row_checks import RowChecks
from drakesep.systems.equations.forces_of_run import spring_forces
from drakesep.systems.equations.loads_of_run import joint_loads
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.separation import Attachment, Pair, Separation
from drakesep.systems.model.springs import DisplacementSpring
from drakesep.systems.simulation.simulation import Simulation


LIMITS = (math.inf,) * 3
ACCURATE = Integration(accuracy=1e-9)
REQUIREMENTS = [
    {"quantity": "joint_force_N", "of": "a4", "at_most": 9000.0},
    {"quantity": "rate_after_separation_deg_s", "at_most": [3.0, 3.0, 3.0]},
    {"quantity": "longitudinal_speed_m_s", "when": "after_separation", "at_least": 0.3},
]


def stuck_design(**changes):
    """Four springs of 500 N over 80 mm at 400 mm; the fourth lock never opens."""
    attachments = symmetric_design().model_dump()["attachments"]
    attachments["a4"]["release_time_s"] = "never"
    return symmetric_design(attachments=attachments, **changes)


def held_by(joint: Joint, **changes) -> Separation:
    """The same, with another lock."""
    design = stuck_design().separation
    *others, stuck = design.attachments
    others = [dataclasses.replace(a, **changes) for a in others]
    stuck = dataclasses.replace(stuck, joint=joint)
    return dataclasses.replace(design, attachments=(*others, stuck))


def test_what_is_told_of_it():
    study = drakesep.simulate(stuck_design(requirements=REQUIREMENTS))
    assert study.completed and study.run.held == ("a4",)
    assert study.run.releases == {"a1": 0.0, "a2": 0.0, "a3": 0.0, "a4": math.inf}
    assert study.run.stroke_ends == dict.fromkeys(["s1", "s2", "s3", "s4"], math.inf)
    [remark] = study.remarks
    assert remark.text.startswith("a4 holds to the end, with up to 2")
    assert remark.text.endswith(": sc does not separate.")
    verdicts = study.requirements["verdict"].tolist()
    assert verdicts == ["met", *["not looked at"] * 4]
    assert math.isnan(study.labelled.metrics["separation_end"])
    assert study.labelled.metrics["longitudinal_speed_max"] > 0.0


def test_no_verdict_that_it_is_met():
    case = stuck_design(requirements=REQUIREMENTS[1:])
    study = drakesep.verify(case)
    assert (study.verdict, study.passed) == ("not looked at", False)
    said = " ".join(check_verifiable(case))
    assert said.count("there is no verdict: a4 never lets go") == 4


def test_a_rigid_lock_carries_what_pushes():
    """Nothing moves: the lock carries four springs, and the moments of three."""
    design = held_by(Joint(rigid=True))
    run = Simulation(design, ACCURATE).run()
    pads = np.array([a.p_AoPad_A for a in design.attachments])
    force = np.array([500.0, 0.0, 0.0])
    torque = np.cross(pads[:3] - pads[3], force).sum(axis=0)
    load = joint_loads(run)["a4"]
    expected = np.tile([*-torque, *-4.0 * force], (len(load), 1))
    # Round-off of forces of kN, and of the motion of a mm in a hundred billion.
    assert load == pytest.approx(expected, abs=1e-6)
    # In all 2000 N, 0.4 m beside it.
    [remark] = remarks({"": run})
    assert remark.text.startswith("a4 holds to the end, with up to 2000 N and 800 N m:")
    assert abs(run.motion.relative_velocity).max() < 1e-9


def test_a_damped_lock_comes_to_rest_where_forces_are_in_balance():
    design = dataclasses.replace(stuck_design().separation, duration=6.0)
    run = Simulation(design).run()
    pushed = 500.0 + sum(force[-1] for force in spring_forces(run).values())
    # Within what is left of the ringing: a few thousandths.
    assert joint_loads(run)["a4"][-1, 3] == pytest.approx(-pushed, rel=3e-3)
    assert spring_forces(run)["s4"].max() == 0.0


def test_it_hinges_on_a_lock_that_turns():
    """Without loss: what the springs give is in the motion, and momentum stays."""
    axis = {"x_axis_A": (0.0, -math.sqrt(0.5), -math.sqrt(0.5))}
    hinge = Joint(type="revolute", rigid=True, y_axis_A=(1.0, 0.0, 0.0), **axis)
    run = Simulation(held_by(hinge), ACCURATE).run()
    ends = [run.stroke_ends[name] for name in ("s1", "s2", "s3")]
    assert 0.0 < max(ends) < 1.0 and run.held == ("a4",)
    whole = of_all_bodies(run)
    # All three over their strokes, along A's x axis.
    assert whole.kinetic[-1] == pytest.approx(3.0 * 20.0, rel=1e-7)
    assert abs(whole.momentum).max() < 1e-6
    assert abs(whole.angular).max() < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("joint", ["damped", "turns"])
def test_both_engines(joint):
    design = stuck_design().separation
    if joint == "turns":
        design = held_by(Joint(type="spherical", K_F=1e6, D_F=5e3, K_T=0.0, D_T=0.0))
    batch = Batch(design, ["sc.mass", "s1.force_max"])
    rows = np.array([[500.0, 500.0], [510.0, 420.0]])
    result = batch.run(rows)
    assert not result.failures
    assert "rate_after_separation_x" not in result.metrics
    assert "G_Linf" in result.metrics
    for row, told in zip(rows, result.metrics.to_dict("records"), strict=True):
        values = dict(zip(batch.names, row.tolist(), strict=True))
        metrics = metrics_of_run(Simulation(design, ACCURATE).run(values), LIMITS)
        for name, value in told.items():
            # 1e-8 of states that ring, of which integrals add up some.
            assert metrics[name] == pytest.approx(value, abs=1e-7), name
    [run] = batch.runs(rows[:1])
    assert run.held == ("a4",)


def test_never_as_a_value(tmp_path):
    """As a failure case says it of a design whose locks open; and read from results."""
    design = symmetric_design()
    study = drakesep.simulate(design, {"a4.release_time_s": math.inf}, output=tmp_path)
    assert study.run.held == ("a4",)
    same = drakesep.simulate(stuck_design()).run
    assert (study.run.motion.rate == same.motion.rate).all()
    assert study.summary["a4.release_time_s"].tolist() == [math.inf]
    [read] = read_results(tmp_path).runs
    assert read.run.held == ("a4",)
    assert read.run.separation == study.run.separation


@pytest.mark.parametrize("name", ["sc.mass", "s1.stroke"])
def test_nothing_else_may_be_infinite(name):
    with pytest.raises(ValueError, match="must be finite, got inf"):
        Simulation(symmetric_design().separation).run({name: math.inf})


def test_a_row_of_a_batch_lets_go():
    names = ["a4.release_time"]
    failures = RowChecks(symmetric_design().separation, names).failures(
        np.array([[math.inf]])
    )
    assert "must be finite" in failures[0]


def test_of_another_body_all_is_told():
    """Two on one launcher, of which one stays."""
    one = stuck_design().separation
    second = dataclasses.replace(one.body("sc"), name="other", p_ABo=(0.0, 3.0, 0.0))
    attachments = tuple(
        dataclasses.replace(
            a,
            name=f"b{i}",
            B="other",
            p_AoPad_A=(0.0, 3.0 + a.p_AoPad_A[1], a.p_AoPad_A[2]),
            spring=dataclasses.replace(a.spring, name=f"t{i}"),
            release_time=0.0,
        )
        for i, a in enumerate(one.attachments, 1)
    )
    both = dataclasses.replace(
        one,
        bodies=(*one.bodies, second),
        attachments=(*one.attachments, *attachments),
        others=(drakesep.systems.Pair(A="lv", B="other"),),
    )
    run = Simulation(both).run()
    metrics = metrics_of_run(run, LIMITS)
    assert run.held == ("a4",)
    assert math.isnan(metrics["separation_end"])
    assert 0.0 < metrics["other.separation_end"] < 1.0
    assert max(run.stroke_ends[f"t{i}"] for i in (1, 2, 3, 4)) < 1.0
    assert min(run.stroke_ends[f"s{i}"] for i in (1, 2, 3, 4)) == math.inf


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("rate_after_separation", False),
        ("rate_until_separation", False),
        ("rate_since_release", True),
        ("rate_at_end", True),
        ("a1.joint_force_at_release", True),
        ("a4.joint_force_at_release", False),
        ("a4.joint_force", True),
        ("s4.spring_force_since_release", False),
        ("s1.spring_force_since_release", True),
        ("s1.spring_force_after_separation", False),
    ],
)
def test_what_comes_about(name, told):
    metric, _ = find_metric(name)
    assert metric.comes_about(stuck_design().separation) == told
    assert metric.comes_about(symmetric_design().separation)


def test_the_word():
    assert stuck_design().separation.attachments[3].release_time == math.inf
    attachments = stuck_design().model_dump()["attachments"]
    attachments["a4"]["release_time_s"] = "ever"
    with pytest.raises(ValueError, match="release_time_s"):
        symmetric_design(attachments=attachments)
    values = parse_changes(["a4.release_time_s=never", "a1.release_time_s=0.01"])
    assert values == {"a4.release_time_s": math.inf, "a1.release_time_s": 0.01}


def capped(stroke):
    """A lock of sc that would let go at an angle it never comes to; a cap on sc."""
    hinge = Joint(type="revolute", rigid=True)
    design = stuck_design().separation
    *_, stuck = design.attachments
    cap = dataclasses.replace(design.bodies[1], name="cap", parts=())
    spring = DisplacementSpring(name="pusher", force_max=500.0, stroke=stroke)
    shut = {"release_time": math.inf, "release_angle": 3.0}
    return dataclasses.replace(
        design,
        bodies=(*design.bodies, cap),
        others=(Pair(A="sc", B="cap"),),
        attachments=(
            dataclasses.replace(stuck, joint=hinge, spring=None, **shut),
            Attachment(
                name="c1",
                A="sc",
                B="cap",
                p_AoPad_A=(1.2, 0.0, 0.0),
                joint=hinge,
                spring=spring,
            ),
        ),
    )


@pytest.mark.parametrize("stroke", [0.08, 9.0])
def test_what_stays_shut_is_no_excuse_for_others(stroke):
    """The lock is of sc; the spring of its cap has no such reason to be short."""
    run = Simulation(capped(stroke)).run()
    if stroke < 1.0:
        assert run.motion is not None and run.held == ("a4",)
        assert run.not_separated.startswith("a4 has not let go")
    else:
        assert run.message.startswith("pusher has not reached its stroke")


def test_what_does_not_separate_meets_nothing():
    """Neither where its motion is told, and within a limit."""
    slow = Requirement(metric="longitudinal_speed_max", sense="<=", limit=9.0)
    case = AnalysisCase(separation=capped(0.08), requirements=(slow,))
    study = drakesep.verify(case)
    assert study.runs[0].metrics["longitudinal_speed_max"] < 9.0
    assert study.failure.startswith("nominal: failed: a4 has not let go")
    assert study.requirements["verdict"].tolist() == ["not looked at"]
    assert study.verdict is None and not study.passed
