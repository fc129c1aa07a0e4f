"""The pictures show what they say."""

import numpy as np
import pytest
from pictures import is_drawn
from runs import made_up_run

from drakesep.analysis.metrics.objectives import OBJECTIVES
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.plots.motion import rotation_figure, translation_figure
from drakesep.plots.tornado import tornado_figure
from drakesep.tables.labelled_run import LabelledRun
from drakesep.tables.roles import Nominal, Worst
from drakesep.units import unit_of


@pytest.fixture(scope="module")
def shown(vega_verification):
    return [
        one
        for one in vega_verification.runs
        if isinstance(one.role, Nominal | Worst)
        if one.objective in (None, *OBJECTIVES)
    ]


def test_curves_are_the_runs(shown, vega_verification):
    figure = rotation_figure(shown, vega_verification.case.requirements)
    panels = {axes.get_title(): axes for axes in figure.axes}
    assert set(panels) == {
        *(f"angle, {angle}" for angle in ("roll", "pitch", "yaw")),
        *(f"rate, {axis}" for axis in "xyz"),
        *(f"angular momentum change, {axis}" for axis in "xyz"),
    }
    line = panels["rate, z"].get_lines()[3]
    assert line.get_label() == "worst_Linf"
    motion = shown[3].run.motion
    expected = motion.rate[:, 2] * unit_of("rate_z").per_si
    assert np.array_equal(line.get_ydata(), expected)


@pytest.mark.parametrize(
    ("make", "title", "limit"),
    [
        (rotation_figure, "rate, y", 1.5),
        (rotation_figure, "angle, yaw", 1.0),
        (translation_figure, "relative velocity, x", 0.5),
    ],
)
def test_limits_are_drawn(shown, vega_verification, make, title, limit):
    figure = make(shown, vega_verification.case.requirements)
    [axes] = [axes for axes in figure.axes if axes.get_title() == title]
    assert axes.get_lines()[-1].get_ydata()[0] == pytest.approx(limit)


@pytest.mark.parametrize(
    ("make", "title", "metric", "limit", "span"),
    [
        (rotation_figure, "angle, pitch", "angle_at_separation_pitch", -0.1, "before"),
        (rotation_figure, "angle, yaw", "deviation_at_separation_yaw", 0.1, "before"),
        (rotation_figure, "rate, y", "rate_max_after_separation_y", 0.1, "after"),
        (rotation_figure, "rate, z", "final_rate_z", 0.1, "whole"),
        (translation_figure, "relative velocity, x", "G_PM", -0.1, "whole"),
        (translation_figure, "relative velocity, x", "G_L1", 0.1, None),
        (translation_figure, "relative velocity, x", "clearance", 0.1, None),
    ],
)
def test_a_limit_is_drawn_where_and_while_it_holds(make, title, metric, limit, span):
    """Of a value of the component itself; on both sides if it is of a magnitude."""
    run = made_up_run(angle=lambda t: (-t, -t, -t), rate=lambda t: (t, t, t))
    end, duration = run.separation_end, run.separation.duration
    required = Requirement(metric=metric, sense="<=", limit=limit)
    labelled = LabelledRun(role=Nominal(), run=run, metrics={})
    figure = make([labelled], [required])
    drawn = {
        axes.get_title(): axes.get_lines()[2:]  # after the run, and separation's end
        for axes in figure.axes
        if len(axes.get_lines()) > 2
    }
    if span is None:
        assert not drawn
        return
    assert list(drawn) == [title]
    times = {"before": (0.0, end), "after": (end, duration), "whole": (0.0, duration)}
    sides = [limit, -limit] if metric.startswith("deviation") else [limit]
    if metric == "G_PM":  # less the largest speed
        sides = [-limit]
    for line, side in zip(drawn[title], sides, strict=True):
        assert tuple(line.get_xdata()) == times[span]
        height = unit_of(metric).from_si(side)
        assert tuple(line.get_ydata()) == pytest.approx((height, height))


def test_legend_names_every_run(shown, vega_verification):
    figure = translation_figure(shown, vega_verification.case.requirements)
    [legend] = figure.legends
    names = [text.get_text() for text in legend.get_texts()]
    assert names == [
        *(one.label for one in shown),
        "end of separation",
        "limit",
    ]


def test_tornado_has_a_panel_for_each_objective(vega_verification, vega_folder):
    """Bars are the table's, the largest on top."""
    frame = vega_verification.sensitivities
    figure = tornado_figure(frame)
    panels = {axes.get_title(): axes for axes in figure.axes if axes.get_visible()}
    assert len(panels) == frame["objective"].nunique()
    rows = frame[frame["objective"] == "L1"]
    bars = panels["L1"].containers[0].patches
    assert [bar.get_width() for bar in bars] == pytest.approx(
        rows["per_tolerance_at_worst"].head(len(bars)).tolist()
    )
    assert is_drawn(vega_folder / "tornado.png")


@pytest.mark.parametrize("objective", ["L1", "lowest_longitudinal_speed_after_release"])
def test_legend_is_not_cut(objective):
    """Whatever runs are called, it ends within the figure."""
    run = made_up_run()
    roles = [Nominal(), *(Worst(f"{objective}_{i}") for i in range(6))]
    runs = [LabelledRun(role=role, run=run, metrics={}) for role in roles]
    figure = rotation_figure(runs, [])
    figure.draw_without_rendering()
    [legend] = figure.legends
    extent, whole = legend.get_window_extent(), figure.bbox
    assert whole.x0 <= extent.x0 and extent.x1 <= whole.x1
