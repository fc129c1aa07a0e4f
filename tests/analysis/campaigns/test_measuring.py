"""Which draws are measured, and that they tell all that decides."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drakesep.analysis.campaigns import measuring
from drakesep.analysis.campaigns.answers import CampaignAnswer, LaunchRequirement
from drakesep.analysis.campaigns.measuring import SURE, NearestOfDraws, next_draws
from drakesep.analysis.campaigns.order_statistics import CampaignSize
from drakesep.analysis.metrics.requirements import Requirement


def requirement(limit, share, sense=">="):
    of_share = {"share": share, "confidence": 0.9}
    return LaunchRequirement(
        limits=(Requirement(metric="clearance", sense=sense, limit=limit, **of_share),)
    )


def measured_by_rounds(required, true, at_least):
    """As a campaign does it, with what is true of the draws that it asks for."""
    at_least, measured = at_least.copy(), np.zeros(len(true), bool)
    size = CampaignSize(
        share=required.share, confidence=required.confidence, runs=len(true)
    )
    while True:
        now = NearestOfDraws(
            required=required, size=size, at_least=at_least, measured=measured
        )
        draws = next_draws([now])
        if not len(draws):
            return now
        assert not measured[draws].any()
        at_least, measured = at_least.copy(), measured.copy()
        at_least[draws], measured[draws] = true[draws], True


@settings(max_examples=200, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    share=st.sampled_from([0.7, 0.95, 0.99]),
    limit=st.floats(0.0, 0.04),
    loose=st.sampled_from([0.0, 1e-4, 3e-3]),
    untold=st.sampled_from([0, 1, 40]),
)
def test_count_and_bound_are_those_of_all_draws(seed, share, limit, loose, untold):
    """Some hardly differ, some are bounded by nothing, some do not tell."""
    rng = np.random.default_rng(seed)
    true = np.maximum(rng.normal(0.03, 0.01, 400), 0.0).round(5)
    at_least = true - loose * rng.uniform(size=400) ** 2
    at_least[rng.choice(400, 5)] = -math.inf
    failed = rng.choice(400, untold, replace=False)
    true[failed] = at_least[failed] = math.nan
    required = requirement(limit, share)
    found = measured_by_rounds(required, true, at_least)
    answer = CampaignAnswer(
        required=required, tally=found.tally((found.size.allowed or 0) + 10)
    )
    assert answer.tally.untold == untold
    assert answer.tally.beyond == np.sum(true < limit)
    assert answer.tally.doubtful == 0
    place = found.size.rank - 1 - untold
    if place < 0:
        assert answer.margin == -math.inf
    else:
        exact = np.sort(true[~np.isnan(true)])[place]
        assert answer.margin + limit == pytest.approx(exact, abs=SURE)
        assert found.measured[answer.deciding_draw]
    # Nothing is measured that decides nothing, but for what the first rounds took.
    needless = found.measured & (at_least >= max(limit, np.sort(true)[max(place, 0)]))
    assert needless.sum() <= measuring.ROUND


def test_of_equals_no_more_are_measured_than_decide():
    """A gap that nothing changes: all draws are as near, and all but 0.1 mm proven."""
    true = np.full(100_000, 0.02)
    found = measured_by_rounds(requirement(0.01, 0.99865), true, true - 0.9 * SURE)
    assert found.size.rank <= found.measured.sum() < 2 * found.size.rank
    answer = CampaignAnswer(required=found.required, tally=found.tally(130))
    assert answer.bounds == pytest.approx((0.02,), abs=1e-12)


def test_too_many_to_be_measured_are_never_met(monkeypatch):
    """What is proven counts as proven, and no more; the rest does not tell."""
    monkeypatch.setattr(measuring, "MOST", 30)
    true = np.linspace(0.01, 0.05, 1000)
    required = requirement(0.011, 0.9)
    loose = measured_by_rounds(required, true, true - 0.005)
    assert loose.measured.sum() == 30
    tally = loose.tally(100)
    # 150 are not proven to be beyond 11 mm, and 30 of them are measured.
    assert tally.untold == np.sum(true - 0.005 < 0.011) - 30
    answer = CampaignAnswer(required=required, tally=tally)
    assert answer.verdict.value == "not shown"
    proven = measured_by_rounds(required, true, true - 0.0005)
    answer = CampaignAnswer(required=required, tally=proven.tally(100))
    assert answer.verdict.value == "met"
    rank = proven.size.rank
    assert 0.011 + answer.margin == pytest.approx(true[rank - 1] - 0.0005, abs=1e-9)


def test_that_nothing_touches_is_met_by_what_is_proven_apart():
    true = np.array([0.0, 2e-6, 1e-3, 0.1])
    found = measured_by_rounds(requirement(0.0, 0.3, ">"), true, true - 1e-3)
    assert found.measured.all()
    assert found.tally(4).beyond == 1
