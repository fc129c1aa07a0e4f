"""Parameters by name: each reaches its place, and only that."""

import math

import pytest
from separations import generic_pair

from drakesep.systems.model.parameters import parameters, with_values


@pytest.mark.parametrize("name", parameters(generic_pair()))
def test_each_parameter_changes_alone(name):
    separation = generic_pair()
    before = parameters(separation)
    value = before[name] * (1.0 + 1e-3) + 1e-4
    after = parameters(with_values(separation, {name: value}))
    assert after == {**before, name: value}


def test_several_entries_of_one_vector():
    values = {"upper.cg_x": 1.0, "upper.cg_z": 2.0}
    changed = with_values(generic_pair(), values)
    assert changed.body("upper").p_BoBcm_B == (1.0, -0.02, 2.0)


def test_nothing_changed_is_the_same_separation():
    assert with_values(generic_pair(), {}) == generic_pair()


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("upper.mas", 1.0, "unknown parameter 'upper.mas'; did you mean 'upper.mass'"),
        ("upper.mass", math.nan, "upper.mass must be finite, got nan"),
        ("upper.mass", -1.0, "upper: mass must be > 0, got -1"),
        ("spring_1.stroke", 0.0, "spring_1: stroke must be > 0"),
    ],
)
def test_bad_values(name, value, message):
    with pytest.raises(ValueError, match=message):
        with_values(generic_pair(), {name: value})
