"""Descriptions that make no sense are refused, by the name of the field."""

import dataclasses
import math
import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st
from separations import generic_pair, inertia_of_points

from drakesep.systems.model.integration import Integration
from drakesep.systems.model.orbit import Orbit
from drakesep.systems.model.separation import Body, InitialMotion


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("mass", -3.0, "upper: mass must be > 0, got -3"),
        ("p_BoBcm_B", (0.0, 1.0), "upper: CG must have 3 entries, got 2"),
        ("mass", math.nan, "upper: mass must be finite, got nan"),
        ("p_BoBcm_B", (0.0, math.inf, 0.0), "upper: CG must be finite, got inf"),
        ("I_BBcm_B", (1.0, 1.0, 3.0, 0, 0, 0), "triangle inequality; got xx 1"),
        ("I_BBcm_B", (1.0, -1.0, 1.0, 0, 0, 0), "must be positive definite; got xx 1"),
    ],
)
def test_impossible_body(field, value, message):
    upper = generic_pair().body("upper")
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(upper, **{field: value})


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("force_max", -1.0, "spring_1: maximum force must be >= 0, got -1"),
        ("lost_stroke", 1.0, "spring_1: lost stroke must be >= 0 and below 1, got 1"),
        ("stroke", 0.0, "spring_1: stroke must be > 0, got 0"),
        ("design_mass", -1.0, "spring_1: design mass must be > 0, got -1"),
    ],
)
def test_impossible_spring(field, value, message):
    spring = generic_pair().springs[0]
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(spring, **{field: value})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"B": "lower"}, "must join two different bodies, got 'lower' twice"),
        ({"B": "uper"}, "unknown body 'uper'; did you mean 'upper'"),
        ({"release_time": 1.0}, "release time must lie before the end of the run"),
        ({"release_time": math.nan}, "release time must be finite, got nan"),
        ({"release_time": 0.95}, "duration must be longer than it takes the springs"),
        ({"name": "spring_2"}, "names must differ, got 'spring_2' 2 times"),
        ({"name": "before_separation"}, "it is reserved"),
        ({"release_time": -0.1}, "release time must be >= 0, got -0.1"),
    ],
)
def test_impossible_attachment(changes, message):
    separation = generic_pair()
    first, *others = separation.attachments
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(
            separation, attachments=(dataclasses.replace(first, **changes), *others)
        )


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"B": "payload"}, "pair: unknown body 'payload'"),
        ({"B": "lower"}, "pair: must name two different bodies"),
        ({"A": "upper", "B": "lower"}, None),
        ({"duration": 0.0}, "duration must be > 0"),
        ({"duration": "3"}, "duration must be a number, got '3'"),
    ],
)
def test_impossible_separation(changes, message):
    if message is None:
        dataclasses.replace(generic_pair(), **changes)
        return
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(generic_pair(), **changes)


def test_base_stands_at_the_origin_of_the_stack():
    separation = generic_pair()
    lower, upper = separation.bodies
    shifted = dataclasses.replace(lower, p_ABo=(1.0, 0.0, 0.0))
    with pytest.raises(ValueError, match="lower: mated place must be zero"):
        dataclasses.replace(separation, bodies=(shifted, upper))


def test_every_body_is_attached():
    separation = generic_pair()
    loose = dataclasses.replace(separation.body("upper"), name="loose")
    with pytest.raises(ValueError, match="loose: must be attached"):
        dataclasses.replace(separation, bodies=(*separation.bodies, loose))


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("scheme", "euler", "unknown integration scheme 'euler'"),
        ("accuracy", 0.1, "accuracy must be from 1e-12 to 0.001, got 0.1"),
        ("accuracy", 1e-15, "accuracy must be from 1e-12 to 0.001, got 1e-15"),
        ("max_step", 0.0, "max_step must be > 0, got 0"),
    ],
)
def test_impossible_integration(field, value, message):
    with pytest.raises(ValueError, match=message):
        Integration(**{field: value})


def test_other_records_check_themselves():
    with pytest.raises(ValueError, match="orbit: radius must be > 0"):
        Orbit(radius=-1.0)
    with pytest.raises(ValueError, match="rate before separation must be finite"):
        InitialMotion(w_WA_A=(0.0, math.nan, 0.0))
    joint = generic_pair().attachments[0].joint
    with pytest.raises(ValueError, match="joint D_T must be >= 0, got -1"):
        dataclasses.replace(joint, D_T=-1.0)


@given(seed=st.integers(0, 10_000), mass=st.floats(1e-3, 1e6))
def test_every_cloud_of_points_is_a_body(seed, mass):
    inertia = inertia_of_points(seed, mass)
    Body(name="cloud", mass=mass, p_BoBcm_B=(0.0, 0.0, 0.0), I_BBcm_B=inertia)


def test_separations_travel_between_processes():
    separation = generic_pair()
    assert pickle.loads(pickle.dumps(separation)) == separation
