"""The overview of a motion: runs, limits while they hold, and what decides."""

import math

import pytest
from runs import made_up_run

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.plots.motion_overview import overview_figure
from drakesep.plots.shown_runs import ShownRuns
from drakesep.tables.labelled_run import LabelledRun
from drakesep.tables.roles import Nominal, Worst
from drakesep.units import unit_of


LIMIT = Requirement(
    metric="rate_after_separation_y", sense="<=", limit=math.radians(2.0), id="R-7"
)
TITLES = [
    *(f"rate, {x}" for x in "xyz"),
    *(f"angle, {x}" for x in ("roll", "pitch", "yaw")),
    *(f"relative velocity, {x}" for x in "xyz"),
]


def labelled(run, role):
    metrics = metrics_of_run(run, (math.inf,) * 3, [LIMIT.judged_by])
    return LabelledRun(role=role, run=run, metrics=metrics)


@pytest.fixture(scope="module")
def figure():
    nominal = labelled(made_up_run(), Nominal())
    case = AnalysisCase(separation=nominal.run.separation, requirements=(LIMIT,))
    worst = labelled(made_up_run(), Worst("rate_after_separation_y_up"))
    shown = ShownRuns.of([nominal, worst], case)
    return nominal, overview_figure(shown, shown.run.separation.pairs[0], 7.0)


def test_panels_are_rates_angles_and_speeds(figure):
    _, drawn = figure
    titles = [axes.get_title().replace("\n", " ") for axes in drawn.axes]
    assert [title.partition(" (")[0] for title in titles] == TITLES
    assert titles[1] == "rate, y (R-7: ≤ 2 deg/s)"


def test_curves_are_the_runs(figure):
    nominal, drawn = figure
    motion = nominal.run.motion
    for i, axes in enumerate(drawn.axes[:3]):
        [curve] = [x for x in axes.get_lines() if x.get_label() == "nominal"]
        expected = motion.rate[:, i] * unit_of("rate_x").per_si
        assert curve.get_ydata() == pytest.approx(expected, rel=1e-15)
        assert curve.get_xdata() == pytest.approx(motion.time, rel=1e-15)


def test_a_limit_stands_in_its_panel_alone(figure):
    _, drawn = figure
    heights = {
        title: [y for line in axes.get_lines() for y in set(line.get_ydata())]
        for title, axes in zip(TITLES, drawn.axes, strict=True)
    }
    at_limit = [
        title
        for title, ys in heights.items()
        if any(isinstance(y, float) and abs(y - 2.0) < 1e-12 for y in ys)
    ]
    assert at_limit == ["rate, y"]
