"""How what is required is distributed over the draws of a campaign."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drakesep.analysis.campaigns.flights import FlownDraws
from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.analysis.campaigns.shares import ShareFinding, nearest_of_draws
from drakesep.plots.limits import LIMIT, limit_words
from drakesep.plots.style import COLOURS, DASHES, save_plot, wrapped
from drakesep.systems.arrays import Array
from drakesep.units import unit_of


_ACROSS = 3
_CELL = 4.6
"""Width of a panel, in."""
_POINTS = 2000
"""Of a curve, at most."""
_RING: dict[str, Any] = {"marker": "o", "fillstyle": "none", "markersize": 9}


def save_campaign(
    findings: Sequence[ShareFinding],
    plan: CampaignPlan,
    flown: FlownDraws,
    folder: Path,
) -> None:
    """Write campaign.png into a folder."""
    save_plot(campaign_figure(findings, plan, flown), folder / "campaign.png")


def campaign_figure(
    findings: Sequence[ShareFinding],
    plan: CampaignPlan,
    flown: FlownDraws,
    *,
    most_across: int = _ACROSS,
    cell: float = _CELL,
) -> Figure:
    """Return which share of draws is beyond each value of what is required.

    A panel for each quantity and side of its limit, with a curve for each axis, that
    ends at the worst draw; where it crosses the limit, it tells the share beyond that.

    Args:
        findings: of each requirement.
        plan: of the campaign.
        flown: all draws.
        most_across: panels beside each other, at most.
        cell: width of a panel, in.
    """
    panels: dict[tuple[str, str, bool], list[ShareFinding]] = {}
    for one in findings:
        if one.beyond is not None:
            required = one.requirement
            key = required.pair, required.quantity[0], required.from_above
            panels.setdefault(key, []).append(one)
    across = min(len(panels), most_across)
    down = math.ceil(len(panels) / across)
    figure = Figure(figsize=(cell * across, 3.8 * down + 0.6), layout="constrained")
    grid = figure.subplots(down, across, squeeze=False)
    for axes, (key, mine) in zip(grid.flat, panels.items(), strict=False):
        pair, quantity, _ = key
        _draw(axes, mine, plan, flown)
        title = f"{quantity}{f', {pair}' if pair else ''}".replace("_", " ")
        axes.set_title(wrapped(title, cell - 1.0, 9), fontsize=9)
    for axes in grid.flat[len(panels) :]:
        axes.set_visible(False)
    title = (
        f"{plan.case.name}: share of {plan.runs} draws beyond a value; dashed: limit, "
        "ring: bound of the share that is required, dot: worst draw"
    )
    figure.suptitle(wrapped(title, cell * across - 0.2, 11), fontsize=11)
    return figure


def _draw(
    axes: Axes, findings: Sequence[ShareFinding], plan: CampaignPlan, flown: FlownDraws
) -> None:
    """Draw the findings on one side of one quantity."""
    unit = unit_of(findings[0].requirement.metric)
    for k, one in enumerate(findings):
        required, colour = one.requirement, COLOURS[k % len(COLOURS)]
        value, share = _beyond(_values(one, plan, flown), required.from_above)
        label = required.quantity[1] or None
        style: dict[str, Any] = {"color": colour, "ls": DASHES[k % len(DASHES)]}
        axes.plot(unit.from_si(1.0) * value, share, label=label, **style)
        if len(value):
            last = unit.from_si(float(value[-1])), float(share[-1])
            axes.plot(*last, marker="o", color=colour, markersize=5)
        if math.isfinite(one.bound):
            rank = (one.size.rank or 1) / plan.runs
            bound = unit.from_si(one.bound), rank
            axes.plot(*bound, color=colour, **_RING)
    several = len({one.requirement.limit for one in findings}) > 1
    for k, one in enumerate(findings):
        colour = COLOURS[k % len(COLOURS)] if several else LIMIT["color"]
        axes.axvline(
            unit.from_si(one.requirement.limit),
            **LIMIT | {"color": colour},
            label=limit_words(one.requirement) if several or not k else None,
        )
    for required_share in {one.size.share for one in findings}:
        axes.axhline(
            1.0 - required_share, color="#555555", linestyle=":", linewidth=1.0
        )
    axes.set_yscale("log")
    axes.set_ylim(0.5 / plan.runs, 1.3)
    if not findings[0].requirement.from_above:
        axes.invert_xaxis()  # worse is to the right
    axes.set_xlabel(unit.symbol)
    axes.set_ylabel("share of draws beyond", fontsize=8)
    axes.grid(alpha=0.3)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(
            **{"loc": "upper center", "bbox_to_anchor": (0.5, -0.16), "ncols": 2},
            **{"fontsize": 7, "frameon": False, "handlelength": 3.5},
        )


def _values(finding: ShareFinding, plan: CampaignPlan, flown: FlownDraws) -> Array:
    """Return (N,) what all draws tell of a requirement.

    Of a clearance as far as it is known: infinite of draws that come after those.
    """
    required = finding.requirement
    if required.metric not in plan.clearances or flown.clearances is None:
        return flown.metrics[:, plan.metrics.index(required.judged_by)]
    nearest = nearest_of_draws(plan, required, flown.clearances)
    known = nearest.measured & (nearest.at_least <= nearest.known_to)
    values: Array = np.where(np.isnan(nearest.values) | known, nearest.values, np.inf)
    return values


def _beyond(values: Array, from_above: bool) -> tuple[Array, Array]:
    """Return values in order, to the worst, and the share of draws as bad or worse.

    Runs that failed are beyond every value.
    """
    told = np.sort(values[~np.isnan(values)])
    told = told if from_above else told[::-1]
    share = (len(values) - np.arange(len(told))) / len(values)
    told, share = told[np.isfinite(told)], share[np.isfinite(told)]
    if len(told) > _POINTS:  # dense where few are left
        steps = np.geomspace(1, len(told), _POINTS).round().astype(int)
        kept = len(told) - np.unique(steps)[::-1]
        told, share = told[kept], share[kept]
    return told, share
