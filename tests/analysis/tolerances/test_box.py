"""The box of tolerances."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from separations import generic_pair

from drakesep.analysis.tolerances.box import Dispersion, ToleranceBox


TOLERANCES = {"upper.mass": 20.0, "spring_2.stroke": 1e-3, "upper.cg_y": 0.013}
BOX = ToleranceBox.around(generic_pair(), TOLERANCES)


def test_corners():
    values = BOX.values([1.0, -1.0, 0.0])
    expected = {"upper.mass": 1220.0, "spring_2.stroke": 0.101, "upper.cg_y": -0.02}
    assert values == pytest.approx(expected, rel=1e-15)


@given(u=st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3))
def test_there_and_back(u):
    # a value is rounded at its own size, 1e5 times its tolerance at most
    assert BOX.scaled(BOX.values(u)) == pytest.approx(np.array(u), abs=1e-11)


def test_what_is_not_given_is_nominal():
    assert BOX.scaled({"upper.mass": 1210.0}).tolist() == [0.5, 0.0, 0.0]


@pytest.mark.parametrize(
    ("tolerances", "message"),
    [
        (
            {"upper.mas": 1.0},
            "unknown parameter 'upper.mas'; did you mean 'upper.mass'",
        ),
        ({"upper.mass": 0.0}, "upper.mass: tolerance must be > 0, got 0"),
        ({"upper.mass": math.nan}, "upper.mass: tolerance must be finite, got nan"),
        ({"upper.mass": 1200.0}, "upper.mass: tolerance must keep to physical values"),
        ({"spring_1.stroke": 0.2}, "spring_1.stroke: tolerance must keep to physical"),
        (
            {"upper.inertia_xx": 1e4},
            "upper.inertia_xx: tolerance must keep to physical",
        ),
        ({"attachment_1.release_time": 2.0}, "release_time: tolerance must keep"),
    ],
)
def test_bad_tolerances(tolerances, message):
    with pytest.raises(ValueError, match=message):
        ToleranceBox.around(generic_pair(), tolerances)


def test_unknown_name_of_a_point():
    with pytest.raises(ValueError, match=r"unknown dispersed parameter 'upper.cg_x'"):
        BOX.scaled({"upper.cg_x": 1.0})


def test_bad_dispersion():
    with pytest.raises(ValueError, match="a: nominal must be finite"):
        Dispersion(name="a", nominal=math.inf, tolerance=1.0)
