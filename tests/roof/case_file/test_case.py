"""Case files: what is read, and what is refused in one line."""

import copy
import math
from pathlib import Path

import pytest
from bad_cases import BAD, VEGA, changed
from hypothesis import given, settings
from hypothesis import strategies as st
from ruamel.yaml import YAML

import drakesep
from drakesep.case_file.reader import load_case
from drakesep.systems.model.orbit import EARTH_RADIUS
from drakesep.systems.model.springs import DisplacementSpring


@pytest.fixture
def written(tmp_path):
    """Writes data into a case file."""

    def write(data) -> Path:
        path = tmp_path / "case.yaml"
        with path.open("w") as file:
            YAML(typ="safe").dump(data, file)
        return path

    return write


def test_vega_in_si():
    separation = load_case("vega").separation
    lv, payload = separation.bodies
    # a uniform solid cylinder of 750 kg, radius 0.95 m, length 1.7 m
    assert lv.I_BBcm_B[0] == pytest.approx(750 * 0.95**2 / 2)
    assert lv.I_BBcm_B[1] == pytest.approx(750 * (3 * 0.95**2 + 1.7**2) / 12)
    assert lv.p_BoBcm_B == (-0.85, 0.0, 0.0)
    assert payload.p_BoBcm_B == (1.933, 0.001, 0.008)
    for attachment, angle in zip(
        separation.attachments, (45, 135, 225, 315), strict=True
    ):
        a = math.radians(angle)
        place = (0.0, 0.4685 * math.cos(a), 0.4685 * math.sin(a))
        assert attachment.p_AoPad_A == pytest.approx(place, abs=1e-9)
        mu = 750 * 1860 / 2610
        assert attachment.spring.design_mass == pytest.approx(mu / 4, rel=1e-9)
    assert separation.orbit.radius == EARTH_RADIUS + 700e3
    assert separation.initial.rpy_WA == pytest.approx(
        [math.radians(x) for x in (0.466, 0.479, 0.461)]
    )


def test_a_users_file(written):
    case = load_case(written(changed("bodies.payload.mass_kg", 1900)))
    assert case.separation.body("payload").mass == 1900.0


def test_springs_driven_by_displacement(written):
    data = copy.deepcopy(VEGA)
    for attachment in data["attachments"].values():
        del attachment["spring"]["design_mass_kg"]
        attachment["spring"] |= {"law": "displacement", "damping_N_s_m": 20.0}
    case = load_case(written(data))
    assert case.separation.springs[2] == DisplacementSpring(
        name="spring_3", force_max=1485.0, stroke=0.121, damping=20.0
    )
    assert case.values_in_si({"spring_1.damping_N_s_m": 5}) == {"spring_1.damping": 5.0}


def test_values_in_si():
    values = load_case("vega").values_in_si({"payload.cg_x_mm": 1953.0})
    assert values == {"payload.cg_x": 1.953}


@pytest.mark.parametrize("name", BAD)
def test_bad_case_is_refused_in_one_line(name, written):
    data, message = BAD[name]
    path = written(data)
    with pytest.raises(drakesep.CaseError) as error:
        load_case(path)
    assert str(error.value).startswith(f"{path}: {message}")
    assert "\n" not in str(error.value)


def test_several_mistakes_have_a_line_each(written):
    data = changed("bodies.payload.mass_kg", -3)
    data["run"]["accuracy"] = "high"
    with pytest.raises(drakesep.CaseError) as error:
        load_case(written(data))
    assert len(str(error.value).splitlines()) == 2


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: [1, 2", "must be YAML, got: expected ',' or ']'"),
        ("a: 1\na: 2\n", 'must be YAML, got: found duplicate key "a"'),
        ("", "must be a mapping of keys, got None"),
    ],
)
def test_not_yaml(text, message, tmp_path):
    path = tmp_path / "case.yaml"
    path.write_text(text)
    with pytest.raises(drakesep.CaseError) as error:
        load_case(path)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_missing_file():
    with pytest.raises(drakesep.CaseError, match=r"no-such\.yaml: must be a readable"):
        load_case("no-such.yaml")


def test_file_that_is_not_text(tmp_path):
    path = tmp_path / "case.yaml"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(drakesep.CaseError, match="got: not a text file"):
        load_case(path)


leaf = st.none() | st.booleans() | st.floats() | st.text(max_size=3) | st.just([])


@settings(max_examples=40)  # thousands are `-m fuzz`
@given(
    section=st.sampled_from(["bodies", "attachments", "run", "requirements", "pair"]),
    value=leaf | st.dictionaries(st.text(max_size=3), leaf, max_size=2),
)
def test_any_rubbish_is_an_error_of_ours(section, value):
    """Never a traceback of a library's."""
    data = {**VEGA, section: value}
    import tempfile

    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
        YAML(typ="safe").dump(data, file)
        file.flush()
        try:
            load_case(file.name)
        except drakesep.CaseError as error:
            assert str(error).startswith(file.name)
