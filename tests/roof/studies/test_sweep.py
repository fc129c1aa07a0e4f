"""Variants of a case: against closed forms, `simulate`, and from both engines."""

import itertools
import json
import math

import matplotlib.figure
import numpy as np
import pandas as pd
import pytest
from command_line import run
from hypothesis import given
from hypothesis import strategies as st
from small_case import small_case, write_case

import drakesep
from drakesep.case_file.case import Case
from drakesep.cli.sweep_command import parse_swept
from drakesep.plots.sweep import sweep_figure
from drakesep.studies import sweep as study_of_sweeps
from drakesep.studies.sweep import _on_batch


SPEED = "longitudinal_speed_after_separation_m_s"
MASSES = [1150.0, 1200.0, 1250.0]


def straight():
    """One spring through both CGs: nothing turns, v = sqrt(2 E / mu)."""
    data = small_case(published=None, objectives=None, before_separation=None)
    one = data["attachments"].pop("one")
    data["attachments"] = {"one": {**one, "position_mm": [0.0, 0.0, 0.0]}}
    spring = {"name": "s1", "law": "displacement"}
    spring |= {"force_max_N": 1500.0, "stroke_mm": 100.0}
    data["attachments"]["one"]["spring"] = spring
    for body in data["bodies"].values():
        body["cg_mm"] = [body["cg_mm"][0], 0.0, 0.0]
        del body["geometry"]
    data["dispersions"] = {"upper.mass_kg": 50.0}
    data["requirements"] = [
        {
            "quantity": "longitudinal_speed_m_s",
            "when": "after_separation",
            "at_least": 0.5,
            "at_most": 0.6,
        }
    ]
    return Case.model_validate(data)


def by_energy(mass, force):
    """Of 700 kg and another mass, pushed apart by a force that falls over 100 mm."""
    return math.sqrt(2.0 * (0.5 * force * 0.1) * (1.0 / 700.0 + 1.0 / mass))


@pytest.mark.parametrize("engine", ["drake", "batch"])
def test_every_combination_leaves_at_the_speed_of_the_energy(engine):
    forces = [1000.0, 1500.0]
    values = {"upper.mass_kg": MASSES, "s1.force_max_N": forces}
    table = drakesep.sweep(straight(), values, engine=engine).table
    assert table["variant"].tolist() == [1, 2, 3, 4, 5, 6]
    combinations = list(itertools.product(MASSES, forces))
    columns = ["upper.mass_kg", "s1.force_max_N"]
    assert [*table[columns].itertuples(index=False, name=None)] == combinations
    expected = [by_energy(*one) for one in combinations]
    # Drake's accuracy of 1e-6 a step, over the few steps of a stroke.
    assert table[SPEED].to_numpy() == pytest.approx(expected, rel=5e-6)
    verdicts = ["met" if 0.5 <= v <= 0.6 else "not met" for v in expected]
    assert table["verdict"].tolist() == verdicts
    assert set(verdicts) == {"met", "not met"}
    for v, violated in zip(expected, table["violated"], strict=True):
        limit = "" if v <= 0.6 else f"{SPEED} <= 0.6"
        assert violated == (f"{SPEED} >= 0.5" if v < 0.5 else limit)
    assert set(table["status"]) == {"completed"}


def test_in_drake_a_variant_is_what_simulate_flies():
    """To the last bit, clearance aside, which `simulate` does not measure."""
    case = Case.model_validate(small_case(published=None))
    values = {"upper.mass_kg": [1180.0, 1220.0]}
    study = drakesep.sweep(case, values)
    assert study.engine == "drake"
    for variant, mass in zip(study.variants, *values.values(), strict=True):
        flown = drakesep.simulate(case, {"upper.mass_kg": mass})
        assert variant.metrics == flown.labelled.metrics


def both(data, values):
    case = Case.model_validate(data)
    return [
        drakesep.sweep(case, values, engine=engine, workers=1).table
        for engine in ("drake", "batch")
    ]


def assert_alike(in_drake, on_batch):
    """Same columns; Drake's accuracy of 1e-6 a step, in degrees and over a second."""
    assert [*in_drake] == [*on_batch]
    numbers = in_drake.select_dtypes("number")
    assert numbers.to_numpy() == pytest.approx(
        on_batch[[*numbers]].to_numpy(), rel=2e-5, abs=2e-4, nan_ok=True
    )
    for column in ("verdict", "violated"):
        assert in_drake[column].tolist() == on_batch[column].tolist()


def test_what_steps_tell_is_the_same_on_both_engines():
    """With a failed variant, and a limit beyond the end of the run: no verdict."""
    data = small_case(published=None)
    limits = {"quantity": "rate_deg_s", "when": {"at_s": 5.0}, "at_most": [9, 9, 9]}
    data["requirements"].append(limits)
    tables = both(data, {"upper.mass_kg": [*MASSES, -1.0]})
    assert_alike(*tables)
    for table in tables:
        assert table["rate_at_5_s_x_deg_s"].isna().all()
        assert table["verdict"].tolist()[:3] == ["not looked at"] * 3
        assert table["verdict"].tolist()[3] == ""
        assert table["status"].tolist() == [
            *["completed"] * 3,
            "failed: upper: mass must be > 0, got -1.0",
        ]
        assert table.iloc[3][[SPEED]].isna().all()


def test_what_is_measured_is_the_same_on_both_engines():
    """A clearance and the force of a spring, which steps do not tell."""
    data = small_case(published=None)
    data["requirements"] += [
        {"quantity": "clearance_mm", "at_least": 1.0},
        {"quantity": "spring_force_N", "at_most": 9999.0, "of": "s1"},
    ]
    tables = both(data, {"s1.force_max_N": [1100.0, 1200.0]})
    assert_alike(*tables)
    [force] = [name for name in tables[0] if name.startswith("s1.spring_force")]
    # Its largest is what it begins with.
    assert tables[0][force].tolist() == pytest.approx([1100.0, 1200.0])
    assert tables[0]["clearance_mm"].between(1.0, 200.0).all()


def test_which_engine_flies(monkeypatch):
    """Drake flies a few, and what the batch engine cannot."""
    grid = [{"upper.mass": 1180.0}, {"upper.mass": 1190.0}]
    free = Case.model_validate(small_case()).in_si()
    pushed = small_case(recontact={"stiffness_N_m": 1e6})
    pushed = Case.model_validate(pushed).in_si()
    assert _on_batch(free, grid, None, None) is None
    assert _on_batch(free, grid, None, "batch") is not None
    monkeypatch.setattr(study_of_sweeps, "_FEW", 1)
    assert _on_batch(free, grid, None, None) is not None
    assert _on_batch(free, grid, None, "drake") is None
    assert _on_batch(pushed, grid, None, None) is None
    with pytest.raises(ValueError, match="recontact: the batch engine knows no"):
        _on_batch(pushed, grid, None, "batch")


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({}, "values: must be of one parameter or more, got none"),
        ({"upper.mas_kg": [1.0]}, "unknown parameter 'upper.mas_kg'; did you mean"),
        ({"upper.mass_kg": []}, "upper.mass_kg: must have one value or more, got none"),
        ({"upper.mass_kg": [1.0, math.nan]}, "upper.mass_kg must be finite, got nan"),
        (
            {"upper.mass_kg": [1.0] * 2000, "lower.mass_kg": [1.0] * 2000},
            "values: must make at most 100000 variants, got 4000000",
        ),
    ],
)
def test_what_is_refused_leaves_the_folder_alone(values, message, tmp_path):
    case = Case.model_validate(small_case())
    with pytest.raises(ValueError, match=message):
        drakesep.sweep(case, values, output=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_unknown_engine():
    with pytest.raises(ValueError, match="engine: must be 'drake' or 'batch', got"):
        drakesep.sweep(straight(), {"upper.mass_kg": MASSES}, engine="steam")


def test_folder_and_what_does_it_again(tmp_path):
    study = drakesep.sweep(straight(), {"upper.mass_kg": MASSES}, output=tmp_path / "a")
    study.save(tmp_path / "b")
    assert (tmp_path / "a" / "sweep.csv").read_text() == (
        tmp_path / "b" / "sweep.csv"
    ).read_text()
    names = {path.name for path in (tmp_path / "a").iterdir()}
    assert names == {"sweep.csv", "sweep.png", "study.json", "case.json"}
    results = drakesep.read_results(tmp_path / "a")
    read = results.table("sweep.csv")
    assert read.pop("violated").isna().all()
    pd.testing.assert_frame_equal(read, study.table.drop(columns="violated"))
    assert results.record.arguments == {"values": {"upper.mass_kg": MASSES}}
    again = drakesep.sweep(results.case, **results.record.arguments)
    pd.testing.assert_frame_equal(again.table, study.table)


def test_interrupted_sweep_leaves_what_was_done(tmp_path):
    def interrupt(progress):
        if progress.done >= 8:
            raise KeyboardInterrupt

    masses = np.linspace(1150.0, 1250.0, 20).tolist()
    with pytest.raises(KeyboardInterrupt):
        drakesep.sweep(
            straight(),
            {"upper.mass_kg": masses},
            output=tmp_path,
            workers=1,
            on_progress=interrupt,
        )
    done = pd.read_csv(tmp_path / "sweep.csv")["upper.mass_kg"].tolist()
    assert done == masses[: len(done)]
    assert 8 <= len(done) < 20
    said = json.loads((tmp_path / "study.json").read_text())
    assert said["ended"] == "interrupted"
    assert "sweep.csv" in [file["name"] for file in said["files"]]


def test_progress():
    """The plan first, then how many are done; all, at the end."""
    seen = []
    drakesep.sweep(
        straight(), {"upper.mass_kg": MASSES}, workers=1, on_progress=seen.append
    )
    assert str(seen[0]).startswith("3 variants of upper.mass_kg, flown in Drake; about")
    done = [progress.done for progress in seen]
    assert done[0] == 0
    assert done == sorted(done)
    assert done[-1] == 3
    shares = [progress.remaining.share for progress in seen]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_plot_has_each_quantity_and_its_limits():
    """Variants in the order of the parameter; the failed one is a gap."""
    values = {"upper.mass_kg": [1250.0, 1150.0, -1.0, 1200.0]}
    study = drakesep.sweep(straight(), values, workers=1)
    figure = sweep_figure(study.variants, study.case)
    assert isinstance(figure, matplotlib.figure.Figure)
    [axes] = [axes for axes in figure.axes if axes.get_visible()]
    curves = [line for line in axes.lines if len(line.get_xdata()) == 4]
    speeds = dict(zip(study.table["upper.mass_kg"], study.table[SPEED], strict=True))
    assert len(curves) == 2  # the smallest after separation, and the largest
    for curve in curves:
        assert list(curve.get_xdata()) == [-1.0, 1150.0, 1200.0, 1250.0]
        y = list(curve.get_ydata())
        assert math.isnan(y[0])
        # Both are the speed at which it leaves, by what splines make of its last push.
        assert y[1:] == pytest.approx([speeds[x] for x in MASSES], rel=1e-5)
    levels = {
        line.get_label(): float(line.get_ydata()[0])
        for line in axes.lines
        if line not in curves
    }
    assert levels.items() >= {"≥ 0.5 m/s": 0.5, "≤ 0.6 m/s": 0.6}.items()
    told = {text.get_text() for text in axes.get_legend().get_texts()}
    assert told == {"largest", "smallest", "≥ 0.5 m/s", "≤ 0.6 m/s"}


def test_no_plot_of_two_parameters(tmp_path):
    values = {"upper.mass_kg": [1200.0], "s1.force_max_N": [1400.0, 1500.0]}
    drakesep.sweep(straight(), values, output=tmp_path)
    assert not (tmp_path / "sweep.png").exists()


def test_a_case_without_requirements_has_its_metrics(tmp_path, capsys, monkeypatch):
    data = small_case(requirements=None, objectives=None, published=None)
    case = write_case(tmp_path, data)
    words = ["sweep", case, "upper.mass_kg=1190,1210", "-o", tmp_path / "out"]
    code, out, _ = run(capsys, monkeypatch, *words)
    assert code == 0
    assert "final_rate_x" in out
    table = pd.read_csv(tmp_path / "out" / "sweep.csv")
    assert table["verdict"].isna().all()
    assert not (tmp_path / "out" / "sweep.png").exists()


@given(
    first=st.floats(-1e6, 1e6, allow_subnormal=False),
    last=st.floats(-1e6, 1e6, allow_subnormal=False),
    count=st.integers(2, 50),
)
def test_values_between_have_the_very_ends(first, last, count):
    [values] = parse_swept([f"x={first!r}:{last!r}:{count}"]).values()
    assert len(values) == count
    assert (values[0], values[-1]) == (first, last)
    steps = np.diff(values)
    spacing = (last - first) / (count - 1)
    # Round-off of two numbers of the size of the ends, and of the smallest there are.
    apart = 4e-15 * (abs(first) + abs(last)) + 1e-300
    assert steps == pytest.approx(spacing, abs=apart)


@pytest.mark.parametrize(
    ("texts", "values"),
    [
        (["a.b_kg=1,2.5,3e2"], {"a.b_kg": [1.0, 2.5, 300.0]}),
        (["a=7"], {"a": [7.0]}),
        (["a=0:1:3", "b=-1,1"], {"a": [0.0, 0.5, 1.0], "b": [-1.0, 1.0]}),
        (["a=3:1:3"], {"a": [3.0, 2.0, 1.0]}),
    ],
)
def test_values_as_they_are_written(texts, values):
    assert parse_swept(texts) == values


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        (["a"], "a: must be NAME=FROM:TO:N or NAME=VALUE,VALUE,..., got no ="),
        (["a=1:2"], "a: must be FROM:TO:N, got '1:2'"),
        (["a=1:2:3:4"], "a: must be FROM:TO:N, got '1:2:3:4'"),
        (["a=1:2:1"], "a: N must be a whole number of 2 or more, got '1'"),
        (["a=1:2:2.5"], "a: N must be a whole number of 2 or more, got '2.5'"),
        (["a=1:x:3"], "a: must be a number, got 'x'"),
        (["a=1,,2"], "a: must be a number, got ''"),
        (["a="], "a: must be a number, got ''"),
        (["a=inf:2:3"], "a must be finite, got inf"),
        (
            ["a=1e308:-1e308:3"],
            "a: FROM and TO must differ by a number that a computer can hold, got "
            "'1e308:-1e308:3'",
        ),
        (
            ["a=1:2:99999999999"],  # which would take a terabyte
            "a: must make at most 100000 variants, got 99999999999",
        ),
        (["a=1", "a=2"], "a: must stand once, got it twice"),
    ],
)
def test_values_that_cannot_be_read(texts, message):
    with pytest.raises(ValueError) as error:
        parse_swept(texts)
    assert str(error.value) == message
