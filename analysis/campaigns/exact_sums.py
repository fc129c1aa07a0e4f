"""Sums of floats without round-off: they do not depend on any order.

A float is a whole number of units of 2^-1126; so is a sum of floats, as Python's whole
numbers, which have no end. What is summed in parts has the same bits as the whole.
"""

from fractions import Fraction

import numpy as np

from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError


_DIGITS = 53
"""Of the mantissa of a float."""
_LOW = 26
"""Of them, those that are summed apart, so that neither sum is rounded."""
_UNIT = 1073 + _DIGITS
"""Binary places of the unit: of the least float's last digit as `frexp` has it."""
_MOST = 2**14
"""Values that are summed together: they fit the cache, and of less than 2^26 the sums
of digits, 27 or 26 each, are exact."""
_LARGEST = 1e150
"""Of a value whose square is summed."""


def exact_sum(values: Array) -> int:
    """Return the sum of finite values (N,), in units of 2^-1126."""
    return sum(map(_sum_of_few, _in_parts(values)))


def exact_sum_of_squares(values: Array) -> int:
    """Return the sum of the squares of finite values (N,), in units of 2^-1126.

    Exact for zero and from 1e-140 in magnitude: the last digits of smaller squares are
    below the least float.

    Raises:
        ValueError: a value is beyond 1e150.
    """
    if (largest := np.abs(values).max(initial=0.0)) > _LARGEST:
        raise InputError(f"values must be at most {_LARGEST:g}, got {largest:g}")
    return sum(map(_squares_of_few, _in_parts(values)))


def in_units(total: int) -> Fraction:
    """Return what a sum in units of 2^-1126 is."""
    return Fraction(total, 2**_UNIT)


def _in_parts(values: Array) -> list[Array]:
    return [values[start : start + _MOST] for start in range(0, len(values), _MOST)]


def _squares_of_few(values: Array) -> int:
    square = values * values
    # What rounding takes from it, by Dekker (1971), doi:10.1007/BF01397083.
    scaled = 134217729.0 * values  # 2^27 + 1
    high = scaled - (scaled - values)
    low = values - high
    rest = ((high * high - square) + 2.0 * high * low) + low * low
    return _sum_of_few(square) + _sum_of_few(rest)


def _sum_of_few(values: Array) -> int:
    """Return the sum of values: by exponent, their high and their low digits apart."""
    mantissas, exponents = np.frexp(values)
    digits = np.ldexp(mantissas, _DIGITS).astype(np.int64)
    least = int(exponents.min(initial=0))
    places = exponents - least
    total = 0
    for part, shift in ((digits >> _LOW, _LOW), (digits & (2**_LOW - 1), 0)):
        sums = np.bincount(places, weights=part)
        for place in np.flatnonzero(sums).tolist():
            total += int(sums[place]) << (place + shift)
    return total << (least - _DIGITS + _UNIT)
