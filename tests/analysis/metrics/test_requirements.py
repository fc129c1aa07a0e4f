"""Requirements: margins, the worst of several runs, verdicts."""

import dataclasses
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drakesep.analysis.metrics.metric import SENSES
from drakesep.analysis.metrics.requirements import (
    Requirement,
    UnusableLimit,
    Verdict,
    assess,
    check_limits,
    deviation_limits,
    limits_together,
    verdict_on_all,
)


AT_MOST = Requirement(metric="deviation_at_separation_pitch", sense="<=", limit=2.0)
AT_LEAST = Requirement(metric="longitudinal_speed_max", sense=">=", limit=0.5)


def test_margin():
    assert AT_MOST.margin(1.5) == 0.5
    assert AT_MOST.margin(2.5) == -0.5
    assert AT_LEAST.margin(0.75) == 0.25
    assert AT_LEAST.margin(0.25) == -0.25


def test_worst_of_several_runs():
    runs = {
        "nominal": {AT_MOST.metric: 1.0, AT_LEAST.metric: 1.0},
        "a": {AT_MOST.metric: 1.9, AT_LEAST.metric: 0.4},
        "b": {AT_MOST.metric: 1.2, AT_LEAST.metric: 0.6},
    }
    pitch, speed = assess([AT_MOST, AT_LEAST], runs, "nominal")
    assert (pitch.nominal, pitch.worst, pitch.run, pitch.met) == (1.0, 1.9, "a", True)
    assert pitch.margin == pytest.approx(0.1)
    assert (speed.worst, speed.run, speed.met) == (0.4, "a", False)


@pytest.mark.parametrize(
    ("metric", "sense", "runs", "worst"),
    [
        (
            "longitudinal_speed_after_separation",
            "<=",
            {"longitudinal_speed_max_after_separation": 1.2},
            1.2,
        ),
        ("longitudinal_speed_after_separation", ">=", {}, 0.6),
        (
            "rate_after_separation_x",
            ">=",
            {"rate_magnitude_min_after_separation_x": 0.1},
            0.1,
        ),
        ("rate_after_separation_x", "<=", {}, 0.3),
    ],
)
def test_judged_by_the_extreme_that_breaks_the_limit(metric, sense, runs, worst):
    metrics = {
        "longitudinal_speed_after_separation": 0.6,
        "rate_after_separation_x": 0.3,
        **runs,
    }
    requirement = Requirement(metric=metric, sense=sense, limit=0.5)
    [finding] = assess([requirement], {"nominal": metrics}, "nominal")
    assert (finding.worst, finding.nominal) == (worst, worst)


@pytest.mark.parametrize("place", [0, 1, 2])
@pytest.mark.parametrize("wrong", [math.nan, None])
def test_what_a_run_does_not_tell_is_never_met(place, wrong):
    """Wherever it stands among the runs, and however good the others are."""
    labels = ["nominal", "a", "b"]
    runs = {label: {AT_MOST.metric: 1.0} for label in labels}
    runs[labels[place]] = {} if wrong is None else {AT_MOST.metric: wrong}
    [finding] = assess([AT_MOST], runs, "nominal")
    assert finding.verdict is Verdict.NOT_LOOKED_AT
    assert not finding.met
    assert finding.run == labels[place]
    assert math.isnan(finding.worst) and math.isnan(finding.margin)


def test_what_is_measured_apart_is_judged_by_the_runs_that_tell_it():
    clear = Requirement(metric="clearance", sense=">=", limit=0.1)
    runs = {"nominal": {"clearance": 0.3}, "a": {}, "b": {"clearance": 0.2}}
    [finding] = assess([clear], runs, "nominal")
    assert (finding.verdict, finding.worst, finding.run) == (Verdict.MET, 0.2, "b")
    [finding] = assess([clear], {"nominal": {}, "a": {}}, "nominal")
    assert finding.verdict is Verdict.NOT_LOOKED_AT


@pytest.mark.parametrize(
    ("bound", "verdict"), [(0.05, Verdict.NOT_MET), (0.2, Verdict.NOT_LOOKED_AT)]
)
def test_what_ends_too_soon_is_a_violation_if_it_was_one_until_then(bound, verdict):
    """A clearance is the least of a window: what follows makes it no larger."""
    clear = Requirement(metric="clearance", sense=">=", limit=0.1)
    runs = {"nominal": {"clearance": 0.3}, "a": {"clearance": math.nan}}
    [finding] = assess([clear], runs, "nominal", {"a": {"clearance": bound}})
    assert (finding.verdict, finding.run) == (verdict, "a")
    if verdict is Verdict.NOT_MET:
        assert finding.worst == bound


@pytest.mark.parametrize(
    ("value", "verdict"), [(1.0, Verdict.NOT_LOOKED_AT), (2.5, Verdict.NOT_MET)]
)
def test_what_is_not_settled_may_be_broken_and_is_never_met(value, verdict):
    [finding] = assess([AT_MOST], {"nominal": {AT_MOST.metric: value}}, "nominal")
    unsettled = dataclasses.replace(finding, settled=False)
    assert unsettled.verdict is verdict
    assert unsettled.worst == value


def test_a_violation_stands_beside_runs_that_do_not_tell():
    runs = {"nominal": {}, "a": {AT_MOST.metric: 2.5}, "b": {AT_MOST.metric: math.nan}}
    [finding] = assess([AT_MOST], runs, "nominal")
    assert finding.verdict is Verdict.NOT_MET
    assert (finding.worst, finding.run) == (2.5, "a")


@pytest.mark.parametrize(
    ("values", "verdict"),
    [
        ([1.0, 1.0], Verdict.MET),
        ([1.0, math.nan], Verdict.NOT_LOOKED_AT),
        ([math.nan, 2.5], Verdict.NOT_MET),
        ([2.5, 1.0], Verdict.NOT_MET),
    ],
)
def test_one_violation_settles_all_requirements_together(values, verdict):
    findings = [
        finding
        for value in values
        for finding in assess(
            [AT_MOST], {"nominal": {AT_MOST.metric: value}}, "nominal"
        )
    ]
    assert verdict_on_all(one.verdict for one in findings) is verdict


def test_the_worst_verdict_settles_all():
    """What is not shown is no violation, and nothing to pass with."""
    order = [
        Verdict.NOT_MET,
        Verdict.NOT_SHOWN,
        Verdict.NOT_LOOKED_AT,
        Verdict.MET,
    ]
    assert sorted(order, key=order.index) == list(order)
    for i, worst in enumerate(order):
        assert verdict_on_all(order[i:]) is worst
        assert verdict_on_all(reversed(order[i:])) is worst


@pytest.mark.parametrize(("value", "on_runs"), [(1.0, "met"), (2.5, "not met")])
def test_runs_do_not_tell_of_a_share_of_launches(value, on_runs):
    """Neither that the worst is within the limit, nor that it is beyond."""
    asked = dataclasses.replace(AT_MOST, share=0.99865, confidence=0.9)
    assert asked.statistical and not AT_MOST.statistical
    [finding] = assess([asked], {"nominal": {asked.metric: value}}, "nominal")
    assert finding.verdict is Verdict.NOT_LOOKED_AT and not finding.met
    assert finding.verdict_on_runs.value == on_runs
    assert (finding.worst, finding.margin) == (value, 2.0 - value)


def test_limits_of_a_share_stand_alone_or_two_together():
    share = {"share": 0.9973, "confidence": 0.9}
    low = Requirement(metric="final_rate_x", sense=">=", limit=-1.0, **share)
    high = Requirement(metric="final_rate_x", sense="<=", limit=1.0, **share)
    assert limits_together([low, AT_MOST, high]) == [(low,), (high,)]
    two = [dataclasses.replace(one, sides="two") for one in (low, high)]
    other = [dataclasses.replace(one, id="UM-1") for one in two]
    assert limits_together([two[0], *other, two[1]]) == [tuple(two), tuple(other)]
    check_limits([*two, *other])


@pytest.mark.parametrize(
    "other", [{"id": "UM-1"}, {"share": 0.99}, {"confidence": 0.95}, {"sides": "one"}]
)
def test_one_side_of_two_is_refused(other):
    """Unless its metric is a magnitude, whose limit is one of both directions."""
    share = {"share": 0.9973, "confidence": 0.9, "sides": "two"}
    low = Requirement(metric="final_rate_x", sense=">=", limit=-1.0, **share)
    high = Requirement(metric="final_rate_x", sense="<=", limit=1.0, **share)
    check_limits([low, high])
    with pytest.raises(UnusableLimit, match="of two sides must stand with one from "):
        check_limits([low, dataclasses.replace(high, **other)])
    check_limits([dataclasses.replace(AT_MOST, **share)])


@pytest.mark.parametrize(
    ("sense", "met"), [("<=", True), ("<", False), (">=", True), (">", False)]
)
def test_a_strict_limit_is_not_met_by_a_value_at_it(sense, met):
    """Of any metric; on either side of the limit both senses say the same."""
    required = Requirement(metric=AT_MOST.metric, sense=sense, limit=2.0)
    for value in (1.0, 2.0, 3.0):
        [finding] = assess([required], {"nominal": {AT_MOST.metric: value}}, "nominal")
        inside = value < 2.0 if required.from_above else value > 2.0
        assert finding.met == (met if value == 2.0 else inside)


@given(limit=st.floats(-2.0, 2.0) | st.just(0.0), sense=st.sampled_from(SENSES))
def test_a_limit_is_refused_if_no_value_or_every_value_meets_it(limit, sense):
    """Of what is never negative, whose values are as small as 0 and as large as any."""
    required = Requirement(metric=AT_MOST.metric, sense=sense, limit=limit)
    [smallest], [largest] = (
        assess([required], {"nominal": {AT_MOST.metric: value}}, "nominal")
        for value in (0.0, 1e9)
    )
    if smallest.met == largest.met:
        with pytest.raises(UnusableLimit, match="must be >"):
            check_limits([required])
    else:
        check_limits([required])


def test_a_signed_metric_has_limits_on_both_sides_of_zero():
    for sense, limit in (("<=", -1.0), (">=", -1.0), (">=", 0.0)):
        check_limits([Requirement(metric="final_rate_x", sense=sense, limit=limit)])


def test_deviation_limits():
    assert deviation_limits([AT_MOST, AT_LEAST]) == (math.inf, 2.0, math.inf)


def test_of_several_limits_of_a_deviation_the_least_counts():
    """Whatever their order; a limit from below is none of how far it may go."""
    several = [
        Requirement(metric="deviation_at_separation_roll", sense="<=", limit=limit)
        for limit in (0.3, 0.1, 0.2)
    ]
    below = Requirement(metric="deviation_at_separation_roll", sense=">=", limit=0.05)
    for limits in (several, several[::-1], [below, *several]):
        assert deviation_limits(limits) == (0.1, math.inf, math.inf)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"limit": math.nan}, "limit must be finite, got nan"),
        ({"sense": "=="}, "sense must be one of <= < >= >, got '=='"),
        ({"share": 0.99}, "separation_end: must have share and confidence, got no con"),
        ({"confidence": 0.9}, "must have share and confidence, got no share"),
        ({"share": 99.0, "confidence": 0.9}, "share must be > 0 and < 1, got 99.0"),
        ({"share": 0.9, "confidence": 1.0}, "confidence must be > 0 and < 1, got 1.0"),
        ({"sides": "two"}, "separation_end: sides must stand with share, got none"),
        ({"sides": "three"}, "sides must be one or two, got 'three'"),
    ],
)
def test_bad_requirement(changes, message):
    values = {"metric": "separation_end", "sense": "<=", "limit": 1.0, **changes}
    with pytest.raises(ValueError, match=message):
        Requirement(**values)
