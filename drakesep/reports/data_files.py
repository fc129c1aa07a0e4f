"""A run as one file of arrays: MAT, JSON or parquet."""

import json
import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from drakesep.exchange.taken import RATE
from drakesep.files import write_text, written
from drakesep.reports.body_states import BodyStates
from drakesep.reports.handed_run import HandedRun
from drakesep.reports.handover_tables import STATE
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError


FORMAT = 1
"""Of the JSON file: another number means other keys."""


def save_mat(handed: HandedRun, folder: Path) -> list[Path]:
    """Write a MAT-file: ``time``, ``notes``, and a struct of arrays for each body."""
    from scipy.io import savemat

    bodies = {_identifier(b): {"name": b, **_arrays(handed, b)} for b in handed.bodies}
    data = {"time": handed.time[:, None], "notes": handed.notes, "bodies": bodies}
    file = folder / f"{handed.label}.mat"
    with written(file) as beside, beside.open("wb") as stream:
        savemat(stream, data, long_field_names=True)
    return [file]


def _identifier(name: str) -> str:
    """Return the name of a field, as MATLAB allows it."""
    plain = re.sub(r"\W", "_", name)
    return plain if plain[0].isalpha() else f"b_{plain}"


def save_json(handed: HandedRun, folder: Path) -> list[Path]:
    """Write a JSON file of the same arrays."""
    data = {
        "format": FORMAT,
        "notes": handed.notes,
        "time": handed.time.tolist(),
        "bodies": {
            body: {name: x.tolist() for name, x in _arrays(handed, body).items()}
            for body in handed.bodies
        },
    }
    file = folder / f"{handed.label}.json"
    write_text(file, json.dumps(data, allow_nan=False) + "\n")
    return [file]


def _arrays(handed: HandedRun, body: str) -> dict[str, Array]:
    """Return the states of a body: in W, and in the frame if there is one."""
    in_W = handed.in_W(body)
    arrays = {
        "position_in_W": in_W.position,
        "velocity_in_W": in_W.velocity,
        "orientation_in_W": in_W.orientation,
        "rate": in_W.rate,
    }
    if handed.inertial is None:
        return arrays
    states = handed.in_frame(body)
    return arrays | {
        "position": states.position,
        "velocity": states.velocity,
        "orientation": states.orientation,
    }


def save_parquet(handed: HandedRun, folder: Path) -> list[Path]:
    """Write a parquet file: a row for each sample, columns as ``payload.rate_x_rad_s``.

    Raises:
        ValueError: pyarrow is missing.
    """
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise InputError(
            "format: parquet needs pyarrow: pip install 'drakesep[parquet]'"
        ) from None
    columns: dict[str, Array] = {"time_s": handed.time}
    for body in handed.bodies:
        in_W = handed.in_W(body)
        columns |= _flat(f"{body}.in_W_", in_W)
        if handed.inertial is not None:
            columns |= _flat(f"{body}.", handed.in_frame(body))
        columns |= {f"{body}.{n}": x for n, x in zip(RATE, in_W.rate.T, strict=True)}
    table = pyarrow.table(columns).replace_schema_metadata(handed.notes)
    file = folder / f"{handed.label}.parquet"
    with written(file) as beside:
        parquet.write_table(table, beside)
    return [file]


def _flat(prefix: str, states: BodyStates) -> Mapping[str, Array]:
    parts = (states.position, states.velocity, states.orientation)
    numbers = np.concatenate(parts, axis=1).T
    return {f"{prefix}{name}": x for name, x in zip(STATE, numbers, strict=True)}
