"""The space that parts of B sweep, as seen from A."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from drakesep.plots.outlines import fill, outlines
from drakesep.plots.style import COLOURS, columns_of_legend, save_plot, wrapped
from drakesep.systems.arrays import Array
from drakesep.systems.checks import Vector3
from drakesep.systems.geometry.bounding_tree import (
    Node,
    support_point,
    tree_of,
)
from drakesep.systems.geometry.relative_path import RelativePath
from drakesep.systems.model.part_pairs import Names
from drakesep.systems.model.parts import Part
from drakesep.systems.model.run import Run
from drakesep.systems.model.separation import Pair, Separation
from drakesep.units import unit_of


_MOMENTS = 40
"""At which what is swept is drawn."""
_VIEWS = (("x", 0, "z", 2), ("x", 0, "y", 1), ("y", 1, "z", 2))
_WIDTHS = (1.2, 1.2, 1.0)
_STAYS = "#5A5A5A"
_THROUGH = 0.3
"""How opaque a wall of A is, in front of what moves within it."""


def save_swept(run: Run, pairs: Sequence[Names], folder: Path) -> None:
    """Write swept.png into a folder, if parts of A and B are in the pairs.

    Those of other bodies that leave end with their names.
    """
    separation = run.separation
    for pair in separation.pairs:
        end = "" if pair.B == separation.B else f"_{pair.B}"
        if all(_in_pairs(separation, pair, pairs)):
            save_plot(swept_figure(run, pair, pairs), folder / f"swept{end}.png")


def _in_pairs(
    separation: Separation, pair: Pair, pairs: Sequence[Names]
) -> tuple[tuple[Part, ...], tuple[Part, ...]]:
    """Return the parts of A and of B of a pair that are measured to each other."""
    names = [
        {part.name for part in separation.body(body).parts} for body in (pair.A, pair.B)
    ]
    held = {n for ends in pairs if _joins(ends, *names) for n in ends}
    of_A, of_B = (
        tuple(part for part in separation.body(body).parts if part.name in held)
        for body in (pair.A, pair.B)
    )
    return of_A, of_B


def _joins(ends: Names, of_A: set[str], of_B: set[str]) -> bool:
    first, second = ends
    return (first in of_A and second in of_B) or (first in of_B and second in of_A)


def swept_figure(run: Run, pair: Pair, pairs: Sequence[Names]) -> Figure:
    """Return the space that parts of B sweep, as seen from A, along A's axes.

    From the mated place until no part of B is beside one of A any more.

    Args:
        run: a completed run.
        pair: whose B leaves.
        pairs: names of parts; those of A and B that are measured are drawn.
    """
    separation = run.separation
    on_A, on_B = _in_pairs(separation, pair, pairs)
    path = RelativePath(run.completed_trajectory, pair.A, pair.B)
    stays = [tree_of(part) for part in on_A]
    moves = {part.name: tree_of(part) for part in on_B}
    far = _until_clear(stays, list(moves.values()), path, pair.direction)
    clear = path.time_apart(far, pair.direction)
    times = np.linspace(0.0, min(clear, float(path.time[-1])), _MOMENTS)
    figure = Figure(figsize=(14, 4.4), layout="constrained")
    panels = figure.subplots(1, len(_VIEWS), width_ratios=_WIDTHS)
    for axes, (across, i, up, j) in zip(panels, _VIEWS, strict=True):
        colours = dict(zip(moves, COLOURS[1:] * len(moves), strict=False))
        for name, root in moves.items():
            drawn = [
                outline
                for t in times.tolist()
                for outline in outlines(root, (i, j), _place(path, t))
            ]
            fill(axes, drawn, _pale(colours[name]), 1)
        for root in stays:
            fill(axes, outlines(root, (i, j)), (_STAYS, _THROUGH), 2)
        for name, root in moves.items():
            for outline in outlines(root, (i, j), _place(path, 0.0)):
                mm = unit_of("position").per_si * outline[[*range(len(outline)), 0]]
                axes.plot(*mm.T, color=colours[name], linewidth=1.0, zorder=3)
        axes.set_aspect("equal")
        axes.autoscale_view()
        axes.set_xlabel(f"{across} (mm)")
        axes.set_ylabel(f"{up} (mm)")
        axes.grid(alpha=0.3)
    handles = [Patch(color=colours[name], label=name) for name in moves]
    handles.append(Patch(color=(_STAYS, _THROUGH), label=pair.A.replace("_", " ")))
    columns = columns_of_legend([str(each.get_label()) for each in handles], 13.0)
    figure.legend(
        handles=handles, loc="outside lower center", ncols=columns, frameon=False
    )
    title = f"What {pair.B} sweeps, as seen from {pair.A}; lines: at the start"
    figure.suptitle(wrapped(title, 13.5, 12))
    return figure


def _place(path: RelativePath, t: float) -> tuple[Array, Array]:
    pose = path.at(t)
    return pose.R_AB, pose.p_AoBo_A


def _until_clear(
    stays: Sequence[Node],
    moves: Sequence[Node],
    path: RelativePath,
    direction: Vector3,
) -> float:
    """Return how far B must move in its direction to be beyond A's parts, m."""
    x = np.array(direction)
    R, p = _place(path, 0.0)
    front = max(float(support_point(n, x) @ x) for root in stays for n in root.leaves)
    back = min(
        float((R @ support_point(n, -R.T @ x) + p) @ x)
        for root in moves
        for n in root.leaves
    )
    return max(front - back, 1e-3)


def _pale(colour: str) -> tuple[float, ...]:
    part = np.array([int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5)])
    return tuple((0.35 * part + 0.65).tolist())
