"""Plots of the motion show what they say: runs, limits, and what decides them."""

import dataclasses
import math

import numpy as np
import pandas as pd
import pytest
from drawn import TOPICS, curves_of, drawn, texts_of, titles_of
from matplotlib.lines import Line2D
from pictures import is_drawn
from runs import made_up_run
from three_bodies import TO_THIRD, TO_UPPER, with_pairs

import drakesep
from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.metrics.of_run import body_of, metrics_of_run, time_of
from drakesep.analysis.metrics.registry import find_metric
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.plots.panels import ROTATION, TRANSLATION
from drakesep.plots.tornado import tornado_figure
from drakesep.tables.labelled_run import LabelledRun
from drakesep.tables.roles import Nominal, Worst
from drakesep.units import unit_of


CLOSE = 1e-3
"""Between samples, 300 of a run and 64 of a push, extremes are higher by less."""


def labelled(run, *limits, role=None):
    """A run with the metrics that requirements are judged by."""
    limited = [r.judged_by for r in limits if not r.measured_apart]
    metrics = metrics_of_run(run, (math.inf,) * 3, limited)
    return LabelledRun(role=role or Nominal(), run=run, metrics=metrics)


def case_of(run, *limits, **more):
    return AnalysisCase(separation=run.separation, requirements=limits, **more)


def test_curves_are_the_runs(vega_verification):
    study = vega_verification
    figure = drawn(ROTATION, study.runs, study.case)
    assert titles_of(figure) == {
        *(f"angle, {angle}" for angle in ("roll", "pitch", "yaw")),
        *(f"rate, {axis}" for axis in "xyz"),
        *(f"angular momentum change, {axis}" for axis in "xyz"),
    }
    runs = {one.label: one.run for one in study.runs}
    shown = curves_of(figure, "rate, z").runs
    assert set(shown) == {
        *("nominal", "paper_L1_Linf", "paper_L2", "worst_L1", "worst_L2"),
        # Of PM, which is of the translation, none.
        *("worst_Linf", "worst_rate_after_separation_z_up"),
        "worst_deviation_at_separation_yaw_up",
    }
    for label, line in shown.items():
        expected = runs[label].motion.rate[:, 2] * unit_of("rate_z").per_si
        assert np.array_equal(line.get_ydata(), expected)


@pytest.mark.parametrize(
    ("topic", "title", "limit"),
    [
        (ROTATION, "rate, y", 1.5),
        (ROTATION, "angle, yaw", 1.0),
        (TRANSLATION, "relative velocity, x", 0.5),
    ],
)
def test_limits_are_drawn(vega_verification, topic, title, limit):
    figure = drawn(topic, vega_verification.runs, vega_verification.case)
    for part in ("push", "whole run"):
        [line] = curves_of(figure, title, part).limits
        assert line.get_ydata()[0] == pytest.approx(limit)


@pytest.mark.parametrize(
    ("topic", "title", "metric", "limit", "span"),
    [
        (ROTATION, "angle, pitch", "angle_at_separation_pitch", -0.1, "before"),
        (ROTATION, "angle, yaw", "deviation_at_separation_yaw", 0.1, "before"),
        (ROTATION, "rate, y", "rate_max_after_separation_y", 0.1, "after"),
        (ROTATION, "rate, z", "final_rate_z", 0.1, "whole"),
        (ROTATION, "rate, x", "rate_max_from_1_to_2_s_x", 0.1, "a while"),
        (TRANSLATION, "relative velocity, x", "G_PM", -0.1, "whole"),
        (TRANSLATION, "", "G_L1", 0.1, None),
        (TRANSLATION, "", "separation_end", 0.1, None),
    ],
)
def test_a_limit_is_drawn_where_and_while_it_holds(topic, title, metric, limit, span):
    """Of a value of the component itself; on both sides if it is of a magnitude."""
    run = made_up_run(angle=lambda t: (-t, -t, -t), rate=lambda t: (t, t, t))
    end, duration = run.separation_end, run.separation.duration
    required = Requirement(metric=metric, sense="<=", limit=limit)
    figure = drawn(topic, [labelled(run, required)], case_of(run, required))
    limits = {t: curves_of(figure, t).limits for t in titles_of(figure)}
    limits = {title: lines for title, lines in limits.items() if lines}
    if span is None:
        assert not limits
        return
    assert list(limits) == [title]
    times = {"before": (0.0, end), "after": (end, duration), "whole": (0.0, duration)}
    times["a while"] = (1.0, 2.0)
    sides = [limit, -limit] if metric.startswith("deviation") else [limit]
    if metric == "G_PM":  # less the largest speed
        sides = [-limit]
    for line, side in zip(limits[title], sides, strict=True):
        assert tuple(line.get_xdata()) == times[span]
        height = unit_of(metric).from_si(side)
        assert tuple(line.get_ydata()) == pytest.approx((height, height))


def extreme(metric, run, times, values):
    """What a metric would make of a curve: by samples, in the curve's unit."""
    ends = metric.when[:2] if isinstance(metric.when, tuple) else (metric.when,) * 2
    body = body_of(metric, run.separation)
    start, end = (time_of(t, run, body) for t in ends)
    if start == end:
        seen = np.interp([start], times, values)
    else:
        seen = values[(start - 1e-9 <= times) & (times <= end + 1e-9)]
    seen = np.abs(seen) if metric.is_magnitude else seen
    smallest = "smallest" in metric.functional.value
    return seen.min() if smallest else seen.max()


def check_decided(study, figures):
    """Every requirement on a signal: in its panel, its worst run as in the table."""
    runs = {one.label: one.run for one in study.runs}
    table = study.requirements.to_dict("records")
    looked = 0
    for requirement, row in zip(study.case.requirements, table, strict=True):
        metric, axis = find_metric(requirement.judged_by)
        if not metric.is_of_signal_itself:
            continue
        label = row["which_run"]
        found = []
        for (body, _), figure in figures.items():
            if body != body_of(metric, study.case.separation):
                continue
            for title in titles_of(figure):
                whole = curves_of(figure, title)
                at = [x for x in whole.marks if x[1] in (row["worst"], -row["worst"])]
                if at and label in whole.runs:
                    found.append((title, whole.runs[label].get_data()))
        [(title, (times, values))] = found
        assert title.endswith(axis)
        told = extreme(metric, runs[label], times, np.asarray(values))
        assert told == pytest.approx(row["worst"], rel=CLOSE)
        looked += 1
    return looked


def figures_of(study):
    return {
        (pair.B, name): drawn(topic, study.runs, study.case, pair.B)
        for pair in study.case.separation.pairs
        for name, topic in TOPICS.items()
    }


def test_the_worst_in_the_picture_is_that_of_the_table(vega_verification):
    looked = check_decided(vega_verification, figures_of(vega_verification))
    assert looked == 7  # all but the clearance


REQUIRED = [
    {
        "quantity": "longitudinal_speed_m_s",
        "when": "after_separation",
        "at_least": 0.3,
        "at_most": 1.0,
        "id": "UM-4.2",
    },
    {"quantity": "rate_deg_s", "when": "after_separation", "at_most": [1, None, 1]},
    {"quantity": "rate_modulus_deg_s", "when": "after_separation", "at_most": 2.0},
    {"quantity": "transverse_rate_deg_s", "when": "at_separation", "at_most": 1.0},
    {"quantity": "tip_off_angle_deg", "when": {"from_s": 0.5, "to_s": 2}, "at_most": 3},
    {"quantity": "spring_force_N", "at_most": 320.0, "of": "spring_3"},
    {"quantity": "lateral_speed_m_s", "when": "after_separation", "at_most": 0.02},
    {"quantity": "longitudinal_displacement_m", "when": {"at_s": 1}, "at_least": 0.4},
]


@pytest.fixture(scope="module")
def smallsat():
    """Limits of all kinds on the built-in vehicle; what is worst lies in corners."""
    case = drakesep.load_case("smallsat").replaced(
        requirements=REQUIRED,
        dispersions={f"spring_{i}.force_max_N": 15 for i in (1, 2, 3)},
    )
    return drakesep.verify(case, searches=["vertices"], growth=False, workers=1)


def test_every_signal_that_is_required_has_a_panel(smallsat):
    """Moduli, angles between axes, forces, displacements: panels of their own."""
    figures = figures_of(smallsat)
    assert check_decided(smallsat, figures) == 10
    for name, titles in {
        "rotation": {"rate modulus", "transverse rate", "tip off angle"},
        "translation": {
            *("lateral speed", "longitudinal displacement", "spring force of spring_3"),
        },
    }.items():
        figure = figures["smallsat", name]
        assert titles <= titles_of(figure)
        assert len(figure.axes) == 2 * (9 + len(titles))
    texts = texts_of(figures["smallsat", "translation"])
    [worst] = smallsat.requirements["worst"].head(1)
    said = f"UM-4.2: ≥ 0.3 m/s: {worst:.4g} in worst_lowest_longitudinal_speed"
    assert any(text.startswith(said) for text in texts)
    assert any("not met" in t for t in texts_of(figures["smallsat", "rotation"]))


def test_a_curve_stands_only_where_it_has_something_to_say(smallsat):
    """Nominal, and what decides along the axis or along none."""
    figure = figures_of(smallsat)["smallsat", "rotation"]
    alone = {r for r in smallsat.requirements["which_run"][4:7]}
    [x, z] = smallsat.requirements["which_run"][2:4]
    for title, own in (("rate, x", {x}), ("rate, y", set()), ("angle, yaw", {z})):
        assert set(curves_of(figure, title).runs) == {"nominal", *alone, *own}
    assert set(curves_of(figure, "rate modulus").runs) == {"nominal", *alone}


def test_of_each_body_that_leaves():
    """A requirement of another body is in that body's pictures."""
    metrics = [f"rate_after_separation_{axis}" for axis in "xyz"]
    metrics += ["longitudinal_speed_after_separation"]
    case = AnalysisCase(
        separation=with_pairs(TO_UPPER, TO_THIRD),
        tolerances={"upper.mass": 20.0},
        requirements=tuple(
            Requirement(metric=f"{body}{metric}", sense="<=", limit=9.0)
            for body in ("", "third.")
            for metric in metrics
        ),
    )
    study = drakesep.verify(case, searches=["vertices"], growth=False, workers=1)
    assert check_decided(study, figures_of(study)) == 8


def test_the_push_has_a_panel_of_its_own(smallsat):
    """From the first release to the last stroke, and a little around."""
    figure = figures_of(smallsat)["smallsat", "rotation"]
    run = smallsat.runs[0].run
    [push] = [a for a in figure.axes if a.get_label() == "rate, z: push"]
    [whole] = [a for a in figure.axes if a.get_label() == "rate, z: whole run"]
    start, end = push.get_xlim()
    assert start == 0.0
    assert 1.1 * run.separation_end < end < 1.2 * run.separation_end < 0.1
    assert whole.get_xlim() == (0.0, run.separation.duration)
    # What happens until then fills the panel.
    [low, high] = push.get_ylim()
    motion = run.motion
    until = math.degrees(np.abs(motion.rate[motion.time <= end, 2]).max())
    assert low < 0.0 and until <= high


def test_the_legend_has_every_colour_of_what_decides(smallsat):
    figure = figures_of(smallsat)["smallsat", "translation"]
    runs = [curves_of(figure, title).runs for title in titles_of(figure)]
    colours = {
        line.get_color() for each in runs for n, line in each.items() if n != "nominal"
    }
    assert len(colours) > 1
    [legend] = figure.legends
    marked = [line for line in legend.findobj(Line2D) if line.get_marker() == "o"]
    assert {line.get_color() for line in marked} == colours
    words = [text.get_text() for text in legend.get_texts()]
    assert words == ["nominal", "worst by a requirement", "limit", "end of separation"]


def test_what_is_round_off_is_drawn_as_nothing():
    """Signals of 1e-17 about zero, and of 1e-12 about three."""
    run = made_up_run(
        relative_velocity=lambda t: (
            1e-17 * np.sin(9.0 * t),
            3.0 + 1e-12 * np.sin(9.0 * t),
            1e-5 * t,
        )
    )
    figure = drawn(TRANSLATION, [labelled(run)], case_of(run))
    for part in ("push", "whole run"):
        spans = {}
        for axis in "xyz":
            line = curves_of(figure, f"relative velocity, {axis}", part).runs["nominal"]
            low, high = line.axes.get_ylim()
            spans[axis] = high - low
            assert low < 0.0 < high or low < 3.0 < high
        assert min(spans["x"], spans["y"]) > 0.1
        assert spans["z"] < 1e-4  # that is a signal


def test_a_window_that_is_not_reached_is_said():
    run = made_up_run(rate=lambda t: (t, t, t))
    late = Requirement(metric="rate_max_from_2_to_5_s_x", sense="<=", limit=0.1)
    figure = drawn(ROTATION, [labelled(run, late)], case_of(run, late))
    assert "≤ 5.73 deg/s: not looked at" in texts_of(figure)
    whole = curves_of(figure, "rate, x")
    assert not whole.marks
    assert tuple(whole.limits[0].get_xdata()) == (2.0, 3.0)


def test_turns_go_on_as_the_table_has_them():
    """Two turns about x: the curve does not jump from 180 to -180 deg."""
    run = made_up_run(angle=lambda t: (np.angle(np.exp(4j * t)), 0 * t, 0 * t))
    limit = Requirement(metric="angle_max_roll", sense="<=", limit=1.0)
    figure = drawn(ROTATION, [labelled(run, limit)], case_of(run, limit))
    whole = curves_of(figure, "angle, roll")
    [(time, value)] = whole.marks
    assert (time, value) == pytest.approx((3.0, math.degrees(12.0)), rel=1e-9)
    values = whole.runs["nominal"].get_ydata()
    assert np.abs(np.diff(values)).max() < 5.0


def test_legend_names_every_run(vega_verification):
    study = vega_verification
    figure = drawn(TRANSLATION, study.runs, study.case)
    [legend] = figure.legends
    names = [text.get_text() for text in legend.get_texts()]
    assert names == [
        *("nominal", "paper_PM", "worst_PM"),  # the worst by its requirement, too
        "limit",
        "end of separation",
    ]


def test_one_run_is_held_against_the_limits(tmp_path):
    """As `simulate` draws it."""
    simulated = drakesep.simulate("vega", {"payload.mass_kg": 1870}, output=tmp_path)
    figure = drawn(ROTATION, [simulated.labelled], simulated.case)
    rate = simulated.summary["rate_after_separation_y_deg_s"].iloc[0]
    assert f"≤ 1.5 deg/s: {rate:.4g} in run" in texts_of(figure)
    assert list(curves_of(figure, "rate, y").runs) == ["run"]
    assert is_drawn(tmp_path / "rotation.png")


def test_tornado_has_a_panel_for_each_objective(vega_verification, vega_folder):
    """Bars are the table's, the largest on top."""
    frame = vega_verification.sensitivities
    figure = tornado_figure(frame)
    panels = {a.get_title("right"): a for a in figure.axes if a.get_visible()}
    assert len(panels) == frame["objective"].nunique()
    rows = frame[frame["objective"] == "L1"]
    bars = panels["L1"].containers[0].patches
    assert [bar.get_width() for bar in bars] == pytest.approx(
        rows["upward_at_worst"].head(len(bars)).tolist()
    )
    assert is_drawn(vega_folder / "tornado.png")


def renamed(run, name):
    """The same run of a body of another name."""
    pair = run.separation
    bodies = tuple(
        dataclasses.replace(body, name=name) if body.name == pair.B else body
        for body in pair.bodies
    )
    held = tuple(dataclasses.replace(a, B=name) for a in pair.attachments)
    separation = dataclasses.replace(pair, bodies=bodies, attachments=held, B=name)
    return dataclasses.replace(run, separation=separation)


LONG = "W" * 130
"""Of the widest letter there is."""


@pytest.mark.parametrize("name", ["L1", "carrier.longitudinal_speed_at_end", LONG])
@pytest.mark.parametrize("topic", TOPICS.values())
def test_nothing_is_cut_whatever_names_are(topic, name):
    """Titles, what stands above panels, and the legend end within the figure."""
    run = made_up_run(rate=lambda t: (t, t, t))
    limit = Requirement(metric="rate_max_x", sense="<=", limit=0.1, id=name)
    run = renamed(run, name.split(".")[0])
    roles = [Nominal(), *(Worst(f"{name}_{i}") for i in range(6))]
    runs = [labelled(run, limit, role=role) for role in roles]
    figure = drawn(topic, runs, case_of(run, limit))
    figure.draw_without_rendering()
    whole = figure.bbox
    shown = [figure.legends[0], figure._suptitle, *figure.texts]
    for extent in (artist.get_window_extent() for artist in shown):
        assert whole.x0 <= extent.x0 and extent.x1 <= whole.x1
        assert whole.y0 <= extent.y0 and extent.y1 <= whole.y1


@pytest.mark.parametrize("name", ["lowest_carrier.longitudinal_speed_at_end", LONG])
def test_titles_of_tornados_are_not_cut(name):
    bars = {
        "objective": [name] * 2,
        "unit": ["deg"] * 2,
        "parameter": ["a_body_of_a_name.inertia_xy_kg_m2", "b"],
        "upward_at_worst": [1.0, -2.0],
        "downward_at_worst": [-1.0, 1.0],
        "upward_at_nominal": [0.5, 0.5],
        "downward_at_nominal": [-0.5, -0.5],
        "at_worst": ["M", "m"],
    }
    others = {**bars, "objective": ["L1"] * 2}
    frame = pd.concat([pd.DataFrame(others), pd.DataFrame(bars)])
    figure = tornado_figure(frame)
    figure.draw_without_rendering()
    titles = [text for axes in figure.axes for text in (axes.title, axes._right_title)]
    for extent in (t.get_window_extent() for t in titles if t.get_text()):
        assert figure.bbox.x0 <= extent.x0 and extent.x1 <= figure.bbox.x1
