"""Plans of campaigns: what they refuse, and which draws are in which chunk."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_case import small_case

from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.case_file.case import Case


CASE = Case.model_validate(small_case(published=None, objectives=None)).in_si()


@given(runs=st.integers(1, 300), chunk=st.integers(1, 400))
def test_each_draw_is_in_one_chunk(runs, chunk):
    plan = CampaignPlan(case=CASE, runs=runs, chunk=chunk)
    all_of_them = [plan.indices(number) for number in range(plan.chunks)]
    assert np.concatenate(all_of_them).tolist() == [*range(runs)]
    assert all(0 < len(each) <= chunk for each in all_of_them)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"runs": 0}, "runs: must be 1 or more, got 0"),
        (
            {"runs": 10**9},
            "runs: must be 10000000 or fewer where rows are kept, got 1000000000",
        ),
        ({"seed": -1}, "seed: must be 0 or more, got -1"),
        ({"chunk": 0}, "chunk: must be 1 or more, got 0"),
        ({"tolerance": 0.0}, "tolerance must be > 0"),
        ({"metrics": ("rate_x",) * 2}, "metrics: rate_x must stand once"),
        ({"metrics": ("rat_x",)}, "unknown metric 'rat_x'"),
        (
            {"metrics": ("longitudinal_speed_at_5_s",)},
            "metrics: longitudinal_speed_at_5_s: no run of the case tells it",
        ),
        (
            {"case": dataclasses.replace(CASE, tolerances={})},  # none of its failures
            "dispersions: a campaign needs something that varies",
        ),
    ],
)
def test_what_is_refused(changed, message):
    with pytest.raises(ValueError, match=message):
        CampaignPlan(**{"case": CASE, "runs": 10, **changed})


def test_there_is_no_such_chunk():
    plan = CampaignPlan(case=CASE, runs=10, chunk=4)
    for number in (-1, 3):
        with pytest.raises(ValueError, match=f"from 0 to 2, got {number}"):
            plan.indices(number)


def test_what_is_kept_is_what_requirements_are_judged_by():
    plan = CampaignPlan.of(CASE, 10, also=("final_rate_x",))
    judges = [requirement.judged_by for requirement in CASE.requirements]
    assert plan.metrics == (*judges, "final_rate_x")
