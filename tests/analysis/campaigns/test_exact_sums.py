"""Sums without round-off, against exact fractions."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drakesep.analysis.campaigns import exact_sums
from drakesep.analysis.campaigns.exact_sums import (
    exact_sum,
    exact_sum_of_squares,
    in_units,
)
from drakesep.systems.checks import InputError


ANY = st.floats(allow_nan=False, allow_infinity=False)
SQUARED = st.floats(1e-140, 1e150) | st.floats(-1e150, -1e-140) | st.just(0.0)


@given(values=st.lists(ANY, max_size=30))
def test_sums_are_those_of_fractions(values):
    """Of whatever floats, the least among them."""
    wanted = sum(map(Fraction, values), Fraction())
    assert in_units(exact_sum(np.array(values, float))) == wanted


@given(values=st.lists(SQUARED, max_size=30))
def test_sums_of_squares_are_those_of_fractions(values):
    wanted = sum((Fraction(x) ** 2 for x in values), Fraction())
    assert in_units(exact_sum_of_squares(np.array(values, float))) == wanted


def test_more_than_fit_into_a_float(monkeypatch):
    """Sums of digits are cut up where they would be rounded."""
    values = np.random.default_rng(1).standard_normal(1000)
    whole = exact_sum(values)
    monkeypatch.setattr(exact_sums, "_MOST", 7)
    assert exact_sum(values) == whole
    assert in_units(whole) == sum(map(Fraction, values.tolist()))
    # The most that are summed at once, of the largest mantissa: 27 digits and 26.
    assert (2**27) * (2**26) <= 2**53


def test_values_whose_square_is_no_float():
    with pytest.raises(
        InputError, match=r"values must be at most 1e\+150, got 1e\+200"
    ):
        exact_sum_of_squares(np.array([1.0, 1e200]))
