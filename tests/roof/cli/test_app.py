"""The command line: commands, exit codes, errors without a traceback."""

import os
import signal
import subprocess
import sys
import time

import pandas as pd
import pytest
from bad_cases import BAD
from command_line import run
from ruamel.yaml import YAML


@pytest.fixture
def drakesep(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    return lambda *arguments: run(capsys, monkeypatch, *arguments)


def test_cases(drakesep):
    code, out, _ = drakesep("cases")
    assert code == 0
    assert "vega" in out


def test_show(drakesep):
    code, out, _ = drakesep("show", "vega")
    assert code == 0
    for text in ("1933 1 8", "spring_3", "payload.inertia_xz_kg_m2", "<="):
        assert text in out


def test_simulate(drakesep, tmp_path):
    arguments = ("--set", "payload.mass_kg=1880", "--set", "spring_1.stroke_mm=120")
    code, out, _ = drakesep("simulate", "vega", *arguments, "-o", tmp_path)
    assert code == 0
    assert "longitudinal_speed_max" in out
    names = {path.name for path in tmp_path.iterdir()}
    tables = {"motion.csv", "summary.csv", "translation.png", "rotation.png"}
    tables.add("requirements_of_run.csv")
    assert names == {*tables, "study.json", "case.json", "runs"}
    summary = pd.read_csv(tmp_path / "summary.csv")
    assert summary["payload.mass_kg"].tolist() == [1880.0]


@pytest.mark.slow
def test_worst_case(drakesep, tmp_path):
    code, out, _ = drakesep(
        *("worst-case", "vega", "--objective", "PM", "--search", "drake"),
        *("-o", tmp_path, "--workers", 1),
    )
    assert code == 0
    assert "worst_PM" in out
    assert "SQP from the nominal" in out
    worst = pd.read_csv(tmp_path / "worst_cases.csv").set_index("label")
    assert worst.loc["worst_PM", "payload.mass_kg"] == pytest.approx(1880.0)
    assert set(pd.read_csv(tmp_path / "iterates.csv")["objective"]) == {"PM"}


@pytest.mark.slow
def test_verify_fails_where_a_requirement_is_not_met(drakesep, tmp_path):
    """With 5 m/s wanted; one spring's force is the whole box, to be quick."""
    from drakesep.case_file.reader import builtin_cases

    text = builtin_cases()["vega"].read_text()
    text = text.replace("at_least: 0.5", "at_least: 5")
    start, end = text.index("dispersions:"), text.index("requirements:")
    text = text[:start] + "dispersions: {payload.mass_kg: 20}\n" + text[end:]
    text = text[: text.index("objectives: paper")]
    (tmp_path / "case.yaml").write_text(text)
    code, out, _ = drakesep(
        *("verify", tmp_path / "case.yaml", "-o", tmp_path / "out"),
        *("--search", "drake", "--workers", 1),
    )
    assert code == 1
    assert "Not every requirement is met" in out
    requirements = pd.read_csv(tmp_path / "out" / "requirements.csv")
    assert requirements["verdict"].tolist() == ["met"] * 6 + ["not met", "met"]
    assert requirements["margin"].iloc[-2] == pytest.approx(1.14 - 5.0, abs=0.02)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ("show", "vga"),
            "vga: must be a readable case file or a built-in case (dual_launch,",
        ),
        (
            ("simulate", "vega", "--set", "payload.mass=1"),
            "unknown parameter 'payload.mass'; did you mean 'payload.mass_kg'?",
        ),
        (("simulate", "vega", "--set", "payload.mass_kg"), "--set: must be NAME=VALUE"),
        (
            ("simulate", "vega", "--set", "payload.mass_kg=x"),
            "--set payload.mass_kg: must be a number, got 'x'",
        ),
        (
            ("simulate", "vega", "--set", "payload.mass_kg=nan"),
            "payload.mass_kg must be finite, got nan",
        ),
        (
            ("simulate", "vega", *("--set", "payload.mass_kg=1880") * 2),
            "--set payload.mass_kg: must stand once, got it twice",
        ),
        (
            ("simulate", "vega", "--set", "payload.mass_kg=-1"),
            "payload: mass must be > 0, got -1",
        ),
        (
            ("worst-case", "vega", "--objective", "L3"),
            "unknown objective 'L3'; did you mean",
        ),
        (
            ("worst-case", "vega", "--search", "vertex"),
            "unknown search 'vertex'; did you mean 'vertices'?",
        ),
        (
            ("verify", "vega", "--starts", "0"),
            "starts: must be a whole number >= 1, got 0",
        ),
    ],
)
def test_bad_input_is_one_line_and_code_2(drakesep, tmp_path, arguments, message):
    output = () if arguments[0] == "show" else ("-o", tmp_path)
    code, _, err = drakesep(*arguments, *output)
    assert code == 2
    assert err.startswith(f"drakesep: {message}")
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize("name", BAD)
def test_bad_case_is_one_line_and_code_2(drakesep, tmp_path, name):
    data, message = BAD[name]
    path = tmp_path / "case.yaml"
    with path.open("w") as file:
        YAML(typ="safe").dump(data, file)
    code, _, err = drakesep("show", path)
    assert code == 2
    assert err.startswith(f"drakesep: {path}: {message}")
    assert len(err.splitlines()) == 1


def test_output_that_cannot_be_written(drakesep, tmp_path):
    (tmp_path / "file").write_text("")
    code, _, err = drakesep("simulate", "vega", "-o", tmp_path / "file")
    assert code == 2
    assert err.startswith("drakesep: output: must be a folder that can be written")
    assert len(err.splitlines()) == 1


def test_file_in_the_way(drakesep, tmp_path):
    (tmp_path / "motion.csv").mkdir()
    code, _, err = drakesep("simulate", "vega", "-o", tmp_path)
    assert code == 2
    assert err.splitlines() == [f"drakesep: {tmp_path / 'motion.csv'}: Is a directory"]


def test_text_of_a_case_is_not_markup(drakesep, tmp_path):
    from drakesep.case_file.reader import builtin_cases

    text = builtin_cases()["vega"].read_text()
    text = text.replace("description: VEGA", "description: '[/oops] [bold]VEGA' #")
    (tmp_path / "case.yaml").write_text(text)
    code, out, _ = drakesep("show", tmp_path / "case.yaml")
    assert code == 0
    assert "[/oops] [bold]VEGA" in out


def test_narrow_terminal_loses_nothing(drakesep, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    _, out, _ = drakesep("show", "vega")
    assert "…" not in out
    assert max(map(len, out.splitlines())) <= 80


@pytest.mark.slow
def test_interrupt_ends_in_one_line(tmp_path):
    """Ctrl-C in the midst of a search: no traceback, of ours or of a library's."""
    script = (
        # a test run in the background inherits that interrupts are ignored
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "from drakesep.cli.app import main; main()"
    )
    command = [sys.executable, "-c", script]
    verify = subprocess.Popen(
        [*command, "verify", "vega", "-o", str(tmp_path)],
        stderr=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    searches = tmp_path / "searches.csv"
    while verify.poll() is None and not searches.exists():
        time.sleep(0.05)
    time.sleep(0.3)  # in the midst of the second search
    os.killpg(verify.pid, signal.SIGINT)  # the terminal sends it to workers too
    _, err = verify.communicate(timeout=60)
    assert verify.returncode == 130
    lines = [line for line in err.splitlines() if line.startswith("drakesep")]
    assert lines == [f"drakesep: interrupted; what was done is in {tmp_path}"]
    labels = pd.read_csv(tmp_path / "worst_cases.csv")["label"]
    assert labels.tolist()[:2] == ["nominal", "paper_L1_Linf"]


@pytest.mark.parametrize(("level", "quiet"), [(None, True), ("1", False)])
def test_what_xla_says_stays_off_the_screen(level, quiet):
    """Unless its user asks for it: here, that it cannot dump what it compiles."""
    script = (
        "import sys; sys.argv = ['drakesep', 'cases']\n"
        "from drakesep.cli import app as cli\n"
        "try: cli.main()\n"
        "except SystemExit: pass\n"
        "import jax; jax.jit(lambda x: x + 1.0)(1.0)\n"
        "print('ours', file=sys.stderr)\n"
    )
    environment = {**os.environ, "XLA_FLAGS": "--xla_dump_to=/proc/nowhere"}
    environment.pop("TF_CPP_MIN_LOG_LEVEL", None)
    if level is not None:
        environment["TF_CPP_MIN_LOG_LEVEL"] = level
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, env=environment
    )
    assert done.returncode == 0, done.stderr
    assert (done.stderr.splitlines() == ["ours"]) is quiet
    assert done.stderr.splitlines()[-1] == "ours"


def test_help_imports_neither_drake_nor_scipy():
    """So that it comes within a second."""
    script = (
        "import sys; sys.argv = ['drakesep', '--help']\n"
        "from drakesep.cli import app as cli\n"
        "try: cli.main()\n"
        "except SystemExit: pass\n"
        "heavy = {'pydrake', 'scipy', 'pandas', 'matplotlib', 'numpy', 'pydantic'}\n"
        "assert not heavy & set(sys.modules), heavy & set(sys.modules)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert "verify" in done.stdout
