"""What messages of other programs hold: where something is, and how it is turned."""

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal

import numpy as np

from drakesep.exchange.epochs import epoch_text
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError


_SAME_TIME = Decimal("1e-9")
"""Epochs nearer than that are one, s: a body in orbit moves by 1e-5 m in it."""
_SAME = 1e-9
"""By which two states differ that are one, written twice: in digits of decimals."""


@dataclass(frozen=True, kw_only=True)
class Ephemeris:
    """Where a point is, at n epochs."""

    object_name: str
    frame: str
    """Inertial, about `center`."""
    time_system: str
    epochs: Sequence[Decimal]
    """As `epochs` has them."""
    position: Array
    """(n, 3), m."""
    velocity: Array
    """(n, 3), m/s."""
    center: str = "EARTH"


@dataclass(frozen=True, kw_only=True)
class AttitudeHistory:
    """How a body is turned, at n epochs."""

    object_name: str
    frame: str
    """Inertial."""
    body_frame: str
    """Name of the body's axes."""
    time_system: str
    epochs: Sequence[Decimal]
    """As `epochs` has them."""
    orientation: Array
    """(n, 4), unit quaternion q_FB of the body's axes B in the frame F, w first."""
    rate: Array | None
    """(n, 3), of B in F, in B, rad/s; None: the message has none."""


def index_at(source: str, epochs: Sequence[Decimal], at: Decimal, states: Array) -> int:
    """Return which of the epochs is a given one; nothing is interpolated.

    Args:
        source: the file, for errors.
        epochs: n of a history.
        at: the wanted one.
        states: (n, k) numbers that tell states apart.

    Raises:
        ValueError: it is none of them, or several with different states, such as at a
            manoeuvre, where one segment ends and the next begins.
    """
    nearest = min(range(len(epochs)), key=lambda i: abs(epochs[i] - at))
    if abs(epochs[nearest] - at) > _SAME_TIME:
        raise InputError(
            f"at: must be an epoch of {source}, of which the nearest is "
            f"{epoch_text(epochs[nearest])}, got {epoch_text(at)}"
        )
    same = [i for i, epoch in enumerate(epochs) if abs(epoch - at) <= _SAME_TIME]
    if not np.allclose(states[same], states[nearest], rtol=_SAME, atol=_SAME):
        raise InputError(
            f"{source}: must have one state at {epoch_text(at)}, got {len(same)} that "
            "differ"
        )
    return nearest
