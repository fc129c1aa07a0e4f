"""Tolerances whose nominal is not the middle, from the case file to the tables."""

import math

import numpy as np
import pytest
from trade import SPEED, symmetric_design

import drakesep


EFFORT = {"samples": 100, "starts": 2, "growth": True, "corners": 64}
"""Extremes of these cases lie in a corner."""
CLOSE = 1e-6
"""100 times the accuracy, of a run of some hundred steps."""


def speed(force):
    """Of springs of equal force, which turn nothing: as the root of their energy."""
    return SPEED * math.sqrt(force / 500.0)


def springs(**changes):
    """Four springs of 500 N, that may be 10 N weaker or 20 N stronger, each its own."""
    limits = {
        "quantity": "longitudinal_speed_m_s",
        "when": "after_separation",
        "at_least": speed(480.0),  # twice as far as the lower bound
        "at_most": speed(550.0),  # two and a half times as far as the upper one
    }
    return symmetric_design(
        dispersions={"s*.force_max_N": {"lower": 490, "upper": 520}},
        requirements=[limits],
        **changes,
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("results")


@pytest.fixture(scope="module")
def study(folder):
    return drakesep.verify(springs(), output=folder, **EFFORT)


def test_worst_at_either_bound(study):
    rows = study.requirements.set_index("sense")
    assert rows["worst"].to_dict() == pytest.approx(
        {">=": speed(490.0), "<=": speed(520.0)}, rel=CLOSE
    )
    assert study.passed


def test_growth_of_each_side_about_the_nominal(study):
    """The largest factor on both sides at which the limit is reached."""
    rows = study.requirements.set_index("sense")
    # A growth is found to a thousandth.
    expected = {">=": 2.0, "<=": 2.5}
    assert rows["growth_factor"].to_dict() == pytest.approx(expected, rel=1e-3)


def test_tables_mark_the_bounds(study):
    points = study.worst_points.set_index("parameter")
    low = points["lowest_longitudinal_speed_after_separation"]
    high = points["highest_longitudinal_speed_max_after_separation"]
    assert set(low) == {"m"}
    assert set(high) == {"M"}
    sensitivities = study.sensitivities
    assert set(sensitivities["tolerance"]) == {20.0}  # of the larger side
    # Of v = SPEED sqrt(sum F / 2000): for 20 N of one, at the nominal. A slope by
    # differences of 1e-3 tolerances is right to the curvature, 20 / 8000 of it.
    slope = SPEED * 20.0 / (2.0 * 2000.0)
    slopes = sensitivities["per_tolerance_at_nominal"].to_numpy()
    assert slopes == pytest.approx(slope, rel=5e-3)
    assert set(sensitivities["at_worst"]) == {"m", "M"}


def test_either_side_has_its_own_sensitivity(study):
    """10 N less of one spring takes half of what 20 N more gives, to first order."""
    sensitivities = study.sensitivities
    assert set(sensitivities["minus"]) == {10.0}
    assert set(sensitivities["plus"]) == {20.0}
    forces = {"nominal": {"m": 500.0, "M": 500.0}, "worst": {"m": 490.0, "M": 520.0}}
    for at, marked in forces.items():
        force = sensitivities["at_worst"].map(marked).to_numpy()
        # Of v = SPEED sqrt(sum F / 2000), by differences of 1e-3 tolerances.
        of_one = SPEED * np.sqrt(force / 500.0) / (8.0 * force)
        up, down = (sensitivities[f"{way}_at_{at}"] for way in ("upward", "downward"))
        assert up.to_numpy() == pytest.approx(20.0 * of_one, rel=5e-3)
        assert down.to_numpy() == pytest.approx(-10.0 * of_one, rel=5e-3)


def test_a_nominal_in_the_middle_has_the_same_worst_cases():
    """490 to 520 N about 500 and about 505: what is admitted is the same."""
    attachments = springs().model_dump(mode="json", exclude_none=True)["attachments"]
    for attachment in attachments.values():
        attachment["spring"]["force_max_N"] = 505.0
    middle = symmetric_design(
        attachments=attachments, dispersions={"s*.force_max_N": 15}
    )
    objectives = ["highest_final_rate_y", "lowest_longitudinal_speed_max"]
    one, other = (
        drakesep.worst_case(case, objectives, searches=["vertices"])
        .evidence["worst"]
        .to_numpy()
        for case in (springs(), middle)
    )
    # The same rows to round-off, which steps of a run do not enlarge by more.
    assert one == pytest.approx(other, rel=1e-9)


def test_recorded_in_the_folder(study, folder):
    assert drakesep.read_results(folder).case == springs().in_si()
