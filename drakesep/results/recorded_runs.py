"""Runs as a results folder keeps them: all that is needed to draw and measure them.

Of each there are two files in the folder ``runs``. ``LABEL.json`` says what the run is,
which parameters it changes, how it ended and what its metrics are, in SI.
``LABEL.csv.gz`` is its motion over time: of every body in W, and what joints and
springs do. What is read from them draws and measures as the run did.
"""

import contextlib
import dataclasses
import json
import math
import zlib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from drakesep.files import write_text
from drakesep.results.case_json import NO_RECORD, from_json, to_json
from drakesep.results.catalogue.names import RUNS, TABLE
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError
from drakesep.systems.equations.forces_of_run import spring_forces
from drakesep.systems.equations.loads_of_run import joint_loads
from drakesep.systems.equations.motion_of_run import relative_motion_of
from drakesep.systems.model.parameter_table import XYZ
from drakesep.systems.model.parameters import parameters, with_values
from drakesep.systems.model.run import Motion, Run, Trajectory
from drakesep.systems.model.separation import Separation
from drakesep.tables.columns import read_table, write_csv
from drakesep.tables.labelled_run import LabelledRun
from drakesep.tables.roles import Role


STATE = (
    *(f"orientation_{q}" for q in "wxyz"),
    *(f"position_{axis}_m" for axis in XYZ),
    *(f"angular_velocity_{axis}_rad_s" for axis in XYZ),
    *(f"velocity_{axis}_m_s" for axis in XYZ),
)
"""Of a body, all in W: q_WB, p_WBo, w_WB, v_WBo."""
MEASURED = {
    "acceleration": tuple(f"acceleration_{axis}_m_s2" for axis in XYZ),
    "linear_momentum_change": tuple(f"linear_momentum_change_{a}_N_s" for a in XYZ),
    "angular_momentum_change": tuple(f"angular_momentum_change_{a}_N_m_s" for a in XYZ),
}
"""Of a body that leaves, which its states do not tell."""
LOAD = (*(f"torque_{a}_N_m" for a in XYZ), *(f"force_{a}_N" for a in XYZ))
"""Of a joint."""
FORCE = "force_N"
"""Of a spring."""
_IN_SEPARATION = ("separation",)
_SAMPLED = ("motion", "others", "trajectory")
_BROKEN = (*NO_RECORD, EOFError, zlib.error)
"""What comes of reading what is not, or not all, of a run."""


def save_runs(runs: Iterable[LabelledRun], nominal: Separation, folder: Path) -> None:
    """Write runs of a study into its results folder.

    Args:
        runs: completed or failed.
        nominal: the separation that they vary.
        folder: of the results.
    """
    home = folder / RUNS
    home.mkdir(exist_ok=True)
    for one in runs:
        write_text(home / f"{one.label}.json", _text(one, nominal))
        if one.run.trajectory is not None:
            write_csv(_table(one.run), home / f"{one.label}{TABLE}")


def _text(one: LabelledRun, nominal: Separation) -> str:
    record = _fields(one, without=("run",))
    run = _fields(one.run, without=(*_IN_SEPARATION, *_SAMPLED))
    changed = _changed(one.run.separation, nominal)
    return json.dumps({**record, "run": {"values": changed, **run}}, indent=1) + "\n"


def _fields(record: Any, without: tuple[str, ...]) -> dict[str, Any]:
    names = (f.name for f in dataclasses.fields(record) if f.name not in without)
    return {name: to_json(getattr(record, name)) for name in names}


def _changed(flown: Separation, nominal: Separation) -> dict[str, float]:
    before, after = parameters(nominal), parameters(flown)
    changed = {k: x for k, x in after.items() if x != before.get(k)}
    return changed | {k: math.inf for k in before if k not in after}


def _table(run: Run) -> pd.DataFrame:
    """Return the motion of all bodies, loads and forces: a row for each sample."""
    trajectory, separation = run.completed_trajectory, run.separation
    columns: dict[str, Array] = {"time_s": trajectory.time}
    for name in trajectory.names:
        _add(columns, name, STATE, trajectory.of(name))
    for pair in separation.pairs:
        motion = run.motion_of(pair.B)
        for field, names in MEASURED.items():
            _add(columns, pair.B, names, getattr(motion, field))
    for name, loads in joint_loads(run).items():
        _add(columns, name, LOAD, loads)
    for name, force in spring_forces(run).items():
        columns[f"{name}.{FORCE}"] = force
    return pd.DataFrame(columns)


def _add(columns: dict[str, Array], owner: str, names: Iterable[str], x: Array) -> None:
    columns |= {f"{owner}.{n}": c for n, c in zip(names, x.T, strict=True)}


def read_run(folder: Path, label: str, nominal: Separation) -> LabelledRun:
    """Return a run of a results folder.

    Args:
        folder: of the results.
        label: of the run.
        nominal: the separation that it varies, as the folder has it.

    Raises:
        ValueError: there is no such run, or its files are not those of one.
    """
    file, table = _files(folder, label)
    with _of_a_study(file):
        record = _record(file)
        facts = {k: from_json(v) for k, v in record.pop("run").items()}
        flown = with_values(nominal, facts.pop("values"))
    sampled: Mapping[str, Any] = {}
    if table.exists():
        with _of_a_study(table):
            sampled = _sampled(read_table(table), flown)
    with _of_a_study(file):
        run = Run(separation=flown, **facts, **sampled)
        return LabelledRun(run=run, **{k: from_json(v) for k, v in record.items()})


def read_role(folder: Path, label: str) -> tuple[Role, bool]:
    """Return what a run of a results folder is, and whether its motion is there.

    Args:
        folder: of the results.
        label: of the run.

    Raises:
        ValueError: there is no such run, or its file is not that of one.
    """
    file, table = _files(folder, label)
    with _of_a_study(file):
        return from_json(_record(file)["role"]), table.exists()


def _files(folder: Path, label: str) -> tuple[Path, Path]:
    """Return the files of a run: what it is, and its motion."""
    file = folder / RUNS / f"{label}.json"
    return file, file.with_suffix(TABLE)


def _record(file: Path) -> dict[str, Any]:
    record: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return record


@contextlib.contextmanager
def _of_a_study(file: Path) -> Iterator[None]:
    """Say in errors which file they are of."""
    try:
        yield
    except _BROKEN as error:
        reason = f"{type(error).__name__}: {error}"
        raise InputError(f"{file}: must be that of a run, got {reason}") from error


def _sampled(table: pd.DataFrame, separation: Separation) -> dict[str, Any]:
    names = tuple(body.name for body in separation.bodies)
    time = table["time_s"].to_numpy(float)
    states = np.stack([_columns(table, name, STATE) for name in names], axis=1)
    trajectory = Trajectory(names=names, time=time, states=states)
    motions = {
        pair.B: Motion(
            time=time,
            **relative_motion_of(separation, pair, trajectory),
            **{k: _columns(table, pair.B, c) for k, c in MEASURED.items()},
        )
        for pair in separation.pairs
    }
    first = motions.pop(separation.B)
    return {"trajectory": trajectory, "motion": first, "others": motions}


def _columns(table: pd.DataFrame, owner: str, names: Iterable[str]) -> Array:
    return table[[f"{owner}.{name}" for name in names]].to_numpy(float)
