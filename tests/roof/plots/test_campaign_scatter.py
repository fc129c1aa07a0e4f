"""Points, limits and the draw that decides are where their numbers say."""

import math

import numpy as np
import pytest

from drakesep.analysis.metrics.requirements import Requirement
from drakesep.plots.campaign_points import Against, Scatter
from drakesep.plots.campaign_scatter import scatter_figure


DEG = 180.0 / math.pi
RATES = np.array([1.0, 2.0, 3.0, np.nan]) / DEG


def scatter(limit, *parameters):
    over = tuple(
        Against(
            parameter=name,
            values=0.001 * np.arange(4),
            deciding=0.007,
            correlation=correlation,
        )
        for name, correlation in parameters
    )
    required = Requirement(
        metric="rate_after_separation_y", sense="<=", limit=limit / DEG, id="R-1"
    )
    return Scatter(requirement=required, values=RATES, deciding=3.5 / DEG, over=over)


def test_each_panel_shows_one_parameter():
    two = (("payload.cg_y", 0.81), ("payload.mass", -0.4))
    figure = scatter_figure("mine", [scatter(4.0, *two)])
    first, second = figure.axes
    points, diamond, limit = first.get_lines()
    assert points.get_xdata() == pytest.approx([0.0, 1.0, 2.0, 3.0])  # mm
    assert points.get_ydata() == pytest.approx([1.0, 2.0, 3.0, np.nan], nan_ok=True)
    assert [*diamond.get_xdata(), *diamond.get_ydata()] == pytest.approx([7.0, 3.5])
    assert list(limit.get_ydata()) == pytest.approx([4.0, 4.0])
    assert first.get_title() == "rate after separation y\nR-1: ≤ 4 deg/s"
    assert first.get_xlabel() == "payload.cg_y (mm), +0.81"
    assert second.get_xlabel() == "payload.mass (kg), -0.40"
    assert first.get_ylabel() == "deg/s"


@pytest.mark.parametrize(
    ("limit", "arrow"), [(6.9, ""), (7.1, "↑ "), (-2.9, ""), (-3.1, "↓ ")]
)
def test_a_limit_far_from_all_points_is_an_arrow(limit, arrow):
    """They span 2 deg/s, from 1 to 3: twice that beyond them is far."""
    [axes] = scatter_figure("mine", [scatter(limit, ("payload.mass", 0.1))]).axes
    assert len(axes.get_lines()) == (2 if arrow else 3)
    assert axes.get_title().split("\n")[1].startswith(f"{arrow}R-1: ≤ {limit:g}")
