"""Names that carry units."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drakesep.units import unit_of, with_unit


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("payload.cg_x", "payload.cg_x_mm"),
        ("payload.inertia_xy", "payload.inertia_xy_kg_m2"),
        ("spring_1.force_max", "spring_1.force_max_N"),
        ("before_separation.rate_x", "before_separation.rate_x_deg_s"),
        ("rate_x", "rate_x_deg_s"),
        ("G_Linf", "G_Linf_deg_s"),
    ],
)
def test_with_unit(name, expected):
    assert with_unit(name) == expected


@given(value=st.floats(-1e6, 1e6))
@pytest.mark.parametrize("name", ["payload.cg_x", "rate_x", "payload.mass"])
def test_there_and_back(name, value):
    unit = unit_of(name)
    assert unit.from_si(unit.to_si(value)) == pytest.approx(value, rel=3e-16)


def test_known_conversions():
    assert unit_of("payload.cg_x").to_si(1933.0) == 1.933
    assert unit_of("rate_x").to_si(180.0) == math.pi
