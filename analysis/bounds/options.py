"""Options: numbers of which a quantity is the largest, each with its derivatives.

Each belongs to a choice, such as of a sign: section 7 of docs/proof.md.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drakesep.analysis.bounds.intervals import Interval, total
from drakesep.systems.arrays import Array


class Options(NamedTuple):
    """Numbers of which a quantity is the largest, and their derivatives."""

    value: Interval
    """(boxes, options)."""
    slopes: Interval
    """(parameters, boxes, options)."""
    choice: Array
    """(options,) to which choice each belongs, from 0."""
    shape: tuple[int, ...]
    """How many choices there are of each term; those of the last one are next to each
    other."""


def option(value: Interval, slopes: Interval) -> Options:
    """Return options of one choice."""
    return Options(value, slopes, np.zeros(value.lo.shape[-1], dtype=int), (1,))


def beside(parts: Sequence[Options]) -> Options:
    """Return options of one choice each as those of several."""
    counts = [part.value.lo.shape[-1] for part in parts]
    return Options(
        _side_by_side([part.value for part in parts]),
        _side_by_side([part.slopes for part in parts]),
        np.repeat(np.arange(len(parts)), counts),
        (len(parts),),
    )


def _side_by_side(parts: Sequence[Interval]) -> Interval:
    lo, hi = ([getattr(x, end) for x in parts] for end in ("lo", "hi"))
    return Interval(np.concatenate(lo, -1), np.concatenate(hi, -1))


def summed(parts: Sequence[Options]) -> Options:
    """Return all sums of an option of each."""
    shape = tuple(part.value.lo.shape[-1] for part in parts)
    return Options(
        _every_sum([part.value for part in parts]),
        _every_sum([part.slopes for part in parts]),
        np.arange(math.prod(shape)),
        shape,
    )


def _every_sum(parts: Sequence[Interval]) -> Interval:
    """Return sums of an entry of each, along the last axis."""
    terms = []
    for a, part in enumerate(parts):
        ones = [1] * len(parts)
        ones[a] = part.lo.shape[-1]
        shape = (*part.lo.shape[:-1], *ones)
        terms.append(Interval(part.lo.reshape(shape), part.hi.reshape(shape)))
    sums = total(terms)
    flat = (*parts[0].lo.shape[:-1], math.prod(p.lo.shape[-1] for p in parts))
    return Interval(sums.lo.reshape(flat), sums.hi.reshape(flat))
