"""Case files: what is read, and what is refused in one line."""

import copy
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from ruamel.yaml import YAML

import drakesep
from drakesep.case_file.reader import builtin_cases, load_case
from drakesep.systems.model.separation import EARTH_RADIUS
from drakesep.systems.model.springs import DisplacementSpring


VEGA = YAML(typ="safe").load(builtin_cases()["vega"])


def changed(path: str, value=...):
    """VEGA with the value at a dotted path changed, or taken out."""
    data = copy.deepcopy(VEGA)
    *parents, last = (
        path.split(".", 3)
        if "dispersions" not in path
        else (
            "dispersions",
            path.removeprefix("dispersions."),
        )
    )
    place = data
    for parent in parents:
        place = place[parent]
    if value is ...:
        del place[last]
    else:
        place[last] = value
    return data


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


BAD = {
    "unknown key": (
        changed("bodies.payload.mass", 1.0),
        "bodies.payload: unknown key 'mass'; did you mean 'mass_kg'?",
    ),
    "unknown top key": (
        changed("boddies", {}),
        "unknown key 'boddies'; did you mean 'bodies'?",
    ),
    "missing key": (
        changed("bodies.payload.mass_kg"),
        "bodies.payload: mass_kg: missing, as are solid and model",
    ),
    "a section without a value": (
        changed("recontact", None),
        "recontact: must have a value, got none",
    ),
    "an entry without a value": (
        changed("loads", {"gust": {"torque_N_m": [0.0, None, 0.0]}}),
        "loads.gust.torque_N_m (entry 2): must have a value, got none",
    ),
    "wrong type": (
        changed("bodies.payload.mass_kg", "heavy"),
        "bodies.payload.mass_kg: must be a number, got 'heavy'",
    ),
    "number as text": (
        changed("bodies.payload.mass_kg", "1860"),
        "bodies.payload.mass_kg: must be a number, got '1860'",
    ),
    "yes for a number": (
        changed("bodies.payload.mass_kg", True),
        "bodies.payload.mass_kg: must be a number, got True",
    ),
    "NaN": (
        changed("bodies.payload.mass_kg", math.nan),
        "bodies.payload.mass_kg: must be finite, got nan",
    ),
    "infinity": (
        changed("before_separation.rate_deg_s", [0.0, math.inf, 0.0]),
        "before_separation.rate_deg_s (entry 2): must be finite, got inf",
    ),
    "two entries": (
        changed("bodies.payload.cg_mm", [1.0, 2.0]),
        "bodies.payload.cg_mm: must be 3 numbers, got [1.0, 2.0]",
    ),
    "negative mass": (
        changed("bodies.payload.mass_kg", -3),
        "bodies.payload.mass_kg: must be > 0, got -3",
    ),
    "zero stroke": (
        changed("attachments.attachment_2.spring.stroke_mm", 0),
        "attachments.attachment_2.spring.stroke_mm: must be > 0, got 0",
    ),
    "impossible inertia": (
        changed("bodies.payload.inertia_kg_m2.xx", 10),
        "payload: inertia must have principal moments that obey the triangle",
    ),
    "indefinite inertia": (
        changed("bodies.payload.inertia_kg_m2.xy", 5000),
        "payload: inertia must be positive definite",
    ),
    "no design mass": (
        changed("attachments.attachment_1.spring.design_mass_kg"),
        "attachments.attachment_1.spring: design_mass_kg: missing; law: time needs it",
    ),
    "design mass too many": (
        changed("attachments.attachment_1.spring.law", "displacement"),
        "attachments.attachment_1.spring: design_mass_kg: law: displacement has none",
    ),
    "damper of a timed spring": (
        changed("attachments.attachment_1.spring.damping_N_s_m", 1.0),
        "attachments.attachment_1.spring: damping_N_s_m: law: time has none",
    ),
    "unknown law": (
        changed("attachments.attachment_1.spring.law", "force"),
        "attachments.attachment_1.spring.law: must be 'time', 'displacement' or",
    ),
    "no such body": (
        changed("attachments.attachment_1.B", "payloud"),
        "attachment_1: unknown body 'payloud'; did you mean 'payload'?",
    ),
    "no such pair": (
        changed("pair.A", "lv"),
        "pair: unknown body 'lv'; known: launch_vehicle, payload",
    ),
    "late release": (
        changed("attachments.attachment_1.release_time_s", 3.5),
        "attachment_1: release time must lie before the end of the run at 3",
    ),
    "short run": (
        changed("run.duration_s", 0.1),
        "duration must be longer than it takes the springs",
    ),
    "non-physical tolerance": (
        changed("dispersions.payload.mass_kg", 1900),
        "dispersions: payload.mass_kg ± 1900: payload: mass must be > 0, got -40",
    ),
    "zero tolerance": (
        changed("dispersions.payload.mass_kg", 0),
        "dispersions.payload.mass_kg: must be > 0, got 0",
    ),
    "unknown tolerance": (
        changed("dispersions.payload.mas_kg", 20),
        "dispersions: unknown parameter 'payload.mas_kg'; did you mean 'payload.mass",
    ),
    "unknown integrator": (
        changed("run.integrator", "runge_kutta4"),
        "run.integrator: must be 'runge_kutta3', 'bogacki_shampine3' or 'radau3', got",
    ),
    "zero accuracy": (changed("run.accuracy", 0.0), "run.accuracy: must be > 0, got 0"),
    "unknown quantity": (
        changed("requirements", [{"quantity": "speed", "at_least": 1.0}]),
        "requirements (entry 1).quantity: must be 'rate_after_separation_deg_s'",
    ),
    "no limit": (
        changed("requirements", [{"quantity": "rate_after_separation_deg_s"}]),
        "requirements (entry 1): must have one of 'at_most' and 'at_least', got none",
    ),
    "one limit of three": (
        changed(
            "requirements",
            [{"quantity": "rate_after_separation_deg_s", "at_most": 1.5}],
        ),
        "requirements (entry 1): must have 3 limits, got 1.5",
    ),
    "one body": (
        changed("bodies", {"payload": VEGA["bodies"]["payload"]}),
        "bodies: dictionary should have at least 2 items",
    ),
    "NaN as a limit": (
        changed(
            "requirements",
            [
                {
                    "quantity": "longitudinal_speed_after_separation_m_s",
                    "at_least": math.nan,
                }
            ],
        ),
        "requirements (entry 1).at_least (entry 1): must be finite, got nan",
    ),
    "name that leaves its folder": (
        changed("name", "../../elsewhere"),
        "name: must be made of letters, digits, _ and -, got '../../elsewhere'",
    ),
    "number for a section": (
        changed("bodies.payload.inertia_kg_m2", 60),
        "bodies.payload.inertia_kg_m2: must be a mapping of keys, got 60",
    ),
    "negative release": (
        changed("attachments.attachment_1.release_time_s", -0.1),
        "attachment_1: release time must be >= 0, got -0.1",
    ),
    "negative limit": (
        changed(
            "requirements",
            [{"quantity": "rate_after_separation_deg_s", "at_most": [1.0, -2.0, 1.0]}],
        ),
        "requirements: rate_after_separation_y_deg_s: at_most must be >= 0, got -2",
    ),
    "requirement twice": (
        changed("requirements", 2 * VEGA["requirements"][:1]),
        "requirements: rate_after_separation_deg_s must stand once",
    ),
    "published twice": (
        changed("published", 2 * VEGA["published"][:1]),
        "published: label 'paper_L1_Linf' must stand once",
    ),
    "published under our label": (
        changed("published", [{**VEGA["published"][0], "label": "worst_L1"}]),
        "published: label 'worst_L1' is taken by our own runs",
    ),
    "published with a bad mark": (
        changed(
            "published",
            [{**VEGA["published"][0], "values": {"payload.mass_kg": "Q"}}],
        ),
        "published (entry 1).values.payload.mass_kg: must be M, m or a number, got 'Q'",
    ),
    "published but impossible": (
        changed(
            "published",
            [{**VEGA["published"][0], "values": {"payload.inertia_xx_kg_m2": 1.0}}],
        ),
        "published: paper_L1_Linf: payload: inertia must have principal moments",
    ),
    "Drake's own name": (
        changed("bodies", {**VEGA["bodies"], "world": VEGA["bodies"]["payload"]}),
        "names must differ, got 'world' 2 times (it is reserved)",
    ),
    "not a mapping": ([1, 2], "must be a mapping of keys, got [1, 2]"),
}


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
