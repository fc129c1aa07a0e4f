"""A case made in Python, without a case file, gives what the case file gives."""

import dataclasses
import math

import pandas as pd
import pytest
from ruamel.yaml import YAML

import drakesep
from drakesep.analysis import AnalysisCase, Ellipsoid, Requirement
from drakesep.case_file.reader import load_case
from drakesep.systems import (
    Attachment,
    Body,
    InitialMotion,
    Integration,
    Joint,
    Separation,
    Spring,
)


TEXT = """
name: small
pair: {A: lower, B: upper}
bodies:
  lower:
    mass_kg: 700
    cg_mm: [-800, 0, 0]
    inertia_kg_m2: {xx: 300, yy: 350, zz: 350}
  upper:
    mass_kg: 500
    cg_mm: [600, 2, -3]
    inertia_kg_m2: {xx: 180, yy: 120, zz: 130}
attachments:
  pad:
    A: lower
    B: upper
    position_mm: [0, 10, 0]
    joint: &joint
      stiffness_N_m: 1.0e+6
      damping_N_s_m: 5.0e+3
      angular_stiffness_N_m_rad: 1.0e+5
      angular_damping_N_m_s_rad: 500
    spring: {name: push, force_max_N: 1500, stroke_mm: 100, design_mass_kg: 290}
before_separation: {rate_deg_s: [0.5, 0, 0]}
dispersions: {upper.mass_kg: 20, upper.cg_y_mm: 5, upper.cg_z_mm: 4}
ellipsoids:
- parameters: [upper.cg_y_mm, upper.cg_z_mm]
requirements:
- {quantity: longitudinal_speed_after_separation_m_s, at_least: 0.3}
run: {duration_s: 1, accuracy: 1.0e-6}
"""


def made_in_python() -> AnalysisCase:
    """The same, in SI and radians."""
    lower = Body(
        name="lower",
        mass=700.0,
        p_BoBcm_B=(-0.8, 0.0, 0.0),
        I_BBcm_B=(300.0, 350.0, 350.0, 0.0, 0.0, 0.0),
    )
    upper = Body(
        name="upper",
        mass=500.0,
        p_BoBcm_B=(0.6, 0.002, -0.003),
        I_BBcm_B=(180.0, 120.0, 130.0, 0.0, 0.0, 0.0),
    )
    pad = Attachment(
        name="pad",
        A="lower",
        B="upper",
        p_AoPad_A=(0.0, 0.01, 0.0),
        joint=Joint(K_F=1e6, D_F=5e3, K_T=1e5, D_T=500.0),
        spring=Spring(name="push", force_max=1500.0, stroke=0.1, design_mass=290.0),
        release_time=0.0,
    )
    return AnalysisCase(
        name="small",
        separation=Separation(
            bodies=(lower, upper),
            attachments=(pad,),
            A="lower",
            B="upper",
            # 1 deg is 1 / math.degrees(1.0) rad to the last bit, as files have it.
            initial=InitialMotion(w_WA_A=(0.5 / math.degrees(1.0), 0.0, 0.0)),
            duration=1.0,
        ),
        integration=Integration(accuracy=1e-6),
        tolerances={"upper.mass": 20.0, "upper.cg_y": 0.005, "upper.cg_z": 0.004},
        ellipsoids=(Ellipsoid(names=("upper.cg_y", "upper.cg_z")),),
        requirements=(
            Requirement(
                metric="longitudinal_speed_after_separation", sense=">=", limit=0.3
            ),
        ),
    )


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("small") / "small.yaml"
    path.write_text(TEXT)
    return path


def test_it_is_the_record_of_the_file(file):
    assert load_case(file).in_si() == made_in_python()
    case = drakesep.Case.model_validate(YAML(typ="safe").load(TEXT))
    assert case.in_si() == made_in_python()


def test_one_run(file):
    heavier = {"upper.mass_kg": 515.0}
    ours, of_file = (
        drakesep.simulate(case, heavier) for case in (made_in_python(), file)
    )
    assert ours.completed
    pd.testing.assert_frame_equal(ours.summary, of_file.summary, check_exact=True)
    pd.testing.assert_frame_equal(ours.motion, of_file.motion, check_exact=True)
    assert ours.summary["role"].tolist() == ["changed"]


def test_verification(file):
    """In Drake alone: nothing is compiled."""
    ours, of_file = (
        drakesep.verify(case, searches=["drake"], workers=1)
        for case in (made_in_python(), load_case(file))
    )
    assert ours.passed
    for name in ("table", "requirements", "evidence", "iterates"):
        first, second = (getattr(study, name) for study in (ours, of_file))
        assert len(first)
        pd.testing.assert_frame_equal(first, second, check_exact=True)


def test_what_varies_it_is_flown():
    """0.9 m/s is wanted of bodies that part at sqrt(F m_S L) / mu = 0.72 m/s."""
    case = made_in_python()
    [least] = case.requirements
    strict = dataclasses.replace(least, limit=0.9)
    of_mass = dataclasses.replace(
        case, requirements=(strict,), tolerances={"upper.mass": 20.0}, ellipsoids=()
    )
    study = drakesep.verify(of_mass, searches=["drake"], workers=1)
    assert study.completed
    assert not study.passed
    # The heaviest payload is the slowest.
    speeds = study.table.set_index("label")
    worst = speeds.loc["worst_lowest_longitudinal_speed_after_separation"]
    assert worst["upper.mass_kg"] == pytest.approx(520.0)
    with pytest.raises(ValueError, match=r"upper\.mass: tolerance must keep"):
        dataclasses.replace(case, tolerances={"upper.mass": 500.0}, ellipsoids=())
