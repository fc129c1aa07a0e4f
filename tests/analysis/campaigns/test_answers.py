"""What campaigns say of requirements, on metrics whose distribution is known."""

import dataclasses
import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binom, binomtest, norm

from drakesep.analysis.campaigns.answers import (
    CampaignAnswer,
    LaunchRequirement,
    Tally,
    launch_requirements,
    worst_to_keep,
)
from drakesep.analysis.campaigns.order_statistics import CampaignSize
from drakesep.analysis.metrics.requirements import Requirement, Verdict
from drakesep.results.case_json import from_json, to_json
from drakesep.systems.checks import InputError


X = "final_rate_x"
"""A signed metric, judged by itself."""
SHARE = {"share": 0.99, "confidence": 0.9}
HIGH = Requirement(metric=X, sense="<=", limit=1.0, **SHARE)
LOW = Requirement(metric=X, sense=">=", limit=-1.0, **SHARE)


def required(*limits) -> LaunchRequirement:
    return LaunchRequirement(limits=limits)


def answer(limits, values, kept=None) -> CampaignAnswer:
    """Of draws of X."""
    asked, values = required(*limits), np.asarray(values, float)
    tally = Tally.of(asked, {X: values}, kept=len(values) if kept is None else kept)
    return CampaignAnswer(required=asked, tally=tally)


def uniform(runs, seed=0) -> np.ndarray:
    return np.random.default_rng(seed).random(runs)


@pytest.mark.parametrize(
    ("sides", "share", "size", "allowed"),
    [("one", 0.99865, 1705, 0), ("two", 0.9973, 1440, 1), ("one", 0.99, 700, 3)],
)
def test_2000_campaigns_pass_what_is_just_too_bad_as_seldom_as_they_say(
    sides, share, size, allowed
):
    """Of a normal metric, whose share within the limits is just what is required."""
    campaigns, of_share = 2000, {"share": share, "sides": sides}
    limit = norm.ppf(share if sides == "one" else (1.0 + share) / 2.0)
    limits = [dataclasses.replace(HIGH, limit=limit, **of_share)]
    if sides == "two":
        limits.append(dataclasses.replace(LOW, limit=-limit, **of_share))
    draws = np.random.default_rng(24).standard_normal((campaigns, size))
    answers = [answer(limits, row, kept=10) for row in draws]
    passed = sum(one.verdict is Verdict.MET for one in answers)
    interval = binomtest(passed, campaigns).proportion_ci(0.999)
    assert answers[0].allowed == allowed
    risk = binom.cdf(allowed, size, 1.0 - share)
    assert risk <= 0.1 and answers[0].size.consumers_risk == pytest.approx(risk)
    assert interval.low <= risk <= interval.high
    # As seldom is it said not to be met, though just that share is within.
    refused = sum(one.verdict is Verdict.NOT_MET for one in answers)
    assert 0 < binomtest(refused, campaigns).proportion_ci(0.999).low <= 0.1
    # The same by the share that is shown, and by the bound.
    assert sum(one.share_shown >= share for one in answers) == passed
    assert sum(one.margin >= 0.0 for one in answers) == passed


def test_the_bound_of_a_campaign_is_beyond_its_quantile():
    """At the confidence: of 2000, in no fewer than that share, but for chance."""
    draws = np.random.default_rng(2).random((2000, 600))
    bounds = [answer([HIGH], row, kept=5).bounds[0] for row in draws]
    covered = int(np.sum(np.array(bounds) >= SHARE["share"]))
    assert binomtest(covered, 2000).proportion_ci(0.999).high >= 0.9
    risk = binom.cdf(2, 600, 0.01)
    interval = binomtest(2000 - covered, 2000).proportion_ci(0.999)
    assert interval.low <= risk <= interval.high


def test_what_the_numbers_of_an_answer_are():
    """1000 draws of which 5 are allowed: the bound is the sixth from above."""
    values = uniform(1000)
    values[[7, 77]] = 1.25, 1.125
    one = answer([HIGH], values)
    assert (one.tally.beyond, one.failures, one.allowed) == (2, 2, 5)
    assert one.verdict is Verdict.MET
    worst = np.sort(values)[::-1]
    # limit - (limit - x) is x but for round-off.
    assert one.bounds == pytest.approx((worst[5],), rel=1e-15)
    assert one.margin == 1.0 - worst[5]
    assert values[one.deciding_draw] == worst[5]
    assert one.tally.worst_draws[:2] == (7, 77)
    assert one.tally.worst_margins[:2] == (-0.25, -0.125)
    assert one.share_shown >= 0.99 and one.share_at_most < 1.0
    assert one.why == "2 of 1000 draws are beyond; at most 5 may be"


@pytest.mark.parametrize(
    ("beyond", "untold", "verdict"),
    [
        (5, 0, Verdict.MET),
        (6, 0, Verdict.NOT_SHOWN),
        (14, 0, Verdict.NOT_SHOWN),  # 10 would be so on average
        (15, 0, Verdict.NOT_MET),
        (2, 3, Verdict.MET),
        (2, 4, Verdict.NOT_SHOWN),
        (2, 500, Verdict.NOT_SHOWN),  # what does not tell disproves nothing
        (0, 1000, Verdict.NOT_LOOKED_AT),
    ],
)
def test_verdicts(beyond, untold, verdict):
    """Of 1000 draws 5 may fail; that 15 do has a chance of a tenth if it is met."""
    values = np.full(1000, 0.5)
    values[100 : 100 + beyond] = 2.0
    values[-untold or 1000 :] = math.nan
    one = answer([HIGH], values)
    assert one.verdict is verdict
    assert (one.margin >= 0.0) == (verdict is Verdict.MET)
    assert (one.margin == -math.inf) == (untold > 5) == (one.deciding_draw is None)


def test_too_few_draws_show_nothing_however_good_they_are():
    one = answer([HIGH], np.full(229, 0.5))  # 230 are needed
    assert (one.verdict, one.allowed, one.margin) == (
        Verdict.NOT_SHOWN,
        None,
        -math.inf,
    )
    assert one.bounds == (math.inf,)
    assert one.why.endswith("so few draws show nothing, even if none is")
    assert answer([HIGH], np.full(230, 0.5)).verdict is Verdict.MET
    # But a bad design is told from few.
    assert answer([HIGH], np.full(3, 2.0)).verdict is Verdict.NOT_MET


@pytest.mark.parametrize(
    ("sense", "met"), [("<=", True), ("<", False), (">=", True), (">", False)]
)
def test_a_draw_at_a_strict_limit_is_beyond_it(sense, met):
    limit = dataclasses.replace(HIGH, sense=sense)
    one = answer([limit], np.full(300, 1.0))
    assert (one.tally.beyond == 0) == met == (one.verdict is Verdict.MET)


def test_two_sides_are_one_requirement():
    """Failures on either count together; the nearer limit is the margin."""
    two = [dataclasses.replace(one, sides="two") for one in (LOW, HIGH)]
    values = np.linspace(-0.5, 0.5, 1000)
    values[:3], values[-3:] = -1.5, 1.25
    (both,) = launch_requirements(two)
    assert both.limits == tuple(two) and both.sides == "two"
    one = answer(two, values)
    assert one.failures == 6 and one.verdict is Verdict.NOT_SHOWN
    assert one.margin == -0.25 and one.bounds == (-1.25, 1.25)
    # Each by itself is met, which is another requirement.
    each = launch_requirements([LOW, HIGH])
    assert [one.limits for one in each] == [(LOW,), (HIGH,)]
    assert {answer(one.limits, values).verdict for one in each} == {Verdict.MET}


def test_one_side_that_is_beyond_tells_though_the_other_does_not():
    """Where two metrics judge a band."""
    speed = "longitudinal_speed_after_separation"
    low, high = (
        Requirement(metric=speed, sense=sense, limit=limit, sides="two", **SHARE)
        for sense, limit in ((">=", 0.5), ("<=", 1.0))
    )
    asked = required(low, high)
    least, most = asked.metrics
    assert least != most
    draws = {
        least: np.array([0.75, 0.25, 0.75, math.nan, math.nan]),
        most: np.array([0.75, math.nan, 1.5, 0.75, 2.0]),
    }
    margins = asked.margins(draws)
    assert np.array_equal(margins, [0.25, -0.25, -0.5, math.nan, -1.0], equal_nan=True)


@given(
    values=st.lists(
        st.sampled_from(
            [-2.0, -1.0, 0.0, 0.5, 1.0, 1.5, math.nan, math.inf, -math.inf]
        ),
        min_size=1,
        max_size=40,
    ),
    kept=st.integers(0, 12),
    seed=st.integers(0, 1000),
)
@settings(deadline=None)
def test_parts_make_the_whole_in_whatever_order(values, kept, seed):
    """To the bit, and what is kept are the worst of all: by sorting all of them."""
    rng = np.random.default_rng(seed)
    asked, values = required(HIGH), np.array(values)
    cuts = np.sort(rng.integers(0, len(values) + 1, 4))
    parts = [
        Tally.of(asked, {X: part}, first=int(first), kept=kept)
        for first, part in zip([0, *cuts], np.split(values, cuts), strict=True)
    ]
    whole = Tally.merged(parts)
    shuffled = [parts[i] for i in rng.permutation(len(parts))]
    assert Tally.merged(shuffled) == whole
    two = [Tally.merged(shuffled[:2]), Tally.merged(shuffled[2:])]
    assert Tally.merged(two) == whole
    margins = [(1.0 - x, i) for i, x in enumerate(values.tolist()) if not math.isnan(x)]
    worst = list(zip(whole.worst_margins, whole.worst_draws, strict=True))
    # Of draws that equal the last, any: each part keeps its own.
    assert [m for m, _ in worst] == [m for m, _ in sorted(margins)][: len(worst)]
    assert worst == sorted(worst) and {*worst} <= {*margins}
    assert len({*worst}) == len(worst)
    assert len(worst) >= min(kept, len(margins)) or kept < len(margins)
    counted = whole.runs, whole.beyond, whole.untold
    assert counted == (
        len(values),
        sum(margin < 0.0 for margin, _ in margins),
        int(np.isnan(values).sum()),
    )


def test_a_large_campaign_keeps_what_its_bound_needs():
    """Some draws of each part: a million in a hundred, against sorting all."""
    values = np.random.default_rng(3).standard_normal(1_000_000)
    size = CampaignSize(share=0.99865, confidence=0.9, runs=len(values))
    asked = required(dataclasses.replace(HIGH, limit=3.0, share=0.99865))
    kept = worst_to_keep(size, 10_000)
    assert kept < 60 < size.rank
    tally = Tally.merged(
        Tally.of(asked, {X: part}, first=10_000 * i, kept=kept)
        for i, part in enumerate(np.split(values, 100))
    )
    one = CampaignAnswer(required=asked, tally=tally)
    assert one.margin == 3.0 - np.sort(values)[-size.rank]
    # The 99.865 % quantile is 3 but for round-off of its share; the bound is farther.
    assert -0.02 < one.margin < 0.0


@pytest.mark.parametrize("bad", [0.0, 0.3, 1.0])
def test_draws_that_are_equal_stand_for_one_another(bad):
    """Ten parts of a metric that has one value, or two: each keeps too few alone."""
    values = np.where(np.random.default_rng(0).random(30_000) < bad, 0.9, 0.5)
    size = CampaignSize(share=0.9, confidence=0.9, runs=len(values))
    asked = required(dataclasses.replace(HIGH, share=0.9))
    kept = worst_to_keep(size, 3000)
    assert kept < size.rank
    tally = Tally.merged(
        Tally.of(asked, {X: part}, first=3000 * i, kept=kept)
        for i, part in enumerate(np.split(values, 10))
    )
    one = CampaignAnswer(required=asked, tally=tally)
    assert one.verdict is Verdict.MET
    assert one.margin == 1.0 - np.sort(values)[-size.rank]
    assert 1.0 - values[one.deciding_draw] == one.margin


def test_an_answer_is_kept_as_json():
    """With what it has not: a bound, and margins of draws at infinity."""
    for one in (
        answer([LOW, dataclasses.replace(HIGH, id="UM-1")], uniform(500)),
        answer([HIGH], [math.nan, -math.inf, 0.5]),
    ):
        read = from_json(json.loads(json.dumps(to_json(one))))
        assert read == one and read.margin == one.margin


def test_what_keeps_too_few_is_refused():
    with pytest.raises(
        InputError, match="tally must keep the 6 worst of 1000 draws, g"
    ):
        answer([HIGH], uniform(1000), kept=5)
    assert answer([HIGH], uniform(1000), kept=6).verdict is Verdict.MET


def test_a_limit_of_every_run_is_none_of_a_share():
    plain = Requirement(metric=X, sense="<=", limit=1.0)
    assert launch_requirements([plain]) == ()
    with pytest.raises(
        InputError, match="limits must be of a share of launches, one o"
    ):
        required(plain)
    with pytest.raises(
        InputError, match="limits must be of a share of launches, one o"
    ):
        required()
