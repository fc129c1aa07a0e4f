"""Studies from Python: progress, interruption, results on disk."""

import dataclasses
import math

import pandas as pd
import pytest
from trade import symmetric_design

import drakesep
from drakesep.analysis.metrics.objectives import OBJECTIVES, highest
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.run import RunStatus
from drakesep.systems.simulation.simulation import Simulation
from drakesep.tables.roles import failed


IN_DRAKE = {"searches": ["drake"], "workers": 1}


def test_progress_tells_every_iterate(tmp_path):
    seen = []
    study = drakesep.worst_case(
        "vega", ["PM"], output=tmp_path, on_progress=seen.append, **IN_DRAKE
    )
    [ascended] = study.searched[0].candidates
    history = ascended.ascent.history
    planned, *searched, confirmed = [p.search for p in seen]
    assert planned.search == "plan"
    assert str(seen[0].effort).startswith(
        "worst cases of 1 objective over 18 parameters: SQP from the nominal; about"
    )
    shares = [p.remaining.share for p in seen]
    assert shares == sorted(shares)
    assert shares[0] == 0.0
    assert shares[-1] == pytest.approx(1.0)
    assert [search.iterate for search in searched] == [(0, 1, i) for i in history]
    assert {search.search for search in searched} == {"sqp"}
    assert [o.name for o in seen[0].objectives] == ["PM"]
    assert confirmed.search == "confirmation"
    # Where the search ended is the worst that was found.
    assert (confirmed.done, confirmed.total) == (1, 1)


def test_interrupted_study_leaves_what_was_done(tmp_path):
    """Ctrl-C in the second search: the references and the first search are there."""

    def interrupt(progress):
        if progress.search.search == "vertices":
            raise KeyboardInterrupt

    case = drakesep.load_case("vega")
    few = dict(list(case.dispersions.items())[:2])
    case = case.replaced(dispersions=few, published=[])
    with pytest.raises(KeyboardInterrupt):
        drakesep.worst_case(
            case, ["PM", "L2"], samples=100, output=tmp_path, on_progress=interrupt
        )
    worst = pd.read_csv(tmp_path / "worst_cases.csv")
    assert worst["label"].tolist() == ["nominal"]
    candidates = pd.read_csv(tmp_path / "candidates.csv")
    assert candidates["search"].tolist() == ["samples", "samples"]
    assert not (tmp_path / "evidence.csv").exists()


def test_same_answer_whatever_the_number_of_workers():
    tables = [
        drakesep.worst_case("vega", ["PM"], searches=["drake"], workers=n).table
        for n in (1, 2)
    ]
    pd.testing.assert_frame_equal(*tables, check_exact=True)


def test_drake_alone_finds_what_the_batch_engine_finds(vega_verification):
    """The baseline: SQP from the nominal, with differences over Drake's runs."""
    study = drakesep.worst_case("vega", ["PM"], **IN_DRAKE)
    [searched] = study.searched
    assert searched.note == "SQP from the nominal, slopes by differences"
    evidence = study.evidence.set_index("objective").loc["PM"]
    exact = vega_verification.evidence.set_index("objective").loc["PM"]
    assert evidence["sqp"] == pytest.approx(exact["worst"], abs=2e-5)
    assert evidence["difference"] == 0.0
    assert evidence["fraction_beyond_at_95_percent"] == 1.0


def test_users_objectives():
    """A function of the run, a window, and a sum, of two parameters, in Drake."""
    case = drakesep.load_case("vega")
    few = {
        name: case.dispersions[name] for name in ("payload.cg_y_mm", "payload.mass_kg")
    }
    case = case.replaced(dispersions=few, published=[])

    def last_rate_z(run):
        return float(run.completed_motion.rate[-1, 2])

    late = highest("G_L1", window=(1.0, 2.0))
    study = drakesep.worst_case(
        case, [last_rate_z, late, late + OBJECTIVES["L1"]], **IN_DRAKE
    )
    assert study.completed
    worst = study.table.set_index("label").loc["worst_last_rate_z"]
    assert worst["final_rate_z_deg_s"] == pytest.approx(
        math.degrees(study.worst[0].value)
    )
    assert worst["payload.cg_y_mm"] == pytest.approx(14.0)
    assert study.evidence["objective"].tolist() == [
        "last_rate_z",
        "highest_G_L1_1_to_2_s",
        "highest_G_L1_1_to_2_s+L1",
    ]
    assert study.comparison.empty


def test_difference_between_the_engines_is_an_error(monkeypatch):
    """Loudly: the study has not completed, and says what differs."""
    case = drakesep.load_case("vega")
    few = dict(list(case.dispersions.items())[:1])
    case = case.replaced(dispersions=few, published=[])
    flown = Simulation.run

    def heavier(self, values):
        return flown(self, {**values, "launch_vehicle.mass": 800.0})

    monkeypatch.setattr("drakesep.analysis.engines.drake_pool.Simulation.run", heavier)
    study = drakesep.worst_case(
        case, "PM", searches=["vertices"], samples=10, workers=1
    )
    assert not study.completed
    status = study.table.set_index("label").loc["worst_PM", "status"]
    assert status.startswith("failed: Drake gives -1.1")
    assert "where the search found" in status


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"objectives": ["L3"]}, "unknown objective 'L3'; did you mean 'L"),
        ({"objectives": []}, "objectives: must be one or more, got none"),
        (
            {"objectives": [highest("G_L1").named("L1")]},
            "'L1' is the name of one of the case's own",
        ),
        ({"objectives": [5.0]}, "must be an Objective or text or a function, got 5.0"),
        (
            {"objectives": [lambda run: 1.0, lambda run: 2.0]},
            "names must differ, got '<lambda>' twice",
        ),
        ({"searches": ["sqq"]}, "unknown search 'sqq'; did you mean 'sqp'"),
        ({"searches": ["drake", "sqp"]}, "'drake' stands alone in it, got"),
        ({"searches": "sqp"}, "searches must be a sequence, each text"),
        ({"searches": []}, "searches: must be one or more"),
        ({"starts": 0}, "starts: must be a whole number >= 1, got 0"),
    ],
)
def test_bad_searches_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        drakesep.worst_case("vega", **arguments)


def test_case_without_requirements_or_dispersions():
    case = drakesep.load_case("vega")
    with pytest.raises(
        ValueError, match="requirements: a case to verify must have some"
    ):
        drakesep.verify(case.replaced(requirements=[]))
    with pytest.raises(ValueError, match="dispersions: a worst case needs some"):
        drakesep.worst_case(case.replaced(dispersions={}, published=[]))


def test_what_is_looked_at_is_what_the_case_asks(tmp_path):
    """Requirements alone, or what is named beside them: the paper's on request."""
    case = drakesep.load_case("vega").replaced(
        dispersions={"payload.cg_y_mm": 13.0},
        objectives=None,
        published=[],
        requirements=[
            {"quantity": "rate_after_separation_deg_s", "at_most": [1.5, 1.5, 1.5]}
        ],
    )
    study = drakesep.verify(case, output=tmp_path, **IN_DRAKE)
    directions = [
        f"rate_after_separation_{axis}_{way}"
        for axis in "xyz"
        for way in ("up", "down")
    ]
    assert [o.name for o in study.objectives] == directions
    assert study.comparison.empty
    written = {path.name for path in tmp_path.iterdir()}
    assert "requirements.csv" in written
    assert written.isdisjoint({"comparison.csv", "table_4.csv"})

    asked = drakesep.verify(
        case, objectives=["L2", "highest_final_rate_z"], output=tmp_path, **IN_DRAKE
    )
    assert [o.name for o in asked.objectives] == [
        *directions,
        "L2",
        "highest_final_rate_z",
    ]
    assert asked.comparison["objective"].tolist() == ["G_L2"]
    assert (tmp_path / "table_4.csv").exists()
    assert asked.requirements["verdict"].tolist() == ["met"] * 3


def test_what_a_case_has_already_is_searched_once():
    case = drakesep.load_case("vega").replaced(
        dispersions={"payload.cg_y_mm": 13.0}, published=[]
    )
    study = drakesep.verify(case, objectives=["L1", OBJECTIVES["PM"]], **IN_DRAKE)
    assert [o.name for o in study.objectives] == [*drakesep.case_objectives(case)]


def test_a_case_that_asks_for_nothing_says_what_to_give():
    case = drakesep.load_case("vega").replaced(
        objectives=None, published=[], requirements=[]
    )
    with pytest.raises(ValueError, match="objectives: vega has no requirement and no"):
        drakesep.worst_case(case)
    assert drakesep.case_objectives(case) == {}
    study = drakesep.worst_case(
        case.replaced(dispersions={"payload.mass_kg": 20.0}), "PM", **IN_DRAKE
    )
    assert study.comparison["objective"].tolist() == ["G_PM"]


def test_verify_without_dispersions_judges_the_nominal(tmp_path):
    case = drakesep.load_case("vega")
    case = case.replaced(dispersions={}, published=[])
    study = drakesep.verify(case, output=tmp_path, workers=1)
    assert study.passed
    assert study.table["label"].tolist() == ["nominal"]
    assert (study.requirements["which_run"] == "nominal").all()


@pytest.mark.parametrize(
    "wrong", [{"searches": ["foo"]}, {"samples": -5}, {"objectives": ["nonsense"]}]
)
def test_what_is_refused_leaves_an_earlier_study_alone(wrong, tmp_path):
    (tmp_path / "requirements.csv").touch()
    with pytest.raises(ValueError, match=r"foo|samples|nonsense"):
        drakesep.worst_case("vega", output=tmp_path, **wrong)
    assert (tmp_path / "requirements.csv").exists()


def test_verdict_of_an_earlier_study_does_not_outlive_it(tmp_path):
    def interrupt(_):
        raise KeyboardInterrupt

    case = drakesep.load_case("vega").replaced(
        dispersions={"payload.mass_kg": 20}, published=[]
    )
    quick = case.replaced(requirements=case.requirements[:1])
    drakesep.verify(quick, output=tmp_path, **IN_DRAKE)
    assert (tmp_path / "requirements.csv").exists()
    with pytest.raises(KeyboardInterrupt):
        drakesep.verify(case, output=tmp_path, on_progress=interrupt, **IN_DRAKE)
    assert not (tmp_path / "requirements.csv").exists()


def test_nothing_turns_nominally():
    """Objectives of zero at the nominal: no division, and the search still ends."""
    data = drakesep.load_case("vega").model_dump()
    data["orbit"] = None
    data["before_separation"]["rate_deg_s"] = (0.0, 0.0, 0.0)
    data["bodies"]["payload"]["cg_mm"] = (1933.0, 0.0, 0.0)
    data["dispersions"] = {"payload.cg_y_mm": 13.0}
    data["published"] = []
    study = drakesep.worst_case(
        drakesep.Case.model_validate(data), ["L1", "L2"], samples=100
    )
    assert study.completed
    assert study.comparison["above_nominal_percent"].isna().all()
    assert (study.comparison["worst"] > 0.1).all()
    cg = study.table.set_index("label").loc[["worst_L1", "worst_L2"], "payload.cg_y_mm"]
    assert cg.abs().tolist() == pytest.approx([13.0, 13.0])


def test_failed_run_is_a_row_with_its_reason(tmp_path, monkeypatch):
    """Joints that only steps of nanoseconds can follow, while they hold."""
    monkeypatch.setattr("drakesep.systems.simulation.simulation._MOST_STEPS", 1000)
    case = drakesep.load_case("vega")
    stiff = {
        "stiffness_N_m": 1e15,
        "damping_N_s_m": 0.0,
        "angular_stiffness_N_m_rad": 1e15,
        "angular_damping_N_m_s_rad": 0.0,
    }
    data = case.model_dump()
    for attachment in data["attachments"].values():
        attachment["joint"] = stiff
        attachment["release_time_s"] = 1.0
    failed = drakesep.simulate(drakesep.Case.model_validate(data))
    assert failed.run.status is RunStatus.FAILED
    assert failed.run.separation.attachments[0].joint == Joint(
        K_F=1e15, D_F=0.0, K_T=1e15, D_T=0.0
    )
    failed.save(tmp_path)
    [row] = pd.read_csv(tmp_path / "summary.csv").to_dict("records")
    assert row["status"].startswith("failed: ")
    assert row["payload.mass_kg"] == 1860.0
    assert not (tmp_path / "motion.csv").exists()


@pytest.mark.parametrize(("at_least", "verdict"), [(0.01, None), (5.0, "not met")])
def test_a_run_that_fails_within_the_tolerances_takes_the_verdict(at_least, verdict):
    """The run is over when 510 kg would leave the springs: 520 kg never does.

    A quarter of a period of the reduced mass on four springs of 500 N over 80 mm, whose
    80 J give 400 kg no 5 m/s: what a run breaks stays broken, whatever fails.
    """
    reduced = 510.0 * 2000.0 / 2510.0
    end = 0.5 * math.pi * math.sqrt(reduced * 0.08 / 2000.0)
    speed = {"quantity": "longitudinal_speed_m_s", "when": "at_separation"}
    short = symmetric_design(
        requirements=[{**speed, "at_least": at_least}],
        dispersions={"sc.mass_kg": 20.0},
        run={"duration_s": end, "accuracy": 1e-8},
    )
    study = drakesep.verify(short, searches=["vertices", "sqp"], growth=False)
    assert study.searches.set_index("search")["failed"]["vertices"] == 1
    assert not study.completed
    assert not study.passed
    assert study.verdict == verdict
    # Nor does its row say that all is well.
    assert study.requirements["verdict"].tolist() == [verdict or "not looked at"]
    assert "vertices: 1 of 2 runs within the tolerances failed" in study.failure


def test_what_is_not_confirmed_is_not_met_and_the_others_are():
    speed = {"quantity": "longitudinal_speed_m_s", "when": "at_separation"}
    case = symmetric_design(
        requirements=[{**speed, "at_least": 0.01, "at_most": 5.0}],
        dispersions={"sc.mass_kg": 20.0},
    )
    study = drakesep.verify(case, searches=["vertices"], growth=False)
    assert study.requirements["verdict"].tolist() == ["met", "met"]
    lowest, _ = (objective.name for objective in study.objectives)
    assert lowest.startswith("lowest")
    runs = [
        dataclasses.replace(one, outcome=failed("Drake gives another value"))
        if one.objective == lowest
        else one
        for one in study.runs
    ]
    doubtful = dataclasses.replace(study, runs=tuple(runs))
    assert doubtful.verdict is None
    told = doubtful.requirements.set_index("sense")["verdict"]
    assert told.to_dict() == {">=": "not looked at", "<=": "met"}
