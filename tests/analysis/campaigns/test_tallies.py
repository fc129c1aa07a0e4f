"""Draws of which no rows are kept say the same as rows do, however they are cut.

Draws are numbers that follow from their own: nothing is flown.
"""

import dataclasses
import random
from itertools import pairwise

import numpy as np
import pytest
from small_case import small_case

from drakesep.analysis.campaigns.flights import FlownDraws
from drakesep.analysis.campaigns.gathering import Gathered, kept
from drakesep.analysis.campaigns.plan import BINS, CampaignPlan
from drakesep.analysis.campaigns.shares import findings_of, share_findings
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.case_file.case import Case


SPEED, RATE = "longitudinal_speed_at_separation", "final_rate_x"
RUNS, CHUNK = 5000, 64
SHARE = {"share": 0.99, "confidence": 0.9}
"""Of 5000 draws 40 may be beyond."""
LIMITS = (
    Requirement(metric=SPEED, sense=">=", limit=-2.3, **SHARE),
    Requirement(metric=SPEED, sense="<=", limit=1.5, **SHARE),
    Requirement(metric=RATE, sense="<=", limit=2.5, sides="two", id="band", **SHARE),
    Requirement(metric=RATE, sense=">=", limit=-2.0, sides="two", id="band", **SHARE),
    Requirement(metric=RATE, sense="<=", limit=4.0),
)


@pytest.fixture(scope="module")
def plan():
    case = Case.model_validate(small_case(published=None, objectives=None)).in_si()
    case = dataclasses.replace(case, requirements=LIMITS)
    return CampaignPlan(
        case=case,
        runs=RUNS,
        metrics=(SPEED, RATE),
        chunk=CHUNK,
        keep="worst",
        spans=((-2.0, 2.0), (-3.0, 3.0)),
    )


def drawn(failed):
    """Normal numbers, many of them equal to others; some draws fail."""
    rng = np.random.default_rng(0)
    metrics = rng.normal(size=(RUNS, 2)).round(2)
    numbers = rng.choice(RUNS, failed, replace=False).tolist()
    metrics[numbers] = np.nan
    return FlownDraws(
        first=0,
        metrics=metrics,
        failure=np.full(RUNS, -1, np.int16),
        attempts=rng.integers(0, 3, RUNS).astype(np.int32),
        reasons={i: f"draw {i}" for i in sorted(numbers)},
    )


def chunk_of(whole, plan, number):
    some = whole.some(plan.indices(number).tolist())
    return kept(plan, some)


def gathered(whole, plan, numbers):
    chunks = Gathered(plan)
    for number in numbers:
        chunks.add(number, chunk_of(whole, plan, number))
    return chunks.whole()


@pytest.fixture(scope="module", params=[0, 7, 200])
def both(request, plan):
    whole = drawn(request.param)
    return whole, gathered(whole, plan, range(plan.chunks))


def test_verdicts_bounds_and_counts_are_those_of_rows(both, plan):
    whole, tallied = both
    rows = share_findings(plan, whole.metrics, [*whole.reasons])
    worst = findings_of(plan, tallied.counted(plan), [*tallied.reasons])
    assert len(rows) == len(worst) == len(LIMITS)
    for one, other in zip(rows, worst, strict=True):
        assert other.verdict is one.verdict
        assert other.beyond == one.beyond
        np.testing.assert_equal((other.bound, other.worst), (one.bound, one.worst))
        for name in ("share_shown", "share_at_most", "deciding_draw", "why"):
            assert getattr(other.answer, name) == getattr(one.answer, name)
            assert getattr(other.alone, name) == getattr(one.alone, name)
        assert other.deciding_rank == one.deciding_rank
        ranks = range(1, (one.size.rank or 1) + 1)
        assert [*map(other.draw_of_rank, ranks)] == [*map(one.draw_of_rank, ranks)]


def test_they_are_what_sorting_says(both, plan):
    """The bound of the first: the 41st of all, failed runs before all others."""
    whole, tallied = both
    finding = findings_of(plan, tallied.counted(plan), [*tallied.reasons])[0]
    speeds = np.sort(np.nan_to_num(whole.metrics[:, 0], nan=-np.inf))
    assert finding.size.allowed == 40
    bound = speeds[40]
    assert np.isnan(finding.bound) if np.isinf(bound) else finding.bound == bound
    assert finding.beyond == (speeds < -2.3).sum()


def test_means_deviations_and_histograms_are_those_of_all(both, plan):
    whole, tallied = both
    for k, summary in enumerate(tallied.summaries):
        told = whole.metrics[~np.isnan(whole.metrics[:, k]), k]
        assert summary.mean == pytest.approx(told.mean(), abs=1e-15)
        assert summary.deviation == pytest.approx(told.std(ddof=1), rel=1e-13)
        assert (summary.least, summary.greatest) == (told.min(), told.max())
        edges = np.array(summary.histogram.edges)
        assert len(edges) == BINS + 1
        ends = [-np.inf, *edges, np.inf]
        counts = [((told >= a) & (told < b)).sum() for a, b in pairwise(ends)]
        assert [*summary.histogram.counts] == counts
    assert tallied.failed == len(whole.reasons)
    assert tallied.again == whole.attempts.sum()
    assert tallied.reasons == whole.reasons


def test_in_any_order_they_are_the_same(both, plan):
    whole, tallied = both
    numbers = [*range(plan.chunks)]
    random.Random(1).shuffle(numbers)
    assert vars(gathered(whole, plan, numbers)) == vars(tallied)


def test_little_is_kept_of_many(both, plan):
    """Of a part some dozens of the worst, as many as it may have of those that decide.

    Of a requirement of every run the bound is of 99.865 %: of 4947
    and more three may be beyond.
    """
    whole, _ = both
    part = chunk_of(whole, plan, 3)
    assert [len(one.worst_draws) for one in part.tallies] == [15, 15, 15, 15, 4]


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"keep": "all"}, "keep: must be rows or worst, got 'all'"),
        ({"runs": 10**11}, "runs: must be 10000000000 or fewer where worst are kept"),
        (
            {"runs": 10**7 + 1, "keep": "rows", "spans": ()},
            "runs: must be 10000000 or fewer where rows are kept, got 10000001",
        ),
        ({"spans": ((0.0, 1.0),)}, "spans: must be one for each of 2 metrics, got 1"),
    ],
)
def test_what_is_refused(changed, told, plan):
    with pytest.raises(ValueError, match=f"^{told}"):
        dataclasses.replace(plan, **changed)


def test_rows_are_kept_of_as_many_as_fit(plan):
    for runs, keep, chunk in ((10**7, "rows", 32_768), (10**9, "worst", 262_144)):
        made = CampaignPlan.of(plan.case, runs)
        assert (made.keep, made.chunk) == (keep, chunk)
