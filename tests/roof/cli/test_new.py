"""`drakesep new`: what it writes works as it stands, and its comments are true."""

import math
import re
from pathlib import Path

import pandas as pd
import pytest
from command_line import run

import drakesep
from drakesep.case_file.new_case import new_case
from drakesep.case_file.reader import builtin_cases


@pytest.fixture
def call(capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    return lambda *words: run(capsys, monkeypatch, *words)


def test_a_new_case_goes_through_every_command(call):
    code, out, err = call("new", "mine")
    assert (code, err) == (0, "")
    assert out == "The case is mine.yaml: see `drakesep show mine.yaml`\n"
    code, out, err = call("show", "mine.yaml")
    assert (code, err) == (0, "")
    assert "Note: " not in out
    assert call("simulate", "mine.yaml")[0] == 0
    quick = ("--samples", 32, "--starts", 2, "--workers", 1, "--no-growth")
    code, out, err = call("verify", "mine.yaml", *quick)
    assert (code, "Every requirement is met" in out) == (0, True), err
    table = pd.read_csv("results/mine/verify/requirements.csv")
    assert set(table["id"]) == {"R-1", "R-2"}
    assert set(table["verdict"]) == {"met"}


def test_what_its_comments_say_of_the_spring(call):
    """75 J by which it leaves at 0.736 m/s: v = sqrt(2 E / mu)."""
    call("new", "mine")
    text = Path("mine.yaml").read_text()
    [energy] = map(float, re.findall(r"(\d+) J", text))
    [speed] = map(float, re.findall(r"at ([\d.]+) m/s", text.replace("\n    # ", " ")))
    case = drakesep.load_case("mine.yaml")
    [attachment] = case.separation.attachments
    force, stroke = attachment.spring.force_max, attachment.spring.stroke
    assert energy == 0.5 * force * stroke
    stage, satellite = (body.mass for body in case.separation.bodies)
    by_energy = math.sqrt(2.0 * energy * (1.0 / stage + 1.0 / satellite))
    assert speed == round(by_energy, 3)
    [row] = drakesep.simulate(case).summary.to_dict("records")
    # What turns takes of the energy: with the CG 5 mm off, (5 mm)^2 over the square of
    # the radius of gyration, about 7e-5.
    flown = row["longitudinal_speed_max_m_s"]
    assert flown == pytest.approx(by_energy, rel=1e-4)


def test_every_section_of_the_file_is_explained(call):
    """But the run's length, which says itself."""
    call("new", "mine")
    lines = Path("mine.yaml").read_text().splitlines()
    sections = [k for k, line in enumerate(lines) if re.match(r"^[a-z_]+:$", line)]
    assert len(sections) == 6
    for k in sections:
        assert lines[k - 1].startswith("#") or lines[k] == "run:"


@pytest.mark.parametrize("builtin", builtin_cases())
def test_from_a_built_in_case(builtin, call):
    """The same but for its name; its comments are the built-in case's."""
    assert call("new", "mine", "--from", builtin)[0] == 0
    mine, theirs = drakesep.load_case("mine.yaml"), drakesep.load_case(builtin)
    assert mine.name == "mine"
    assert mine.replaced(name=builtin) == theirs
    changed = [
        (old, new)
        for old, new in zip(
            builtin_cases()[builtin].read_text().splitlines(),
            Path("mine.yaml").read_text().splitlines(),
            strict=True,
        )
        if old != new
    ]
    assert changed == [(f"name: {builtin}", 'name: "mine"')]


@pytest.mark.parametrize("more", [(), ("--from", "smallsat")])
@pytest.mark.parametrize(
    "name",
    ["123", "null", "1e5", "2024-01-01", "2024-13-01", "yes", "0x1F", "my_new_case"],
)
def test_a_name_that_yaml_would_not_read_as_text(name, more, call):
    assert call("new", name, *more)[0] == 0
    assert drakesep.load_case(f"{name}.yaml").name == name


@pytest.mark.parametrize("more", [(), ("--from", "vega")])
def test_nothing_is_overwritten(more, call):
    Path("mine.yaml").write_text("mine")
    code, _, err = call("new", "mine", *more)
    assert code == 2
    assert err == (
        "drakesep: output: must be a file that is not there yet, got mine.yaml\n"
    )
    assert Path("mine.yaml").read_text() == "mine"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("my case",), "name: must be made of letters, digits, _ and -, got 'my case'"),
        (("mine.yaml",), "name: must be made of letters"),
        (("../mine",), "name: must be made of letters"),
        (("vega",), "name: must not be that of a built-in case, got 'vega'"),
        (
            ("mine", "--from", "vga"),
            "unknown built-in case 'vga'; did you mean 'vega'?",
        ),
        (("mine", "-o", "there/mine.yaml"), "there/mine.yaml: No such file or"),
    ],
)
def test_what_is_refused(words, message, call):
    code, _, err = call("new", *words)
    assert code == 2
    assert err.startswith(f"drakesep: {message}")
    assert len(err.splitlines()) == 1
    assert list(Path.cwd().iterdir()) == []


def test_the_file_may_stand_elsewhere(call, tmp_path):
    assert call("new", "mine", "-o", "other.yaml")[0] == 0
    assert drakesep.load_case("other.yaml").name == "mine"
    assert new_case("ours", file=tmp_path / "x.yaml") == tmp_path / "x.yaml"
    assert drakesep.new_case("ours") == Path("ours.yaml")


def test_what_it_is_made_of_is_no_built_in_case():
    assert set(builtin_cases()).isdisjoint({"new_case", "mine"})
