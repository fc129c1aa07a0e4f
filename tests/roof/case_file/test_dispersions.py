"""Tolerances as people write them: shares, bounds, sides, and many by one name."""

import json
import math
import re

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from ruamel.yaml import YAML
from trade import BODIES, symmetric_design

from drakesep.analysis.tolerances.sides import Sides
from drakesep.case_file.case import Case
from drakesep.case_file.errors import CaseError
from drakesep.results.case_json import from_json, to_json


def tolerances(**dispersions):
    return dict(symmetric_design(dispersions=dispersions).in_si().tolerances)


@given(share=st.floats(0.01, 50.0))
def test_share_of_the_nominal(share):
    text = f"{share:.4f} %"
    read = tolerances(**{"sc.mass_kg": text, "lv.cg_x_mm": text})
    part = float(text[:-2]) / 100.0
    # Of 500 kg, and of -1200 mm: to either side.
    assert read["sc.mass"] == pytest.approx(500.0 * part, rel=1e-12)
    assert read["lv.cg_x"] == pytest.approx(1.2 * part, rel=1e-12)


def test_a_pattern_gives_each_its_own():
    read = tolerances(**{"s?.force_max_N": 15, "s2.force_max_N": "10 %"})
    assert read == {
        "s1.force_max": 15.0,
        "s2.force_max": pytest.approx(50.0),  # what is named has its own
        "s3.force_max": 15.0,
        "s4.force_max": 15.0,
    }
    read = tolerances(**{"*.mass_kg": "2 %"})
    assert read == {"lv.mass": pytest.approx(40.0), "sc.mass": pytest.approx(10.0)}
    # As if each were written: in their units.
    read = tolerances(**{"sc.cg_[yz]_mm": 3})
    assert read == {"sc.cg_y": 0.003, "sc.cg_z": 0.003}


@pytest.mark.parametrize(
    ("dispersions", "message"),
    [
        ({"sc.cg_y_mm": "5 %"}, "sc.cg_y_mm: a share must be of a nominal that is not"),
        ({"sc.cg_*_mm": "5 %"}, "sc.cg_y_mm: a share must be of a nominal that is not"),
        ({"t*.force_max_N": 1}, "t*.force_max_N: must fit a parameter, got none"),
        (
            {"s1*.force_max_N": 1, "s?.force_max_N": 2},
            "s1.force_max_N: must fit one pattern, got s1*.force_max_N and s?",
        ),
        ({"sc.mas_kg": 1}, "unknown parameter 'sc.mas_kg'; did you mean 'sc.mass_kg'?"),
    ],
)
def test_what_fits_nothing_is_refused(dispersions, message):
    with pytest.raises(ValueError, match=re.escape(f"dispersions: {message}")):
        tolerances(**dispersions)


@pytest.mark.parametrize("wrong", ["5", "5 kg", "-5 %", "0 %", "%", 0, -1.0])
def test_what_is_no_tolerance_is_refused(wrong):
    with pytest.raises(ValueError, match="must be"):
        tolerances(**{"sc.mass_kg": wrong})


# A bound that round-off alone tells from the nominal is refused.
_BELOW = st.just(600.0) | st.floats(0.0, 600.0 - 1e-9)
_ABOVE = st.just(600.0) | st.floats(600.0 + 1e-9, 1e4)


@given(lower=_BELOW, upper=_ABOVE)
def test_bounds_are_values_of_the_parameter(lower, upper):
    """Of sc.cg_x, 600 mm; either may be the nominal."""
    assume(lower < upper)
    read = tolerances(**{"sc.cg_x_mm": {"lower": lower, "upper": upper}})["sc.cg_x"]
    # Round-off of the bounds in m.
    close = {"rel": 1e-12, "abs": 1e-15}
    assert read.minus == pytest.approx(0.6 - 1e-3 * lower, **close)
    assert read.plus == pytest.approx(1e-3 * upper - 0.6, **close)


def test_sides_are_from_the_nominal():
    read = tolerances(
        **{
            "s*.force_max_N": {"minus": 10, "plus": "3 %"},  # of 500
            "s2.force_max_N": {"lower": 400, "upper": 510},
            "a1.release_time_s": {"minus": 0, "plus": 0.01},
            "sc.cg_x_mm": {"minus": "0 %", "plus": "1 %"},  # of 600
        }
    )
    sides = Sides(minus=10.0, plus=15.0)
    assert read == {
        "s1.force_max": sides,
        "s2.force_max": Sides(minus=100.0, plus=10.0),
        "s3.force_max": sides,
        "s4.force_max": sides,
        "a1.release_time": Sides(minus=0.0, plus=0.01),
        "sc.cg_x": Sides(minus=0.0, plus=0.006),
    }


def test_bounds_of_a_pattern_hold_each_nominal():
    bodies = BODIES | {"lv": BODIES["lv"] | {"mass_kg": 520.0}}
    case = symmetric_design(
        bodies=bodies, dispersions={"*.mass_kg": {"lower": 490, "upper": 530}}
    )
    assert dict(case.in_si().tolerances) == {
        "lv.mass": Sides(minus=30.0, plus=10.0),
        "sc.mass": Sides(minus=10.0, plus=30.0),
    }


@pytest.mark.parametrize(
    ("tolerance", "message"),
    [
        (
            {"lower": 2, "upper": 8},
            "dispersions: sc.cg_x_mm: lower and upper must hold the nominal, 600, got "
            "2 to 8",
        ),
        ({"lower": 700, "upper": 800}, "must hold the nominal, 600, got 700 to 800"),
        (
            {"lower": 5, "upper": 3},
            "dispersions.sc.cg_x_mm: upper must be > lower, got 5 to 3",
        ),
        ({"lower": 5, "upper": 5}, "sc.cg_x_mm: upper must be > lower, got 5 to 5"),
        (
            {"lower": 5},
            "dispersions.sc.cg_x_mm: must have lower and upper, or minus and plus, got "
            "lower",
        ),
        ({"minus": 5}, "must have lower and upper, or minus and plus, got minus"),
        ({"lower": 5, "plus": 5}, "or minus and plus, got lower and plus"),
        ({}, "discrete, lower and upper, or minus and plus, got none"),
        ({"lowr": 5, "upper": 7}, "unknown key 'lowr'; did you mean 'lower'?"),
        ({"lower": "5 %", "upper": 7}, "sc.cg_x_mm.lower: must be a number, got '5 %'"),
        ({"minus": 0, "plus": 0}, "minus or plus must be > 0, got 0 for both"),
        ({"minus": -1, "plus": 1}, "sc.cg_x_mm.minus: must be finite and >= 0, got -1"),
        ({"minus": 1, "plus": "a"}, "sc.cg_x_mm.plus: must be a number, or a share"),
        ({"minus": "0 %", "plus": 0}, "minus or plus must be > 0, got 0 for both"),
        ({"minus": "0 %", "plus": "0.0 %"}, "minus or plus must be > 0, got 0 for"),
        ([2, 8], "dispersions.sc.cg_x_mm: must be a number, or a share of the nominal"),
        (True, "dispersions.sc.cg_x_mm: must be a number, or a share of the nominal"),
        (math.inf, "dispersions.sc.cg_x_mm: must be finite and > 0, got inf"),
    ],
)
def test_what_is_no_bound_is_refused(tolerance, message):
    case = symmetric_design()
    with pytest.raises(CaseError, match=re.escape(message)):
        case.replaced(dispersions={"sc.cg_x_mm": tolerance})


numbers = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.integers(-10, 10),
    st.booleans(),
    st.none(),
    st.sampled_from(["5 %", "0 %", "5", ""]),
)
keys = st.sampled_from(["lower", "upper", "minus", "plus", "nominal"])


@given(tolerance=st.one_of(numbers, st.dictionaries(keys, numbers)))
def test_read_or_refused_by_name(tolerance):
    """Nothing else: no traceback, and no tolerance that is none."""
    try:
        case = symmetric_design().replaced(dispersions={"sc.cg_y_mm": tolerance})
    except CaseError as error:
        assert "sc.cg_y_mm" in str(error)
        return
    [read] = case.in_si().tolerances.values()
    sides = Sides.of(read)
    assert 0.0 <= sides.minus < math.inf
    assert 0.0 <= sides.plus < math.inf
    assert sides.larger > 0.0


def test_what_is_not_physical_is_told_with_its_sides():
    case = symmetric_design()
    message = "dispersions: sc.mass_kg -600 +1: sc: mass must be > 0, got -100"
    with pytest.raises(CaseError, match=re.escape(message)):
        case.replaced(dispersions={"sc.mass_kg": {"minus": 600, "plus": 1}})


def test_an_ellipsoid_needs_the_middle():
    both = {"sc.cg_y_mm": {"lower": -1, "upper": 2}, "sc.cg_z_mm": 2}
    message = "ellipsoids: ellipsoid: sc.cg_y must have the same tolerance to either"
    with pytest.raises(CaseError, match=re.escape(message)):
        symmetric_design().replaced(
            dispersions=both, ellipsoids=[{"parameters": list(both)}]
        )


def test_written_and_read_again():
    """In the text of a case, and in what a results folder records."""
    sides = {
        "sc.cg_y_mm": {"lower": -1, "upper": 3},
        "s1.force_max_N": {"minus": "2 %", "plus": 3},
        "sc.mass_kg": 2.5,
    }
    case = symmetric_design(dispersions=sides)
    again = Case.model_validate(YAML(typ="safe").load(case.text))
    assert again == case
    record = case.in_si()
    assert from_json(json.loads(json.dumps(to_json(record)))) == record
