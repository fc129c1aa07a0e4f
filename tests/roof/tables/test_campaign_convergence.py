"""What more and more draws say: of arrays whose every number is known by hand."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import binomtest
from small_case import small_case

from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.analysis.campaigns.shares import share_findings
from drakesep.case_file.case import Case
from drakesep.tables.campaign_convergence import convergence_table, share_within


def table_of(requirements, **metrics):
    """Of made-up draws, in SI, by the name of the metric."""
    data = small_case(published=None, objectives=None, failure_cases=None)
    data["requirements"] = requirements
    case = Case.model_validate(data).in_si()
    values = np.stack([*metrics.values()], axis=1)
    plan = CampaignPlan(case=case, runs=len(values), metrics=tuple(metrics))
    failed = np.flatnonzero(np.isnan(values).any(axis=1)).tolist()
    findings = share_findings(plan, values, failed)
    return convergence_table(plan, values, findings, ["upper"])


SPEED = {"quantity": "longitudinal_speed_m_s", "when": "after_separation"}
METRIC = "longitudinal_speed_after_separation"
HIGHEST = "longitudinal_speed_max_after_separation"


def test_each_row_is_of_the_first_draws():
    """0, 1, ..., 39 over 10 m/s; the fifth run failed; those below 0.3 m/s are beyond.

    So of any first draws these are draws 0, 1, 2, and the fifth.
    """
    values = np.arange(40) / 10.0
    values[4] = np.nan
    required = {**SPEED, "at_least": 0.3, "share": 0.9, "confidence": 0.9}
    table = table_of([required], **{METRIC: values})
    assert table["draws"].iloc[[0, -1]].tolist() == [10, 40]
    assert table["draws"].is_monotonic_increasing and len(table) <= 12
    assert set(table["failures"]) == {4}
    assert table["share_beyond"].tolist() == pytest.approx(4.0 / table["draws"])
    assert table["quantile_of"].tolist() == pytest.approx([0.1] * len(table))
    first, last = table.iloc[0], table.iloc[-1]
    # 0 + ... + 9 = 45, less 4, of nine; their squares are 285, less 16.
    assert first["mean"] == pytest.approx(4.1 / 9)
    assert first["deviation"] == pytest.approx(((2.69 - 4.1**2 / 9) / 8) ** 0.5)
    assert last["mean"] == pytest.approx((78.0 - 0.4) / 39)
    half = 1.959964 * last["deviation"] / 39**0.5
    assert last["mean_to"] - last["mean"] == pytest.approx(half, rel=1e-6)
    assert last["quantile"] == pytest.approx(0.3)  # the fourth of 39: 3.9, rounded up
    assert first["quantile_from"] == -np.inf  # nine draws bound no such quantile


def test_two_sides_are_counted_together():
    values = np.array([0.5] * 12 + [2.0, 0.0, 0.5, 0.5])
    both = {**SPEED, "share": 0.8, "confidence": 0.9, "sides": "two"}
    limits = [{**both, "at_least": 0.3}, {**both, "at_most": 1.0}]
    table = table_of(limits, **{METRIC: values, HIGHEST: values})
    ends = table.groupby("sense").last()
    assert ends["failures"].to_dict() == {"<=": 2, ">=": 2}
    assert (table.groupby("sense")["failures"].first() == 0).all()


def test_what_is_not_required_has_no_row():
    assert table_of([], final_rate_x=np.arange(20.0)).empty
    assert isinstance(table_of([], final_rate_x=np.ones(20)), pd.DataFrame)


@pytest.mark.parametrize(("failures", "draws"), [(0, 10), (3, 40), (10, 10)])
def test_intervals_are_those_of_scipy(failures, draws):
    found = share_within(failures, draws, 0.95)
    exact = binomtest(failures, draws).proportion_ci(0.95, method="exact")
    assert found.value == failures / draws
    # Of 1 less a share, the last bits are lost.
    assert [found.low, found.high] == pytest.approx([exact.low, exact.high], abs=1e-9)
