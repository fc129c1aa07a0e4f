"""Bits against numpy's own Philox, and against those of the paper's code."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drakesep.analysis.campaigns.philox import philox


words = st.integers(0, 2**64 - 1)


def ours(key, counter):
    return [
        int(w[0]) for w in philox(key, tuple(np.array([c], np.uint64) for c in counter))
    ]


@given(key=st.integers(0, 2**128 - 1), counter=st.tuples(words, words, words, words))
def test_as_numpy_has_it(key, counter):
    # numpy counts on by one, in 256 bits, before its first block.
    number = sum(c << 64 * i for i, c in enumerate(counter))
    theirs = np.random.Philox(counter=(number - 1) % 2**256, key=key).random_raw(4)
    assert ours(key, counter) == theirs.tolist()


@pytest.mark.parametrize(
    ("key", "counter", "wanted"),
    [  # of Random123, kat_vectors
        (
            0,
            [0] * 4,
            [
                *(0x16554D9ECA36314C, 0xDB20FE9D672D0FDC),
                *(0xD7E772CEE186176B, 0x7E68B68AEC7BA23B),
            ],
        ),
        (
            2**128 - 1,
            [2**64 - 1] * 4,
            [
                *(0x87B092C3013FE90B, 0x438C3C67BE8D0224),
                *(0x9CC7D7C69CD777B6, 0xA09CAEBF594F0BA0),
            ],
        ),
    ],
)
def test_known_answers(key, counter, wanted):
    assert ours(key, counter) == wanted
