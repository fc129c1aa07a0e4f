"""Tables of runs, as pandas frames whose columns carry their units."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from drakesep.analysis.clearance.objective import LOWEST
from drakesep.analysis.clearance.of_pair import Clearance
from drakesep.analysis.metrics.objectives import OBJECTIVES, Objective
from drakesep.analysis.metrics.of_run import ANGLES, AXES
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.systems.checks import InputError, unknown
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.run import Motion
from drakesep.tables.labelled_run import LabelledRun
from drakesep.units import unit_of, with_unit


if TYPE_CHECKING:  # JAX comes with them
    from drakesep.analysis.search.sqp import Iteration
from drakesep.tables.columns import in_units, shown, unit_of_objective


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
