"""The pictures show what they say."""

import numpy as np
import pytest

from drakesep import figures
from drakesep.units import unit_of


@pytest.fixture(scope="module")
def shown(vega_verification):
    return [f for f in vega_verification.flights if f.published is None]


def test_curves_are_the_runs(shown, vega_verification):
    figure = figures.rotation_figure(shown, vega_verification.case.limits)
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
        (figures.rotation_figure, "rate, y", 1.5),
        (figures.rotation_figure, "angle, yaw", 1.0),
        (figures.translation_figure, "relative velocity, x", 0.5),
    ],
)
def test_limits_are_drawn(shown, vega_verification, make, title, limit):
    figure = make(shown, vega_verification.case.limits)
    [axes] = [axes for axes in figure.axes if axes.get_title() == title]
    assert axes.get_lines()[-1].get_ydata()[0] == pytest.approx(limit)


def test_legend_names_every_run(shown, vega_verification):
    figure = figures.translation_figure(shown, vega_verification.case.limits)
    [legend] = figure.legends
    names = [text.get_text() for text in legend.get_texts()]
    assert names == [*(flight.label for flight in shown), "end of separation", "limit"]
