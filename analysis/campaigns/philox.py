"""Random bits as a function of a key and a counter: Philox4x64-10, on arrays.

J. K. Salmon, M. A. Moraes, R. O. Dror, D. E. Shaw, "Parallel random numbers: as easy as
1, 2, 3", SC11, 2011, doi:10.1145/2063384.2063405.
"""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray


Words: TypeAlias = NDArray[np.uint64]
"""Of 64 bits each."""

_MULTIPLIERS = 0xD2E7470EE14C6C93, 0xCA5A826395121157
_WEYL = 0x9E3779B97F4A7C15, 0xBB67AE8584CAA73B
_ROUNDS = 10
_HALF = np.uint64(32)
_LOW = np.uint64(0xFFFFFFFF)
_WORD = 1 << 64


def philox(
    key: int, counter: tuple[Words, Words, Words, Words]
) -> tuple[Words, Words, Words, Words]:
    """Return the four words (N,) that belong to each counter.

    Args:
        key: of less than 128 bits.
        counter: its four words, the lowest first, each (N,).
    """
    c0, c1, c2, c3 = counter
    k0, k1 = key % _WORD, key // _WORD
    for _ in range(_ROUNDS):
        high_0, low_0 = _product(_MULTIPLIERS[0], c0)
        high_1, low_1 = _product(_MULTIPLIERS[1], c2)
        high_1 ^= c1
        high_1 ^= np.uint64(k0)
        high_0 ^= c3
        high_0 ^= np.uint64(k1)
        c0, c1, c2, c3 = high_1, low_1, high_0, low_0
        k0, k1 = (k0 + _WEYL[0]) % _WORD, (k1 + _WEYL[1]) % _WORD
    return c0, c1, c2, c3


def _product(factor: int, words: Words) -> tuple[Words, Words]:
    """Return the upper and the lower words of products of 128 bits, by halves."""
    upper, lower = np.uint64(factor >> 32), np.uint64(factor & 0xFFFFFFFF)
    high, low = words >> _HALF, words & _LOW
    carried = low * lower
    carried >>= _HALF
    carried += high * lower  # at most 2^64 - 2^32
    low *= upper
    high *= upper
    carried += low & _LOW
    carried >>= _HALF
    low >>= _HALF
    high += low
    high += carried
    return high, words * np.uint64(factor)
