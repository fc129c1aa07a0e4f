"""What a run is and how it ended, as types and as tables have them."""

import pandas as pd
import pytest
from runs import made_up_run
from separations import generic_pair

from drakesep.analysis.analysis_case import AnalysisCase, PublishedCase
from drakesep.systems.checks import InputError
from drakesep.tables.columns import write_csv
from drakesep.tables.comparison import comparison_table
from drakesep.tables.labelled_run import LabelledRun, nominal_of
from drakesep.tables.roles import (
    COMPLETED,
    CONFIRMED,
    Changed,
    Ending,
    Nominal,
    Outcome,
    Published,
    SearchEnd,
    Worst,
    check_labels,
    failed,
)
from drakesep.tables.run_tables import read_runs, runs_table


PAPER = PublishedCase(label="worst_of_all", values={}, objectives=("L1",))
"""A label that begins as ours do, and is none of ours."""
RUNS = [
    # role, outcome; label, role and status in a table; G_L1
    (Worst("L1"), CONFIRMED, "worst_L1", "worst", "confirmed", 3.0),
    (Published(PAPER), COMPLETED, "worst_of_all", "published", "completed", 2.0),
    (
        *(SearchEnd("sqp", "L1"), Outcome(Ending.STALLED, "said the optimiser")),
        *("sqp_L1", "sqp", "stopped without further ascent", 3.0),
    ),
    (
        *(Worst("mine"), failed("no step: nan")),
        *("worst_mine", "worst", "failed: no step: nan", 0.0),
    ),
    (Nominal(), COMPLETED, "nominal", "nominal", "completed", 1.0),
]


@pytest.fixture
def runs():
    """Of a study, with the nominal last: nothing rests on the order."""
    run = made_up_run()
    return [
        LabelledRun(role=role, outcome=outcome, run=run, metrics={"G_L1": value})
        for role, outcome, *_, value in RUNS
    ]


def test_round_trip_through_the_table(runs, tmp_path):
    write_csv(runs_table(runs, ["upper.mass"]), tmp_path / "runs.csv")
    table = pd.read_csv(tmp_path / "runs.csv")
    assert list(table.columns[:3]) == ["label", "role", "upper.mass_kg"]
    expected = [(label, role, status) for _, _, label, role, status, _ in RUNS]
    columns = zip(table["label"], table["role"], table["status"], strict=True)
    assert list(columns) == expected
    # What a status begins with is the value of the ending.
    endings = [Ending(status.partition(": ")[0]) for status in table["status"]]
    assert endings == [one.outcome.ending for one in runs]
    # Worst cases of the paper's objectives, and no other run whose label begins so.
    assert list(read_runs(tmp_path / "runs.csv")) == ["worst_L1"]
    named = read_runs(tmp_path / "runs.csv", ["worst_of_all", "nominal"])
    assert list(named) == ["worst_of_all", "nominal"]


def test_table_without_roles(runs, tmp_path):
    """As versions before this one wrote it: the labels that are named can be shown."""
    frame = runs_table(runs, ["upper.mass"]).drop(columns="role")
    write_csv(frame, tmp_path / "runs.csv")
    assert list(read_runs(tmp_path / "runs.csv", ["worst_L1"])) == ["worst_L1"]
    with pytest.raises(InputError, match="must have a column role, which tells worst"):
        read_runs(tmp_path / "runs.csv")


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("a,worst,heavy\n", "a: upper.mass_kg must be a finite number, got heavy"),
        ("a,worst,\n", "a: upper.mass_kg must be a finite number, got nan"),
        ("a,worst,inf\n", "a: upper.mass_kg must be a finite number, got inf"),
        ("a,worst,1\na,worst,2\n", "run 'a' must stand once"),
    ],
)
def test_table_of_runs_that_cannot_be_read(rows, message, tmp_path):
    (tmp_path / "runs.csv").write_text(f"label,role,upper.mass_kg\n{rows}")
    with pytest.raises(InputError, match=f"runs.csv: {message}"):
        read_runs(tmp_path / "runs.csv")


def test_odd_rows_matter_to_their_own_run_alone(tmp_path):
    text = "label,role,upper.mass_kg\n1,worst,1200\na,worst,heavy\n"
    (tmp_path / "runs.csv").write_text(text)
    read = read_runs(tmp_path / "runs.csv", ["1"])
    assert read == {"1": {"upper.mass_kg": 1200.0}}


def test_nominal_and_worst_are_told_by_their_roles(runs):
    assert nominal_of(runs) is runs[-1]
    [row] = comparison_table(runs).to_dict("records")
    found = ("sqp", "published", "worst")
    ratios = {name: row[name] / row["nominal"] for name in found}
    assert ratios == pytest.approx({"sqp": 3.0, "published": 2.0, "worst": 3.0})
    assert row["which_run"] == "worst_L1"


def test_outcomes():
    assert failed("why").failed
    assert not CONFIRMED.failed
    wanted = {Ending.COMPLETED, Ending.CONFIRMED, Ending.CONVERGED}
    assert {ending for ending in Ending if Outcome(ending).as_wanted} == wanted
    assert len({str(Outcome(ending)) for ending in Ending}) == len(Ending)


def test_labels_that_our_own_runs_bear_are_refused():
    case = AnalysisCase(
        separation=generic_pair(), objectives="paper", published=(PAPER,)
    )
    check_labels(case, ["L1", "mine"])
    with pytest.raises(InputError, match="label 'worst_of_all' is taken by our own"):
        check_labels(case, ["L1", "of_all"])
    for label in ("nominal", "sqp_PM"):
        published = PublishedCase(label=label, values={})
        case = AnalysisCase(
            separation=generic_pair(), objectives="paper", published=(published,)
        )
        with pytest.raises(InputError, match=f"label '{label}' is taken"):
            check_labels(case, [])
    assert LabelledRun(role=Changed(), run=made_up_run(), metrics={}).label == "run"
