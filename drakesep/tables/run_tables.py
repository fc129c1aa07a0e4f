"""Tables of runs, as pandas frames whose columns carry their units."""

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from drakesep.analysis.clearance.objective import LOWEST
from drakesep.analysis.clearance.of_pair import Clearance
from drakesep.analysis.metrics.objectives import OBJECTIVES, Objective
from drakesep.analysis.metrics.of_run import ANGLES, AXES
from drakesep.analysis.metrics.requirements import Finding, Requirement
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.systems.checks import InputError, unknown
from drakesep.systems.model.parameters import ParameterName, parameters
from drakesep.systems.model.run import Motion, Run
from drakesep.tables.labelled_run import LabelledRun
from drakesep.units import SI, Unit, split_axis, unit_of, with_unit


if TYPE_CHECKING:  # JAX comes with them
    from drakesep.analysis.margins.tolerance_margins import Growth
    from drakesep.analysis.search.sqp import Iteration


def unit_of_objective(objective: Objective) -> Unit:
    """Return the unit of an objective: of its metric, or SI."""
    return SI if objective.metric is None else unit_of(objective.metric)


def shown(objective: Objective, value: float) -> float:
    """Return the value of an objective as tables show it: its metric, in its unit."""
    return objective.sign * unit_of_objective(objective).from_si(value)


def write_csv(frame: pd.DataFrame, path: Path) -> None:
    """Write a table; its floats are written to read back exactly."""
    frame.to_csv(path, index=False)


_MOTION = {
    "rate": AXES,
    "relative_rate": AXES,
    "angle": ANGLES,
    "relative_position": AXES,
    "relative_velocity": AXES,
    "acceleration": AXES,
    "linear_momentum_change": AXES,
    "angular_momentum_change": AXES,
}


def motion_table(motion: Motion) -> pd.DataFrame:
    """Return the motion over time: a row for each sample."""
    columns = {with_unit("time"): motion.time}
    for quantity, axes in _MOTION.items():
        for i, axis in enumerate(axes):
            name = f"{quantity}_{axis}"
            samples = getattr(motion, quantity)[:, i]
            columns[with_unit(name)] = samples * unit_of(name).per_si
    return pd.DataFrame(columns)


_CONTACT = ("contact_time", "contact_end", "force_max", "impulse")


def contacts_table(run: Run) -> pd.DataFrame:
    """Return a row for each contact of parts that push each other, in its order."""
    rows = []
    for contact in run.contacts:
        force = np.linalg.norm(contact.force, axis=1)
        ends = np.flatnonzero(force == 0.0)
        for part in np.split(np.arange(len(force)), ends):
            mine = part[force[part] > 0.0]
            if not len(mine):
                continue
            whole = np.arange(max(mine[0] - 1, 0), min(mine[-1] + 2, len(force)))
            impulse = np.trapezoid(contact.force[whole], contact.time[whole], axis=0)
            rows.append(
                {
                    "first": contact.first,
                    "second": contact.second,
                    **in_units(
                        {
                            "contact_time": contact.time[mine[0]],
                            "contact_end": contact.time[whole[-1]],
                            "force_max": float(force[mine].max()),
                            "impulse": float(np.linalg.norm(impulse)),
                        }
                    ),
                }
            )
    columns = ["first", "second", *map(with_unit, _CONTACT)]
    frame = pd.DataFrame(rows, columns=columns)
    return frame.sort_values(columns[2], ignore_index=True)


def contact_forces_table(run: Run) -> pd.DataFrame:
    """Return the forces between parts that touch again: a row for each step."""
    frames = [
        pd.DataFrame(
            {
                with_unit("time"): contact.time,
                "first": contact.first,
                "second": contact.second,
                with_unit("force"): np.linalg.norm(contact.force, axis=1),
                **{
                    with_unit(f"force_{axis}"): contact.force[:, i]
                    for i, axis in enumerate(AXES)
                },
            }
        )
        for contact in run.contacts
    ]
    if not frames:
        forces = ("force", *(f"force_{axis}" for axis in AXES))
        names = [with_unit("time"), "first", "second", *map(with_unit, forces)]
        return pd.DataFrame(columns=names)
    return pd.concat(frames, ignore_index=True)


def runs_table(runs: Iterable[LabelledRun], names: Sequence[str]) -> pd.DataFrame:
    """Return a row for each run: parameters, metrics, and how it was found.

    Args:
        runs: the runs.
        names: the parameters to show.
    """
    rows = []
    for labelled in runs:
        values = parameters(labelled.run.separation)
        rows.append(
            {
                "label": labelled.label,
                **in_units({name: values[name] for name in names}),
                **in_units(labelled.metrics),
                **_nearest_pair(labelled.nearest),
                "iterations": labelled.iterations,
                "evaluations": labelled.evaluations,
                "status": labelled.status,
            }
        )
    frame = pd.DataFrame(rows)
    last = ["iterations", "evaluations", "status"]
    frame = frame[[column for column in frame if column not in last] + last]
    return frame.astype({"iterations": "Int64", "evaluations": "Int64"})


def _nearest_pair(nearest: Clearance | None) -> dict[str, object]:
    """Return which parts come nearest in a run, and when, if that was asked for."""
    if nearest is None:
        return {}
    pair = f"{nearest.first} to {nearest.second}"
    return {"nearest": pair, **in_units({"nearest_time": nearest.time})}


def read_runs(
    file: str | Path, labels: Sequence[str] | None = None
) -> dict[str, dict[str, float]]:
    """Return parameter values of runs by their labels, from a study's worst_cases.csv.

    Args:
        file: the table.
        labels: of the runs; if None the worst cases of the paper's objectives and of
            the clearance, or all worst cases if there are none of these.

    Raises:
        ValueError: it is no such table, or has no such run.
    """
    try:
        frame = pd.read_csv(file)
    except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeError) as error:
        raise InputError(f"{file}: must be a table of runs, got: {error}") from error
    if "label" not in frame:
        raise InputError(f"{file}: must be a table of runs with a column label")
    known = frame["label"].astype(str).tolist()
    worst = [label for label in known if label.startswith("worst_")]
    shown = [f"worst_{name}" for name in (*OBJECTIVES, LOWEST)]
    wanted = labels or [label for label in worst if label in shown] or worst
    for label in wanted:
        if label not in known:
            raise InputError(f"{file}: {unknown('run', label, known)}")
    parameters_ = [str(name) for name in frame if "." in str(name)]
    rows = frame.set_index("label")[parameters_]
    return {
        label: dict(zip(parameters_, map(float, rows.loc[label]), strict=True))
        for label in wanted
    }


def metrics_table(labelled: LabelledRun) -> pd.DataFrame:
    """Return a row for each metric of one run."""
    return pd.DataFrame(
        {
            "metric": name,
            "value": unit_of(name).from_si(value),
            "unit": unit_of(name).symbol,
        }
        for name, value in labelled.metrics.items()
    )


def history_table(
    iterations: "Mapping[Objective, Sequence[Iteration]]", box: ToleranceBox
) -> pd.DataFrame:
    """Return a row for each iterate of each search, by objective."""
    rows = []
    for objective, history in iterations.items():
        for iteration in history:
            rows.append(
                {
                    "objective": objective.name,
                    "iteration": iteration.number,
                    "value": shown(objective, iteration.value),
                    "unit": unit_of_objective(objective).symbol,
                    "evaluations": iteration.evaluations,
                    **in_units(box.values(iteration.u)),
                }
            )
    return pd.DataFrame(rows)


def comparison_table(runs: Sequence[LabelledRun]) -> pd.DataFrame:
    """Return, for each objective of the paper, its values: nominal, published, worst.

    SQP is the paper's method; the worst is that of all runs. Increases are percentages
    of the nominal and of the published magnitude.
    """
    flown = [labelled for labelled in runs if labelled.metrics]
    searched = {labelled.objective for labelled in flown}
    rows = []
    for objective in [name for name in OBJECTIVES if name in searched]:
        name = f"G_{objective}"
        unit = unit_of(name)
        values = {labelled.label: labelled.metrics[name] for labelled in flown}
        published = [
            values[labelled.label]
            for labelled in flown
            if labelled.published and objective in labelled.published.objectives
        ]
        # Of runs as bad, the one that bears the name.
        label = max(
            values, key=lambda label: (values[label], label.startswith("worst_"))
        )
        nominal, worst = flown[0].metrics[name], values[label]
        reference = max(published, default=math.nan)
        rows.append(
            {
                "objective": name,
                "unit": unit.symbol,
                "nominal": unit.from_si(nominal),
                "published": unit.from_si(reference),
                "sqp": unit.from_si(values.get(f"sqp_{objective}", math.nan)),
                "worst": unit.from_si(worst),
                "which_run": label,
                "above_nominal_percent": _increase(nominal, worst),
                "above_published_percent": _increase(reference, worst),
            }
        )
    return pd.DataFrame(rows)


_ROUND_OFF = 1e-12
"""A reference below this part of a value is zero but for round-off."""


def _increase(reference: float, value: float) -> float:
    if abs(reference) <= _ROUND_OFF * abs(value):
        return math.nan
    return 100.0 * (value - reference) / abs(reference)


def requirements_table(
    findings: Sequence[Finding],
    growths: "Sequence[tuple[Requirement, Growth]]" = (),
    single_growths: "Sequence[tuple[Requirement, Growth]]" = (),
    box: ToleranceBox | None = None,
) -> pd.DataFrame:
    """Return a row for each requirement and axis, with its margins and verdict.

    Args:
        findings: of each requirement.
        growths: of all tolerances together.
        single_growths: of single tolerances.
        box: the tolerances, if they grow.
    """
    of_all = dict(growths)
    rows = []
    for finding in findings:
        requirement = finding.requirement
        unit = unit_of(requirement.metric)
        stem, axis = split_axis(requirement.metric)
        growth = of_all.get(requirement)
        rows.append(
            {
                "requirement": f"{stem} {requirement.condition}".replace(
                    "_", " "
                ).strip(),
                "axis": axis,
                "unit": unit.symbol,
                "sense": requirement.sense,
                "limit": unit.from_si(requirement.limit),
                "nominal": unit.from_si(finding.nominal),
                "worst": unit.from_si(finding.worst),
                "which_run": finding.run,
                "margin": unit.from_si(finding.margin),
                "growth_factor": math.nan if growth is None else growth.factor,
                "looked_up_to": math.nan if growth is None else growth.most,
                **_first_tolerance(finding, single_growths, box),
                "verdict": "met" if finding.met else "not met",
            }
        )
    return pd.DataFrame(rows)


def _first_tolerance(
    finding: Finding,
    growths: "Sequence[tuple[Requirement, Growth]]",
    box: ToleranceBox | None,
) -> dict[str, str | float]:
    """Return the tolerance that violates a requirement with the least growth.

    Of one that is violated, the tolerance that restores it by shrinking least.
    """
    mine = [growth for r, growth in growths if r == finding.requirement]
    if not mine or box is None:
        return {"first_tolerance": "", "its_growth_factor": math.nan}
    first = min(mine, key=lambda growth: growth.factor)
    if not finding.met:
        first = max(mine, key=lambda growth: growth.factor)
        if not first.factor > 0.0:  # shrinking one is not enough
            return {"first_tolerance": "", "its_growth_factor": math.nan}
    name = ""
    if math.isfinite(first.factor) and first.limit.parameter is not None:
        name = with_unit(box.names[first.limit.parameter])
    return {"first_tolerance": name, "its_growth_factor": first.factor}


MARK = 5e-3
"""How near to a bound or to the nominal a value is marked as M, m or Nom, as a part
of its tolerance."""


def table_4(runs: Sequence[LabelledRun], box: ToleranceBox) -> pd.DataFrame:
    """Return the worst cases in the form of the paper's Table 4.

    Conditions after separation, then M (maximum), m (minimum), Nom (nominal) or the
    value of each property. A published run has what was printed in parentheses.

    Args:
        runs: the nominal run, then the worst cases.
        box: the tolerances.
    """
    groups = _groups(box)
    columns = {}
    for labelled in runs:
        printed = labelled.published and labelled.published.printed
        cells = _conditions(labelled)
        if printed:
            numbers = [
                *printed.rate_deg_s,
                printed.deviation_within_limits_until_s,
                printed.longitudinal_speed_m_s,
            ]
            cells = [
                f"{cell} ({number:g})"
                for cell, number in zip(cells, numbers, strict=True)
            ]
        values = parameters(labelled.run.separation)
        for names in groups.values():
            cells.append(_marks({name: values[name] for name in names}, box))
        if printed:
            cells.append(f"({printed.iterations})")
        else:
            cells.append(
                "-" if labelled.iterations is None else str(labelled.iterations)
            )
        columns[labelled.label] = cells
    labels = [
        *(f"rate {axis} (deg/s)" for axis in AXES),
        "deviation within limits until (s)",
        "longitudinal speed, max (m/s)",
        *groups,
        "solver iterations",
    ]
    return pd.DataFrame({"condition or property": labels, **columns})


def _conditions(labelled: LabelledRun) -> list[str]:
    names = [f"final_rate_{axis}" for axis in AXES]
    names += ["deviation_within_limits_until", "longitudinal_speed_max"]
    metrics = labelled.metrics
    return [
        f"{unit_of(name).from_si(metrics[name]):.2f}" if metrics else "failed"
        for name in names
    ]


def _groups(box: ToleranceBox) -> dict[str, list[str]]:
    def key(name: str) -> tuple[str, str]:
        owner, stem, axis = ParameterName.of(name)
        if stem == "inertia":
            stem += " moments" if axis[0] == axis[1] else " products"
        # Axes of one owner stand together, and so do owners without axes.
        return stem, owner if axis else ""

    def label(stem: str, names: list[str]) -> str:
        parts = [ParameterName.of(name) for name in names]
        owners = list(dict.fromkeys(part.owner for part in parts))
        axes = [part.axis for part in parts]
        first, last = owners[0], owners[-1]
        owner = first if first == last else f"{first} ... {last}"
        return " ".join(
            filter(None, [owner, stem, *axes, f"({unit_of(names[0]).symbol})"])
        ).replace("_", " ")

    groups = {}
    for (stem, _), group in itertools.groupby(box.names, key):
        names = list(group)
        groups[label(stem, names)] = names
    return groups


def _marks(values: Mapping[str, float], box: ToleranceBox) -> str:
    index = [box.names.index(name) for name in values]
    u = box.scaled(values)[index]
    marks = []
    for (name, value), scaled in zip(values.items(), u, strict=True):
        nearest = np.round(scaled)
        if abs(scaled - nearest) <= MARK and abs(nearest) <= 1.0:
            marks.append({1.0: "M", -1.0: "m", 0.0: "Nom"}[float(nearest)])
        else:
            marks.append(f"{unit_of(name).from_si(value):.6g}")
    return " ".join(marks)


def in_units(values: Mapping[str, float]) -> dict[str, float]:
    """Return values by the names that carry their units, in those units."""
    return {
        with_unit(name): unit_of(name).from_si(value) for name, value in values.items()
    }
