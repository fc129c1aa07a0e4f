"""The picture of convergence shows the numbers of its table."""

import numpy as np
import pandas as pd

from drakesep.plots.campaign_convergence import convergence_figure


DRAWS = [10, 100, 1000]


def table(limit, axis="y"):
    return pd.DataFrame(
        {
            **{"requirement": "final rate", "axis": axis, "pair": "", "sense": "<="},
            **{"limit": limit, "unit": "deg/s", "quantile_of": 0.99, "draws": DRAWS},
            **{"quantile": [1.0, 1.2, 1.1], "quantile_from": [0.9, 1.0, 1.05]},
            "quantile_to": [np.inf, 1.4, 1.2],
        }
    )


def test_curve_and_interval_are_those_of_the_table():
    rows = pd.concat([table(1.5), table(1.5, "z")])
    figure = convergence_figure(rows, across=2, cell=3.5)
    assert [axes.get_title().split("\n")[0] for axes in figure.axes] == [
        *("final rate y", "final rate z"),
    ]
    for axes in figure.axes:
        limit, curve = axes.get_lines()
        assert [*curve.get_xdata()] == DRAWS
        assert [*curve.get_ydata()] == [1.0, 1.2, 1.1]
        assert [*limit.get_ydata()] == [1.5, 1.5]
        [band] = axes.collections
        ends = band.get_paths()[0].vertices
        assert {*ends[ends[:, 0] == 1000, 1]} == {1.05, 1.2}
        assert np.isfinite(ends).all()  # of ten draws it has no end


def test_a_limit_far_away_is_only_told():
    """Values span 0.5: beyond twice that above 1.4 a line would hide them."""
    [axes] = convergence_figure(table(9.0), across=2, cell=3.5).axes
    assert len(axes.get_lines()) == 1
    assert axes.get_title().split("\n")[1] == "↑ ≤ 9 deg/s; 99 % of launches"


def test_draws_that_tell_nothing_are_said_so():
    nothing = table(1.5).assign(quantile=np.nan, quantile_from=np.nan)
    [axes] = convergence_figure(
        nothing.assign(quantile_to=np.nan), across=2, cell=3.5
    ).axes
    assert [text.get_text() for text in axes.texts] == ["no draw tells"]
