"""Sliders over parameters, runs flown for them, charts of these."""

import os
import signal

import numpy as np
import pytest
from small_case import small_case

from drakesep.case_file.case import Case
from drakesep.page import charts, playing
from drakesep.page.flights import Flights, FlightsEnded
from drakesep.page.flown import fly
from drakesep.studies.simulate import simulate


@pytest.fixture(scope="module")
def case():
    return Case(**small_case())


@pytest.fixture(scope="module")
def flown(case):
    return fly(case.in_si(), {"upper.mass_kg": 1180.0}, measure=False)


def test_sliders_are_over_the_tolerances(case):
    found = {each.name: each for each in playing.dispersed(case)}
    mass = found["upper.mass_kg"]
    tolerance = small_case()["dispersions"]["upper.mass_kg"]
    assert (mass.low, mass.nominal, mass.high) == (
        1200.0 - tolerance,
        1200.0,
        1200.0 + tolerance,
    )
    assert (mass.words, mass.unit) == ("upper · mass", "kg")
    for each in found.values():
        steps = (each.high - each.low) / each.step
        assert 80 <= steps <= 201  # a round number, fine enough
        places = (each.nominal - each.low) / each.step
        assert places == pytest.approx(round(places), abs=1e-6)  # nominal is one


def test_another_parameter_has_a_slider_about_its_value(case):
    played = playing.other(case, "lower.mass_kg")
    assert (played.low, played.high) == (560.0, 840.0)
    start = playing.other(case, "one.release_time_s")
    assert start.low == 0.0 < start.high


def test_what_stands_at_its_nominal_is_no_change(case):
    state = playing.Playing()
    assert state.follow(case) and not state.follow(case)
    state.put("upper.mass_kg", 1190.0)
    assert state.values == {"upper.mass_kg": 1190.0}
    state.put("upper.mass_kg", 1200.0)
    assert not state.values
    state.add(case, "lower.mass_kg")
    state.put("lower.mass_kg", 710.0)
    changed = small_case()
    changed["bodies"]["lower"]["mass_kg"] = 710.0
    assert state.follow(Case(**changed))
    assert not state.values  # it is nominal now
    state.put("lower.mass_kg", 720.0)
    state.reset()
    assert not state.values


def test_a_run_is_that_of_the_command(case, flown):
    """The page shows what `drakesep simulate` writes."""
    result = simulate(case, {"upper.mass_kg": 1180.0})
    signals = {(s.quantity, s.axis): s for s in flown.signals if s.body == "upper"}
    for (quantity, axis), column in {
        ("rate", "y"): "rate_y_deg_s",
        ("angle", "yaw"): "angle_yaw_deg",
        ("relative velocity", "x"): "relative_velocity_x_m_s",
    }.items():
        expected = result.motion[column].to_numpy()
        np.testing.assert_array_equal(signals[quantity, axis].values, expected)
    np.testing.assert_array_equal(flown.times["upper"], result.motion["time_s"])
    assert [f.verdict for f in flown.fares] == list(result.requirements["verdict"])


def test_a_chart_has_curves_and_limits_while_they_hold(flown):
    found = charts.charts_of(flown, "upper")
    assert [chart.quantity for chart in found][:3] == [
        *("rate", "angle", "relative velocity")
    ]
    for chart in found:
        series = {each["id"]: each for each in charts.options(chart, flown)["series"]}
        told = {each["id"]: each["data"] for each in charts.run_data(chart, flown)}
        nominal = {each["id"] for each in charts.nominal_data(chart, flown)}
        assert told.keys() | nominal == series.keys()
        for s in flown.signals:
            if (s.quantity, s.body) == (chart.quantity, "upper"):
                drawn = np.array(told[f"run {s.axis}"])
                assert drawn[-1] == pytest.approx(
                    [flown.times["upper"][-1], s.values[-1]], rel=1e-5, abs=1e-12
                )
                for i, limit in enumerate(s.limits):
                    line = told[f"limit {s.axis} {i}"]
                    assert line[:2] == [
                        [limit.start, limit.values[0]],
                        [limit.end, limit.values[0]],
                    ]
    assert sum(len(s.limits) for s in flown.signals) == sum(
        f.verdict != "not looked at" for f in flown.fares
    )


def test_a_run_that_fails_says_why(case):
    data = small_case()
    data["published"] = None
    for attachment in data["attachments"].values():
        spring = attachment["spring"]
        spring.pop("design_mass_kg", None)
        spring |= {"law": "displacement", "stroke_mm": 5000.0}
    failed = fly(Case(**_without_none(data)).in_si(), {}, measure=False)
    assert "has not reached its" in failed.message and not failed.signals


def _without_none(data):
    return {key: value for key, value in data.items() if value is not None}


def test_the_newest_is_flown_and_a_killed_process_is_told_and_started_again(case):
    flights, si = Flights(), case.in_si()
    try:
        asked = [flights.fly(si, {"upper.mass_kg": 1190.0 + i}) for i in range(5)]
        beside = [flights.fly(si, {}, asker=who) for who in ("other", "third")]
        answers = [each.result(timeout=120) for each in asked]
        assert [answer is None for answer in answers] == [
            False,
            True,
            True,
            True,
            False,
        ]
        newest = fly(si, {"upper.mass_kg": 1194.0}, measure=False)
        for one, other in zip(answers[-1].signals, newest.signals, strict=True):
            np.testing.assert_array_equal(one.values, other.values)
        # Each asker has its own turn.
        assert all(one.result(timeout=120) is not None for one in beside)
        with pytest.raises(ValueError, match="mass must be > 0"):
            flights.fly(si, {"upper.mass_kg": -1.0}).result(timeout=120)
        [process] = flights._pool._processes
        waits = flights.fly(si, {}, measure=True)
        os.kill(process, signal.SIGKILL)
        with pytest.raises(FlightsEnded):
            waits.result(timeout=120)
        assert flights.fly(si, {}).result(timeout=120).message == ""
    finally:
        flights.end()
