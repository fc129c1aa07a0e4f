"""Tables of requirements: what identifies a row, and what of a tolerance is whose."""

import dataclasses
import io
import math

import pytest
from rich.console import Console

from drakesep.analysis.margins.tolerance_margins import Growth, Limit
from drakesep.analysis.metrics.requirements import Requirement, assess
from drakesep.analysis.tolerances.box import Dispersion, ToleranceBox
from drakesep.analysis.tolerances.sides import Sides
from drakesep.cli.console import print_frame
from drakesep.cli.requirement_lines import growth_lines, requirement_lines
from drakesep.tables.requirement_tables import requirements_table, tolerances_table


BODIES = ("left", "right")
SPEED = "longitudinal_speed_at_separation"
FAST = Requirement(metric=SPEED, sense="<=", limit=1.0, id="UM-1", source="guide")
SLOW = Requirement(metric=f"right.{SPEED}", sense=">=", limit=0.3)
TOUCH = Requirement(metric="clearance", sense=">", limit=0.0)
BOX = ToleranceBox(
    [
        Dispersion(
            name="left.cg_x", nominal=0.1, tolerance=Sides(minus=0.002, plus=0.008)
        ),
        Dispersion(
            name="left.mass", nominal=80.0, tolerance=Sides(minus=0.0, plus=4.0)
        ),
    ]
)


def growth(parameter, factor, most=5.0, message=""):
    limit = Limit(objective=0, value=1.0, u=(0.0, 0.0), parameter=parameter)
    return Growth(limit=limit, factor=factor, most=most, values={}, message=message)


def test_each_side_of_a_tolerance_is_its_own():
    """2 mm below and 8 above, three times as far; a side that is none stays none."""
    single = [(FAST, growth(0, 3.0)), (FAST, growth(1, math.inf))]
    cg, mass = tolerances_table(single, BOX, BODIES).to_dict("records")
    assert (cg["minus"], cg["plus"]) == pytest.approx((2.0, 8.0))
    assert (cg["violated_minus"], cg["violated_plus"]) == pytest.approx((6.0, 24.0))
    assert (mass["minus"], mass["plus"]) == (0.0, 4.0)
    assert (mass["violated_minus"], mass["violated_plus"]) == (0.0, math.inf)


def test_rows_of_single_tolerances_say_which_requirement_they_are_of():
    single = [(FAST, growth(0, 3.0)), (SLOW, growth(0, 2.0))]
    first, second = tolerances_table(single, BOX, BODIES).to_dict("records")
    said = ("requirement", "sense", "limit", "unit", "pair", "id", "source")
    words = "longitudinal speed at separation"
    assert [first[s] for s in said] == [
        *(words, "<=", 1.0, "m/s", "left", "UM-1", "guide")
    ]
    assert [second[s] for s in said] == [words, ">=", 0.3, "m/s", "right", "", ""]


RUNS = {
    "nominal": {SPEED: 0.6, f"right.{SPEED}": 0.5, "clearance": 0.02},
    "worst": {SPEED: 1.2, f"right.{SPEED}": math.nan},
}


def table(growths=(), single=()):
    findings = assess([FAST, SLOW, TOUCH], RUNS, "nominal")
    return requirements_table(findings, growths, single, BOX, BODIES)


def test_what_growth_was_not_looked_at_says_so():
    """Nothing told, not even the nominal; a failure; and as far as it was looked."""
    growths = [
        (FAST, growth(None, math.nan)),
        (SLOW, growth(None, math.nan, message="lost")),
        (TOUCH, growth(None, math.inf, most=1.5)),
    ]
    none, failed, some = table(growths).to_dict("records")
    assert none["growth_by"] == "not looked at"
    assert failed["growth_by"] == "failed: lost"
    assert math.isnan(none["looked_up_to"]) and math.isnan(failed["looked_up_to"])
    assert (some["growth_factor"], some["looked_up_to"]) == (math.inf, 1.5)
    assert growth_lines(table(growths), BODIES)["all by"].tolist() == [
        *("not looked at", "failed: lost", "none up to 1.5")
    ]


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_a_tolerance_that_was_not_looked_at_is_not_passed_over(order):
    """Beside one that violates nothing it may be the first; a violation stands."""
    unknown, harmless = growth(0, math.nan), growth(1, math.inf)
    single = [(TOUCH, (unknown, harmless)[i]) for i in order]
    assert table(single=single)["first_tolerance"].tolist()[2] == "not looked at"
    single = [(TOUCH, (unknown, growth(1, 2.0))[i]) for i in order]
    row = table(single=single).to_dict("records")[2]
    assert (row["first_tolerance"], row["its_growth_factor"]) == ("left.mass_kg", 2.0)
    lines = growth_lines(table(single=single), BODIES)
    assert lines["one alone by"].tolist()[2] == "2 left.mass_kg"


@pytest.mark.parametrize("width", [80, 100, 200])
def test_a_row_on_the_console_is_whole_and_says_what_it_is_of(width):
    """However narrow: its name, limit, values and verdict side by side."""
    console = Console(width=width, record=True, file=io.StringIO())
    frame = requirement_lines(table(), BODIES)
    print_frame(console, "Requirements", frame, whole=True)
    text = console.export_text()
    assert text.count("verdict") == 1
    assert frame["requirement"].tolist() == [
        "longitudinal speed at separation, left (UM-1)",
        "longitudinal speed at separation, right",
        "no contact, all",
    ]
    assert frame["limit"].tolist() == ["<= 1 m/s", ">= 0.3 m/s", "> 0 mm"]
    assert frame["verdict"].tolist() == ["not met", "not looked at", "met"]
    assert max(map(len, text.splitlines())) <= width
    no_contact = next(line for line in text.splitlines() if "no contact" in line)
    assert "20" in no_contact and "met" in no_contact


def test_one_body_that_leaves_is_not_named_on_the_console():
    one = requirements_table(assess([FAST], RUNS, "nominal"), (), (), BOX, ["left"])
    [name] = requirement_lines(one, ["left"])["requirement"]
    assert name == "longitudinal speed at separation (UM-1)"
    [name] = growth_lines(one, ["left"])["requirement"]
    assert name == "longitudinal speed at separation (UM-1)"


@pytest.mark.parametrize("limit", [30.0, 950.001, 0.31623, 1e6])
def test_a_limit_on_the_console_is_the_one_that_was_asked_for(limit):
    """Not rounded to where a value beyond it looks equal; degrees without round-off."""
    asked = Requirement(
        metric="rate_after_separation_x", sense="<=", limit=math.radians(limit)
    )
    findings = assess([asked], {"nominal": {asked.metric: 0.0}}, "nominal")
    one = requirements_table(findings, (), (), BOX, ["left"])
    [told] = requirement_lines(one, ["left"])["limit"]
    wanted, number, unit = told.split(" ")
    assert (wanted, float(number), unit) == ("<=", limit, "deg/s")


def test_of_how_many_launches_a_limit_is():
    """Said in the table and on the console; of every run nothing is said."""
    asked = dataclasses.replace(FAST, share=0.99865, confidence=0.9, sides="two")
    table = requirements_table(
        assess([FAST, asked], RUNS, "nominal"), (), (), BOX, [""]
    )
    plain, of_share = table.to_dict("records")
    columns = ("share", "confidence", "sides", "verdict")
    assert [of_share[name] for name in columns] == [
        0.99865,
        0.9,
        "two",
        "not looked at",
    ]
    assert math.isnan(plain["share"]) and math.isnan(plain["confidence"])
    assert (plain["sides"], plain["verdict"]) == ("", "not met")
    assert plain["worst"] == of_share["worst"] and plain["margin"] == of_share["margin"]
    lines = requirement_lines(table, [""])["limit"].tolist()
    assert lines == ["<= 1 m/s", "<= 1 m/s in 99.865 % of launches"]
