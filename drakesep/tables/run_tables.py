"""Tables of runs, as pandas frames whose columns carry their units."""

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import pandas as pd

from drakesep.analysis.clearance.of_pair import Clearance
from drakesep.analysis.metrics.functions import FunctionRequirement
from drakesep.analysis.metrics.objectives import OBJECTIVES
from drakesep.analysis.metrics.of_run import metric_named, signal_of_run
from drakesep.analysis.metrics.registry import find_metric
from drakesep.systems.checks import InputError, unknown
from drakesep.systems.model.parameter_table import ROLL_PITCH_YAW, XYZ
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.run import Run
from drakesep.tables.columns import in_units, read_table
from drakesep.tables.labelled_run import LabelledRun
from drakesep.tables.roles import WORST, Worst, label_of, role_in_tables
from drakesep.units import split_unit, unit_of, with_unit


_MOTION = {
    "rate": XYZ,
    "relative_rate": XYZ,
    "angle": ROLL_PITCH_YAW,
    "relative_position": XYZ,
    "relative_velocity": XYZ,
    "acceleration": XYZ,
    "linear_momentum_change": XYZ,
    "angular_momentum_change": XYZ,
}


_ROTATIONS = [metric_named("rotation_x"), metric_named("total_rotation")]
"""Of their signals, all turns are counted."""


def motion_table(run: Run, body: str) -> pd.DataFrame:
    """Return the motion of a body that leaves over time: a row for each sample.

    Args:
        run: a completed run.
        body: that leaves.

    Raises:
        RuntimeError: the run failed.
    """
    motion = run.motion_of(body)
    columns = {with_unit("time"): motion.time}
    for quantity, axes in _MOTION.items():
        for i, axis in enumerate(axes):
            name = f"{quantity}_{axis}"
            samples = getattr(motion, quantity)[:, i]
            columns[with_unit(name)] = samples * unit_of(name).per_si
    for metric in _ROTATIONS:
        turned = signal_of_run(run, metric.of(body))
        for name, samples in zip(metric.names, turned.T, strict=True):
            columns[with_unit(name)] = samples * unit_of(name).per_si
    return pd.DataFrame(columns)


def runs_table(
    runs: Iterable[LabelledRun],
    names: Sequence[str],
    functions: Sequence[FunctionRequirement] = (),
) -> pd.DataFrame:
    """Return a row for each run: parameters, metrics, and how it was found.

    Args:
        runs: the runs.
        names: the parameters to show.
        functions: that are required, and have been told.
    """
    rows = []
    for one in runs:
        values = parameters(one.run.separation)
        rows.append(
            {
                "label": one.label,
                "role": role_in_tables(one.role),
                **in_units({name: values.get(name, math.inf) for name in names}),
                **in_units(one.metrics),
                **_nearest_pair(one.nearest),
                **{f.column: one.of_functions.get(f.name, math.nan) for f in functions},
                "iterations": one.iterations,
                "evaluations": one.evaluations,
                "status": one.status,
            }
        )
    frame = pd.DataFrame(rows)
    last = ["iterations", "evaluations", "status"]
    frame = frame[[column for column in frame if column not in last] + last]
    return frame.astype({"iterations": "Int64", "evaluations": "Int64"})


def is_column_of_runs(name: str) -> bool:
    """Return whether tables of runs have, or may have, a column of a name.

    Of what they say of a run, or of a metric; those of parameters have a point.
    """
    stem, _ = split_unit(name)
    return name in _OTHER_COLUMNS or find_metric(stem) is not None


_OTHER_COLUMNS = frozenset(
    "label role iterations evaluations status nearest nearest_time_s".split()
)


def _nearest_pair(measured: Mapping[str, Clearance]) -> dict[str, object]:
    """Return which parts come nearest in a run, and when, if that was asked for."""
    if not measured:
        return {}
    nearest = min(measured.values(), key=lambda one: one.minimum)
    return {"nearest": nearest.pair, **in_units({"nearest_time": nearest.time})}


def read_runs(
    file: str | Path, labels: Sequence[str] | None = None
) -> dict[str, dict[str, float]]:
    """Return parameter values of runs by their labels, from a study's worst_cases.csv.

    Args:
        file: the table.
        labels: of the runs; if None the worst cases of the paper's objectives and of
            the clearance, or all worst cases if there are none of these objectives.

    Raises:
        ValueError: it is no such table, has no such run, or does not say which runs are
            worst cases where labels are not given.
    """
    try:
        frame = read_table(file)
    except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeError) as error:
        raise InputError(f"{file}: must be a table of runs, got: {error}") from error
    if "label" not in frame:
        raise InputError(f"{file}: must be a table of runs with a column label")
    known = frame["label"].astype(str).tolist()
    wanted = labels or _worst_cases(file, frame)
    for label in wanted:
        if label not in known:
            raise InputError(f"{file}: {unknown('run', label, known)}")
        if known.count(label) > 1:
            raise InputError(f"{file}: run {label!r} must stand once")
    parameters_ = [str(n) for n in frame if "." in str(n) and not _is_metric(str(n))]
    entries = frame.set_axis(known)[parameters_]
    numbers = entries.apply(pd.to_numeric, errors="coerce").astype(float)
    for label in wanted:
        for name in parameters_:
            entry: object = entries.at[label, name]
            if not math.isfinite(numbers.at[label, name]):
                raise InputError(
                    f"{file}: {label}: {name} must be a finite number, got {entry}"
                )
    return {
        label: {name: float(numbers.at[label, name]) for name in parameters_}
        for label in wanted
    }


def _is_metric(column: str) -> bool:
    """Return whether a column is a metric of another body that leaves."""
    words = column.split("_")
    stems = ("_".join(words[:k]) for k in range(len(words), 0, -1))
    return any(find_metric(s) and with_unit(s) == column for s in stems)


def _worst_cases(file: str | Path, frame: pd.DataFrame) -> list[str]:
    """Return the labels of the worst cases that are shown if none is asked for."""
    if "role" not in frame:
        raise InputError(
            f"{file}: must have a column role, which tells worst cases from other "
            "runs, or labels of runs must be given; got neither"
        )
    return shown_first(frame.loc[frame["role"] == WORST, "label"].astype(str).tolist())


def shown_first(worst: Sequence[str]) -> list[str]:
    """Return those of the labels of worst cases that are shown if none is asked for."""
    of_paper = {label_of(Worst(name)) for name in OBJECTIVES}
    if of_paper.isdisjoint(worst):
        return list(worst)
    return [label for label in worst if label in of_paper or _of_clearance(label)]


def _of_clearance(label: str) -> bool:
    """Return whether a run's label says that it is the worst case of a clearance."""
    lowest = label_of(Worst("lowest_"))
    found = find_metric(label.removeprefix(lowest))
    return label.startswith(lowest) and found is not None and not found[0].of_every_run


def metrics_table(metrics: Mapping[str, float]) -> pd.DataFrame:
    """Return a row for each metric of a run, which are given by name, in SI."""
    return pd.DataFrame(
        {
            "metric": name,
            "value": unit_of(name).from_si(value),
            "unit": unit_of(name).symbol,
        }
        for name, value in metrics.items()
    )
