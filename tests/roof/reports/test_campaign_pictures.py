"""Pictures of a campaign with much that is required: none is higher than a page."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from drakesep.analysis.metrics.requirements import Requirement
from drakesep.plots.campaign_points import Against, Scatter
from drakesep.reports import campaign_pictures, pictures


MANY = 7


@pytest.fixture
def heights(monkeypatch):
    """Heights of the figures that a report draws, in."""
    drawn = []
    monkeypatch.setattr(
        campaign_pictures,
        "picture_of",
        lambda figure, *_: drawn.append((figure.get_figheight(), len(figure.axes))),
    )
    return drawn


def test_points(heights):
    draws = np.linspace(0.0, 1.0, 5)
    limit = Requirement(metric="rate_after_separation_y", sense="<=", limit=2.0)
    over = tuple(
        Against(parameter=name, values=draws, deciding=0.5, correlation=0.1)
        for name in ("payload.cg_y", "payload.cg_z")
    )
    each = Scatter(requirement=limit, values=draws, deciding=1.0, over=over)
    plan = SimpleNamespace(case=SimpleNamespace(name="mine"))
    [*campaign_pictures._points(plan, [each] * MANY)]
    fit_all(heights, 2 * MANY)


def test_convergence(heights, tmp_path):
    row = {"axis": "y", "pair": "", "sense": "<=", "unit": "deg/s", "limit": 1.0}
    row |= {"quantile": 0.5, "quantile_from": 0.4, "quantile_to": 0.6}
    row |= {"quantile_of": 0.99, "draws": 10}
    rows = [row | {"requirement": f"rate {k}"} for k in range(3 * MANY)]
    results = SimpleNamespace(table=lambda _: pd.DataFrame(rows))
    [*campaign_pictures._convergence(SimpleNamespace(results=results))]
    fit_all(heights, 3 * MANY)


def fit_all(heights, panels):
    assert len(heights) > 1
    assert max(height for height, _ in heights) <= pictures.HEIGHT
    shown = sum(number for _, number in heights)
    assert shown in (panels, panels + 1)  # of an odd number one stays empty
