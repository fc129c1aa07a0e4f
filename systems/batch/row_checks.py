"""Which rows of parameter values are not physical, and why."""

import math
from collections.abc import Sequence
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray

from drakesep.systems.arrays import Array
from drakesep.systems.checks import check_finite
from drakesep.systems.equations.pushers import values_of
from drakesep.systems.equations.springs import law_of
from drakesep.systems.model.inertia import Entry, is_positive_definite
from drakesep.systems.model.parameters import (
    declarations,
    names_of,
    parameters,
    with_values,
)
from drakesep.systems.model.pushers import Pusher
from drakesep.systems.model.separation import Attachment, Separation


_MARGIN = 1e-9
"""Relative: what is nearer to its edge is looked at closely."""
_BLOCK = 4096
"""Rows that are looked at together: they stay in a core's cache."""


class RowChecks:
    """Finds the rows of parameter values that are not physical.

    What a row may hold is said once, in the model: this only finds, at the speed of
    arrays, the rows that may not pass, and lets the model judge them.
    """

    def __init__(self, separation: Separation, names: Sequence[str]):
        """Prepare.

        Args:
            separation: whose parameters they are.
            names: (n_p,) of the parameters.
        """
        self._separation, self._names = separation, tuple(names)
        self._nominal = parameters(separation)
        declared = declarations(separation)
        limits = np.array([declared[name].limits for name in names]).reshape(-1, 2)
        self._least, self._most = limits.T
        times = [declared[name].kind == "time" for name in names]
        latest = math.nextafter(separation.duration - _latest_start(separation), 0.0)
        self._most[times] = np.minimum(self._most[times], latest)
        inertias = [names_of([body], ["I_BBcm_B"]) for body in separation.bodies]
        self._inertias = [keys for keys in inertias if set(keys) & set(names)]

    def failures(self, values: Array) -> dict[int, str]:
        """Return why rows are not physical, by their numbers.

        Args:
            values: (n, n_p) in SI.
        """
        failures = {}
        for begin in range(0, len(values), _BLOCK):
            block = values[begin : begin + _BLOCK]
            for row in np.flatnonzero(self._doubtful(block)).tolist():
                try:
                    self._check(block[row].tolist())
                except ValueError as error:
                    failures[begin + row] = str(error)
        return failures

    def _check(self, row: list[float]) -> None:
        """Raise ValueError unless the model has it that a row is physical."""
        values = dict(zip(self._names, row, strict=True))
        with_values(self._separation, values)
        for name, value in values.items():
            check_finite(name, value)

    def _doubtful(self, rows: Array) -> NDArray[np.bool_]:
        """Return (n,) whether rows may be such as are not physical."""
        within = np.asarray(((rows >= self._least) & (rows <= self._most)).all(axis=1))
        # What is out of its range has been found, and makes no number here.
        with np.errstate(all="ignore"):
            of = self._nominal | dict(zip(self._names, rows.T, strict=True))
            for keys in self._inertias:
                within &= _is_possible(*(of[key] for key in keys))
            for attachment, spring in self._separation.pushing:
                within &= self._in_time(attachment, spring, of)
        return ~within

    def _in_time(
        self, attachment: Attachment, spring: Pusher, of: dict[str, Entry]
    ) -> NDArray[np.bool_]:
        """Return (n,) whether a spring that pushes for a time ends within the run."""
        law = law_of(spring)
        if not law.by_time or math.isinf(attachment.release_time):
            return np.asarray(True)
        p = SimpleNamespace()
        for field in values_of(law, spring)._fields:
            entries = [of[name] for name in names_of([spring], [field])]
            setattr(p, field, entries if len(entries) > 1 else entries[0])
        [release] = names_of([attachment], ["release_time"])
        end = of[release] + law.end(p, np)
        return np.asarray(end < (1.0 - _MARGIN) * self._separation.duration)


def _latest_start(separation: Separation) -> float:
    return max((load.times[0] for load in separation.loads), default=0.0)


def _is_possible(
    xx: Entry, yy: Entry, zz: Entry, xy: Entry, xz: Entry, yz: Entry
) -> NDArray[np.bool_]:
    """Return (n,) whether an inertia is one that a rigid body has, clearly.

    Its second moment of mass (see `drakesep.systems.model.inertia`), less what is too
    near to the edge, is positive definite.
    """
    inner = (1.0 - _MARGIN) * 0.5 * (xx + yy + zz)
    return is_positive_definite(inner - xx, inner - yy, inner - zz, -xy, -xz, -yz)
