"""What share of launches meets a requirement, by metrics that are known."""

import dataclasses
import math

import numpy as np
import pytest
from small_case import small_case

from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.analysis.campaigns.shares import share_findings
from drakesep.analysis.metrics.requirements import Requirement, Verdict
from drakesep.case_file.case import Case


SPEED, ROLL = "longitudinal_speed_at_separation", "deviation_at_separation_roll"
SHARE, CONFIDENCE = 0.9, 0.9
"""22 runs show it without a failure: 0.9^22 = 0.098."""


@pytest.fixture(scope="module")
def case():
    data = small_case(published=None, objectives=None)
    return Case.model_validate(data).in_si()


def required(sense, limit, metric=SPEED, share=SHARE, **more):
    confidence = None if share is None else CONFIDENCE
    return Requirement(
        metric=metric,
        sense=sense,
        limit=limit,
        share=share,
        confidence=confidence,
        **more,
    )


def found(case, requirements, speeds):
    return found_by(planned(case, requirements, len(speeds)), speeds)


def planned(case, requirements, runs):
    case = dataclasses.replace(case, requirements=tuple(requirements))
    return CampaignPlan(case=case, runs=runs, metrics=(SPEED,))


def found_by(plan, speeds):
    values = np.asarray(speeds, dtype=float)
    failed = np.flatnonzero(np.isnan(values)).tolist()
    return share_findings(plan, values[:, None], failed)


@pytest.mark.parametrize(
    ("beyond", "verdict"),
    [
        # Of 100 with 0.9 to be shown at 0.9, 5 may fail: P(X <= 5) = 0.0576, and
        # P(X <= 6) = 0.117. That it is not met, 15 show: P(X >= 15) = 0.073, and
        # P(X >= 14) = 0.124 (of a binomial distribution of 100 and 0.1).
        (0, Verdict.MET),
        (5, Verdict.MET),
        (6, Verdict.NOT_SHOWN),
        (14, Verdict.NOT_SHOWN),
        (15, Verdict.NOT_MET),
        (100, Verdict.NOT_MET),
    ],
)
def test_verdict_by_the_number_beyond(case, beyond, verdict):
    speeds = np.arange(100) + 0.5
    [finding] = found(case, [required(">=", float(beyond))], speeds)
    assert finding.beyond == beyond
    assert finding.verdict is verdict
    assert finding.bound == 5.5  # the sixth from below: five may be beyond
    assert finding.margin == 5.5 - beyond
    assert finding.worst == 0.5
    assert finding.ranked[:6] == (0, 1, 2, 3, 4, 5)


def test_from_above_the_largest_are_worst(case):
    speeds = np.random.default_rng(1).permutation(100) + 0.5
    [finding] = found(case, [required("<=", 98.0)], speeds)
    assert (finding.beyond, finding.bound, finding.worst) == (2, 94.5, 99.5)
    assert speeds[[*finding.ranked[:3]]].tolist() == [99.5, 98.5, 97.5]


@pytest.mark.parametrize(("sense", "beyond"), [("<=", 0), ("<", 3)])
def test_the_limit_itself(case, sense, beyond):
    [finding] = found(case, [required(sense, 1.0)], [1.0] * 3 + [0.0] * 97)
    assert finding.beyond == beyond


def test_runs_that_failed_are_beyond_every_limit(case):
    """The first of all; where they alone are more than may be, there is no bound."""
    speeds = np.full(100, 1.0)
    speeds[[7, 3, 50]] = np.nan
    above, below = found(case, [required("<=", 9.0), required(">=", 0.5)], speeds)
    for finding in (above, below):
        assert finding.beyond == 3
        assert finding.ranked[:3] == (3, 7, 50)
        assert finding.bound == 1.0
        assert finding.verdict is Verdict.MET
    speeds[:20] = np.nan
    [finding] = found(case, [required("<=", 9.0)], speeds)
    assert finding.beyond == 21
    assert math.isnan(finding.bound)
    assert finding.verdict is Verdict.NOT_SHOWN  # they do not tell
    [every] = found(case, [required("<=", 9.0, share=None)], speeds)
    assert every.verdict is Verdict.NOT_LOOKED_AT
    [finding] = found(case, [required("<=", 9.0)], np.full(100, np.nan))
    assert finding.beyond == 100
    assert finding.verdict is Verdict.NOT_LOOKED_AT
    assert math.isnan(finding.worst)


def test_every_run_must(case):
    """A campaign disproves it by one run, and never shows it."""
    speeds = [1.0] * 99 + [5.0]
    good, bad = found(
        case,
        [required("<=", 9.0, share=None), required("<=", 4.0, share=None, id="b")],
        speeds,
    )
    assert good.verdict is Verdict.NOT_LOOKED_AT
    assert bad.verdict is Verdict.NOT_MET
    assert math.isnan(good.bound)  # of three sigma, which 100 runs do not show
    assert good.size.share == 0.99865


def test_two_sides_are_one_requirement(case):
    """Three below and three above are six of it: more than five."""
    speeds = np.arange(100) + 0.5
    sides = {"sides": "two", "id": "band"}
    band = [required(">=", 3.0, **sides), required("<=", 97.0, **sides)]
    below, above = found(case, band, speeds)
    assert below.beyond == above.beyond == 6
    assert below.verdict is above.verdict is Verdict.NOT_SHOWN
    apart = found(case, [required(">=", 3.0), required("<=", 97.0)], speeds)
    assert [one.beyond for one in apart] == [3, 3]
    assert all(one.verdict is Verdict.MET for one in apart)
    assert below.together
    assert not apart[0].together


def test_of_two_sides_each_limit_has_its_own_bound_and_worst(case):
    """Values of draws, on the side of the limit; that of the other tells nothing."""
    speeds = np.arange(100) + 0.5
    sides = {"sides": "two", "id": "band"}
    band = [required(">=", 3.0, **sides), required("<=", 97.2, **sides)]
    below, above = found(case, band, speeds)
    assert (below.bound, above.bound) == (5.5, 94.5)  # the sixth to either side
    assert (below.margin, above.margin) == pytest.approx((2.5, 2.7))
    assert below.ranked[:6] == (0, 1, 2, 3, 4, 5)
    assert above.ranked[:6] == (99, 98, 97, 96, 95, 94)
    # Margins together: 97, 98, 99 are by 0.3, 1.3, 2.3 beyond, 2, 1, 0 by 0.5, 1.5,
    # 2.5. The sixth is that of draw 97, the third from above.
    assert above.answer.deciding_draw == 97
    assert above.deciding_rank == 3
    assert above.verdict is below.verdict is Verdict.NOT_SHOWN


def test_what_is_not_told_is_not_looked_at(case):
    speed, roll = found(
        case, [required("<=", 9.0), required("<=", 9.0, ROLL)], np.ones(100)
    )
    assert speed.verdict is Verdict.MET
    assert roll.verdict is Verdict.NOT_LOOKED_AT
    assert roll.beyond is None


def test_what_drake_does_not_confirm_is_not_met(case):
    good, bad = found(
        case, [required("<=", 9.0), required(">=", 90.0)], np.arange(100) / 20.0
    )
    doubted = [dataclasses.replace(one, confirmed=False) for one in (good, bad)]
    assert good.verdict is Verdict.MET
    assert [one.verdict for one in doubted] == [
        Verdict.NOT_LOOKED_AT,
        Verdict.NOT_MET,
    ]


def test_equal_margins_come_in_the_order_of_draws(case):
    [finding] = found(case, [required("<=", 9.0)], np.ones(1000))
    assert finding.ranked == (*range(len(finding.ranked)),)


def test_realised_risk_of_a_metric_whose_distribution_is_known(case):
    """Of designs that are just too bad, a tenth pass at most: 2000 campaigns.

    Each of 100 exponential speeds, of which 0.9 are within the limit. The probability
    is 0.0576, by which the number that pass spreads by sqrt(2000 p (1 - p)) = 10.4.
    """
    rng = np.random.default_rng(0)
    limit = -math.log(0.1)
    plan, passed = planned(case, [required("<=", limit)], 100), 0
    for _ in range(2000):
        [finding] = found_by(plan, rng.exponential(size=100))
        passed += finding.verdict is Verdict.MET
    assert abs(passed - 2000 * 0.0576) < 4.0 * 10.4
    assert passed <= 200
