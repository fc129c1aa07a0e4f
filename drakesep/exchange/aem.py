"""Attitude ephemeris messages: CCSDS 504.0-B, in KVN.

The quaternion from frame A to frame B is that of the rotation that takes the axes of A
into those of B (504.0-B-2, annex F2): with A inertial and B a body it is q_AB, which
also turns components in B into components in A.
"""

import math
from collections.abc import Sequence

import numpy as np

from drakesep.exchange.epochs import epoch_text, parse_epoch
from drakesep.exchange.histories import AttitudeHistory
from drakesep.exchange.kvn import Message, data_line, message_text, rows_of
from drakesep.exchange.oem import check_inertial
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError
from drakesep.systems.vectors import rotation_matrix, unrotate


VERSION = "2.0"
"""Of what is written: the first that has a quaternion with an angular velocity."""
_QUATERNION, _WITH_RATE = "QUATERNION", "QUATERNION/ANGVEL"
_A2B, _B2A = ("A2B", "A->B"), ("B2A", "B->A")
_UNIT = 1e-6
"""By which the length of a quaternion that is written in decimals may miss one."""


def attitudes_of(message: Message) -> AttitudeHistory:
    """Return what an attitude ephemeris message says, of version 1.0 or 2.0.

    Raises:
        ValueError: it is of no quaternion, of none from an inertial frame to a body, or
            a line is wrong.
    """
    kind = message.value("ATTITUDE_TYPE").upper()
    if kind not in (_QUATERNION, _WITH_RATE):
        raise InputError(
            f"{message.source}: ATTITUDE_TYPE must be {_QUATERNION} or {_WITH_RATE}, "
            f"got {kind}"
        )
    frame, body = message.value("REF_FRAME_A"), message.value("REF_FRAME_B")
    check_inertial(message.source, "REF_FRAME_A", frame)
    epochs, rows = rows_of(message, 7 if kind == _WITH_RATE else 4)
    numbers = np.array(rows)
    first = _one_of(message, "QUATERNION_TYPE", "LAST", "FIRST") == "FIRST"
    q = numbers[:, :4] if first else np.roll(numbers[:, :4], 1, axis=1)
    if _one_of(message, "ATTITUDE_DIR", *_A2B, *_B2A) in _B2A:
        q = q * [1.0, -1.0, -1.0, -1.0]
    q = q / unit_length(message.source, q)
    return AttitudeHistory(
        object_name=message.value("OBJECT_NAME"),
        frame=frame,
        body_frame=body,
        time_system=message.time_system,
        epochs=[parse_epoch(f"{message.source}: an epoch", text) for text in epochs],
        orientation=q,
        rate=_rates(message, q, numbers[:, 4:]) if kind == _WITH_RATE else None,
    )


def unit_length(source: str, quaternions: Array) -> Array:
    """Return lengths (..., 1) of quaternions (..., 4), which must be nearly one.

    Raises:
        ValueError: one is not, or is NaN.
    """
    length: Array = np.linalg.norm(quaternions, axis=-1, keepdims=True)
    off = float(np.abs(length - 1.0).max())
    if not off <= _UNIT:
        raise InputError(
            f"{source}: quaternions must be of length 1, got one off by {off:g}"
        )
    return length


def _one_of(message: Message, key: str, *known: str) -> str:
    """Return what a key says, which is one of what is known; the first if absent."""
    value = message.value(key, known[0]).upper()
    if value not in known:
        raise InputError(
            f"{message.source}: {key} must be {' or '.join(known)}, got {value}"
        )
    return value


def _rates(message: Message, q: Array, degrees: Array) -> Array:
    """Return rates (n, 3) in the body's axes, rad/s."""
    rates = degrees * math.radians(1.0)
    given, body = message.value("ANGVEL_FRAME"), message.value("REF_FRAME_B")
    if given == body:
        return rates
    if given != message.value("REF_FRAME_A"):
        raise InputError(
            f"{message.source}: ANGVEL_FRAME must be REF_FRAME_A or REF_FRAME_B, got "
            f"{given}"
        )
    w, x, y, z = q.T
    return np.stack(unrotate(rotation_matrix((w, x, y, z)), tuple(rates.T)), axis=1)


def aem_text(
    attitudes: AttitudeHistory, comments: Sequence[str], created: str, originator: str
) -> str:
    """Return attitudes, with their rates, as a message.

    Args:
        attitudes: with rates.
        comments: what is meant by them, line by line.
        created: when, in UTC, in ISO 8601.
        originator: who made it.
    """
    assert attitudes.rate is not None
    first, last = (epoch_text(attitudes.epochs[i]) for i in (0, -1))
    scalar_last = np.roll(attitudes.orientation, -1, axis=1)
    rows = np.concatenate([scalar_last, np.degrees(attitudes.rate)], axis=1)
    return message_text(
        "AEM",
        VERSION,
        {"CREATION_DATE": created, "ORIGINATOR": originator},
        comments,
        {
            "OBJECT_NAME": attitudes.object_name,
            "OBJECT_ID": "UNKNOWN",
            "CENTER_NAME": "EARTH",
            "REF_FRAME_A": attitudes.frame,
            "REF_FRAME_B": attitudes.body_frame,
            "TIME_SYSTEM": attitudes.time_system,
            "START_TIME": first,
            "STOP_TIME": last,
            "ATTITUDE_TYPE": _WITH_RATE,
            "ANGVEL_FRAME": attitudes.body_frame,
        },
        map(data_line, attitudes.epochs, rows.tolist()),
    )
