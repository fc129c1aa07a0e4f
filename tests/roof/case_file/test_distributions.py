"""Distributions, correlations and probabilities as people write them."""

import json
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from ruamel.yaml import YAML
from trade import symmetric_design

from drakesep.analysis.campaigns.draws import Draws
from drakesep.analysis.tolerances.correlations import RankCorrelation
from drakesep.analysis.tolerances.distributions import (
    Discrete,
    Lognormal,
    Normal,
    Table,
    Triangular,
    TruncatedNormal,
    Uniform,
)
from drakesep.analysis.tolerances.sides import Sides, ends_of
from drakesep.case_file.case import Case
from drakesep.case_file.errors import CaseError
from drakesep.results.case_json import from_json, to_json
from drakesep.systems.checks import InputError


def read(stated, name="sc.cg_x_mm"):
    """How sc.cg_x, 600 mm, is distributed: in m."""
    [tolerance] = (
        symmetric_design(dispersions={name: stated}).in_si().tolerances.values()
    )
    return tolerance


@pytest.mark.parametrize(
    ("stated", "record"),
    [
        ({"tolerance": 6}, 0.006),
        ({"tolerance": 6, "distribution": "uniform"}, Uniform(extent=0.006)),
        ({"tolerance": 6, "distribution": "normal"}, Normal(sigma=0.002, within=0.006)),
        (
            {"tolerance": "1 %", "distribution": "normal", "sigmas": 2},
            Normal(sigma=0.003, within=0.006),
        ),
        (
            {"tolerance": 6, "distribution": "lognormal"},
            Lognormal(sigma=0.002, within=0.006),
        ),
        (
            {"minus": 6, "plus": 6, "distribution": "truncated_normal"},
            TruncatedNormal(sigma=0.002, extent=Sides(minus=0.006, plus=0.006)),
        ),
        (
            {"minus": 0, "plus": "1 %", "distribution": "triangular"},
            Triangular(extent=Sides(minus=0.0, plus=0.006)),
        ),
        ({"uniform": 8}, Uniform(extent=0.008)),
        (
            {"uniform": {"minus": 1, "plus": 2}, "within": 0.5},
            Uniform(extent=Sides(minus=0.001, plus=0.002), within=0.0005),
        ),
        ({"triangular": "0.5 %"}, Triangular(extent=0.003)),
        ({"normal": {"sigma": 2}}, Normal(sigma=0.002)),
        (
            {"normal": {"sigma": "0.5 %"}, "within": {"minus": 4, "plus": 8}},
            Normal(sigma=0.003, within=Sides(minus=0.004, plus=0.008)),
        ),
        (
            {"truncated_normal": {"sigma": 2, "tolerance": {"minus": 4, "plus": 0}}},
            TruncatedNormal(sigma=0.002, extent=Sides(minus=0.004, plus=0.0)),
        ),
        (
            {"lognormal": {"sigma": 2}, "within": 8},
            Lognormal(sigma=0.002, within=0.008),
        ),
        (
            {"table": {"values": [601, 598, 600]}},
            Table(values=(0.601, 0.598, 0.6)),
        ),
        (
            {"table": {"values": [601, 598], "weights": [1, 3]}, "within": 2},
            Table(values=(0.601, 0.598), weights=(1.0, 3.0), within=0.002),
        ),
        (
            {"discrete": {"values": [590, 610], "probabilities": [0.25, 0.75]}},
            Discrete(values=(0.59, 0.61), probabilities=(0.25, 0.75)),
        ),
    ],
    ids=str,
)
def test_read(stated, record):
    got = read(stated)
    assert type(got) is type(record)
    assert ends_of(0.6, got) == pytest.approx(ends_of(0.6, record), rel=1e-14)
    assert to_json(got) == to_json_nearly(record)
    # As it stands in the text of the case, and in a results folder.
    case = symmetric_design(dispersions={"sc.cg_x_mm": stated})
    assert Case.model_validate(YAML(typ="safe").load(case.text)) == case
    back = from_json(json.loads(json.dumps(to_json(case.in_si()))))
    assert back == case.in_si()


def to_json_nearly(record):
    """JSON, whose numbers are right to the round-off of units."""

    def near(value):
        if isinstance(value, float):
            return pytest.approx(value, rel=1e-14)
        if isinstance(value, dict):
            return {key: near(entry) for key, entry in value.items()}
        return [near(entry) for entry in value] if isinstance(value, list) else value

    return near(to_json(record))


def test_a_tolerance_is_three_standard_deviations():
    """20 kg of a normal distribution, and the same by its sigma."""
    of_tolerance = read({"tolerance": 20, "distribution": "normal"}, "sc.mass_kg")
    by_sigma = read({"normal": {"sigma": 20 / 3}}, "sc.mass_kg")
    assert of_tolerance.sigma == by_sigma.sigma
    assert of_tolerance.sides(500.0) == by_sigma.sides(500.0)


def test_each_that_fits_a_pattern_has_its_own():
    normal = {"normal": {"sigma": "2 %"}}
    case = symmetric_design(dispersions={"*.mass_kg": normal, "s?.force_max_N": normal})
    assert dict(case.in_si().tolerances) == {
        "lv.mass": Normal(sigma=40.0),
        "sc.mass": Normal(sigma=10.0),
        **{f"s{i}.force_max": Normal(sigma=10.0) for i in range(1, 5)},
    }


@pytest.mark.parametrize(
    ("stated", "message"),
    [
        (
            {"normal": {"sigma": 1}, "uniform": 2},
            "dispersions.sc.cg_x_mm: must have one of tolerance, uniform, triangular, "
            "normal, truncated_normal, lognormal, table, discrete, lower and upper, or "
            "minus and plus, got uniform and normal",
        ),
        ({"tolerance": 2, "minus": 2, "plus": 1}, "got minus and plus and tolerance"),
        ({"within": 2}, "or minus and plus, got none"),
        (
            {"normal": {"sigma": 1}, "distribution": "normal"},
            "distribution must be of a tolerance, bounds or sides, got normal",
        ),
        (
            {"tolerance": 1, "sigmas": 2},
            "sigmas must be of a distribution that is normal, truncated_normal, "
            "lognormal, got none",
        ),
        ({"tolerance": 1, "sigmas": 2, "distribution": "uniform"}, "got uniform"),
        (
            {"tolerance": 1, "within": 2},
            "within must be of a distribution without a tolerance, which is what "
            "searches look at",
        ),
        (
            {"tolerance": 1, "distribution": "gauss"},
            "sc.cg_x_mm.distribution: must be 'uniform', 'normal', 'truncated_normal'",
        ),
        ({"normal": {"sigma": 0}}, "sc.cg_x_mm.normal.sigma: must be finite and > 0"),
        ({"normal": {"sigma": "5"}}, "normal.sigma: must be a number, or a share of"),
        ({"normal": {"sigma": "0 %"}}, "normal.sigma: must be > 0, got '0 %'"),
        ({"normal": {}}, "sc.cg_x_mm.normal.sigma: missing"),
        ({"normal": {"sigm": 1}}, "normal: unknown key 'sigm'; did you mean 'sigma'?"),
        ({"normal": 5}, "sc.cg_x_mm.normal: must be a mapping of keys, got 5"),
        ({"norml": {"sigma": 1}}, "unknown key 'norml'; did you mean 'normal'?"),
        ({"uniform": -1}, "sc.cg_x_mm.uniform: must be finite and > 0, got -1"),
        ({"uniform": {"lower": 1}}, "uniform: must have lower and upper, or minus and"),
        (
            {"uniform": {"lower": 1, "upper": 2}},
            "sc.cg_x_mm: lower and upper must hold the nominal, 600, got 1 to 2",
        ),
        (
            {"minus": 1, "plus": 2, "distribution": "normal"},
            "dispersions: sc.cg_x_mm: normal: a tolerance of some standard deviations "
            "must be the same to either side, got 0.001 below the nominal and 0.002",
        ),
        (
            {"truncated_normal": {"sigma": 1e9, "tolerance": 1}},
            "sc.cg_x_mm: truncated_normal: sigma must be at most 1e+06 times the",
        ),
        (
            {"table": {"values": [1, 1]}},
            "dispersions: sc.cg_x_mm: table: values must be two different ones or more",
        ),
        (
            {"table": {"values": [1, 2], "weights": [1]}},
            "sc.cg_x_mm: table: weights must be 2, one for each value, got 1",
        ),
        (
            {"discrete": {"values": [1, 2], "probabilities": [0.5, 0.6]}},
            "sc.cg_x_mm: discrete: probabilities must add up to 1, got 1.1",
        ),
        ({"discrete": {"values": [1, 2]}}, "discrete.probabilities: missing"),
    ],
)
def test_what_is_no_distribution_is_refused(stated, message):
    with pytest.raises(CaseError, match=re.escape(message)):
        symmetric_design().replaced(dispersions={"sc.cg_x_mm": stated})


@pytest.mark.parametrize(
    ("name", "stated", "message"),
    [
        # Of a nominal of 0, and below.
        (
            "sc.cg_y_mm",
            {"lognormal": {"sigma": 1}},
            "cg_y_mm: lognormal: needs a nomin",
        ),
        ("lv.cg_x_mm", {"lognormal": {"sigma": 1}}, "needs a nominal > 0, its median"),
        (
            "sc.cg_y_mm",
            {"normal": {"sigma": "1 %"}},
            "sc.cg_y_mm: sigma: a share must be of a nominal that is not zero",
        ),
        # Searches go to three standard deviations.
        (
            "sc.mass_kg",
            {"normal": {"sigma": 200}},
            "dispersions: sc.mass_kg ± 600: sc: mass must be > 0, got -100",
        ),
    ],
)
def test_what_is_none_about_a_nominal_is_refused(name, stated, message):
    with pytest.raises(CaseError, match=re.escape(message)):
        symmetric_design().replaced(dispersions={name: stated})


def test_correlations_by_names_and_patterns():
    case = symmetric_design(
        dispersions={"s*.force_max_N": 5, "sc.cg_x_mm": 2},
        correlations=[
            {"of": ["s[12].force_max_N", "sc.cg_x_mm"], "rank": 0.5},
            {"of": ["s3.force_max_N", "s4.force_max_N"], "rank": -0.25},
        ],
    )
    assert case.in_si().correlations == (
        RankCorrelation(names=("s1.force_max", "s2.force_max", "sc.cg_x"), rank=0.5),
        RankCorrelation(names=("s3.force_max", "s4.force_max"), rank=-0.25),
    )
    record = case.in_si()
    assert from_json(json.loads(json.dumps(to_json(record)))) == record


@pytest.mark.parametrize(
    ("correlation", "message"),
    [
        (
            {"of": ["s1.force_max_N", "s2.force_max"], "rank": 0.5},
            "correlations: unknown parameter 's2.force_max'; did you mean",
        ),
        (
            {"of": ["s1.force_max_N", "sc.mass_kg"], "rank": 0.5},
            "correlations: correlation of s1.force_max, sc.mass: unknown dispersed",
        ),
        ({"of": ["s1.force_max_N"], "rank": 0.5}, "two different parameters or more"),
        (
            {"of": ["t*"], "rank": 0.5},
            "correlations: t*: must fit a parameter, got none",
        ),
        ({"of": ["s*.force_max_N"], "rank": -0.9}, "whose matrix is positive definite"),
        ({"of": ["s*.force_max_N"], "rank": 2}, "rank must be between -1 and 1, got 2"),
        ({"of": ["s*.force_max_N"]}, "correlations (entry 1).rank: missing"),
    ],
)
def test_what_is_no_correlation_is_refused(correlation, message):
    case = symmetric_design(dispersions={"s*.force_max_N": 5})
    with pytest.raises(CaseError, match=re.escape(message)):
        case.replaced(correlations=[correlation])


def test_probabilities_of_failures():
    case = symmetric_design(failure_cases="standard", failures={"s3_out": 0.001})
    assert dict(case.in_si().failure_probabilities) == {"s3_out": 0.001}
    record = case.in_si()
    assert from_json(json.loads(json.dumps(to_json(record)))) == record
    for failures, message in (
        (
            {"s3_ot": 0.1},
            "failures: unknown failure case 's3_ot'; did you mean 's3_out'",
        ),
        ({"s3_out": 0}, "failures: s3_out must be > 0, got 0"),
        ({"s3_out": True}, "failures.s3_out: must be a number, got True"),
        ({"s3_out": 0.6, "s2_out": 0.6}, "must add up to less than 1, got 1.2"),
    ):
        with pytest.raises(CaseError, match=re.escape(message)):
            case.replaced(failures=failures)


numbers = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.floats(0.1, 10.0),
    st.integers(-3, 3),
    st.sampled_from([True, None, "2 %", "0 %", "5", "normal", 1e308, 5e-324]),
)
extents = numbers | st.fixed_dictionaries(
    {}, optional=dict.fromkeys(("lower", "upper", "minus", "plus"), numbers)
)
lists = st.lists(numbers, max_size=4) | numbers
PARTS = {
    **dict.fromkeys(("lower", "upper", "minus", "plus", "sigmas"), numbers),
    **dict.fromkeys(("tolerance", "uniform", "triangular", "within"), extents),
    **dict.fromkeys(("normal", "lognormal"), st.fixed_dictionaries({"sigma": numbers})),
    "truncated_normal": st.fixed_dictionaries({"sigma": numbers, "tolerance": extents}),
    "table": st.fixed_dictionaries({"values": lists}, optional={"weights": lists}),
    "discrete": st.fixed_dictionaries({"values": lists, "probabilities": lists}),
    "distribution": st.sampled_from(["uniform", "normal", "lognormal", "triangular"]),
}
stated_any = st.lists(st.sampled_from(sorted(PARTS)), max_size=3).flatmap(
    lambda keys: st.fixed_dictionaries({key: PARTS[key] for key in keys})
)


@given(stated=stated_any)
def test_read_and_drawn_or_refused_by_name(stated):
    """Nothing else: no traceback, no warning, and no value that is none."""
    try:
        case = symmetric_design().replaced(dispersions={"sc.cg_x_mm": stated})
    except CaseError as error:
        assert "sc.cg_x_mm" in str(error)
        return
    record = case.in_si()
    [low, high] = record.box.dispersions[0].bounds
    assert low < high
    assert low <= 0.6 <= high
    try:
        drawn = Draws(record, 1).at(range(10))
    except InputError as error:
        assert "values of which a thousandth can be" in str(error)
        return
    assert np.isfinite(drawn.values).all()
