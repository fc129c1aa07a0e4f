"""Epochs as CCSDS messages write them, without losing digits.

An epoch is a number of seconds since 2000-01-01T00:00:00 in its own time system, by
days of 86 400 s, as an exact decimal. Leap seconds are not counted: an epoch within one
is refused, and in UTC a time that runs over one is off by it.
"""

import math
import re
from datetime import datetime, timedelta
from decimal import Decimal
from typing import Literal, TypeAlias, get_args

from drakesep.systems.checks import InputError


TimeSystem: TypeAlias = Literal["UTC", "TAI", "TT", "GPS", "TDB"]
"""That epochs may be of: a second is one of SI in them, or so nearly that a separation
does not see it."""
_START = datetime(2000, 1, 1)
_EPOCH = re.compile(
    r"(\d{4})-(?:(\d\d)-(\d\d)|(\d{3}))T(\d\d):(\d\d):(\d\d(?:\.\d+)?)(?:Z|\+00:00)?"
)
_FIRST, _LAST = 2, 9998
"""Years of epochs: a run that begins in one ends in one that has a date."""
PLACES = Decimal("1e-12")
"""To which epochs are written: a body in orbit moves by 1e-8 m in it."""


def parse_epoch(name: str, text: str) -> Decimal:
    """Return the seconds that an epoch is after the beginning of 2000.

    Args:
        name: what it is, for errors.
        text: YYYY-MM-DDThh:mm:ss or YYYY-DDDThh:mm:ss, with decimals of a second and a
            Z, or without.

    Raises:
        ValueError: it is none, or within a leap second.
    """
    found = _EPOCH.fullmatch(text.strip())
    wrong = f"{name} must be an epoch such as 2026-03-01T12:00:00.5, got {text!r}"
    if found is None:
        raise InputError(wrong)
    year, month, day, of_year, hour, minute, seconds = found.groups()
    if (hour, minute) == ("23", "59") and 60 <= Decimal(seconds) < 61:
        raise InputError(
            f"{name} must not be within a leap second, which is not counted: give it "
            f"in TAI, got {text!r}"
        )
    try:
        if of_year is None:
            date = datetime(int(year), int(month), int(day))
        else:
            date = datetime(int(year), 1, 1) + timedelta(days=int(of_year) - 1)
    except (ValueError, OverflowError):
        raise InputError(wrong) from None
    outside = int(hour) > 23 or int(minute) > 59 or Decimal(seconds) >= 60
    outside |= not _FIRST <= date.year <= _LAST
    if outside or str(date.year) != str(int(year)) or of_year == "000":
        raise InputError(wrong)
    days = (date - _START).days
    whole = 86400 * days + 3600 * int(hour) + 60 * int(minute)
    return whole + Decimal(seconds)


def check_time_system(name: str, system: str) -> str:
    """Return the name of a time system, in capitals.

    Args:
        name: what says it, for errors.
        system: as it stands there.

    Raises:
        ValueError: it is none of those that epochs may be of.
    """
    known = get_args(TimeSystem)
    if system.upper() not in known:
        raise InputError(f"{name} must be one of {', '.join(known)}, got {system!r}")
    return system.upper()


def epoch_text(epoch: Decimal) -> str:
    """Return an epoch as text, to `PLACES`, without zeros at its end."""
    rounded = epoch.quantize(PLACES)
    whole = math.floor(rounded)
    date = _START + timedelta(seconds=whole)
    decimals = f"{rounded - whole:.12f}"[1:].rstrip("0").rstrip(".")
    return f"{date:%Y-%m-%dT%H:%M:%S}{decimals}"
