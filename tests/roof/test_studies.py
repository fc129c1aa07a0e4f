"""Studies from Python: progress, interruption, results on disk."""

import pandas as pd
import pytest

import drakesep
from drakesep.systems.joints import Joint
from drakesep.systems.run import RunStatus


def test_progress_tells_every_iterate(tmp_path):
    seen = []
    study = drakesep.worst_case(
        "vega", ["PM"], workers=1, output=tmp_path, on_progress=seen.append
    )
    assert [p.iteration for p in seen] == study.iterations["PM"]
    assert {p.objective for p in seen} == {"PM"}
    assert (seen[0].searches, seen[0].done) == (1, 0)


def test_interrupted_study_leaves_what_was_done(tmp_path):
    """Ctrl-C in the second search: the first is whole, the second's iterates too."""

    def interrupt(progress):
        if progress.done == 1 and progress.iteration.number == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        drakesep.worst_case(
            "vega", ["PM", "L2"], output=tmp_path, on_progress=interrupt
        )
    worst = pd.read_csv(tmp_path / "worst_cases.csv")
    assert worst["label"].iloc[-1] == "worst_PM"
    history = pd.read_csv(tmp_path / "history.csv")
    assert (history["objective"] == "L2").sum() == 2


def test_same_answer_whatever_the_number_of_workers():
    tables = [drakesep.worst_case("vega", ["PM"], workers=n).table for n in (1, 2)]
    pd.testing.assert_frame_equal(*tables, check_exact=True)


def test_case_without_requirements_or_dispersions():
    case = drakesep.load_case("vega")
    with pytest.raises(
        ValueError, match="requirements: a case to verify must have some"
    ):
        drakesep.verify(case.model_copy(update={"requirements": []}))
    with pytest.raises(ValueError, match="dispersions: a worst case needs some"):
        drakesep.worst_case(
            case.model_copy(update={"dispersions": {}, "published": []})
        )


def test_verify_without_dispersions_judges_the_nominal(tmp_path):
    case = drakesep.load_case("vega")
    update = {"dispersions": {}, "published": []}
    study = drakesep.verify(case.model_copy(update=update), output=tmp_path, workers=1)
    assert study.passed
    assert study.table["label"].tolist() == ["nominal"]
    assert (study.requirements["which_run"] == "nominal").all()


def test_verdict_of_an_earlier_study_does_not_outlive_it(tmp_path):
    (tmp_path / "requirements.csv").write_text("met")
    drakesep.worst_case("vega", "PM", output=tmp_path, workers=1)
    assert not (tmp_path / "requirements.csv").exists()


def test_nothing_turns_nominally():
    """Objectives of zero at the nominal: no division, and the search still ends."""
    data = drakesep.load_case("vega").model_dump()
    data["orbit"] = None
    data["before_separation"]["rate_deg_s"] = (0.0, 0.0, 0.0)
    data["bodies"]["payload"]["cg_mm"] = (1933.0, 0.0, 0.0)
    data["dispersions"] = {"payload.cg_y_mm": 13.0}
    data["published"] = []
    study = drakesep.worst_case(drakesep.Case.model_validate(data), ["L1", "L2"])
    assert study.completed
    assert study.comparison["above_nominal_percent"].isna().all()
    assert (study.comparison["worst"] > 0.1).all()
    cg = study.table.set_index("label").loc[["worst_L1", "worst_L2"], "payload.cg_y_mm"]
    assert cg.abs().tolist() == pytest.approx([13.0, 13.0])


def test_failed_run_is_a_row_with_its_reason(tmp_path):
    """Joints that no step can follow, while they hold."""
    case = drakesep.load_case("vega")
    stiff = {
        "stiffness_N_m": 1e30,
        "damping_N_s_m": 0.0,
        "angular_stiffness_N_m_rad": 1e30,
        "angular_damping_N_m_s_rad": 0.0,
    }
    data = case.model_dump()
    for attachment in data["attachments"].values():
        attachment["joint"] = stiff
        attachment["release_time_s"] = 1.0
    failed = drakesep.simulate(drakesep.Case.model_validate(data))
    assert failed.flight.run.status is RunStatus.FAILED
    assert failed.flight.run.separation.attachments[0].joint == Joint(
        K_F=1e30, D_F=0.0, K_T=1e30, D_T=0.0
    )
    failed.save(tmp_path)
    [row] = pd.read_csv(tmp_path / "summary.csv").to_dict("records")
    assert row["status"].startswith("failed: ")
    assert row["payload.mass_kg"] == 1860.0
    assert not (tmp_path / "motion.csv").exists()
