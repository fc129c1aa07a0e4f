"""Orbit ephemeris messages: CCSDS 502.0-B, in KVN."""

from collections.abc import Sequence

import numpy as np

from drakesep.exchange.epochs import epoch_text, parse_epoch
from drakesep.exchange.histories import Ephemeris
from drakesep.exchange.kvn import Message, data_line, message_text, rows_of
from drakesep.systems.checks import InputError


_KM = 1000.0
VERSION = "2.0"
"""Of what is written: every reader knows it; 3.0 has nothing more that is used."""
INERTIAL = ("EME2000", "ICRF", "GCRF", "TEME", "MOD", "TOD", "J2000")
"""Frames whose axes do not turn, or so slowly that a separation does not see it."""


def ephemeris_of(message: Message) -> Ephemeris:
    """Return what an orbit ephemeris message says.

    Raises:
        ValueError: it is not of the Earth, in no frame that is known to be inertial, or
            a line is wrong.
    """
    frame = message.value("REF_FRAME")
    check_inertial(message.source, "REF_FRAME", frame)
    center = message.value("CENTER_NAME").upper()
    if center != "EARTH":
        raise InputError(f"{message.source}: CENTER_NAME must be EARTH, got {center}")
    epochs, rows = rows_of(message, 6, also=9)  # with accelerations
    states = _KM * np.array(rows)
    return Ephemeris(
        object_name=message.value("OBJECT_NAME"),
        frame=frame,
        time_system=message.time_system,
        epochs=[parse_epoch(f"{message.source}: an epoch", text) for text in epochs],
        position=states[:, :3],
        velocity=states[:, 3:],
        center=center,
    )


def check_inertial(source: str, key: str, frame: str) -> None:
    """Raise InputError unless the axes of a frame do not turn.

    Args:
        source: the file, for errors.
        key: that names the frame.
        frame: its name.
    """
    if frame.upper() not in INERTIAL:
        raise InputError(
            f"{source}: {key} must be an inertial frame ({', '.join(INERTIAL)}), got "
            f"{frame}"
        )


def oem_text(
    ephemeris: Ephemeris, comments: Sequence[str], created: str, originator: str
) -> str:
    """Return an ephemeris as a message.

    Args:
        ephemeris: the ephemeris.
        comments: what is meant by it, line by line.
        created: when, in UTC, in ISO 8601.
        originator: who made it.
    """
    first, last = (epoch_text(ephemeris.epochs[i]) for i in (0, -1))
    states = np.concatenate([ephemeris.position, ephemeris.velocity], axis=1) / _KM
    return message_text(
        "OEM",
        VERSION,
        {"CREATION_DATE": created, "ORIGINATOR": originator},
        comments,
        {
            "OBJECT_NAME": ephemeris.object_name,
            "OBJECT_ID": "UNKNOWN",
            "CENTER_NAME": ephemeris.center,
            "REF_FRAME": ephemeris.frame,
            "TIME_SYSTEM": ephemeris.time_system,
            "START_TIME": first,
            "STOP_TIME": last,
        },
        map(data_line, ephemeris.epochs, states.tolist()),
    )
