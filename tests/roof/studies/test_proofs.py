"""Proven bounds of the small case, against runs in Drake and against limits.

Whether the prover is right is tested where it is; here, what is made of its bounds.
"""

import dataclasses
import itertools
import json
import math

import numpy as np
import pandas as pd
import pytest
from command_line import run
from small_case import small_case, write_case

import drakesep
from drakesep.analysis.bounds import answers, certificate
from drakesep.analysis.bounds.answers import questions_of
from drakesep.analysis.bounds.branch_and_bound import Prover
from drakesep.analysis.metrics.functions import FunctionRequirement
from drakesep.analysis.metrics.of_run import metric_of_run
from drakesep.analysis.metrics.requirements import NO_LIMITS
from drakesep.case_file.case import Case
from drakesep.studies.kept_proofs import KeptProofs
from drakesep.studies.proofs import LongCertificate
from drakesep.systems.checks import InputError
from drakesep.systems.simulation.simulation import Simulation


DEG = math.degrees(1.0)
DRAKE = {"searches": ["drake"], "workers": 1, "growth": False}
SPEED, RATE = "longitudinal_speed_after_separation", "rate_after_separation_y"
ONE = {"upper.mass_kg": 20.0}
CLEARANCE = {"quantity": "clearance_mm", "at_least": 1.0}


def small(**sections):
    """Two requirements that are soon proven, over two parameters."""
    varying = {"upper.mass_kg": 20.0, "upper.cg_y_mm": 4.0}
    given = {"published": None, "objectives": None, "dispersions": varying}
    speed, rate = small_case()["requirements"][:2]
    rate = {**rate, "at_most": [None, rate["at_most"][1], None], "id": "R-2"}
    return small_case(**{**given, "requirements": [speed, rate], **sections})


def case(**sections):
    return Case.model_validate(small(**sections)).in_si()


@pytest.fixture(scope="module")
def proven(tmp_path_factory):
    """Of requirements, and of an objective."""
    folder = tmp_path_factory.mktemp("proven")
    study = drakesep.prove(case(), ["PM"], output=folder)
    return study, folder


@pytest.fixture(scope="module")
def beside(tmp_path_factory):
    """Beside worst cases, with what no bound covers."""
    folder = tmp_path_factory.mktemp("beside")
    required = [*small()["requirements"], CLEARANCE]
    study = drakesep.verify(
        case(requirements=required, dispersions=ONE), prove=True, output=folder, **DRAKE
    )
    return study, folder


def test_no_corner_in_drake_is_beyond_a_bound(proven):
    """Nor far from it: the corners of two parameters have the worst of both."""
    study, folder = proven
    table = pd.read_csv(folder / "proofs.csv").set_index("claim")
    record = study.case
    simulation = Simulation(record.separation, record.integration)
    signs = itertools.product((-1.0, 1.0), repeat=2)
    runs = [simulation.run(record.box.values(np.array(u))) for u in signs]
    speeds = [metric_of_run(run, SPEED, NO_LIMITS) for run in runs]
    rates = [DEG * metric_of_run(run, RATE, NO_LIMITS) for run in runs]
    lowest = table.loc[f"lowest_{SPEED}"]
    # Drake's own error is 1e-6 of these; 0.5 % is the gap that is asked for.
    assert 0.99 * min(speeds) < lowest["proven_bound"] < min(speeds)
    highest = table.loc[f"highest_{RATE}"]
    assert max(rates) < highest["proven_bound"] < 1.01 * max(rates)
    assert lowest["found"] == pytest.approx(min(speeds), rel=1e-2)
    assert table.loc["highest_G_PM", "objective"] == "PM"


def test_options_are_the_arguments_in_python(tmp_path, capsys, monkeypatch):
    data = small(dispersions=ONE)
    words = ["--objective", "PM", "--gap-percent", 2.0, "--proof-seconds", 60]
    file = write_case(tmp_path, data)
    code, _, err = run(capsys, monkeypatch, "prove", file, "-o", tmp_path / "t", *words)
    assert code == 0, err
    assert "Proof of 3 bounds over a parameter" in err
    assert "at most 3 min" in err
    how = {"gap_percent": 2.0, "proof_seconds": 60.0}
    study = drakesep.prove(file, ["PM"], output=tmp_path / "p", **how)
    typed, called = (tmp_path / name / "proofs.csv" for name in ("t", "p"))
    assert typed.read_bytes() == called.read_bytes()
    # A larger gap is a wider bound, and enough of one.
    assert (study.table["gap_percent"] > 0.6).all()
    assert (study.table["gap_percent"] < 2.001).all()


def test_columns_computed_anew(proven):
    study, folder = proven
    table = without_gaps(folder / "proofs.csv")
    for row in table.to_dict("records"):
        above = row["sense"] == "<="
        beyond = row["proven_bound"] - row["found"]
        gap = 100.0 * (beyond if above else -beyond) / abs(row["found"])
        assert 0.0 < row["gap_percent"] == pytest.approx(gap, rel=1e-6)
        # A thousandth for the room that claims keep for another arithmetic.
        assert row["gap_percent"] < 0.501
        assert (row["found_by"], row["reason"]) == ("enclosure", "")
    assert table["verdict"].tolist() == ["proven met", "proven met", "bounded"]
    assert table["limit"].tolist()[:2] == [0.49, 1.72]
    assert table["unit"].tolist() == ["m/s", "deg/s", "m/s"]
    assert table["id"].tolist() == ["", "R-2", ""]
    assert (study.verdict, study.failure) == ("proven met", "")
    record = drakesep.read_results(folder).record
    assert (record.ended.value, record.verdict) == ("completed", "proven met")


def test_the_certificate_has_every_claim(proven):
    study, folder = proven
    record = json.loads((folder / "proof.json").read_text())
    bounds = {one["name"]: float.fromhex(one["bound"]) for one in record["claims"]}
    table = study.table.set_index("claim")
    assert set(bounds) == set(table.index)
    for name, bound in bounds.items():
        told = study.bounds.proven[name].claim.value(bound)
        row = table.loc[name]
        in_si = told * (DEG if row["unit"] == "deg/s" else 1.0)
        assert row["proven_bound"] == pytest.approx(in_si, rel=1e-14)


def test_beside_worst_cases_the_worst_run_is_what_was_found(beside):
    study, folder = beside
    table = without_gaps(folder / "proofs.csv")
    required = without_gaps(folder / "requirements.csv")
    runs = study.table.set_index("label")
    for proof, row in zip(
        table.to_dict("records"), required.to_dict("records"), strict=True
    ):
        assert row["proven"] == proof["verdict"]
        for column in ("proven_bound", "gap_percent"):
            assert row[column] == pytest.approx(proof[column], rel=0, nan_ok=True)
        if row["proven"] == "proven met":
            assert proof["found"] == row["worst"]
            column = SPEED + "_m_s" if row["axis"] == "" else RATE + "_deg_s"
            assert runs.loc[proof["found_by"], column] == row["worst"]
    assert table["verdict"].tolist() == ["proven met", "proven met", "not covered"]
    assert study.verdict == "met"


def test_what_is_not_covered_is_named_and_has_no_number(beside):
    _, folder = beside
    table = pd.read_csv(folder / "proofs.csv").iloc[-1]
    assert table["requirement"] == "clearance"
    assert table[["proven_bound", "gap_percent", "boxes"]].isna().all()
    assert table["reason"] == "clearance: bounds do not cover clearance"
    names = {
        one["name"] for one in json.loads((folder / "proof.json").read_text())["claims"]
    }
    assert names == {f"lowest_{SPEED}", f"highest_{RATE}"}


def test_a_limit_that_is_attained_is_not_proven(proven):
    study, _ = proven
    found = study.answers[1].found
    required = dataclasses.replace(study.case.requirements[1], limit=0.99 * found)
    other = dataclasses.replace(study.case, requirements=(required,))
    [answer] = drakesep.prove(other).answers
    assert (answer.verdict, answer.value > required.limit) == ("not proven", True)
    assert answer.reason == "beyond the limit in a point of the box"


def test_without_time_there_is_a_bound_of_the_whole_box(proven):
    study, _ = proven
    [first, *_] = drakesep.prove(case(), proof_seconds=1e-6).answers
    known = study.answers[0]
    assert first.value <= known.value
    finished = first.bound.proof.finished
    assert finished or first.reason.startswith("time was over")


def without_gaps(file):
    """A table whose texts are empty where nothing stands."""
    table = pd.read_csv(file)
    words = ("axis", "id", "reason", "found_by", "objective", "requirement")
    texts = [name for name in words if name in table]
    return table.astype(dict.fromkeys(texts, object)).fillna(dict.fromkeys(texts, ""))


def narrowed(monkeypatch):
    """A prover whose bounds are a hundredth too near."""
    prove = answers.prove_bounds

    def wrong(*arguments, **how):
        bounds = prove(*arguments, **how)
        proven = {
            name: dataclasses.replace(bound, value=0.98 * bound.value)
            if name.startswith("highest")
            else bound
            for name, bound in bounds.proven.items()
        }
        return dataclasses.replace(bounds, proven=proven)

    monkeypatch.setattr(answers, "prove_bounds", wrong)


@pytest.mark.parametrize("met", [True, False])
def test_a_run_beyond_a_bound_is_a_contradiction(met, tmp_path, capsys, monkeypatch):
    """Unless a run is beyond a limit as well, there is no verdict."""
    narrowed(monkeypatch)
    data = small(dispersions=ONE)
    data["requirements"][0]["at_least"] = 0.49 if met else 5.0
    words = ["verify", write_case(tmp_path, data), "-o", tmp_path / "out", "--prove"]
    words += ["--search", "drake", "--workers", "1", "--no-growth", "--json"]
    code, out, err = run(capsys, monkeypatch, *words)
    told = json.loads(out)
    assert code == told["exit_code"] == (4 if met else 1)
    assert told["verdict"] == (None if met else "not met")
    assert "is beyond the proven bound of highest_rate_after_separation_y" in err
    assert "one of the two is wrong" in told["error"]
    verdicts = [row["verdict"] for row in told["proofs"]]
    assert verdicts == ["proven met" if met else "not proven", "contradicted"]


def test_a_case_that_is_not_covered_says_so_in_a_line(tmp_path, capsys, monkeypatch):
    """By name; and `verify` ends as without."""
    data = small(dispersions=ONE)
    data["requirements"] = [{**data["requirements"][0], "at_least": 0.1}]
    spring = data["attachments"]["two"]["spring"]
    del spring["design_mass_kg"]
    spring["law"] = "displacement"
    file = write_case(tmp_path, data)
    why = "Nothing is proven of small: s2: bounds cover springs of Eq. 5 alone."
    code, out, _ = run(capsys, monkeypatch, "prove", file, "-o", tmp_path / "proof")
    assert (code, why in out.replace("\n", " ")) == (1, True)
    assert not (tmp_path / "proof" / "proof.json").exists()
    more = ["--prove", "--search", "drake", "--workers", "1", "--no-growth"]
    words = ["verify", file, "-o", tmp_path / "out", *more]
    code, out, _ = run(capsys, monkeypatch, *words)
    assert (code, why in out.replace("\n", " ")) == (0, True)


def test_functions_of_a_run_are_not_covered():
    mine = FunctionRequirement(
        name="mine", function=lambda run: 0.0, unit="m", at_most=1.0
    )
    [*_, last] = questions_of(case(), [*mine.objectives], [mine])
    assert last.refused == "mine: bounds do not cover functions"


def test_progress_says_how_long_before_it_begins():
    told = []
    drakesep.prove(case(), proof_seconds=30, on_progress=told.append)
    first = "proof of 2 bounds over 2 parameters, all corners and everything between: "
    assert str(told[0]) == f"{first}at most 60 s"
    assert (told[0].claim, told[0].done, told[0].total) == ("", 0, 2)
    assert [*dict.fromkeys(one.claim for one in told[1:])] == [
        f"lowest_{SPEED}",
        f"highest_{RATE}",
    ]


@pytest.fixture
def proven_anew(monkeypatch):
    """The numbers of claims that were proven, not taken from where they are kept."""
    count, prove = [], Prover.prove

    def counted(*arguments):
        count.append(1)
        return prove(*arguments)

    monkeypatch.setattr(Prover, "prove", counted)
    return count


def end_at(claim):
    """Progress that ends a study as it comes to a claim."""

    def told(progress):
        if progress.claim == claim:
            raise KeyboardInterrupt

    return told


def test_what_is_proven_is_kept_and_not_proven_again(
    proven, tmp_path, capsys, monkeypatch, proven_anew
):
    """Interrupted in the second of three bounds, it ends as it would have."""
    _, once = proven

    def prove(**how):
        return drakesep.prove(case(), ["PM"], output=tmp_path, **how)

    with pytest.raises(KeyboardInterrupt):
        prove(on_progress=end_at(f"highest_{RATE}"))
    assert len(proven_anew) == 2
    assert not (tmp_path / "proofs.csv").exists()
    with pytest.raises(InputError, match=r"proof_seconds = 60.0, got 5.0"):
        prove(resume=True, proof_seconds=5.0)
    told = []
    prove(resume=True, on_progress=told.append)
    assert len(proven_anew) == 4
    assert "proof of 3 bounds" in str(told[0]) and "at most 2 min" in str(told[0])
    for name in ("proofs.csv", "proof.json"):
        assert (tmp_path / name).read_bytes() == (once / name).read_bytes()
    assert not (tmp_path / ".parts").exists()
    words = [write_case(tmp_path, small()), "--objective", "PM", "-o", tmp_path]
    code, _, err = run(capsys, monkeypatch, "prove", *words, "--resume")
    assert (code, err.rstrip().endswith("completed")) == (2, True), err


def test_beside_worst_cases_too(beside, tmp_path, monkeypatch, proven_anew):
    _, once = beside
    required = [*small()["requirements"], CLEARANCE]
    file = write_case(tmp_path, small(requirements=required, dispersions=ONE))

    def verify(**how):
        folder = tmp_path / "out"
        return drakesep.verify(file, prove=True, output=folder, **DRAKE, **how)

    keep = KeptProofs.keep

    def keep_and_end(mine, claim, proof):
        keep(mine, claim, proof)
        raise KeyboardInterrupt

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(KeptProofs, "keep", keep_and_end)
        verify()
    verify(resume=True)
    assert len(proven_anew) == 2
    for name in ("proofs.csv", "proof.json", "requirements.csv"):
        assert (tmp_path / "out" / name).read_bytes() == (once / name).read_bytes()


@pytest.mark.parametrize("fit", [1, 0])
def test_a_certificate_that_is_too_long_loses_no_bound(
    fit, proven, tmp_path, monkeypatch
):
    """Proofs that do not fit are named; their bounds stand in the table."""
    study, once = proven
    record = json.loads((once / "proof.json").read_text())
    shortest, *others = sorted(
        record["claims"], key=lambda claim: len(json.dumps(claim))
    )
    record["claims"] = [shortest]
    length = len(json.dumps(record, separators=(",", ":"))) + 1
    # A comma's place is left for each claim.
    monkeypatch.setattr(certificate, "MOST", length + 2 if fit else 100)
    names = {claim["name"] for claim in others} | (set() if fit else {shortest["name"]})
    with pytest.warns(LongCertificate, match=r"larger than .* MB") as told:
        study.save(tmp_path)
    assert all(name in str(told[0].message) for name in names)
    assert pd.read_csv(tmp_path / "proofs.csv")["proven_bound"].notna().all()
    file = tmp_path / "proof.json"
    assert file.exists() == bool(fit)
    if fit:
        assert [c["name"] for c in json.loads(file.read_text())["claims"]] == [
            shortest["name"]
        ]
        assert file.stat().st_size <= certificate.MOST


def test_what_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"^output: .* study to resume, got None"):
        drakesep.prove(case(), resume=True)
    with pytest.raises(InputError, match=r"^gap_percent must be > 0"):
        drakesep.prove(case(), gap_percent=0.0, output=tmp_path)
    with pytest.raises(InputError, match=r"^proof_seconds must be > 0"):
        drakesep.verify(case(), prove=True, proof_seconds=0.0, output=tmp_path)
    with pytest.raises(InputError, match=r"^proof_seconds: must stand with prove"):
        drakesep.verify(case(), proof_seconds=5.0, output=tmp_path)
    with pytest.raises(InputError, match=r"^dispersions: a bound needs some"):
        drakesep.prove(case(dispersions={}), output=tmp_path)
    with pytest.raises(InputError, match=r"^objectives: small has no requirement"):
        drakesep.prove(case(requirements=[]), output=tmp_path)
    assert not [*tmp_path.iterdir()]
