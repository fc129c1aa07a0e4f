"""A campaign beside worst cases: the same draws as alone, and which of both decides.

Limits lie between the bound of the draws and the worst case, which are known apart from
each other: by a campaign alone, and by a study of worst cases alone.
"""

import dataclasses

import numpy as np
import pandas as pd
import pytest
from batches import compiled_once
from left_behind import whole
from small_case import small_case, write_case

import drakesep
from drakesep.results.campaign_files import DRAWS
from drakesep.studies.campaign import confirmation, flight
from drakesep.studies.worst_case.session import Session


RUNS = 300
HARD = {"samples": 40, "starts": 2, "growth": False, "workers": 1}
SHARE = {"share": 0.99, "confidence": 0.9}


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    data = small_case(published=None, objectives=None, failure_cases=None)
    data["requirements"] = data["requirements"][:2]
    return write_case(tmp_path_factory.mktemp("case"), data)


@pytest.fixture(scope="module", autouse=True)
def quick():
    """Batches are compiled once, few are confirmed, nothing is drawn."""
    with pytest.MonkeyPatch.context() as patch:
        compiled_once(patch, "drakesep.analysis.campaigns.flights")
        patch.setattr(confirmation, "SAMPLE", 2)
        patch.setattr(Session, "draw", lambda *_: None)
        patch.setattr("drakesep.plots.campaign.save_campaign", lambda *_: None)
        yield


@pytest.fixture(scope="module")
def both(case, tmp_path_factory):
    folder = tmp_path_factory.mktemp("both")
    study = drakesep.verify(case, campaign=RUNS, output=folder, **SHARE, **HARD)
    return study, folder


@pytest.fixture(scope="module")
def alone(case, tmp_path_factory):
    """The campaign by itself, and the worst cases by themselves."""
    folder = tmp_path_factory.mktemp("alone")
    campaign = drakesep.campaign(case, RUNS, output=folder, **SHARE)
    return campaign, drakesep.verify(case, **HARD), folder


def test_both_say_what_they_say_alone(both, alone):
    study, folder = both
    campaign, worst, other = alone
    assert (folder / DRAWS).read_bytes() == (other / DRAWS).read_bytes()
    assert (folder / "plan.json").read_bytes() == (other / "plan.json").read_bytes()
    answers = pd.read_csv(folder / "answers.csv", keep_default_na=False)
    table, found = campaign.requirements, worst.requirements
    for mine, theirs in (
        *(("bound", "bound"), ("worst_of_draws", "worst"), ("allowed", "allowed")),
        *(("failures", "failures"), ("by_campaign", "verdict")),
    ):
        assert answers[mine].tolist() == table[theirs].tolist()
    np.testing.assert_array_equal(answers["worst_case_found"], found["worst"])
    assert answers["by_worst_case"].tolist() == found["verdict"].tolist()
    assert set(answers["decided_by"]) == {"campaign"}
    assert study.verdict == "met"
    assert study.requirements["verdict"].tolist() == ["met"] * 4


def test_how_far_the_worst_case_lies_beyond_the_bound(both):
    """A speed is too low, a rate too high: to either side worse is more than zero."""
    study, folder = both
    answers = study.answers
    sign = np.where(answers["sense"] == "<=", 1.0, -1.0)
    beyond = sign * (answers["worst_case_found"] - answers["bound"])
    assert answers["worst_case_beyond_bound"].to_numpy() == pytest.approx(beyond)
    assert (beyond > 0.0).all()
    table = pd.read_csv(folder / "campaign.csv")
    assert table["worst_case_found"].tolist() == answers["worst_case_found"].tolist()


def limited(case, alone, *, share):
    """The speed's limit half-way from the bound of the draws to the worst case."""
    campaign, worst, _ = alone
    loaded = drakesep.load_case(case).in_si()
    [speed, *rates] = loaded.requirements
    limit = 0.5 * (campaign.findings[0].bound + worst.findings[0].worst)
    shares = SHARE if share else {}
    required = dataclasses.replace(speed, limit=limit, **shares)
    return dataclasses.replace(loaded, requirements=(required, *rates))


def test_a_share_is_decided_by_draws_and_what_every_run_must_by_the_worst_case(
    case, alone
):
    verdicts = {}
    for share in (True, False):
        study = drakesep.verify(
            limited(case, alone, share=share), campaign=RUNS, **HARD
        )
        first = study.answers.iloc[0]
        assert first["by_worst_case"] == "not met"
        assert first["by_campaign"] == ("met" if share else "not looked at")
        assert first["decided_by"] == ("campaign" if share else "worst case")
        assert set(study.answers["decided_by"][1:]) == {"worst case"}
        assert study.answers["verdict"][1:].tolist() == ["met"] * 3
        verdicts[share] = study.verdict
    assert verdicts == {True: "met", False: "not met"}


def test_a_worse_draw_within_the_tolerances_was_missed(case):
    """By a search that looks at one sample: no verdict is made of it."""
    one = {**HARD, "samples": 1, "searches": ["samples"]}
    study = drakesep.verify(case, campaign=RUNS, **one)
    missed = study.answers["missed_draw"]
    assert missed.notna().any()
    required, draw = next(iter(study.missed.items()))
    column = study.campaign.plan.metrics.index(required.judged_by)
    value = study.campaign.flown.metrics[draw, column]
    [finding] = [f for f in study.findings if f.requirement == required]
    assert required.margin(value) < finding.margin
    assert finding.verdict.value == "not looked at"
    assert study.verdict is None
    assert "the searches have missed it" in study.failure


def test_interrupted_among_its_chunks_it_goes_on(case, both, tmp_path, monkeypatch):
    """Neither a search nor a chunk goes twice; it ends the same."""
    how = {"campaign": RUNS, "output": tmp_path, **SHARE, **HARD}
    keep, chunks = Session.keep_search, flight.write_chunk

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(flight, "write_chunk", interrupted)
    with pytest.raises(KeyboardInterrupt):
        drakesep.verify(case, **how)
    searched = []
    monkeypatch.setattr(flight, "write_chunk", chunks)
    monkeypatch.setattr(
        Session, "keep_search", lambda *of: (searched.append(of), keep(*of))
    )
    drakesep.verify(case, resume=True, **how)
    assert not searched
    but = ("again",)
    assert whole(tmp_path, but=but) == whole(both[1], but=but)


def test_what_is_refused(case, tmp_path):
    with pytest.raises(ValueError, match=r"^share: must stand with a campaign"):
        drakesep.verify(case, share=0.99)
    with pytest.raises(ValueError, match=r"^confidence: must stand with a campaign"):
        drakesep.verify(case, confidence=0.9)
    with pytest.raises(ValueError, match=r"^runs: must be 230 or more to show"):
        drakesep.verify(case, campaign=229, **SHARE)
    rigid = write_case(
        tmp_path, small_case(dispersions=None, published=None, objectives=None)
    )
    with pytest.raises(ValueError, match=r"^dispersions: a campaign beside worst"):
        drakesep.verify(rigid, campaign=RUNS)
