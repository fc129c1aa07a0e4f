"""Rows that are not physical: those that the model refuses, and no others."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import drakesep
from drakesep.systems.batch.row_checks import RowChecks
from drakesep.systems.model.inertia import check_inertia
from drakesep.systems.model.parameters import parameters, with_values


SEPARATION = drakesep.load_case("vega").separation
INERTIA = [f"payload.inertia_{axes}" for axes in ("xx", "yy", "zz", "xy", "xz", "yz")]

moments = st.floats(0.1, 100.0)
products = st.floats(-60.0, 60.0)


def is_refused(row) -> bool:
    try:
        check_inertia("body", tuple(row))
    except ValueError:
        return True
    return False


@given(rows=st.lists(st.tuples(*[moments] * 3, *[products] * 3), min_size=1))
def test_inertias(rows):
    failures = RowChecks(SEPARATION, INERTIA).failures(np.array(rows))
    assert sorted(failures) == [i for i, row in enumerate(rows) if is_refused(row)]


@pytest.mark.parametrize("slack", [1e-15, 1e-12, 1e-6, -1e-6, -1e-12])
def test_inertias_at_the_edge(slack):
    """Flat bodies, and rods, whose other moments are each other's sum or zero."""
    rows = np.array([[3.0 + slack, 1.0, 2.0, 0, 0, 0], [slack, 1.0, 1.0, 0, 0, 0]])
    failures = RowChecks(SEPARATION, INERTIA).failures(rows)
    assert sorted(failures) == [i for i, row in enumerate(rows) if is_refused(row)]


@given(data=st.data())
def test_every_parameter_about_its_ends(data):
    """One row of many, of which one parameter is at an end of what it may be."""
    nominal = parameters(SEPARATION)
    name = data.draw(st.sampled_from(list(nominal)))
    ends = st.sampled_from([-1e300, -1.0, -1e-300, 0.0, 5e-324, 1.0, 1e16, np.inf])
    values = data.draw(st.lists(ends | st.just(np.nan), min_size=1, max_size=5))

    def refused(value: float) -> bool:
        try:
            with_values(SEPARATION, {name: value})
        except ValueError:
            return True
        return not np.isfinite(value)

    failures = RowChecks(SEPARATION, [name]).failures(np.array(values)[:, None])
    assert sorted(failures) == [i for i, value in enumerate(values) if refused(value)]


def test_rows_of_many_blocks_keep_their_numbers():
    rows = np.full((10_000, 1), parameters(SEPARATION)["payload.mass"])
    bad = [0, 4095, 4096, 9999]
    rows[bad] = -1.0
    failures = RowChecks(SEPARATION, ["payload.mass"]).failures(rows)
    assert list(failures) == bad
    assert all("payload: mass must be > 0" in why for why in failures.values())


def test_a_spring_that_pushes_beyond_the_run():
    """Eq. 5: a quarter of the period of a stroke under its force."""
    short = dataclasses.replace(SEPARATION, duration=0.2)
    rows = np.array([[0.0], [0.19], [0.2]])
    names = [f"{SEPARATION.attachments[0].name}.release_time"]
    failures = RowChecks(short, names).failures(rows)
    assert 0 not in failures
    assert {1, 2} <= set(failures)
