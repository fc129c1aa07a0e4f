"""Every body that leaves: what is told of it does not depend on which comes first."""

import dataclasses
import math

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation
from three_bodies import TO_THIRD, TO_UPPER, three_bodies, with_pairs
from trade import symmetric_design

import drakesep
from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.analysis.metrics.registry import METRICS, find_metric
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.case_file.case import Case
from drakesep.systems.checks import InputError
from drakesep.systems.model.integration import Integration
from drakesep.systems.simulation.simulation import Simulation
from drakesep.tables.run_tables import read_runs


NONE = (math.inf,) * 3


@pytest.mark.slow
@pytest.mark.parametrize(
    ("first", "second"),
    [
        (TO_UPPER, TO_THIRD),
        pytest.param(TO_THIRD, TO_UPPER, marks=pytest.mark.slow),
    ],
)
def test_which_is_named_first_does_not_matter(first, second):
    """In both engines; momentum and acceleration too."""
    limits = (1.0, 0.75, 2.5)
    together, alone = with_pairs(first, second), with_pairs(second)
    integration = Integration(accuracy=1e-10)
    run = Simulation(together, integration).run()
    told = metrics_of_run(run, {second.B: limits})
    flown = Simulation(alone, integration).run()
    expected = metrics_of_run(flown, limits)
    assert len(told) == 2 * len(METRICS)
    first_of = dict.fromkeys(find_metric(n)[0].names[0] for n in METRICS)
    names = [f"{second.B}.{name}" for name in first_of]
    batch = Batch(
        together, ["upper.mass"], deviation_limits={second.B: limits}, metrics=names
    )
    rows = batch.run([[1200.0]]).metrics.iloc[0]
    for name in METRICS:
        # The engines' errors, and those of other steps; of Drake, 10 of its accuracy.
        other = f"{second.B}.{name}"
        assert told[other] == pytest.approx(expected[name], rel=1e-8, abs=1e-9), name
        assert rows[other] == pytest.approx(expected[name], rel=1e-6, abs=1e-7), name
    [sampled] = batch.runs([[1200.0]])
    mine = sampled.motion_of(second.B)
    for field in dataclasses.fields(mine):
        ours, theirs = (getattr(m, field.name) for m in (mine, flown.motion))
        at = np.searchsorted(mine.time, [0.5, 1.0])
        there = np.searchsorted(flown.motion.time, [0.5, 1.0])
        # Accelerations are slopes of third order in Drake's runs.
        assert ours[at] == pytest.approx(theirs[there], rel=1e-4, abs=1e-5), field.name


def test_momentum_given_to_a_body_is_what_it_has():
    """Free of all else, from rest: mass by velocity, in its own axes as it turns."""
    separation = dataclasses.replace(
        with_pairs(TO_UPPER, TO_THIRD),
        initial=dataclasses.replace(three_bodies().initial, w_WA_A=(0.0, 0.0, 0.0)),
    )
    run = Simulation(separation, Integration(accuracy=1e-9)).run()
    given = run.motion_of("third").linear_momentum_change[-1]
    state = run.trajectory.of("third")[-1]
    R_WB = Rotation.from_quat(state[:4], scalar_first=True)
    arm = R_WB.apply(separation.body("third").p_BoBcm_B)
    velocity = state[10:] + np.cross(state[7:10], arm)
    # Eq. 6 adds forces up in B's axes, which turn by some hundredths of a rad
    # meanwhile.
    assert np.linalg.norm(given) == pytest.approx(
        300.0 * np.linalg.norm(velocity), rel=1e-3
    )


BODIES = symmetric_design().model_dump(mode="json", exclude_none=True)


def rideshare(**changes) -> Case:
    """Two payloads side by side, with one spring each through their CGs."""
    data = dict(BODIES)
    sc = data["bodies"]["sc"]
    lv = dict(data["bodies"]["lv"])
    bodies = {"lv": lv}
    attachments = {}
    for i, (y, force) in enumerate(((900.0, 500.0), (-900.0, 700.0)), 1):
        bodies[f"sat{i}"] = {**sc, "mated": {"position_mm": [0.0, y, 0.0]}}
        pad = dict(data["attachments"]["a1"])
        spring = dict(pad["spring"]) | {"name": f"s{i}", "force_max_N": force}
        attachments[f"port{i}"] = pad | {
            "B": f"sat{i}",
            "position_mm": [0.0, y, 0.0],
            "spring": spring,
        }
    del data["pair"]
    given = {
        "pairs": [{"A": "lv", "B": "sat1"}, {"A": "lv", "B": "sat2"}],
        "bodies": bodies,
        "attachments": attachments,
    }
    return Case.model_validate(data | given | changes)


def test_requirements_of_each_pair_and_of_one(tmp_path):
    case = rideshare(
        dispersions={"s2.force_max_N": 20.0},
        requirements=[
            {"quantity": "longitudinal_speed_m_s", "when": "at_end", "at_least": 0.05},
            {
                "quantity": "longitudinal_speed_m_s",
                "when": "at_end",
                "at_most": 0.2,
                "pair": "sat2",
                "id": "S2",
            },
        ],
    )
    study = drakesep.verify(case, samples=100, starts=2, growth=True, output=tmp_path)
    columns = ["requirement", "pair", "sense", "verdict", "id"]
    assert study.requirements[columns].to_numpy().tolist() == [
        ["longitudinal speed at end", "sat1", ">=", "met", ""],
        ["longitudinal speed at end", "sat2", ">=", "met", ""],
        ["longitudinal speed at end", "sat2", "<=", "not met", "S2"],
    ]
    assert study.completed and not study.passed
    # Of the strongest spring: as the root of its energy, but for what the other does.
    [row] = study.requirements[study.requirements["id"] == "S2"].to_dict("records")
    strongest = row["nominal"] * math.sqrt(720.0 / 700.0)
    assert row["worst"] == pytest.approx(strongest, rel=1e-2)
    labels = {one.label for one in study.runs}
    assert "worst_highest_sat2.longitudinal_speed_at_end" in labels
    files = {path.name for path in tmp_path.iterdir()}
    assert {"rotation_sat2.png", "motion_nominal_sat2.csv"} <= files
    # Metrics of the other are no parameters.
    read = read_runs(tmp_path / "worst_cases.csv", ["nominal"])
    assert read == {"nominal": {"s2.force_max_N": 700.0}}
    table = pd.read_csv(tmp_path / "worst_cases.csv")
    assert "sat2.rate_after_separation_x_deg_s" in table


def test_built_in_cases_are_judged_whole():
    for name, leaving in (("dual_launch", "carrier"), ("fairing", "half_right")):
        case = drakesep.load_case(name)
        assert {limit.pair for limit in case.limits} == {"", leaving}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"pair": {"A": "lv", "B": "sat1"}},
            "must have one of 'pair' and 'pairs', got both",
        ),
        ({"pairs": []}, "must have one of 'pair' and 'pairs', got none"),
        (
            {"pairs": 2 * [{"A": "lv", "B": "sat1"}]},
            "pairs: 'sat1' must leave in one pair, got two",
        ),
        (
            {"pairs": [{"A": "lv", "B": "sat1"}, {"A": "lv", "B": "sat3"}]},
            "pair: unknown body 'sat3'",
        ),
        (
            {
                "requirements": [
                    {"quantity": "rate_deg_s", "at_most": [1, 1, 1], "pair": "lv"}
                ]
            },
            "requirements: unknown body that leaves 'lv'",
        ),
    ],
)
def test_pairs_that_make_no_sense(changes, message):
    with pytest.raises(ValueError, match=message):
        rideshare(**changes)


def test_a_body_that_does_not_leave_has_no_metrics():
    separation = with_pairs(TO_UPPER, TO_THIRD)
    name = "lower.rate_at_end_x"
    run = Simulation(separation).run()
    with pytest.raises(InputError, match="unknown body that leaves 'lower'"):
        metrics_of_run(run, NONE, [name])
    with pytest.raises(InputError, match="unknown body that leaves 'lower'"):
        Batch(separation, ["upper.mass"], metrics=[name])
    required = Requirement(metric=name, sense="<=", limit=1.0)
    with pytest.raises(InputError, match="unknown body that leaves 'lower'"):
        AnalysisCase(separation=separation, requirements=(required,))
