"""What stands first in a report, and what its parts say of failure cases and draws."""

import pytest

from drakesep.analysis.metrics.requirements import Requirement
from drakesep.reports.campaign_part import _is_judged
from drakesep.reports.cells import Row
from drakesep.reports.failures_part import _by_requirement
from drakesep.reports.html import _broken
from drakesep.reports.summary import _failure_findings, _touching, _worst_of


LIMIT = {"requirement": "final rate", "axis": "x", "sense": "<=", "limit": 1.0}
LIMIT |= {"unit": "deg/s", "nominal": 0.5}


def rows(*several):
    return [
        Row({**LIMIT, **values}, f"study/table.csv:{i}")
        for i, values in enumerate(several, 1)
    ]


def found(*verdicts):
    cases = rows(
        *({"failure_case": f"case_{i}", "verdict": v} for i, v in enumerate(verdicts))
    )
    return [
        (one.verdict, [name.value for name in one.names])
        for one in _failure_findings(cases)
    ]


def test_where_a_body_stays_is_told_first_and_none_is_left_out():
    told = found("not met", "does not separate", "met", "failed", "does not separate")
    assert told[0] == ("does not separate", ["case_1", "case_4"])
    assert {*map(repr, told[1:])} == {
        repr(("failed", ["case_3"])),
        repr(("not met", ["case_0"])),
    }


def test_met_stands_alone():
    assert found("met", "met") == [("met", [])]
    assert found() == []


def test_the_worst_failure_case_is_by_its_margin():
    """A run may fail within its limits: what is nearest there is not beyond."""
    near, beyond, far = rows(
        {"worst": 0.9, "margin": 0.1, "verdict": "not met"},
        {"worst": 1.2, "margin": -0.2, "verdict": "not met"},
        {"worst": 0.1, "margin": 0.9, "verdict": "not met"},
    )
    untold = Row(LIMIT, "study/table.csv:4")
    assert _worst_of([far, near, untold]) is near
    assert _worst_of([far, beyond, near]) is beyond
    assert _worst_of([untold]) is None


def test_parts_that_touch_are_of_clearances_alone():
    asked = [
        Requirement(metric="clearance_until_0.5_m", sense=">=", limit=0.02),
        Requirement(
            metric="longitudinal_speed_after_separation", sense=">=", limit=0.0
        ),
    ]
    touching, apart, speed = rows(
        {"requirement": "clearance until 0.5 m", "worst": 0.0},
        {"requirement": "clearance until 0.5 m", "worst": 0.1},
        {"requirement": "longitudinal speed after separation", "worst": -0.1},
    )
    assert _touching([touching, apart, speed], asked) == [touching]


@pytest.mark.parametrize(("sense", "sign"), [("<=", "≤"), (">=", "≥"), (">", ">")])
def test_limits_above_columns_have_their_sense(sense, sign):
    [table] = _by_requirement(
        rows({"failure_case": "design", "sense": sense, "worst": 0.5})
    )
    heading = table.headings[1]
    words = [cell.text for cell in heading.cells]
    assert [*words, heading.unit] == ["final rate", "x", sign, "1", "deg/s"]


@pytest.mark.parametrize(
    ("share", "bound", "verdict", "is_judged"),
    [
        ("", 0.4, "not looked at", False),  # every run must: draws say nothing good
        ("", "", "not looked at", True),  # no draw tells anything
        ("", 0.4, "not met", True),
        (0.99, 0.4, "not looked at", True),
    ],
)
def test_draws_have_a_verdict_where_they_can_give_one(share, bound, verdict, is_judged):
    [one] = rows({"share": share, "bound": bound, "verdict": verdict})
    assert _is_judged([one], "verdict") is is_judged


def test_lines_break_within_names_and_never_within_numbers():
    assert _broken("spring_1.lost_stroke 0.5") == (
        "spring_<wbr>1.<wbr>lost_<wbr>stroke 0.5"
    )
