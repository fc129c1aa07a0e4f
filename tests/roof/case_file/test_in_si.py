"""A case is turned into SI once, and what varies it is checked."""

import math

import pytest
from bad_cases import VEGA

import drakesep
from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.case_file.reader import load_case
from drakesep.systems.model.separation import Separation


@pytest.fixture
def built(monkeypatch):
    """Counts the separations that are built."""
    count = []
    check = Separation.__post_init__

    def counted(self):
        count.append(self)
        check(self)

    monkeypatch.setattr(Separation, "__post_init__", counted)
    return count


def test_vega_is_built_once(built):
    """Beside it, one for each bound of each tolerance and each published case.

    These look whether a varied separation is physical: with_values alone can tell.
    """
    case = load_case("vega")
    bounds = 2 * len(VEGA["dispersions"])
    assert len(built) == 1 + bounds + len(VEGA["published"]) == 40
    built.clear()
    for _ in range(2):
        _ = case.separation, case.box, case.tolerance_set, case.limits
        _ = case.integration, case.has_clearance, case.in_si()
        case.values_in_si({"payload.mass_kg": 1880.0})
    assert not built


def test_parts_of_the_record_are_those_of_the_case():
    case = load_case("vega")
    record = case.in_si()
    assert isinstance(record, AnalysisCase)
    assert record is case.in_si()
    assert case.separation is record.separation
    assert case.tolerance_set is record.tolerance_set
    assert case == load_case("vega")


def test_published_cases_in_si():
    """Marks stand for bounds; what is printed, in radians."""
    case = load_case("vega")
    of_L1 = case.in_si().published[0]
    assert of_L1.label == "paper_L1_Linf"
    assert of_L1.objectives == ("L1", "Linf")
    [written] = [p for p in VEGA["published"] if p["label"] == of_L1.label]
    mark = {"M": 1.0, "m": -1.0}[written["values"]["payload.cg_z_mm"]]
    # Nominal 8 mm, of the paper's Table 1, and its tolerance.
    tolerance = VEGA["dispersions"]["payload.cg_z_mm"]
    expected = 1e-3 * (8.0 + mark * tolerance)
    assert of_L1.values["payload.cg_z"] == pytest.approx(expected, rel=1e-15)
    printed = [math.degrees(rate) for rate in of_L1.printed.rate]
    assert printed == pytest.approx(written["printed"]["rate_deg_s"], rel=1e-15)


REPLACEMENTS = [
    ({"dispersions": {"payload.mas_kg": 1.0}}, "dispersions: unknown parameter"),
    (
        {"dispersions": {"payload.mass_kg": 1900.0}, "published": []},
        "dispersions: payload.mass_kg ± 1900: payload: mass must be > 0, got -40",
    ),
    (
        {"dispersions": {}},  # M and m stand for bounds that there are not any more
        "published: paper_L1_Linf: unknown dispersed parameter",
    ),
    ({"run": {"duration_s": "long"}}, "run.duration_s: must be a number, got 'long'"),
    ({"requirments": []}, "unknown key 'requirments'; did you mean 'requirements'?"),
]


@pytest.mark.parametrize(("sections", "message"), REPLACEMENTS)
def test_a_bad_replacement_is_refused_as_a_file_is(sections, message):
    case = load_case("vega")
    with pytest.raises(drakesep.CaseError) as error:
        case.replaced(**sections)
    assert str(error.value).startswith(message)
    with pytest.raises(drakesep.CaseError):
        case.model_copy(update=sections)


def test_a_replacement_is_turned_into_si():
    case = load_case("vega")
    few = case.replaced(dispersions={"payload.mass_kg": 10.0}, published=[])
    assert few.box.names == ("payload.mass",)
    assert few.separation == case.separation
    assert len(case.box) == 18
    heavy = {**case.bodies, "payload": {**case.bodies["payload"].model_dump()}}
    heavy["payload"]["mass_kg"] = 1900.0
    assert case.replaced(bodies=heavy).separation.body("payload").mass == 1900.0
    assert case.replaced() == case
