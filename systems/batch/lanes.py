"""What goes into the equations of a batch: parameters and modes, on lanes.

Every scalar of the laws is an array here, whose last axis are the samples. An axis
before it runs over bodies, attachments, springs or loads.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
from jax import lax

from drakesep.systems.equations.mated_stack import Place
from drakesep.systems.model.parameter_table import ParameterTable
from drakesep.systems.model.parameters import names_of
from drakesep.systems.vectors import Symmetric, Vector


Lanes: TypeAlias = Any
"""A jax array whose last axis are the samples."""


class BatchParameters(NamedTuple):
    """The parameters of a separation on lanes: m bodies, a attachments, k springs."""

    mass: Lanes
    """(m, n), kg."""
    p_BoBcm_B: Vector
    """Of (m, n), m."""
    I_BBcm_B: Symmetric
    """Of (m, n), kg m^2."""
    spin: Lanes
    """(m, n) of the bodies in the mated stack, rad/s; 0 of those that cannot."""
    inverse_I_BBcm_B: Symmetric
    """Of (m, n), 1/(kg m^2)."""
    mated: Place
    """Of (m, n), where it varies; else of (0, n)."""
    p_AoPad_A: Vector
    """Of (a, n), m."""
    p_BoPad_B: Vector
    """Of (a, n), m."""
    release_time: Lanes
    """(a, n), s; infinite where there is none."""
    release_angle: Lanes
    """(a, n), rad; infinite where there is none."""
    release_travel: Lanes
    """(a, n), m; infinite where there is none."""
    springs: Sequence[Any]
    """Of each group of `BatchSprings` what its law reads, of (k_g, n)."""
    push_axis_A: Vector
    """Of (k, n)."""
    push_time: Lanes
    """(k, n) how long each spring that pushes for a time does so, s; 0 for others.

    Computed once: where it is wanted twice, round-off may differ, and an event that is
    stepped to would not be there."""
    p_BoQ_B: Vector
    """Where the loads act, of (l, n), m."""
    load_start: Lanes
    """(l, n), s."""
    load_factor: Lanes
    """(l, n)."""
    rpy_WA: Vector
    """Of (n,), rad."""
    w_WA_A: Vector
    """Of (n,), rad/s."""


class Settler:
    """Has values that are used several times computed once.

    XLA computes what is cheap again wherever it is used, and for long chains of sums
    and products all that goes into them: ten times the work where bodies hang on one
    another. Quotients count as dear, and are kept. A quotient by one is exact, where
    the compiler does not know that it is one.
    """

    def __init__(self, x: Lanes):
        """Prepare.

        Args:
            x: (n,) what is not known before a run, as states.
        """
        # Of one lane, and yet the same whatever that does.
        self._one = jnp.exp(0.0 * jnp.nan_to_num(lax.stop_gradient(x[0])))

    def settled(self, values: Any) -> Any:
        """Return the values, tuples of lanes (..., n)."""
        return jax.tree.map(lambda x: x / self._one, values)


class Mode(NamedTuple):
    """What has happened so far."""

    released: Lanes
    """(a, n) time of each attachment's release, s; infinite while it holds."""
    spent: Lanes
    """(k, n) whether each spring has let go of its pad."""
    corners: Lanes
    """(c, n) whether each corner of a spring's force is passed, spring after spring:
    which piece of it acts."""
    lifted: Lanes
    """(k, n) whether each pad has lifted off, so that its spring does not pull."""
    passed: Lanes
    """(r, n) whether each row of the load tables has been passed, load after load."""


class ParameterReader:
    """Reads parameters as lanes, by the fields of their records.

    Attributes:
        read: names of the parameters that have been read.
    """

    def __init__(self, p: Mapping[str, Lanes], n: int):
        """Prepare.

        Args:
            p: every parameter of the separation by name, (n,) or a single number.
            n: of samples.
        """
        self._p = p
        self._n = n
        self.read: set[str] = set()

    def vector(
        self, table: ParameterTable, records: Sequence[Any], field: str
    ) -> tuple[Lanes, ...]:
        """Return the entries of a field, of (k, n) for k records.

        Args:
            table: of their kind.
            records: of one kind.
            field: that holds parameters.
        """
        columns = [self.entries(record, field) for record in records]
        return tuple(
            rows([column[i] for column in columns], self._n)
            for i in range(len(table.by_field[field]))
        )

    def number(
        self, table: ParameterTable, records: Sequence[Any], field: str
    ) -> Lanes:
        """Return a field that holds one number, (k, n) for k records; see `vector`."""
        [lanes] = self.vector(table, records, field)
        return lanes

    def entries(self, record: Any, field: str) -> list[Lanes]:
        """Return the entries of one record's field, as they are given.

        What the record is without is infinite.
        """
        entries = []
        for name, parameter in zip(
            names_of([record], [field]), record.PARAMETERS.by_field[field], strict=True
        ):
            self.read.add(name)
            missing = parameter.optional and name not in self._p
            entries.append(math.inf if missing else self._p[name])
        return entries


def rows(lanes: Iterable[Lanes], n: int) -> Lanes:
    """Return (k, n) lanes from k of them, or numbers."""
    listed = [jnp.broadcast_to(jnp.asarray(x, dtype=float), (n,)) for x in lanes]
    return jnp.stack(listed) if listed else jnp.zeros((0, n))


def pick(lanes: Any, index: Any) -> Any:
    """Return one body, or some attachments, of tuples of lanes (..., k, n)."""
    return jax.tree.map(lambda x: x[..., index, :], lanes)
