"""The mated stack as its case describes it: parts, attachments, centres of mass."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from scipy.spatial.transform import Rotation

from drakesep.plots.outlines import fill, outlines
from drakesep.plots.style import columns_of_legend
from drakesep.systems.arrays import Array
from drakesep.systems.equations.motion_of_run import mated_trajectory
from drakesep.systems.geometry.bounding_tree import tree_of
from drakesep.systems.model.separation import Body, Separation
from drakesep.units import unit_of


_VIEWS = (("x", 0, "z", 2), ("x", 0, "y", 1))
_SHADES = ("#D5D5D5", "#FFFFFF", "#A9A9A9", "#EDEDED")
_HATCHES = ("", "", "////", "....")
"""Bodies are told apart in grey, too."""
_PAD: dict[str, Any] = {
    "marker": "^",
    "ms": 5,
    "mfc": "black",
    "mec": "white",
    "ls": "none",
}
_CG: dict[str, Any] = {
    "marker": "o",
    "ms": 6,
    "mfc": "white",
    "mec": "black",
    "ls": "none",
}
_CROSS: dict[str, Any] = {"marker": "+", "ms": 6, "color": "black", "ls": "none"}


def stack_figure(separation: Separation) -> Figure:
    """Return the mated stack in A's frame, seen along y and along z."""
    places = _places(separation)
    figure = Figure(figsize=(7.0, 3.0), layout="constrained")
    panels = figure.subplots(1, len(_VIEWS))
    for axes, (across, i, up, j) in zip(panels, _VIEWS, strict=True):
        for k, body in enumerate(separation.bodies):
            _draw(axes, body, k, places[body.name], (i, j))
        _mark(axes, separation, places, (i, j))
        axes.set_aspect("equal", adjustable="datalim")
        axes.autoscale_view()
        axes.set_xlabel(f"{across} (mm)", fontsize=8)
        axes.set_ylabel(f"{up} (mm)", fontsize=8)
        axes.tick_params(labelsize=7)
        axes.grid(alpha=0.3)
        axes.set_axisbelow(True)
    _legend(figure, separation)
    return figure


def _places(separation: Separation) -> dict[str, tuple[Array, Array]]:
    """Return R_AB and p_AoBo_A of each body while mated."""
    mated = mated_trajectory(separation)
    states = {name: mated.of(name)[0] for name in mated.names}
    R_WA, p_WA = _place(states[separation.A])
    places = {name: _place(state) for name, state in states.items()}
    return {name: (R_WA.T @ R, R_WA.T @ (p - p_WA)) for name, (R, p) in places.items()}


def _place(state: Array) -> tuple[Array, Array]:
    rotation = Rotation.from_quat(state[:4], scalar_first=True)
    return rotation.as_matrix(), state[4:7]


def _draw(
    axes: Axes, body: Body, k: int, place: tuple[Array, Array], view: tuple[int, int]
) -> None:
    for part in body.parts:
        drawn = outlines(tree_of(part), view, place)
        style = {"edgecolor": "#333333", "linewidth": 0.6, **_hatched(k)}
        fill(axes, drawn, _SHADES[k % len(_SHADES)], 2 + k, **style)


def _hatched(k: int) -> dict[str, Any]:
    return {"hatch": _HATCHES[k % len(_HATCHES)]}


def _mark(
    axes: Axes,
    separation: Separation,
    places: dict[str, tuple[Array, Array]],
    view: tuple[int, int],
) -> None:
    """Mark where bodies are attached, and their centres of mass."""
    above = 3 + len(separation.bodies)
    mm = unit_of("position").per_si
    for attachment in separation.attachments:
        R, p = places[attachment.A]
        pad = mm * (R @ np.array(attachment.p_AoPad_A) + p)
        axes.plot(pad[view[0]], pad[view[1]], zorder=above, **_PAD)
    for body in separation.bodies:
        R, p = places[body.name]
        cg = mm * (R @ np.array(body.p_BoBcm_B) + p)
        for style in (_CG, _CROSS):
            axes.plot(cg[view[0]], cg[view[1]], zorder=above + 1, **style)
        axes.annotate(
            body.name.replace("_", " "),
            (cg[view[0]], cg[view[1]]),
            xytext=(0.0, 7.0),
            textcoords="offset points",
            ha="center",
            fontsize=7,
            zorder=above + 2,
            annotation_clip=False,
        )


def _legend(figure: Figure, separation: Separation) -> None:
    handles: list[Patch | Line2D] = [
        Patch(
            facecolor=_SHADES[k % len(_SHADES)],
            edgecolor="#333333",
            label=body.name.replace("_", " "),
            **_hatched(k),
        )
        for k, body in enumerate(separation.bodies)
        if body.parts
    ]
    handles += [
        Line2D([], [], label="attachment", **_PAD),
        Line2D([], [], label="centre of mass", **_CG),
    ]
    columns = columns_of_legend([str(h.get_label()) for h in handles], 6.8, 8)
    figure.legend(
        handles=handles,
        loc="outside lower center",
        ncols=columns,
        frameon=False,
        fontsize=8,
    )
