"""The compliance matrix: what several studies say of a requirement, put together."""

import dataclasses
import itertools
import math

import pytest

from drakesep.reports.cells import Cell, Row, number_text
from drakesep.reports.compliance import Entry, worst_verdict
from drakesep.reports.deciding import BOUND, WORST_DRAW, WORST_FOUND
from drakesep.reports.studies import _read


MET, NOT_MET, SHOWN, LOOKED = "met", "not met", "not shown", "not looked at"
EVERY, SHARE = "", 0.99865
SAYS = {"limit": 1.0, "sense": "<=", "unit": "deg/s"}


def row(file, **values):
    return Row({**SAYS, **values}, f"study/{file}:1")


def entry(verify=None, campaign=None, of=EVERY, asked_of_draws=EVERY):
    """An entry with such verdicts, where the case and a campaign ask for shares."""
    searched = drawn = None
    if verify is not None:
        searched = row("requirements.csv", verdict=verify, share=of, worst=0.5)
    if campaign is not None:
        drawn = row("campaign.csv", verdict=campaign, share=asked_of_draws, bound=0.4)
    return Entry(searched=searched, drawn=drawn)


@pytest.mark.parametrize(
    ("verify", "campaign", "of", "draws", "expected"),
    [
        # Every run must: what verify says, unless a draw is beyond.
        (MET, None, EVERY, EVERY, MET),
        (MET, LOOKED, EVERY, EVERY, MET),
        (MET, NOT_MET, EVERY, EVERY, NOT_MET),
        (NOT_MET, LOOKED, EVERY, EVERY, NOT_MET),
        (LOOKED, LOOKED, EVERY, EVERY, LOOKED),
        # A share that the case does not ask for is no answer for every run.
        (LOOKED, MET, EVERY, SHARE, LOOKED),
        (NOT_MET, MET, EVERY, SHARE, NOT_MET),
        (MET, SHOWN, EVERY, SHARE, MET),
        # A share that it asks for is for the campaign to tell.
        (LOOKED, MET, SHARE, SHARE, MET),
        (LOOKED, SHOWN, SHARE, SHARE, SHOWN),
        (LOOKED, NOT_MET, SHARE, SHARE, NOT_MET),
        (LOOKED, None, SHARE, SHARE, LOOKED),
        (None, MET, EVERY, SHARE, MET),
    ],
)
def test_verdict_of_several_studies(verify, campaign, of, draws, expected):
    one = entry(verify, campaign, of, draws)
    assert one.verdict.value == expected
    assert one.verdict.place.endswith(":verdict")


PROVEN = row("proofs.csv", verdict="proven met", proven_bound=0.8, found_by="worst")


@pytest.mark.parametrize(
    ("verify", "of", "expected"),
    [
        (None, EVERY, MET),
        (MET, EVERY, MET),
        # What a run shows, or is not known, no proof mends; and draws may be beyond
        # the tolerances.
        (NOT_MET, EVERY, NOT_MET),
        (LOOKED, EVERY, LOOKED),
        (None, SHARE, LOOKED),
    ],
)
def test_what_is_proven_is_met_if_nothing_else_tells(verify, of, expected):
    proof = Row({**PROVEN.values, "share": of}, PROVEN.place)
    one = dataclasses.replace(entry(verify, of=of), proof=proof)
    assert one.verdict.value == expected
    assert (one.proven.value, one.proven_bound.value) == ("proven met", 0.8)
    assert "bound proven over the tolerances" in one.methods


def test_a_published_run_beyond_a_bound_is_said_to_be_beyond_the_tolerances():
    one = dataclasses.replace(entry(MET), proof=PROVEN)
    assert not any("beyond the tolerances" in point for point in one.open_points)
    searched = row("requirements.csv", verdict=MET, worst=0.9, which_run="theirs")
    one = dataclasses.replace(one, searched=searched)
    assert "in theirs, is beyond the tolerances" in "; ".join(one.open_points)


def test_a_single_run_gives_no_verdict():
    flown = row("requirements_of_run.csv", verdict=MET, value=0.2)
    assert Entry(flown=flown).verdict.value == LOOKED
    assert Entry(flown=flown).nominal.value == 0.2


@pytest.mark.parametrize(
    "words", [*itertools.product([MET, NOT_MET, SHOWN, LOOKED, "no verdict"], repeat=3)]
)
def test_met_only_if_all_are(words):
    together = worst_verdict(words)
    assert (together == MET) == ({*words} == {MET})
    assert together in words
    assert (together == NOT_MET) == (NOT_MET in words)


def test_nothing_is_no_verdict():
    assert worst_verdict([]) == "no verdict"
    assert worst_verdict(["contact"]) == "no verdict"


@pytest.mark.parametrize(
    ("one", "words"),
    [
        (entry(LOOKED, None, SHARE), "for a campaign to show"),
        (entry(None, MET, EVERY, EVERY), "has not been searched"),
        (entry(LOOKED, SHOWN, SHARE, SHARE), "too few draws"),
        (entry(LOOKED), "no run tells it"),
    ],
)
def test_open_points(one, words):
    assert any(words in point for point in one.open_points)


def test_evidence_that_there_is_not_is_an_open_point():
    """A worst case without random samples, unless draws speak for it."""
    searched = row("requirements.csv", worst=0.7, margin=0.3, verdict=MET)
    none, some = (row("evidence.csv", random_samples=n) for n in (0, 50000))
    words = "neither random samples nor draws"
    assert words in " ".join(Entry(searched=searched, evidence=none).open_points)
    for one in (
        Entry(searched=searched, evidence=some),
        Entry(searched=searched, evidence=none, drawn=row("campaign.csv", worst=0.6)),
    ):
        assert words not in " ".join(one.open_points)


@pytest.mark.parametrize(
    ("sense", "nominal", "is_beyond"),
    [
        ("<=", 1.0, False),
        ("<=", 1.1, True),
        (">=", 1.0, False),
        (">=", 0.9, True),
        ("<", 1.0, True),
        (">", 1.0, True),
        (">", 1.1, False),
    ],
)
def test_a_nominal_run_beyond_the_limit_is_an_open_point(sense, nominal, is_beyond):
    one = Entry(searched=row("requirements.csv", sense=sense, nominal=nominal))
    assert one.nominal_is_beyond is is_beyond
    assert (
        any("nominal run is beyond" in point for point in one.open_points) == is_beyond
    )


def test_a_value_beyond_its_limit_is_never_shown_as_the_limit():
    limit = Cell(1.0, "", 10)
    beyond = Cell(1.00000123, "").told_from(limit)
    assert beyond.text == "1.000001"
    assert Cell(1.0).told_from(limit).text == "1"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.123456, "0.1235"),
        (262144.0, "262144"),
        (-1.5, "\N{MINUS SIGN}1.500"),
        (100.0123, "100.0"),
        (1234.5678, "1235"),
        (-6.7124e-08, "\N{MINUS SIGN}6.712·10⁻⁸"),
        (math.inf, "∞"),
        (0.0, "0"),
        (1.25e9, "1.250·10⁹"),
    ],
)
def test_numbers_as_they_are_shown(value, text):
    assert number_text(value, 4) == text


def test_inputs_are_shown_as_they_were_given():
    assert number_text(0.3, 10) == "0.3"
    assert number_text(1e-6, 10) == "1·10⁻⁶"


@pytest.mark.parametrize(
    ("column", "text", "value"),
    [
        ("worst", "0.5", 0.5),
        ("worst", "inf", math.inf),
        ("points", "50000", 50000),
        ("worst", "1e-08", 1e-08),
        ("worst", "", ""),
        ("which_run", "1_000", "1_000"),
        ("id", "4.10", "4.10"),
        ("source", "2024", "2024"),
    ],
)
def test_cells_of_tables_as_they_are_read(column, text, value):
    got = _read(column, text)
    assert (got, type(got)) == (value, type(value))


def test_a_margin_is_of_the_value_beside_it():
    """Of 2.2 deg/s a bound of 2.4 and a worst draw of 8.7: -0.2 and -6.5 apart."""
    told = {"limit": 2.2, "bound": 2.4, "margin": -0.2, "verdict": NOT_MET}
    told |= {"worst": 8.7, "worst_margin": -6.5}
    by_share = Entry(drawn=row("campaign.csv", share=SHARE, **told))
    every = Entry(drawn=row("campaign.csv", share=EVERY, **told))
    assert decided(by_share) == (BOUND, 2.4, -0.2)
    assert decided(every) == (WORST_DRAW, 8.7, -6.5)
    searched = row("requirements.csv", share=SHARE, worst=3.0, margin=-0.8)
    assert decided(Entry(searched=searched)) == (WORST_FOUND, 3.0, -0.8)


def decided(one):
    return one.deciding.by, one.deciding.value.value, one.deciding.margin.value


def test_a_draw_beyond_decides_what_every_run_must_keep():
    """Searches found 0.7 of 1 deg/s, a draw comes to 1.3: -0.3 beside not met."""
    searched = row("requirements.csv", share=EVERY, worst=0.7, margin=0.3, verdict=MET)
    told = {"verdict": NOT_MET, "worst": 1.3, "worst_margin": -0.3, "worst_draw": 17}
    one = Entry(searched=searched, drawn=row("campaign.csv", share=EVERY, **told))
    assert decided(one) == (WORST_DRAW, 1.3, -0.3)
    assert one.verdict.value == NOT_MET
    # A run that was found beyond it decides, whatever draws say.
    searched = row("requirements.csv", worst=1.1, margin=-0.1, verdict=NOT_MET)
    beyond = Entry(searched=searched, drawn=one.drawn)
    assert decided(beyond) == (WORST_FOUND, 1.1, -0.1)


def test_less_than_a_share_that_was_asked_for_says_nothing_of_a_smaller_one():
    searched = row("requirements.csv", share=0.9, verdict=LOOKED)
    one = Entry(
        searched=searched, drawn=row("campaign.csv", share=0.99, verdict=NOT_MET)
    )
    assert one.verdict.value == LOOKED


MARGINS = (-0.3, 0.0, 0.3, None)


@pytest.mark.parametrize("share", [EVERY, SHARE])
@pytest.mark.parametrize(
    ("by_search", "by_draws"),
    [*itertools.product([None, MET, NOT_MET, LOOKED], repeat=2)],
)
@pytest.mark.parametrize("sides", ["one", "two"])
def test_not_met_has_a_negative_margin_or_a_reason(share, by_search, by_draws, sides):
    """Whatever tables say together: of a margin and its words, one tells why."""
    for found, bound, worst in itertools.product(MARGINS, repeat=3):
        if by_search is NOT_MET and by_draws is not NOT_MET:
            # Of a share that is what draws say; of every run, what such a margin says.
            if share or not (found or 0.0) < 0.0:
                continue
        searched = drawn = None
        if by_search is not None:
            value = {} if found is None else {"worst": 1.0 - found, "margin": found}
            searched = row("requirements.csv", verdict=by_search, share=share, **value)
        if by_draws is not None:
            told = {"margin": bound, "worst_margin": worst, "sides": sides}
            told |= {"bound": None if bound is None else 1.0 - bound}
            told |= {"worst": None if worst is None else 1.0 - worst}
            drawn = row("campaign.csv", verdict=by_draws, share=share, **told)
        if searched is None and drawn is None:
            continue
        one = Entry(searched=searched, drawn=drawn)
        if one.verdict.value == NOT_MET:
            margin = one.deciding.margin.value
            assert (margin is not None and margin < 0.0) or one.deciding.why


def test_a_proven_bound_stands_where_a_table_has_it():
    told = {"worst": 0.7, "margin": 0.3, "verdict": MET}
    proven = {"proven_bound": 0.71, "gap_percent": 1.4, "verdict": "proven met"}
    searched = row("requirements.csv", **told)
    with_it = Entry(searched=searched, proof=row("proofs.csv", **proven))
    without = Entry(searched=searched)
    assert [with_it.proven_bound.value, with_it.gap.value] == [0.71, 1.4]
    assert with_it.proven.value == "proven met"
    assert not (without.proven_bound or without.gap or without.proven)
    assert "proven" in " ".join(with_it.methods)
    assert "proven" not in " ".join(without.methods)


@pytest.mark.parametrize(
    ("column", "words", "shown"),
    [
        ("sense", "<=", "≤"),
        ("sense", ">", ">"),
        ("decides", "final_rate_x_deg_s <= 1.5", "final_rate_x_deg_s ≤ 1.5"),
        ("source", "<= 3 of the manual", "<= 3 of the manual"),
    ],
)
def test_senses_are_shown_by_their_signs(column, words, shown):
    assert row("campaign.csv", **{column: words})[column].text == shown
