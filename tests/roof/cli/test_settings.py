"""Every option of every command: it does what its argument in Python does, and that
is something else than without it.

Tables are compared to the last digit, file by file.
"""

import dataclasses
import itertools
import json
import re
import shutil
from collections import OrderedDict

import pandas as pd
import pytest
import typer
from command_line import run
from left_behind import whole
from small_case import small_case, write_case

import drakesep
from drakesep.analysis.engines.drake_pool import DrakePool
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.search.effort import Effort
from drakesep.cli.app import app
from drakesep.results import provenance
from drakesep.studies import tolerance_growth
from drakesep.studies.background_process import BackgroundProcess
from drakesep.studies.worst_case import session
from drakesep.studies.worst_case.session import Session
from drakesep.systems.model.integration import Integration
from drakesep.systems.simulation.simulation import Simulation


HARD = {"samples": 48, "starts": 3, "vertices": 64, "seed": 1}
"""How hard to search, if nothing else is said."""
OF_SEARCH = {
    "--search": (["vertices"], {"searches": ["vertices"]}),
    "--starts": (5, {"starts": 5}),
    "--samples": (32, {"samples": 32}),
    # Too few for all: flips of bounds take their place.
    "--vertices": (3, {"vertices": 3}),
    "--seed": (2, {"seed": 2}),
}
OPTIONS = {
    "cases": {},
    "show": {},
    "new": {},  # test_new.py
    "simulate": {
        "--set": (
            ["upper.mass_kg=1180", "two.position_y_mm=-390"],
            {"values": {"upper.mass_kg": 1180.0, "two.position_y_mm": -390.0}},
        )
    },
    "sweep": {"--engine": ("batch", {"engine": "batch"})},
    "campaign": {
        "--runs": (350, {"runs": 350}),
        "--seed": (2, {"seed": 2}),
        "--share": (0.98, {"share": 0.98}),
        "--confidence": (0.8, {"confidence": 0.8}),
        "--keep": ("worst", {"keep": "worst"}),
        "--metric": (["final_rate_x"], {"metrics": ["final_rate_x"]}),
    },
    "replay": {},  # test_campaign.py
    "report": {},  # roof/reports/test_command.py
    "clearance": {
        "--set": (
            ["upper.mass_kg=1180", "two.position_y_mm=-390"],
            {"values": {"upper.mass_kg": 1180.0, "two.position_y_mm": -390.0}},
        )
    },
    "animate": {},  # below
    "compare": {},  # test_compare.py
    "export": {},  # test_export.py
    "worst-case": {
        **OF_SEARCH,
        "--objective": (
            ["L2", "highest_final_rate_x"],
            {"objectives": ["L2", "highest_final_rate_x"]},
        ),
    },
    "verify": {
        **OF_SEARCH,
        "--objective": (
            ["highest_final_rate_x"],
            {"objectives": ["highest_final_rate_x"]},
        ),
        "--growth": (None, {"growth": True}),
        "--no-growth": (None, {"growth": False}),
        "--failures": (None, {"failures": True}),
        "--campaign": (300, {"campaign": 300}),
    },
    "prove": {},  # test_proofs.py
    "check-proof": {},  # roof/studies/test_proof_check.py
}
"""Of each command: an option, its value, and the same argument in Python."""
ELSEWHERE = {
    "new": {"--from", "--output", "-o"},
    "animate": {"--output", "-o", "--runs", "--run"},
    "compare": {"--output", "-o", "--tolerance"},
    "export": {
        *("--format", "--run", "--epoch", "--frame", "--plane", "--time-system"),
        *("--output", "-o"),
    },
    "simulate": {"--output", "-o"},
    "sweep": {"--output", "-o", "--workers"},
    "campaign": {"--output", "-o", "--workers", "--resume", "--dask", "--chunk"},
    "replay": {"--run", "--animation", "--no-animation", "--output", "-o"},
    "report": {"--output", "-o", "--pdf", "--check", "--tolerance"},
    "clearance": {"--output", "-o"},
    "prove": {
        *("--output", "-o", "--objective", "--gap-percent", "--proof-seconds"),
        "--resume",
    },
    "check-proof": {"--workers"},
    "worst-case": {"--output", "-o", "--workers", "--flips", "--minutes", "--resume"},
    "verify": {
        *("--output", "-o", "--workers", "--flips", "--corners", "--minutes"),
        *("--resume", "--share", "--confidence", "--report", "--prove"),
        "--proof-seconds",
    },
}
"""Tested below; `--report` in roof/reports/test_html.py, `--prove` and the like
in roof/studies/test_proofs.py."""
SWEPT = {"upper.mass_kg": [1180.0, 1200.0, 1220.0]}
FEW = {"runs": 300, "share": 0.99, "confidence": 0.9}
"""Of a campaign: enough to show so much."""
OF_ALL = {"--quiet", "--json"}
"""Tested in test_answer.py."""


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    data = small_case(dispersions={"upper.mass_kg": 50.0, "upper.cg_y_mm": 8.0})
    data["requirements"] = data["requirements"][:1]
    [published] = data["published"]
    published["values"] = {"upper.mass_kg": "M", "s1.force_max_N": 1180.0}
    return write_case(tmp_path_factory.mktemp("case"), data)


@pytest.fixture(scope="module")
def batches():
    return {}


@pytest.fixture(autouse=True)
def quick(monkeypatch, batches):
    """A batch is compiled once for all studies, nothing is drawn, and all is here."""

    def batch(separation, names, **how):
        key = separation, names, repr(how)
        if key not in batches:
            batches[key] = Batch(separation, names, **how)
        return batches[key]

    monkeypatch.setattr("drakesep.studies.variant_engines.Batch", batch)
    monkeypatch.setattr(Session, "draw", lambda *_: None)
    monkeypatch.setattr("drakesep.analysis.campaigns.flights.Batch", batch)
    drawn = (
        "campaign.save_campaign",
        "motion.save_motion",
        "clearance_plots.save_clearance",
        "sweep.save_sweep",
    )
    for module in drawn:
        monkeypatch.setattr(f"drakesep.plots.{module}", lambda *_, **__: None)
    monkeypatch.setattr("drakesep.plots.swept_volume.save_swept", lambda *_: None)
    monkeypatch.setattr(
        "drakesep.studies.background_process.BackgroundProcess.__init__",
        lambda self, workers=None: here(self),
    )


def here(process: BackgroundProcess):
    process._wanted, process._process = False, None


@pytest.fixture
def drakesep_(capsys, monkeypatch):
    def call(*arguments):
        code, _, err = run(capsys, monkeypatch, *arguments)
        assert code == 0, err

    return call


def tables(folder):
    return {path.name: path.read_text() for path in folder.glob("*.csv")}


def options_of(command):
    found = typer.main.get_command(app).commands[command]
    if command == "campaign":  # which flies, if no other of the group is named
        found = found.commands["run"]
    parameters = found.params
    named = [p for p in parameters if p.param_type_name == "option"]
    return {name for p in named for name in (*p.opts, *p.secondary_opts)}


@pytest.mark.parametrize("command", OPTIONS)
def test_every_option_is_here(command):
    here = set(OPTIONS[command]) | ELSEWHERE.get(command, set()) | OF_ALL
    assert here == options_of(command)


def in_words(option, value):
    if value is None:
        return [option]
    values = value if isinstance(value, list) else [value]
    return [word for one in values for word in (option, one)]


def hard_in_words(without=()):
    return [
        word
        for name, value in HARD.items()
        if f"--{name}" not in without
        for word in (f"--{name}", value)
    ]


def called(command, case, folder, arguments):
    """The study in Python, and its tables in a folder."""
    if command in ("simulate", "clearance", "prove"):
        study = getattr(drakesep, command)(case, **arguments)
        study.save(folder)
        return
    if command == "campaign":
        drakesep.campaign(case, output=folder, workers=1, **{**FEW, **arguments})
        return
    if command == "sweep":
        drakesep.sweep(case, SWEPT, output=folder, **arguments)
        return
    options = {**HARD, "growth": False, **arguments}
    if command == "worst-case":
        del options["growth"]
        options.setdefault("objectives", ["L1"])
        drakesep.worst_case(case, output=folder, workers=1, **options)
    else:
        drakesep.verify(case, output=folder, workers=1, **options)


def typed(command, case, folder, option, value):
    """The words of a command line that ask for the same."""
    words = [command, case, "-o", folder, *in_words(option, value)]
    if command == "campaign":
        few = {"--runs": 300, "--share": 0.99, "--confidence": 0.9, "--workers": 1}
        words += [w for k, x in few.items() if k != option for w in (k, x)]
    if command == "sweep":
        words.insert(2, "upper.mass_kg=1180:1220:3")
    if command in ("worst-case", "verify"):
        words += [*hard_in_words(without=[option]), "--workers", 1]
    if command == "worst-case" and option != "--objective":
        words += ["--objective", "L1"]
    if command == "verify" and option not in ("--growth", "--no-growth"):
        words += ["--no-growth"]
    return words


@pytest.fixture(scope="module")
def plain(case, tmp_path_factory):
    """Tables of a command without the option; of --no-growth, with growth."""
    known = {}

    def tables_of(command, option):
        key = command, option == "--no-growth"
        if key not in known:
            folder = tmp_path_factory.mktemp("plain")
            more = {"growth": True} if option == "--no-growth" else {}
            called(command, case, folder, more)
            known[key] = tables(folder)
        return known[key]

    return tables_of


@pytest.mark.parametrize(
    ("command", "option"),
    [(command, option) for command, options in OPTIONS.items() for option in options],
)
def test_option(command, option, case, tmp_path, drakesep_, plain):
    value, arguments = OPTIONS[command][option]
    drakesep_(*typed(command, case, tmp_path / "typed", option, value))
    called(command, case, tmp_path / "called", arguments)
    by_command, in_python = tables(tmp_path / "typed"), tables(tmp_path / "called")
    assert by_command.keys() == in_python.keys()
    for name, text in in_python.items():
        assert by_command[name] == text, name
    assert by_command != plain(command, option)


def test_another_seed_draws_other_points(case, tmp_path, drakesep_):
    """And the same one the same."""
    points = []
    for seed in (1, 2, 1):
        words = [*hard_in_words(without=["--seed"]), "--seed", seed]
        drakesep_(
            *("worst-case", case, "-o", tmp_path, "--objective", "L1"),
            *("--search", "samples", "--workers", 1, *words),
        )
        frame = pd.read_csv(tmp_path / "candidates.csv")
        points.append(frame[["upper.mass_kg", "upper.cg_y_mm"]].to_numpy().tolist())
    assert points[0] == points[2] != points[1]


def test_what_only_python_sets(case, monkeypatch):
    """Generations reach evolution; corners, and the seed with them, the growth."""
    told, grow = [], tolerance_growth.grow

    def noted(problem, limits, **how):
        told.append((how["corners"], how["seed"]))
        return grow(problem, limits, **how)

    monkeypatch.setattr(tolerance_growth, "grow", noted)
    effort = {**HARD, "seed": 7, "corners": 20, "flips": 50, "generations": 2}
    study = drakesep.verify(
        case, searches=["evolution"], growth=True, workers=1, **effort
    )
    assert told == [(20, 7)]
    [note] = study.searches["what"]
    assert "at most 2 generations" in note
    assert set(effort) == set(Effort.__annotations__)


@pytest.mark.parametrize(
    ("command", "words", "planned"),
    [
        ("worst-case", ["--flips", 70], {"flips": 70, "corners": 4096}),
        ("verify", ["--flips", 70, "--corners", 20], {"flips": 70, "corners": 20}),
    ],
)
def test_what_two_parameters_do_not_show(
    command, words, planned, case, tmp_path, drakesep_
):
    """Of two there are four corners, which are all seen at once."""
    words = [*words, "--search", "corners", *hard_in_words()]
    drakesep_(command, case, "-o", tmp_path, *words, "--workers", 1)
    plan = drakesep.read_results(tmp_path).record.plan
    assert {name: plan[name] for name in planned} == planned
    assert plan["searches"] == ["corners"]


def test_chunks_of_a_campaign(case, tmp_path, drakesep_):
    """They change nothing of what it says, but how it is flown."""
    words = ["--runs", 300, "--share", 0.99, "--chunk", 100, "-o", tmp_path]
    drakesep_("campaign", case, *words)
    plan = json.loads((tmp_path / "plan.json").read_text())
    assert (plan["runs"], plan["chunk"], plan["chunks"]) == (300, 100, 3)


def test_share_and_confidence_of_a_campaign_beside(case, tmp_path, drakesep_):
    """They go to the requirements, as those of `campaign` do."""
    words = ["--share", 0.98, "--confidence", 0.8, "--campaign", 300]
    words += ["--search", "vertices", "--workers", 1]
    drakesep_("verify", case, "-o", tmp_path, *words)
    table = pd.read_csv(tmp_path / "answers.csv")
    assert table[["share", "confidence"]].to_numpy().tolist() == [[0.98, 0.8]]
    assert set(table["decided_by"]) == {"campaign"}


@pytest.mark.parametrize("command", ["worst-case", "verify"])
def test_minutes(command, case, tmp_path, capsys, monkeypatch, drakesep_):
    """What they do not allow is refused; the plan itself is tested where it is made."""
    words = [command, case, "-o", tmp_path, "--search", "drake", "--workers", 1]
    words += ["--objective", "PM"] if command == "worst-case" else []
    drakesep_(*words, "--minutes", 60)
    code, _, err = run(capsys, monkeypatch, *words, "--minutes", 1e-6)
    assert code == 2
    told = r"drakesep: minutes: must be 0\.\d+ or more on this machine, got 1e-06, "
    assert re.match(told, err)


@pytest.fixture
def interrupted_at(capsys, monkeypatch):
    """A command, and what it told until it came to a step, where it is interrupted."""
    tell = Session.tell

    def called(step, *words):
        told = []

        def tell_or_end(session, progress):
            told.append(progress.search)
            if progress.search == step:
                raise KeyboardInterrupt
            tell(session, progress)

        monkeypatch.setattr(Session, "tell", tell_or_end)
        code, _, err = run(capsys, monkeypatch, *words)
        assert code == (130 if step else 0), err
        monkeypatch.setattr(Session, "tell", tell)
        return list(dict.fromkeys(told))

    return called


@pytest.mark.parametrize("command", ["worst-case", "verify"])
def test_resume(command, case, tmp_path, monkeypatch, interrupted_at):
    """Interrupted once in each step, it ends as it would have; no search goes twice."""
    words = [command, case, "-o", tmp_path, *hard_in_words(), "--workers", 1]
    words += ["--objective", "L1"] if command == "worst-case" else []
    steps = interrupted_at(None, *words)
    begun_once = whole(tmp_path)
    shutil.rmtree(tmp_path)

    measured = session.measured_speed
    assert steps == [
        *("plan", "samples", "vertices", "sqp", "multistart", "confirmation"),
        *(["growth"] if command == "verify" else []),
    ]
    for before, step in itertools.pairwise(steps):
        told = interrupted_at(step, *words, "--resume")
        assert told == list(dict.fromkeys(["plan", before, step]))
        # Where runs take an hour, growth would be left out: what was planned goes on.
        monkeypatch.setattr(
            session,
            "measured_speed",
            lambda *asked: dataclasses.replace(measured(*asked), run=3600.0),
        )
    assert interrupted_at(None, *words, "--resume")[:2] == ["plan", "confirmation"]
    assert whole(tmp_path) == begun_once


def test_what_may_be_resumed(case, tmp_path, capsys, monkeypatch, interrupted_at):
    """The same study alone: another is refused, and what is kept stays."""
    words = ["worst-case", case, "--objective", "L1", "--workers", 1, "-o", tmp_path]
    interrupted_at("vertices", *words, *hard_in_words(), "--resume")
    kept = whole(tmp_path)

    def refused(*others):
        code, _, err = run(capsys, monkeypatch, *others, "--resume")
        assert code == 2
        assert whole(tmp_path) == kept
        [line] = err.splitlines()
        return line.removeprefix("drakesep: resume: ")

    other_seed = [*hard_in_words(without=["--seed"]), "--seed", 2]
    assert refused(*words, *other_seed).endswith("seed = 1, got 2")
    fewer = [*hard_in_words(without=["--samples"]), "--samples", 47]
    assert refused(*words, *fewer).endswith("samples = 48, got 47")
    more = [*hard_in_words(), "--search", "samples"]
    assert refused(*words, *more).endswith("searches = None, got ['samples']")
    with monkeypatch.context() as patch:
        versions = {**provenance.versions(), "jax": "0.0.1"}
        patch.setattr(provenance, "versions", lambda: versions)
        assert refused(*words, *hard_in_words()).endswith(", got 0.0.1")
    dispersions = {"upper.mass_kg": 51.0, "upper.cg_y_mm": 8.0}
    data = small_case(dispersions=dispersions, published=None)
    words[1] = write_case(tmp_path.parent, data, "other.yaml")
    assert refused(*words, *hard_in_words()).endswith("got one that differs")

    words[1] = case
    part = tmp_path / ".parts" / "samples.json"
    whole_part = part.read_text()
    for text in (whole_part[:100], "3", '[{"record": "Sphere"}]'):
        part.write_text(text)
        code, _, err = run(capsys, monkeypatch, *words, *hard_in_words(), "--resume")
        assert code == 2
        assert err.startswith(f"drakesep: {part}: must be a part of a study, got: ")
    part.write_text(whole_part)
    assert interrupted_at(None, *words, *hard_in_words(), "--resume")[1] == "vertices"
    code, _, err = run(capsys, monkeypatch, *words, *hard_in_words(), "--resume")
    assert code == 2
    assert err.rstrip().endswith("completed")


def test_what_cannot_be_resumed(case, tmp_path):
    """Functions cannot be compared; and there must be a folder."""
    with pytest.raises(ValueError, match=r"^output: .* to resume, got None"):
        drakesep.worst_case(case, ["L1"], resume=True)

    def height(run):
        return float(run.completed_motion.relative_position[-1, 0])

    def asked(**how):
        drakesep.worst_case(case, height, output=tmp_path, workers=1, **HARD, **how)

    def end(_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        asked(on_progress=end)
    with pytest.raises(ValueError, match=r"^resume: .* got functions"):
        asked(resume=True)


@pytest.mark.parametrize(
    "command", ["simulate", "sweep", "clearance", "worst-case", "verify"]
)
def test_output(command, case, tmp_path, monkeypatch, drakesep_):
    """Where it says, or in results beside the caller, by the names of both."""
    monkeypatch.chdir(tmp_path)
    words = ["--search", "samples", *hard_in_words(), "--workers", 1]
    words = words if command in ("worst-case", "verify") else []
    words += ["--objective", "L1"] if command == "worst-case" else []
    words += ["upper.mass_kg=1180,1220"] if command == "sweep" else []
    words += ["--no-growth"] if command == "verify" else []
    for option in ("--output", "-o"):
        drakesep_(command, case, *words, option, tmp_path / option)
    drakesep_(command, case, *words)
    by_default = tables(tmp_path / "results" / "small" / command)
    assert by_default
    assert by_default == tables(tmp_path / "--output") == tables(tmp_path / "-o")


@pytest.mark.parametrize("command", ["worst-case", "verify"])
@pytest.mark.parametrize("workers", [None, 1, 2])
def test_workers(command, workers, case, tmp_path, monkeypatch, drakesep_):
    asked = []

    class Noted(DrakePool):
        def __init__(self, separation, integration=None, *, workers=None):
            asked.append(workers)
            super().__init__(separation, integration, workers=1)

    monkeypatch.setattr("drakesep.studies.worst_case.session.DrakePool", Noted)
    words = [] if workers is None else ["--workers", workers]
    words += ["--objective", "PM"] if command == "worst-case" else []
    drakesep_(command, case, "-o", tmp_path, "--search", "drake", *words)
    assert asked == [workers]


@pytest.mark.parametrize(
    "command", ["simulate", "sweep", "clearance", "animate", "worst-case", "verify"]
)
def test_every_run_is_integrated_as_the_case_says(
    command, tmp_path, monkeypatch, drakesep_
):
    data = small_case(dispersions={"upper.mass_kg": 50.0}, published=None)
    data["run"] |= {
        "integrator": "bogacki_shampine3",
        "accuracy": 3e-7,
        "max_step_s": 0.2,
    }
    wanted = Integration(scheme="bogacki_shampine3", accuracy=3e-7, max_step=0.2)
    monkeypatch.setattr(
        "drakesep.systems.simulation.shared_simulation._of_thread.known", OrderedDict()
    )
    told, begin = [], Simulation.__init__

    def noted(self, separation, integration=None):
        told.append(integration)
        begin(self, separation, integration)

    monkeypatch.setattr(Simulation, "__init__", noted)
    output = tmp_path / "page.html" if command == "animate" else tmp_path
    words = ["--search", "drake", "--workers", 1]
    words = words if command in ("worst-case", "verify") else []
    words += ["upper.mass_kg=1180,1220"] if command == "sweep" else []
    words += ["--objective", "PM"] if command == "worst-case" else []
    drakesep_(command, write_case(tmp_path, data), "-o", output, *words)
    assert told
    assert all(integration == wanted for integration in told)


@pytest.mark.parametrize(("workers", "asked"), [(None, [1]), (1, [1]), (2, [1, 2])])
def test_workers_of_a_sweep(workers, asked, case, tmp_path, monkeypatch, drakesep_):
    """The first pool, in this process, tells how long a run takes."""
    told = []

    class Noted(DrakePool):
        def __init__(self, separation, integration=None, *, workers=None):
            told.append(workers)
            super().__init__(separation, integration, workers=1)

    monkeypatch.setattr("drakesep.studies.variant_engines.DrakePool", Noted)
    words = [] if workers is None else ["--workers", workers]
    drakesep_("sweep", case, "upper.mass_kg=1180,1220", "-o", tmp_path, *words)
    assert told == asked


def test_runs_of_an_animation(case, tmp_path, monkeypatch, drakesep_):
    """All published, or those of a table, or of these the ones that are named."""
    shown = []

    def drawn(flown, *_, **__):
        shown.append({label: run.separation for label, run in flown.items()})
        return "page"

    monkeypatch.setattr("drakesep.plots.animation.animation", drawn)
    pd.DataFrame(
        {
            "label": ["worst_L1", "worst_PM", "mine"],
            "role": ["worst", "worst", "changed"],
            "upper.mass_kg": [1230.0, 1240.0, 1250.0],
        }
    ).to_csv(tmp_path / "runs.csv", index=False)
    table = ("--runs", tmp_path / "runs.csv")
    page = tmp_path / "there" / "page.html"
    drakesep_("animate", case, "-o", page)
    drakesep_("animate", case, "--output", page, *table)
    drakesep_("animate", case, "-o", page, *table, "--run", "mine", "--run", "worst_PM")
    assert page.read_text() == "page"
    monkeypatch.chdir(tmp_path)
    drakesep_("animate", case)
    assert (tmp_path / "results" / "small" / "animate.html").exists()
    masses = [
        {label: s.body("upper").mass for label, s in runs.items()} for runs in shown
    ]
    published = {"nominal": 1200.0, "theirs": 1250.0}
    assert masses == [
        published,
        {"nominal": 1200.0, "worst_L1": 1230.0, "worst_PM": 1240.0},
        {"nominal": 1200.0, "mine": 1250.0, "worst_PM": 1240.0},
        published,
    ]
    python = tmp_path / "python.html"
    runs = {"mine": {"upper.mass_kg": 1250.0}}
    assert drakesep.animate(case, runs, output=python) == ["nominal", "mine"]
