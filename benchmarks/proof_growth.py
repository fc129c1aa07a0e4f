"""How proofs grow: gaps and processor time over tolerances, parameters and springs.

VEGA's rates and speed after separation are bounded, with so many boxes at most that a
bound takes half a minute of a processor: boxes, unlike seconds, are the same on any
machine. Tolerances are scaled; parameters are taken out, or the launch vehicle's put
in, as large relative to what they are of as the payload's; more springs share the push
of four on the same circle. Prints a table and draws docs/proof_growth.png.

    python benchmarks/proof_growth.py [BOXES]
"""

import dataclasses
import math
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullLocator

from drakesep import load_case
from drakesep.analysis import ToleranceBox
from drakesep.analysis.bounds.branch_and_bound import Effort, Prover
from drakesep.analysis.bounds.claims import Side, claim_of
from drakesep.analysis.bounds.grid import make_grid
from drakesep.analysis.bounds.problem import problem_of
from drakesep.analysis.bounds.proving import ProofSettings
from drakesep.analysis.tolerances.sides import Sides
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.separation import Separation


PICTURE = Path(__file__).parents[1] / "docs" / "proof_growth.png"
GAP, BOXES = 0.005, 256
"""At which a bound is good enough, and how many boxes are spent on it at most."""
RATE, SPEED = "rate_after_separation", "longitudinal_speed_after_separation"
CLAIMS: Mapping[str, tuple[str, Side]] = {
    **{f"rate about {axis}": (f"{RATE}_{axis}", "highest") for axis in "xyz"},
    "longitudinal speed": (SPEED, "lowest"),
}
STYLES = dict(
    zip(
        CLAIMS,
        (("#0072B2", "o"), ("#E69F00", "s"), ("#009E73", "^"), ("#555555", "D")),
        strict=True,
    )
)
VEGA = load_case("vega").in_si()
TOLERANCES = {name: Sides.of(size).larger for name, size in VEGA.tolerances.items()}


class Point(NamedTuple):
    """A separation with its box, and where it stands in a panel."""

    panel: str
    at: float
    separation: Separation
    box: ToleranceBox


def points() -> Iterator[Point]:
    """Yield what is proven, panel by panel."""
    separation = VEGA.separation
    for scale in (0.5, 1.0, 1.5, 2.0):
        # Twice as large, an inertia alone is none that a body can have: bounds hold for
        # all of the box, whatever can exist in it.
        box = VEGA.box.grown(scale)
        yield Point("tolerances, times VEGA's", scale, separation, box)
    for chosen in of_more_and_more(separation):
        box = ToleranceBox.around(separation, chosen)
        yield Point("parameters", len(box), separation, box)
    for count in (4, 6, 8):
        several, tolerances = with_springs(separation, count)
        box = ToleranceBox.around(several, tolerances)
        yield Point("springs", count, several, box)


def of_more_and_more(separation: Separation) -> Iterator[dict[str, float]]:
    """Yield tolerances: mass and CG, with inertias, with springs, of both bodies."""
    payload = {n: size for n, size in TOLERANCES.items() if n.startswith("payload.")}
    yield {n: size for n, size in payload.items() if "inertia" not in n}
    yield payload
    yield TOLERANCES
    nominal = parameters(separation)
    other = {}
    for name, size in payload.items():
        mine = name.replace("payload.", "launch_vehicle.")
        of = "inertia_" + name[-2] * 2 if "inertia" in name else "mass"
        share = nominal[f"launch_vehicle.{of}"] / nominal[f"payload.{of}"]
        other[mine] = size if "cg" in name else size * share
    yield {**TOLERANCES, **other}


def with_springs(
    separation: Separation, count: int
) -> tuple[Separation, dict[str, float]]:
    """Return VEGA with as many springs, evenly on the circle of four.

    They share its forces and its masses, so that strokes end when they do; tolerances
    of forces are as large relative to these.
    """
    first, share = separation.attachments[0], 4.0 / count
    assert first.spring is not None
    _, y, z = first.p_AoPad_A
    radius, tolerances = math.hypot(y, z), dict(TOLERANCES)
    attachments = []
    for i in range(count):
        angle = math.atan2(z, y) + 2.0 * math.pi * i / count
        spring = dataclasses.replace(
            first.spring,
            name=f"spring_{i + 1}",
            force_max=share * first.spring.force_max,
            design_mass=share * first.spring.design_mass,
        )
        attachments.append(
            dataclasses.replace(
                first,
                name=f"attachment_{i + 1}",
                p_AoPad_A=(0.0, radius * math.cos(angle), radius * math.sin(angle)),
                spring=spring,
            )
        )
        tolerances[f"spring_{i + 1}.force_max"] = (
            share * TOLERANCES["spring_1.force_max"]
        )
        tolerances[f"spring_{i + 1}.stroke"] = TOLERANCES["spring_1.stroke"]
    return dataclasses.replace(separation, attachments=tuple(attachments)), tolerances


def proven(point: Point, boxes: int) -> Iterator[dict[str, object]]:
    """Yield what comes of each claim."""
    separation, box = point.separation, point.box
    problem, settings = problem_of(separation, box), ProofSettings()
    grid = make_grid(problem, settings.push, settings.coast)
    prover = Prover(problem, grid)
    for name, (metric, side) in CLAIMS.items():
        claim = claim_of(separation, problem, grid, metric, side)
        began = time.process_time()
        proof = prover.prove(claim.quantity, Effort(gap=GAP, boxes=boxes))
        yield {
            "panel": point.panel,
            "at": point.at,
            "parameters": len(box),
            "claim": name,
            "gap %": 100.0 * (proof.bound - proof.found) / abs(proof.found),
            "CPU s": time.process_time() - began,
            "boxes": proof.boxes,
            "finished": proof.finished,
        }


def draw(table: pd.DataFrame, path: Path, boxes: int) -> None:
    """Draw gaps above processor time, a column for each thing that grows."""
    panels = list(dict.fromkeys(table["panel"]))
    rows = ("gap %", "CPU s")
    figure = Figure(figsize=(11, 6.4), layout="constrained")
    grid = figure.subplots(2, len(panels), sharex="col", sharey="row")
    for axes_of_row, column in zip(grid, rows, strict=True):
        for axes, panel in zip(axes_of_row, panels, strict=True):
            axes.set_yscale("log")
            axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axes.yaxis.set_major_formatter("{x:g}")
            axes.yaxis.set_minor_locator(NullLocator())
            _curves(axes, table[table["panel"] == panel], column)
    for axes in grid[0]:
        axes.axhline(100.0 * GAP, color="#888888", linestyle=":", zorder=0)
    grid[0, 0].set_ylabel("gap, % of what is attained")
    grid[1, 0].set_ylabel("processor time of a bound, s")
    for axes, panel in zip(grid[1], panels, strict=True):
        axes.set_xlabel(panel)
        axes.set_xticks(sorted(set(table.loc[table["panel"] == panel, "at"])))
        axes.xaxis.set_major_formatter("{x:g}")
    _legend(figure, boxes)
    figure.suptitle("What VEGA's bounds cost, and how near they are, as the case grows")
    figure.savefig(path, dpi=110)


def _curves(axes: Axes, rows: pd.DataFrame, column: str) -> None:
    for name, (colour, marker) in STYLES.items():
        mine = rows[rows["claim"] == name].sort_values("at")
        axes.plot(mine["at"], mine[column], color=colour, linewidth=1.3)
        for done, some in mine.groupby("finished"):
            face = colour if done else "white"
            axes.plot(
                some["at"], some[column], marker, color=colour, markerfacecolor=face
            )
    axes.grid(visible=True, alpha=0.25)


def _legend(figure: Figure, boxes: int) -> None:
    def mark(colour: str, marker: str, label: str, **more: str) -> Line2D:
        return Line2D([], [], color=colour, marker=marker, label=label, **more)

    handles = [mark(*style, name) for name, style in STYLES.items()]
    handles += [
        mark(
            "black",
            "o",
            f"all is shown: {100 * GAP:g} % (dotted), or what pieces of time allow",
            linestyle="",
        ),
        mark(
            "black",
            "o",
            f"stopped after {boxes} boxes",
            linestyle="",
            markerfacecolor="white",
        ),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False)


def main(arguments: Sequence[str], tell: Callable[[str], None] = print) -> None:
    """Prove, print and draw."""
    boxes = int(arguments[0]) if arguments else BOXES
    rows = []
    for point in points():
        for row in proven(point, boxes):
            rows.append(row)
            gap, seconds = row["gap %"], row["CPU s"]
            told = f"{row['claim']} {gap:.2f} %, {seconds:.1f} s"
            tell(f"{point.panel} {point.at:g}: {told}")
    table = pd.DataFrame(rows)
    tell(table.round(3).to_string(index=False))
    draw(table, PICTURE, boxes)


if __name__ == "__main__":
    main(sys.argv[1:])
