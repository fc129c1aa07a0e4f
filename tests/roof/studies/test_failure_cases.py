"""Failure cases verified beside the design: each is what a case of its own would be."""

import copy
import itertools
import json
import math

import pandas as pd
import pytest
from small_case import small_case

import drakesep
from drakesep.analysis.metrics.objectives import OBJECTIVES
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.analysis.search.effort import SearchSettings
from drakesep.studies import failure_cases
from drakesep.studies.worst_case.effort import of_failure
from drakesep.systems.checks import InputError
from drakesep.systems.simulation.simulation import Simulation
from drakesep.tables import labelled_run
from drakesep.units import unit_of


FAILURES = {
    "s1_weak": {"s1.force_max_N": 900.0},
    "heavy": {"upper.mass_kg": "max"},
    "held": {"two.release_time_s": "never"},
}
HARD = {"samples": 100, "starts": 3, "vertices": 64, "growth": False, "workers": 1}


def case(**sections):
    return drakesep.Case.model_validate(small_case(**sections))


SIMULATION = Simulation(case().separation)


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("failures")
    study = drakesep.verify(
        case(failure_cases=FAILURES), failures=True, output=folder, **HARD
    )
    return study, folder


def test_the_tables_are_in_the_folder(study):
    study, folder = study
    for name in ("failure_cases", "failure_requirements", "failure_runs"):
        left = pd.read_csv(folder / f"{name}.csv", keep_default_na=False)
        assert len(left) == len(getattr(study, name))
    assert (folder / "failure_cases.png").exists()


def test_each_is_as_bad_as_a_grid_flown_in_drake(study):
    """All ends and middles of what still varies: the worst are at ends.

    Within what a search leaves at bounds, and Drake's accuracy, 1e-6 of a value.
    """
    mm = 1e-3
    varying = {
        "upper.mass": (1150.0, 1200.0, 1250.0),
        "s1.force_max": (1140.0, 1200.0, 1260.0),
        "upper.cg_y": (-28.0 * mm, -20.0 * mm, -12.0 * mm),
    }
    found = study[0].failure_requirements.set_index("failure_case")
    requirements = study[0].case.requirements
    for name, failed in (
        ("s1_weak", {"s1.force_max": 900.0}),
        ("heavy", {"upper.mass": 1250.0}),
    ):
        grid = {key: ends for key, ends in varying.items() if key not in failed}
        runs = [
            metrics_of_run(
                SIMULATION.run({**failed, **dict(zip(grid, at, strict=True))}),
                study[0].case.limits_of_pairs,
            )
            for at in itertools.product(*grid.values())
        ]
        for row, required in zip(
            found.loc[name].to_dict("records"), requirements, strict=True
        ):
            values = [
                unit_of(required.metric).from_si(r[required.judged_by]) for r in runs
            ]
            worst = max(values) if required.from_above else min(values)
            assert row["worst"] == pytest.approx(worst, rel=1e-6)
            assert row["nominal"] == pytest.approx(values[len(values) // 2], rel=1e-6)
            assert (row["verdict"] == "met") == required.keeps(
                required.margin(unit_of(required.metric).to_si(worst))
            )


def test_what_never_lets_go_does_not_separate(study):
    study, _ = study
    rows = study.failure_cases.set_index("failure_case")
    assert rows.loc["held", "verdict"] == "does not separate"
    assert rows.loc["held", "changed"] == "two.release_time_s never"
    verdicts = study.failure_requirements.set_index("failure_case").loc["held"]
    assert "met" not in [*verdicts["verdict"]]
    held = [one for one in study.failed_cases if one.failure.name == "held"]
    assert held[0].held == ("upper",)
    # It is a result: one run, flown to its end, with what the joints carry.
    [run] = held[0].study.runs
    assert run.run.motion is not None
    assert math.isfinite(rows.loc["held", "joint_force_N"])


def test_what_has_failed_is_held_in_every_run(study):
    runs = study[0].failure_runs
    assert (runs.query("failure_case == 's1_weak'")["s1.force_max_N"] == 900.0).all()
    heavy = runs.query("failure_case == 'heavy'")
    assert (heavy["upper.mass_kg"] == 1250.0).all()
    assert heavy["s1.force_max_N"].between(1140.0, 1260.0).all()
    assert heavy["s1.force_max_N"].nunique() > 1  # what has not, varies


def test_of_both_directions_of_a_limit_the_worse_is_flown(study):
    """Which is in the tables, and is what the grid is held against."""
    [weak] = [o for o in study[0].failed_cases if o.failure.name == "s1_weak"]
    flown = {one.objective for one in weak.study.runs}
    case = study[0].case
    two = [ways for r in case.requirements if len(ways := case.names_towards(r)) == 2]
    assert two
    for ways in two:
        assert len(flown.intersection(ways)) == 1
    assert not {one.name for one in OBJECTIVES.values()} & flown  # the paper's


@pytest.mark.parametrize(
    ("searches", "expected"),
    [
        (("samples", "vertices", "sqp", "multistart"), ("samples", "corners", "best")),
        (("samples", "corners", "multistart"), ("samples", "corners", "best")),
        (("sqp",), ("best",)),
        (("evolution",), ("evolution",)),
    ],
)
def test_it_is_searched_from_where_the_design_is_worst(searches, expected):
    cheap = [OBJECTIVES["L1"]]
    names, settings = of_failure(searches, SearchSettings(flips=1), cheap)
    assert names == expected
    assert (settings.samples, settings.flips) == (2048, 1)  # no more than is asked for
    _, few = of_failure(searches, SearchSettings(samples=1600), cheap)
    assert (few.samples, few.flips) == (100, 4)


def test_the_verdict_is_that_of_all(study):
    study, folder = study
    assert study.design_verdict == "met"
    assert (study.requirements["verdict"] == "met").all()
    assert study.verdict == "not met"  # of what does not separate
    assert not study.passed
    assert drakesep.read_results(folder).record.verdict == "not met"


def test_it_is_asked_for_what_there_is():
    with pytest.raises(InputError, match=r"failure_cases: .* must have some, got none"):
        drakesep.verify(case(failure_cases=None), failures=True)


def test_without_tolerances_there_are_nominal_runs():
    few = {name: FAILURES[name] for name in ("s1_weak", "held")}
    alone = case(failure_cases=few, dispersions=None, published=None, objectives=None)
    study = drakesep.verify(alone, failures=True)
    assert study.failure_cases["failure_case"].tolist() == ["design", *few]
    assert study.failure_cases["verdict"].tolist()[-1] == "does not separate"
    assert study.failure_runs["label"].tolist() == ["nominal", "nominal"]


def test_a_lock_beside_what_is_fixed_for_good_is_missed_nowhere():
    """Without the tether, which holds nothing, the same body would separate."""
    data = small_case(dispersions=None, published=None, objectives=None)
    tether = copy.deepcopy(data["attachments"]["one"]) | {"release_time_s": "never"}
    del tether["spring"]
    data["attachments"]["tether"] = tether
    data["failure_cases"] = {"held": FAILURES["held"]}
    data["requirements"] = [{"quantity": "longitudinal_speed_max_m_s", "at_most": 9.0}]
    study = drakesep.verify(drakesep.Case.model_validate(data), failures=True)
    assert [one.held for one in study.failed_cases] == [("upper",)]
    assert study.failure_cases["verdict"].tolist() == ["met", "does not separate"]
    assert study.verdict == "not met"


NOMINAL_ALONE = {"dispersions": None, "published": None, "objectives": None}


def test_what_is_finished_is_written_down(tmp_path, monkeypatch):
    """An interrupt in the second failure case leaves the rows of the first."""
    two = {name: FAILURES[name] for name in ("s1_weak", "held")}
    confirmed = failure_cases._confirmed

    def interrupted(one, under_way):
        if one.failure.name == "held":
            raise KeyboardInterrupt
        return confirmed(one, under_way)

    monkeypatch.setattr(failure_cases, "_confirmed", interrupted)
    monkeypatch.setattr(failure_cases, "_TOGETHER", 1)
    with pytest.raises(KeyboardInterrupt):
        drakesep.verify(
            case(failure_cases=two, **NOMINAL_ALONE), failures=True, output=tmp_path
        )
    left = pd.read_csv(tmp_path / "failure_cases.csv")
    assert left["failure_case"].tolist() == ["design", "s1_weak"]
    listed = json.loads((tmp_path / "study.json").read_text())["files"]
    for name in ("failure_cases", "failure_requirements", "failure_runs"):
        assert f"{name}.csv" in {one["name"] for one in listed}


def test_joint_loads_are_computed_once(monkeypatch):
    computed = []
    loads = labelled_run.joint_loads
    monkeypatch.setattr(
        labelled_run, "joint_loads", lambda run: computed.append(run) or loads(run)
    )
    two = {name: FAILURES[name] for name in ("s1_weak", "held")}
    study = drakesep.verify(case(failure_cases=two, **NOMINAL_ALONE), failures=True)
    for _ in range(3):
        assert study.failure_cases["joint_force_N"].notna().all()
    assert len(computed) == 3  # of the design, and of each failure case


def test_what_is_searched_side_by_side_is_what_each_is_alone(study, monkeypatch):
    """But for round-off of rows, of which a search makes no more than its tolerance."""
    monkeypatch.setattr(failure_cases, "_TOGETHER", 1)
    alone = drakesep.verify(case(failure_cases=FAILURES), failures=True, **HARD)
    ours, theirs = (one.failure_requirements for one in (study[0], alone))
    assert ours["failure_case"].tolist() == theirs["failure_case"].tolist()
    assert ours["worst"].tolist() == pytest.approx(
        theirs["worst"].tolist(), rel=1e-8, nan_ok=True
    )


@pytest.mark.slow
def test_an_interrupted_study_goes_on(study, tmp_path):
    """In its second failure case: the first is not searched again."""
    seen = []

    def interrupt(progress):
        if progress.search.search == "failure cases" and progress.search.done == 1:
            raise KeyboardInterrupt

    how = {"failures": True, "output": tmp_path, **HARD}
    with pytest.raises(KeyboardInterrupt):
        drakesep.verify(case(failure_cases=FAILURES), on_progress=interrupt, **how)
    assert drakesep.read_results(tmp_path).record.ended.value == "interrupted"
    drakesep.verify(
        case(failure_cases=FAILURES), resume=True, on_progress=seen.append, **how
    )
    assert "samples" not in {one.search.search for one in seen}
    for name in ("failure_cases", "failure_requirements", "failure_runs", "evidence"):
        ours, theirs = tmp_path / f"{name}.csv", study[1] / f"{name}.csv"
        assert ours.read_bytes() == theirs.read_bytes()
