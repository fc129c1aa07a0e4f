"""Tolerances as people write them: shares of the nominal, and many by one name."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st
from trade import symmetric_design


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
