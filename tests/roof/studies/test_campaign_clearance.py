"""Clearances in campaigns: a box that drifts out of a slot, by the closed form.

Driven sideways once nothing pushes it any more, it leaves straight: nothing turns.
"""

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from batches import compiled_once
from rich.console import Console
from scipy.optimize import minimize_scalar
from trade import JOINT

import drakesep
from drakesep.analysis.campaigns.flights import CampaignFlights
from drakesep.analysis.campaigns.measuring import SURE
from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.analysis.campaigns.shares import share_findings
from drakesep.case_file.case import Case
from drakesep.cli.campaign_lines import print_campaign
from drakesep.plots.campaign_draws import curves_of
from drakesep.results.campaign_files import DRAWS, measured_file
from drakesep.studies.campaign import confirmation, measuring, procedure
from drakesep.studies.campaign.executors import own_processes


ENERGY, STROKE, FORCE = 60.0, 0.08, 1500.0
LV, SC = 2000.0, 500.0
SPEED = math.sqrt(2.0 * ENERGY * (1.0 / SC + 1.0 / LV))
"""m/s, of the spacecraft as seen from the launch vehicle."""
PUSHED = 0.5 * math.pi * STROKE / SPEED
"""When nothing pushes it any more, s."""
SIDE, BEGINS, SHARE = 60.0, 0.25, 0.6
"""Force of the thruster that drives it sideways, N, from when, s, and what is not known
of it."""
GAP, DEPTH = 0.015, 0.3
"""m, to either side of the box, and that its end is in the slot."""
UNTIL = 0.5
RUNS, HOW = 200, {"seed": 2, "chunk": 100}
LEVEL = {"share": 0.7, "confidence": 0.9}


def slot(requirements, **changes) -> Case:
    """The case: B's box in the slot between two boxes of A."""

    def body(mass, x, **parts):
        return {
            "mass_kg": mass,
            "cg_mm": [x, 0.0, 0.0],
            "inertia_kg_m2": dict.fromkeys(("xx", "yy", "zz"), 0.4 * mass),
            "geometry": {
                name: {"box": {"size_mm": size}, "position_mm": position}
                for name, (size, position) in parts.items()
            },
        }

    length, y = 1e3 * (DEPTH + 0.05), 100.0 + 1e3 * GAP + 10.0
    wall = [length, 20.0, 400.0]
    walls = {
        name: (wall, [0.5 * length, side * y, 0.0])
        for name, side in (("left", 1), ("right", -1))
    }
    spring = {"law": "displacement", "force_max_N": FORCE, "stroke_mm": 1e3 * STROKE}
    pad = {"A": "lv", "B": "sc", "position_mm": [0, 0, 0], "joint": JOINT}
    data = {
        "name": "slot",
        "pair": {"A": "lv", "B": "sc"},
        "bodies": {
            "lv": body(LV, -600.0, **walls),
            "sc": body(SC, 250.0, box=([400.0, 200.0, 200.0], [250.0, 0.0, 0.0])),
        },
        "attachments": {
            "pad": {**pad, "spring": {"name": "push", **spring}, "release_time_s": 0.0}
        },
        "loads": {
            "side": {
                "body": "sc",
                "position_mm": [250, 0, 0],
                "direction": [0, 1, 0],
                "times_s": [BEGINS, 2.0],
                "thrusts_N": [SIDE, SIDE],
            }
        },
        "dispersions": {"side.factor": SHARE},
        "requirements": requirements,
        "run": {"duration_s": 1.3, "accuracy": 1e-8},
    }
    return Case.model_validate(data | changes)


def clearance(factor: float) -> float:
    """How near the box comes to the wall until it has moved so far, m."""

    def apart(t):
        aside = 0.5 * factor * SIDE / SC * max(t - BEGINS, 0.0) ** 2
        beyond = STROKE + SPEED * (t - PUSHED) - DEPTH
        return math.hypot(max(beyond, 0.0), max(GAP - aside, 0.0))

    leaves = PUSHED + (DEPTH - STROKE) / SPEED
    end = PUSHED + (UNTIL - STROKE) / SPEED
    after = minimize_scalar(apart, bounds=(leaves, end), options={"xatol": 1e-9})
    return min(apart(leaves), apart(end), after.fun)


LIMIT = 0.003
REQUIRED = [
    {
        "quantity": "clearance_mm",
        "at_least": 1e3 * LIMIT,
        "until_separation_mm": 1e3 * UNTIL,
    }
]
NAME = f"clearance_until_{UNTIL}_m"
EXACT = 1.2e-4
"""m: a clearance is measured to 50 um; motions differ by less."""


@pytest.fixture(scope="module", autouse=True)
def quick():
    with pytest.MonkeyPatch.context() as patch:
        compiled_once(patch, "drakesep.analysis.campaigns.flights")
        patch.setattr(confirmation, "SAMPLE", 2)
        patch.setattr(confirmation, "MOST", 4)
        for module in (procedure, measuring):  # no workers are worth their start
            patch.setattr(module, "WORKERS_START", math.inf)
        patch.setattr("drakesep.plots.campaign.save_campaign", lambda *_: None)
        yield


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reference")
    case = slot(REQUIRED)
    return drakesep.campaign(case, RUNS, output=folder, **HOW, **LEVEL), folder


@pytest.fixture(scope="module")
def true(reference):
    """(N,) by the closed form, of what was drawn."""
    study, _ = reference
    return np.array([clearance(factor) for factor in study.draws["side.factor"]])


def test_what_is_measured_is_the_closed_form_and_the_rest_is_no_nearer(reference, true):
    study, _ = reference
    found = study.flown.clearances
    measured, at_least = found.measured[:, 0], found.at_least[:, 0]
    assert 0 < measured.sum() < RUNS
    np.testing.assert_allclose(at_least[measured], true[measured], atol=EXACT)
    assert (at_least <= true + EXACT).all()
    assert (at_least[~measured] >= LIMIT).all()


def test_every_draw_beyond_the_limit_is_counted(reference, true):
    study, _ = reference
    [finding] = study.findings
    doubtful = np.abs(true - LIMIT) < EXACT
    beyond = int((true[~doubtful] < LIMIT).sum())
    assert 0 < beyond <= finding.beyond <= beyond + doubtful.sum()
    assert finding.verdict.value == "met"  # of 70 % of launches
    assert study.completed and finding.confirmed


def test_the_bound_is_that_of_the_closed_form(reference, true):
    study, _ = reference
    [finding] = study.findings
    assert finding.bound == pytest.approx(
        np.sort(true)[finding.size.rank - 1], abs=EXACT + SURE
    )
    assert finding.worst == pytest.approx(true.min(), abs=EXACT)
    assert abs(true[finding.answer.deciding_draw] - finding.bound) < EXACT


def test_what_is_broken_anyway_need_not_be_counted_to_the_last(true, monkeypatch):
    """Those beyond are at least those that are measured; the others may be."""
    monkeypatch.setattr("drakesep.analysis.campaigns.measuring.ENOUGH", 10)
    strict = drakesep.campaign(slot(REQUIRED), RUNS, **HOW, share=0.98, confidence=0.9)
    [finding] = strict.findings
    assert finding.verdict.value == "not met"
    beyond = int((true < LIMIT - EXACT).sum())
    tally = finding.answer.tally
    assert 0 < tally.beyond < beyond <= tally.beyond + tally.doubtful
    assert f"{tally.doubtful} of which may not be" in finding.answer.why
    assert finding.answer.share_at_most >= 1.0 - tally.beyond / RUNS
    bound = np.sort(true)[finding.size.rank - 1]
    assert finding.bound == pytest.approx(bound, abs=EXACT + SURE)


def test_its_curve_shows_what_is_measured(reference, true):
    """The share of draws that come as near, from where all of them are measured."""
    study, _ = reference
    [curve] = curves_of(study.findings, study.plan, study.flown, study.found)
    assert curve.shares[-1] == 1 / RUNS
    assert curve.values[-1] == pytest.approx(true.min(), abs=EXACT)
    assert len(curve.values) >= study.findings[0].size.rank
    for near, told in zip(curve.values, curve.shares, strict=True):
        low, high = (np.mean(true <= near + off) for off in (-EXACT, EXACT))
        assert low <= told <= high
    console = Console(record=True, width=200)
    print_campaign(console, study)
    measured = study.findings[0].measured
    assert f"{NAME}: measured in {measured} draws; the others" in console.export_text()


def tables(folder):
    names = (DRAWS, "campaign.csv", "campaign_worst.csv", "campaign_runs.csv.gz")
    return {name: (folder / name).read_bytes() for name in names}


def test_in_any_order_and_some_twice_chunks_make_the_same(reference, tmp_path):
    case = slot(REQUIRED)
    recorded = drakesep.plan_campaign(case, RUNS, output=tmp_path, **HOW, **LEVEL)
    assert recorded.plan.chunks == 2
    for number in (1, 0, 1):
        drakesep.run_chunk(tmp_path, number, again=True)
    drakesep.merge_campaign(tmp_path)
    assert tables(tmp_path) == tables(reference[1])


@pytest.mark.slow
@pytest.mark.parametrize("pool", [ThreadPoolExecutor, own_processes])
def test_workers_measure_the_same(pool, reference, tmp_path):
    with pool(2) as executor:
        how = {**HOW, **LEVEL, "executor": executor, "output": tmp_path}
        drakesep.campaign(slot(REQUIRED), RUNS, **how)
    assert tables(tmp_path) == tables(reference[1])


@pytest.mark.slow
def test_interrupted_it_goes_on_from_what_is_measured(reference, tmp_path, monkeypatch):
    wrote = []

    def write(*arguments):
        if wrote:
            raise KeyboardInterrupt
        wrote.append(arguments)
        write_measured(*arguments)

    write_measured = measuring.write_measured
    with monkeypatch.context() as patch:
        patch.setattr(measuring, "write_measured", write)
        with pytest.raises(KeyboardInterrupt):
            drakesep.campaign(slot(REQUIRED), RUNS, output=tmp_path, **HOW, **LEVEL)
    assert measured_file(tmp_path, 0, 0).exists()
    asked, measure = [], CampaignFlights.measured

    def noted(self, name, draws):
        asked.append(set(draws))
        return measure(self, name, draws)

    monkeypatch.setattr(CampaignFlights, "measured", noted)
    how = {**HOW, **LEVEL, "output": tmp_path, "resume": True}
    drakesep.campaign(slot(REQUIRED), RUNS, **how)
    first = {*wrote[0][2]}
    assert not any(first & draws for draws in asked if draws != {0})
    assert tables(tmp_path) == tables(reference[1])


def test_replayed_a_draw_tells_its_clearance(reference, true, tmp_path, monkeypatch):
    _, folder = reference
    monkeypatch.setattr("drakesep.plots.motion.save_motion", lambda *_: None)
    worst = int(true.argmin())
    result = drakesep.replay(folder, worst, output=tmp_path)
    [row] = result.summary.to_dict("records")
    assert row[f"{NAME}_mm"] == pytest.approx(1e3 * true[worst], abs=1e3 * EXACT)
    assert row["nearest"] == "left to box"
    assert result.requirements["verdict"].tolist() == ["not met"]


def test_nothing_is_met_that_could_not_be_measured(monkeypatch, true):
    """Where no plane tells anything, and few may be measured."""
    monkeypatch.setattr(
        "drakesep.analysis.campaigns.screens.ClearanceScreen.lower_bounds",
        lambda self, places: np.full(len(places.q_AB), -math.inf),
    )
    monkeypatch.setattr("drakesep.analysis.campaigns.measuring.MOST", 40)
    monkeypatch.setattr("drakesep.studies.campaign.measuring.MOST", 40)
    study = drakesep.campaign(slot(REQUIRED), RUNS, **HOW, **LEVEL)
    [finding] = study.findings
    assert finding.measured == 40
    assert finding.answer.tally.untold == RUNS - 40
    assert finding.verdict.value == "not shown"
    assert math.isnan(finding.bound)


def test_a_screen_that_proves_too_much_is_found_out_in_drake(monkeypatch):
    """By the draws at random that are flown there."""
    monkeypatch.setattr(
        "drakesep.analysis.campaigns.screens.ClearanceScreen.lower_bounds",
        lambda self, places: np.full(len(places.q_AB), 0.05),
    )
    study = drakesep.campaign(slot(REQUIRED), RUNS, **HOW, **LEVEL)
    assert "where the batch engine proves 0.05" in study.failure
    assert study.verdict == "not looked at"


def test_a_window_that_does_not_end_is_not_met(true):
    """In neither engine: Drake confirms that."""
    far = [{**REQUIRED[0], "until_separation_mm": 2000}]
    study = drakesep.campaign(slot(far), 30, seed=2, share=0.9, confidence=0.9)
    [finding] = study.findings
    assert finding.verdict.value == "not looked at"
    assert finding.measured == 30
    assert (study.completed, study.failure) == (True, "")


def test_a_window_that_ends_on_the_batch_engine_alone_is_found_out():
    """It cannot be proven clear that a run in Drake does not tell."""
    assert confirmation._of_bound(0.05, math.nan, 1e-4).failed
    assert not confirmation._of_bound(-math.inf, math.nan, 1e-4).failed


def test_what_never_lets_go_has_no_clearance():
    """Though it is asked for the first of all, before any is flown."""
    failing = {"failure_cases": {"stuck": {"pad.release_time_s": "never"}}}
    case = slot(REQUIRED, **failing, failures={"stuck": 0.3}).in_si()
    flights = CampaignFlights(CampaignPlan.of(case, RUNS, seed=2))
    stuck = flights.drawn(range(20)).failure >= 0
    assert 0 < stuck.sum() < 20
    told = flights.measured(NAME, dict.fromkeys(range(20), -math.inf))
    np.testing.assert_array_equal(np.isnan(told), stuck)


def test_what_every_run_must_keep_is_broken_by_one(reference):
    study = drakesep.campaign(slot(REQUIRED), RUNS, **HOW)
    [finding] = study.findings
    assert finding.verdict.value == "not met"
    assert finding.worst == reference[0].findings[0].worst


def test_parts_that_touch_while_mated_are_not_looked_at():
    pair = ["left", "box"]
    named = [{"quantity": "no_contact", "parts": [pair]}]
    case = slot(named, clearance={"touching": [pair]}).in_si()
    plan = CampaignPlan.of(case, RUNS)
    assert plan.clearances == ()
    [finding] = share_findings(plan, np.empty((RUNS, 0)), [])
    assert finding.verdict.value == "not looked at"


def test_a_failure_that_makes_them_touch_is_beyond():
    """The thruster that pushes twice as much: it touches the wall in the slot."""
    assert clearance(2.0) == 0.0
    required = [{**REQUIRED[0], "quantity": "no_contact"}]
    del required[0]["at_least"]
    failing = {"failure_cases": {"twice": {"side.factor": 2.0}}}
    case = slot(required, **failing, failures={"twice": 0.2})
    study = drakesep.campaign(case, RUNS, **HOW, share=0.5, confidence=0.9)
    [finding] = study.findings
    found, failed = study.flown.clearances, study.flown.failure == 0
    assert 20 < failed.sum() < 60  # 40, within four deviations
    assert finding.beyond == failed.sum()
    assert found.measured[failed, 0].all() and not found.at_least[failed, 0].any()
    assert (found.at_least[~failed] > 0.0).all()
    assert finding.verdict.value == "met" and study.completed


@pytest.mark.slow
def test_beside_the_worst_case(reference):
    """The same bound as alone, and a worst case that no draw is nearer than."""
    how = {"searches": ["sqp"], "growth": False, "workers": 1}
    study = drakesep.verify(
        slot(REQUIRED), campaign=RUNS, seed=HOW["seed"], **LEVEL, **how
    )
    campaign, _ = reference
    row = study.answers.iloc[0]
    assert row["bound"] == campaign.requirements["bound"].iloc[0]
    assert row["worst_case_found"] <= row["worst_of_draws"] <= row["bound"]
    assert row["by_campaign"] == campaign.findings[0].verdict.value
    assert not study.missed
