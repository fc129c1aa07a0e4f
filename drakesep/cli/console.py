"""What the command line prints: tables, verdicts."""

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import pandas as pd
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from drakesep.case_file.case import Case
from drakesep.cli.requirement_lines import requirement_lines
from drakesep.systems.checks import X_AXIS
from drakesep.systems.equations.springs import law_name
from drakesep.systems.model.orbit import EARTH_RADIUS, Orbit
from drakesep.systems.model.parameters import ParameterName, parameters
from drakesep.systems.model.parts import Cone, Shape
from drakesep.systems.model.separation import Pair
from drakesep.tables.columns import distribution_text, tolerance_text
from drakesep.tables.failure_tables import changed_text
from drakesep.tables.requirement_tables import limits_table
from drakesep.units import unit_of, with_unit


_FIRST_WIDTH, _OTHER_WIDTH = 32, 14
"""Of the columns of a table, about."""


def print_frame(
    console: Console,
    title: str,
    frame: pd.DataFrame,
    digits: int = 5,
    *,
    index: int = 1,
    whole: bool = False,
) -> None:
    """Print a table; numbers to so many significant digits.

    A wide table goes out in parts, each with the first columns, as many as `index`;
    unless it is to stay whole, and fold what has no room in its cells.
    """
    if whole:
        console.print(_table(escape(title), frame, digits))
        return
    first, columns = list(frame.columns[:index]), list(frame.columns[index:])
    room = (console.width - _FIRST_WIDTH) // _OTHER_WIDTH - (index - 1)
    others = max(1, min(len(columns), room))
    for start in range(0, len(columns), others):
        part = frame[[*first, *columns[start : start + others]]]
        console.print(_table("" if start else escape(title), part, digits))


def _table(title: str, frame: pd.DataFrame, digits: int) -> Table:
    table = Table(title=title, title_justify="left", title_style="bold")
    for name in frame.columns:
        number = pd.api.types.is_numeric_dtype(frame[name])
        table.add_column(
            escape(str(name)), justify="right" if number else "left", overflow="fold"
        )
    for row in frame.itertuples(index=False):
        table.add_row(*(_cell(value, digits) for value in row))
    return table


def _cell(value: Any, digits: int) -> str:
    if pd.isna(value):
        return ""
    if isinstance(value, float) and math.isinf(value):
        return "none found"  # such as a growth that violates anything
    if isinstance(value, float):
        return f"{value + 0.0:.{digits}g}"  # -0.0 is 0
    wrong = ("not met", "not shown", "not looked at")
    styles = {"met": "[green]met[/]"} | {w: f"[bold red]{w}[/]" for w in wrong}
    return styles.get(str(value), escape(str(value)))


def print_cases(console: Console, cases: Iterable[Case]) -> None:
    """Print the names and descriptions of cases."""
    table = Table("case", "description")
    for case in cases:
        table.add_row(case.name, escape(case.description))
    console.print(table)


def print_case(console: Console, case: Case) -> None:
    """Print a case: bodies, attachments, dispersions, requirements."""
    console.print(f"{case.name}: {case.description}", markup=False)
    before = case.separation.initial
    attitude, rate = (
        [float(f"{math.degrees(x):.9g}") for x in each]
        for each in (before.rpy_WA, before.w_WA_A)
    )
    leave = "; ".join(map(_leaving, case.separation.pairs))
    console.print(
        f"{leave}; orbit: {_orbit(case.separation.orbit)}; before separation: "
        f"attitude {attitude} deg, rate {rate} deg/s; run: {case.run.duration_s:g} s "
        f"with {case.run.integrator} at accuracy {case.run.accuracy:g}",
        markup=False,
    )
    print_frame(console, "Bodies", _bodies(case))
    print_frame(console, "Attachments", _attachments(case))
    if any(body.parts for body in case.separation.bodies):
        print_frame(console, "Geometry", _geometry(case))
    if case.loads:
        print_frame(console, "Loads", _loads(case))
    if case.dispersions:
        print_frame(console, "Dispersed parameters", _dispersed(case))
    print_frame(console, "Other parameters, by what they are of", _others(case))
    for section in case.ellipsoids:
        related = "correlated" if section.correlation else "uncorrelated"
        names = ", ".join(section.parameters)
        console.print(f"In an ellipsoid, {related}: {names}", markup=False)
    for correlation in case.in_si().correlations:
        names = ", ".join(map(with_unit, correlation.names))
        of_rank = f"Of rank correlation {correlation.rank:g} in a campaign"
        console.print(f"{of_rank}: {names}", markup=False)
    if case.limits:
        bodies = [pair.B for pair in case.separation.pairs]
        lines = requirement_lines(limits_table(case.limits, bodies), bodies)
        print_frame(console, "Requirements", lines, whole=True)
    if failures := case.in_si().failure_cases:
        rows = [{"name": f.name, "changed": changed_text(f.values)} for f in failures]
        frame = pd.DataFrame(rows)
        if likely := case.in_si().failure_probabilities:
            frame["in a launch"] = [likely.get(f.name) for f in failures]
        title = "Failure cases, which `verify --failures` looks at"
        print_frame(console, title, frame, whole=True)


def print_notes(console: Console, notes: Iterable[str]) -> None:
    """Print what should be known, a line each."""
    for note in notes:
        console.print(f"Note: {note}", markup=False)


def _orbit(orbit: Orbit | None) -> str:
    if orbit is None:
        return "none"
    altitude = (orbit.radius - EARTH_RADIUS) / 1000.0
    if orbit.horizontal_speed is None:
        return f"circular, {altitude:g} km"
    return f"eccentricity {orbit.eccentricity:.6g}, at {altitude:.6g} km"


def _leaving(pair: Pair) -> str:
    text = f"{pair.B} leaves {pair.A}"
    if pair.direction == X_AXIS:
        return text
    return f"{text} along [{', '.join(f'{x:g}' for x in pair.direction)}]"


def _bodies(case: Case) -> pd.DataFrame:
    return pd.DataFrame(
        {
            "body": body.name,
            "mass (kg)": body.mass,
            "CG (mm)": _listed("cg", body.p_BoBcm_B),
            "moments xx yy zz (kg m²)": _listed("inertia", body.I_BBcm_B[:3]),
            "products xy xz yz (kg m²)": _listed("inertia", body.I_BBcm_B[3:]),
        }
        for body in case.separation.bodies
    )


def _attachments(case: Case) -> pd.DataFrame:
    rows = []
    for attachment in case.separation.attachments:
        spring = attachment.spring
        releases = []
        if math.isfinite(attachment.release_time):
            releases.append(f"{attachment.release_time:g} s")
        if math.isfinite(attachment.release_angle):
            releases.append(f"{math.degrees(attachment.release_angle):g} deg")
        if math.isfinite(attachment.release_travel):
            releases.append(f"{1e3 * attachment.release_travel:g} mm")
        rows.append(
            {
                "attachment": attachment.name,
                "from": attachment.A,
                "to": attachment.B,
                "position (mm)": _listed("position", attachment.p_AoPad_A),
                "joint": attachment.joint.type,
                "release": " or ".join(releases) or "never",
                "spring": spring.name if spring else "",
                "driven by": law_name(spring) if spring else "",
            }
        )
    return pd.DataFrame(rows)


def _geometry(case: Case) -> pd.DataFrame:
    """Return where parts are: a mesh in the wrong unit is seen at once."""
    from drakesep.systems.geometry.convex_pieces import (
        pieces_of,  # and Drake, where there are any
    )

    mm = unit_of("position")
    rows = []
    for body in case.separation.bodies:
        for part in body.parts:
            points = np.concatenate([piece.points for piece in pieces_of(part)])
            row = {
                "part": part.name,
                "of": body.name,
                "shape": _shape(part.shape),
                "role": part.role,
            }
            for axis, low, high in zip(
                "xyz", points.min(axis=0), points.max(axis=0), strict=True
            ):
                row[f"{axis} (mm)"] = f"{mm.from_si(low):.4g} to {mm.from_si(high):.4g}"
            rows.append(row)
    return pd.DataFrame(rows)


def _shape(shape: Shape) -> str:
    """Return what a shape is called in case files; whether it is hollow."""
    if not isinstance(shape, Cone):
        return type(shape).__name__.lower()
    name = "cylinder" if shape.radius_aft == shape.radius_fore else "cone"
    return name if shape.thickness is None else f"hollow {name}"


def _loads(case: Case) -> pd.DataFrame:
    return pd.DataFrame(
        {
            "load": load.name,
            "on": load.body,
            "position (mm)": _listed("position", load.p_BoQ_B),
            "axes": load.axes,
            "from (s)": load.start + load.times[0],
            "to (s)": load.start + load.times[-1],
            "after": load.after or "start",
            "largest force (N)": max(math.hypot(*force) for force in load.forces),
            "largest torque (N m)": max(math.hypot(*torque) for torque in load.torques),
        }
        for load in case.separation.loads
    )


def _listed(quantity: str, values: Iterable[float]) -> str:
    from_si = unit_of(quantity).from_si
    return " ".join(f"{from_si(value):.6g}" for value in values)


def _dispersed(case: Case) -> pd.DataFrame:
    return pd.DataFrame(
        {
            "parameter": with_unit(d.name),
            "value": unit_of(d.name).from_si(d.nominal),
            "tolerance": tolerance_text(d),
            "distribution": distribution_text(d),
        }
        for d in case.box.dispersions
    )


def _others(case: Case) -> pd.DataFrame:
    """Return what may be dispersed too, a row for each owner."""
    dispersed = set(case.box.names)
    owners: dict[str, dict[str, float]] = {}
    for name, value in parameters(case.separation).items():
        owner = ParameterName.of(name).owner
        mine = owners.setdefault(owner, {})
        if name not in dispersed:
            key = with_unit(name).removeprefix(f"{owner}.")
            mine[key] = unit_of(name).from_si(value)
    return pd.DataFrame(
        {
            "of": owner,
            "name and value": ", ".join(f"{k} {x:.5g}" for k, x in mine.items() if x),
            "that are 0": ", ".join(key for key, x in mine.items() if not x),
        }
        for owner, mine in owners.items()
        if mine
    )
