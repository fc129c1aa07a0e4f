"""The state of a stack, taken from files that another program has written."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from drakesep.exchange.aem import attitudes_of, unit_length
from drakesep.exchange.epochs import check_time_system, epoch_text, parse_epoch
from drakesep.exchange.histories import AttitudeHistory, index_at
from drakesep.exchange.kvn import read_message
from drakesep.exchange.oem import check_inertial, ephemeris_of
from drakesep.files import check_readable
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError


if TYPE_CHECKING:  # takes a while, and few cases are taken from files
    import pandas as pd


@dataclass(frozen=True, kw_only=True)
class TakenState:
    """What files say of a stack at an epoch."""

    frame: str
    """Inertial."""
    time_system: str
    epoch: str
    position: Array | None = None
    """(3,), of a point of it, from the centre of the Earth, m; None: not said."""
    velocity: Array | None = None
    """(3,), of that point, m/s."""
    orientation: Array | None = None
    """(4,), unit quaternion q_FA of its axes A in the frame F, w first."""
    rate: Array | None = None
    """(3,), of A in F, in A, rad/s."""


POSITION = [f"position_{axis}_m" for axis in "xyz"]
"""Columns of a table of ours, in an inertial frame: of a point."""
VELOCITY = [f"velocity_{axis}_m_s" for axis in "xyz"]
"""Of that point."""
ORIENTATION = [f"orientation_{q}" for q in "wxyz"]
"""Of a body's axes."""
RATE = [f"rate_{axis}_rad_s" for axis in "xyz"]
"""In these."""
_NAMES = ("label", "body", "epoch", "time_system", "frame")
_LARGEST = 100_000_000
"""Bytes of a table."""
_COLUMNS = (*_NAMES, *POSITION, *VELOCITY, *ORIENTATION, *RATE)


def taken_from(
    files: Sequence[Path], at: str, run: str | None, body: str | None
) -> TakenState:
    """Return what files say at an epoch: nothing is interpolated.

    Args:
        files: an OEM, an AEM, one of each, or a ``handover.csv``.
        at: the epoch.
        run: label of the run in a table that has several.
        body: name of the body in a table that has several.

    Raises:
        ValueError: a file cannot be read, it has no such epoch, or two files do not fit
            each other.
    """
    wanted = parse_epoch("at", at)
    states = [_read(file, wanted, run, body) for file in files]
    found = states[0]
    for other in states[1:]:
        for name in ("frame", "time_system"):
            was, got = getattr(found, name), getattr(other, name)
            if was != got:
                raise InputError(
                    f"from: files must have one {name}, got {was} and {got}"
                )
        for name in ("position", "velocity", "orientation", "rate"):
            value = getattr(other, name)
            if value is None:
                continue
            if getattr(found, name) is not None:
                raise InputError(f"from: one file must have the {name}, got two")
            found = replace(found, **{name: value})
    return found


def _read(file: Path, at: Decimal, run: str | None, body: str | None) -> TakenState:
    if file.suffix.lower() == ".csv":
        return _of_table(file, at, run, body)
    if run is not None or body is not None:
        raise InputError(f"run and body: must stand with a CSV file, got {file}")
    message = read_message(file)
    if message.kind == "OEM":
        orbit = ephemeris_of(message)
        states = np.hstack([orbit.position, orbit.velocity])
        i = index_at(str(file), orbit.epochs, at, states)
        return TakenState(
            frame=orbit.frame,
            time_system=orbit.time_system,
            epoch=epoch_text(at),
            position=orbit.position[i],
            velocity=orbit.velocity[i],
        )
    if message.kind == "AEM":
        history = attitudes_of(message)
        i = index_at(str(file), history.epochs, at, _turned(history))
        return TakenState(
            frame=history.frame,
            time_system=history.time_system,
            epoch=epoch_text(at),
            orientation=history.orientation[i],
            rate=None if history.rate is None else history.rate[i],
        )
    raise InputError(f"{file}: must be an OEM or an AEM, got {message.kind}")


def _turned(history: AttitudeHistory) -> Array:
    """Return (n, k) numbers that tell attitudes apart, the same for q and -q."""
    q = history.orientation
    products = (q[:, :, None] * q[:, None, :]).reshape(len(q), -1)
    return products if history.rate is None else np.hstack([products, history.rate])


def _of_table(file: Path, at: Decimal, run: str | None, body: str | None) -> TakenState:
    """Return what a table of ours says."""
    import pandas as pd

    try:
        check_readable(file, _LARGEST)
        table = pd.read_csv(file, dtype=dict.fromkeys(_NAMES, str), na_filter=False)
    except InputError:
        raise
    except (OSError, ValueError) as error:
        raise InputError(f"{file}: must be a table, got: {error}") from error
    for name in _COLUMNS:
        if name not in table:
            raise InputError(
                f"{file}: must have a column {name}, as a handover.csv has in a frame, "
                "got none"
            )
    for name, value in (("label", run), ("body", body)):
        if value is not None:
            table = table[table[name] == value]
    if table.empty:
        raise InputError(f"{file}: must have a row of the run and the body, got none")
    epochs = [parse_epoch(f"{file}: an epoch", str(text)) for text in table["epoch"]]
    index = index_at(str(file), epochs, at, np.zeros((len(epochs), 1)))
    if epochs.count(epochs[index]) > 1:
        raise InputError(
            f"{file}: run and body must choose one row at {epoch_text(at)}, got "
            f"{epochs.count(epochs[index])}"
        )
    row = table.iloc[index]
    check_inertial(str(file), "frame", str(row["frame"]))
    system = check_time_system(f"{file}: time_system", str(row["time_system"]))
    quaternion = _numbers(file, row, ORIENTATION)
    return TakenState(
        frame=str(row["frame"]),
        time_system=system,
        epoch=epoch_text(at),
        position=_numbers(file, row, POSITION),
        velocity=_numbers(file, row, VELOCITY),
        orientation=quaternion / unit_length(str(file), quaternion),
        rate=_numbers(file, row, RATE),
    )


def _numbers(file: Path, row: "pd.Series", names: Sequence[str]) -> Array:
    """Return what a row has in columns, all of which must be finite."""
    import pandas as pd

    for name in names:
        found = pd.to_numeric(row[name], errors="coerce")
        if not np.isfinite(found):
            raise InputError(
                f"{file}: {name} must be a finite number, got {str(row[name])!r}"
            )
    return row[list(names)].to_numpy(float)
