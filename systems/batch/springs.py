"""The springs of a batch, and whatever else pushes, on lanes."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from drakesep.systems.batch.lanes import (
    BatchParameters,
    Lanes,
    Mode,
    ParameterReader,
    pick,
    rows,
)
from drakesep.systems.batch.wrenches import WrenchSum
from drakesep.systems.checks import X_AXIS
from drakesep.systems.equations.pushers import (
    AXIS,
    Push,
    PushLaw,
    positive_part,
    push_axis,
    push_displacement,
    push_wrenches,
    values_of,
)
from drakesep.systems.equations.relative_motion import BodyState, Wrench
from drakesep.systems.equations.springs import law_of
from drakesep.systems.model.parameters import names_of
from drakesep.systems.model.pushers import TILT_TABLE
from drakesep.systems.model.separation import Separation
from drakesep.systems.vectors import Vector


class _Group(NamedTuple):
    """Springs of one kind and design."""

    springs: list[int]
    law: PushLaw
    values: type[Any]
    """Named tuple of what the law reads."""


class BatchSprings:
    """The forces of a separation's springs, on lanes.

    Springs are counted in the order of their attachments.

    Attributes:
        count: of the springs, k.
        attachments: (k,) index of each spring's attachment.
        known_end: (k, 1) whether the time at which each ends follows from its release.
        timed: springs that push for a time.
        by_stroke: springs whose displacement ends the push.
    """

    def __init__(self, separation: Separation, varied: Sequence[str]):
        """Prepare.

        Args:
            separation: whose springs they are.
            varied: names of the parameters that vary.
        """
        self._springs = separation.springs
        self.count = len(self._springs)
        self.attachments = [
            separation.attachments.index(attachment)
            for attachment, _ in separation.pushing
        ]
        self._ends = [
            separation.ends(attachment) for attachment, _ in separation.pushing
        ]
        self._laws = [law_of(spring) for spring in self._springs]
        self._groups = _group(separation, self._laws)
        self._place = {
            k: (g, i)
            for g, group in enumerate(self._groups)
            for i, k in enumerate(group.springs)
        }
        # Group by group, as their forces come.
        self.timed = [
            k for group in self._groups if group.law.by_time for k in group.springs
        ]
        self.by_stroke = [k for k, law in enumerate(self._laws) if not law.by_time]
        self.known_end = np.array([law.by_time for law in self._laws], bool)[:, None]

        def may_be(k: int, fields: Sequence[str]) -> bool:
            """Return whether some parameters of a spring vary, or are not zero."""
            spring = self._springs[k]
            names = names_of([spring], fields)
            return any(getattr(spring, field) != 0.0 for field in fields) or any(
                name in varied for name in names
            )

        every = range(len(self._springs))
        self._tilted = [
            self._springs[k].axis_A != X_AXIS or may_be(k, AXIS) for k in every
        ]
        self._damped = [may_be(k, self._laws[k].dampers) for k in every]

    # Parameters.

    def read(self, reader: ParameterReader) -> tuple[tuple[Any, ...], Vector]:
        """Return what the laws of the groups read, and the axes in A, of (k, n)."""
        groups = []
        for group in self._groups:
            springs = [self._springs[k] for k in group.springs]
            table = springs[0].PARAMETERS
            fields = []
            for field in group.values._fields:
                entries = reader.vector(table, springs, field)
                alone = table.by_field[field][0].entry is None
                fields.append(entries[0] if alone else entries)
            groups.append(group.values(*fields))
        tilt_y, tilt_z = (
            reader.number(TILT_TABLE, self._springs, field) for field in AXIS
        )
        axes = [
            push_axis(spring.axis_A, y, z, jnp)
            for spring, y, z in zip(self._springs, tilt_y, tilt_z, strict=True)
        ]
        n = tilt_y.shape[-1]
        return tuple(groups), tuple(rows([a[c] for a in axes], n) for c in range(3))

    def _values(self, k: int, params: BatchParameters) -> Any:
        """Return what the law of a spring reads, of (n,)."""
        g, i = self._place[k]
        return jax.tree.map(lambda lanes: lanes[i], params.springs[g])

    def _axis(self, k: int, params: BatchParameters) -> Vector | None:
        axis: Vector = pick(params.push_axis_A, k)
        return axis if self._tilted[k] else None

    # What ends a push, and where it has kinks.

    def stroke_end(self, params: BatchParameters, mode: Mode) -> Lanes:
        """Return (k, n) when springs that push for a time end, s."""
        return self._released(mode) + params.push_time

    def push_time(self, groups: Sequence[Any], n: int) -> Lanes:
        """Return (k, n) how long springs that push for a time do so, s; 0 for others.

        Args:
            groups: what their laws read, as `read` returns it.
            n: of samples.
        """
        times = [jnp.zeros(n)] * self.count
        for group, values in zip(self._groups, groups, strict=True):
            if group.law.by_time:
                ends = group.law.end(values, jnp)
                ends = jnp.broadcast_to(ends, (len(group.springs), n))
                for k, end in zip(group.springs, ends, strict=True):
                    times[k] = end
        return rows(times, n)

    def stroke(self, k: int, params: BatchParameters) -> Lanes:
        """Return (n,) the displacement that ends a spring's push, m."""
        return self._laws[k].end(self._values(k, params), jnp)

    def past(
        self, k: int, part: float, bodies: BodyState, params: BatchParameters
    ) -> Lanes:
        """Return how far a spring's pad is past a part of its stroke, m."""
        displacement, _ = self.displacement(k, bodies, params)
        return displacement - part * self.stroke(k, params)

    def corners(self, k: int) -> Sequence[float]:
        """Return the parts of a spring's stroke at which its force has a kink."""
        return self._laws[k].corners

    def may_lift(self, k: int) -> bool:
        """Return whether a spring's pad may lift off before the end of its stroke."""
        return self._damped[k]

    def frequency(self, k: int, params: BatchParameters) -> Lanes:
        """Return (n,) how fast the motion is that a spring drives, rad/s."""
        a, b = self._ends[k]
        inverse_mass = 1.0 / params.mass[a] + 1.0 / params.mass[b]
        return self._laws[k].frequency(
            self._values(k, params), len(self._springs), inverse_mass, jnp
        )

    def _released(self, mode: Mode) -> Lanes:
        """Return (k, n) when the springs' attachments let go, s."""
        return mode.released[jnp.array(self.attachments, dtype=int)]

    def pushing(self, mode: Mode) -> Lanes:
        """Return (k, n) whether springs are released, and have not let go."""
        return jnp.isfinite(self._released(mode)) & ~mode.spent

    # Forces.

    def timed_forces(self, t: Lanes, params: BatchParameters, mode: Mode) -> Lanes:
        """Return (..., k_t, n) the forces of `timed` springs at times (..., n), N."""
        index = jnp.array(self.timed, dtype=int)
        pushing = self.pushing(mode)[index]
        shape = (*t.shape[:-1], *pushing.shape)

        def forces(_: None) -> Lanes:
            released = self._released(mode)[index]
            elapsed = jnp.where(pushing, t[..., None, :] - released, 0.0)
            parts, first = [], 0
            for group, values in zip(self._groups, params.springs, strict=True):
                if group.law.by_time:
                    mine = slice(first, first + len(group.springs))
                    first = mine.stop
                    at = elapsed[..., mine, :]
                    force = group.law.force(values, at, 0.0, jnp)
                    parts.append(jnp.broadcast_to(force, at.shape))
            return jnp.where(pushing, jnp.concatenate(parts, axis=-2), 0.0)

        if not self.timed:
            return jnp.zeros(shape)
        return lax.cond(pushing.any(), forces, lambda _: jnp.zeros(shape), None)

    def displacement(
        self, k: int, bodies: BodyState, params: BatchParameters
    ) -> tuple[Lanes, Lanes]:
        """Return how far, m, and how fast, m/s, a spring's pad has moved."""
        a, b = self._ends[k]
        i = self.attachments[k]
        return push_displacement(
            pick(bodies, a),
            pick(bodies, b),
            pick(params.p_AoPad_A, i),
            pick(params.p_BoPad_B, i),
            self._axis(k, params),
        )

    def stroke_force(self, k: int, bodies: BodyState, params: BatchParameters) -> Lanes:
        """Return the force of a spring by displacement, were it to pull, N."""
        at, speed = self.displacement(k, bodies, params)
        return self._laws[k].force(self._values(k, params), at, speed, jnp)

    def forces(
        self, timed: Lanes, bodies: BodyState, params: BatchParameters, mode: Mode
    ) -> list[Lanes]:
        """Return the force of each spring on B, (..., n), N.

        Args:
            timed: what `timed_forces` returns, at the bodies' time.
            bodies: of (..., m, n).
            params: of the batch.
            mode: what has happened.
        """
        forces = [jnp.zeros(())] * len(self._springs)
        for i, k in enumerate(self.timed):
            forces[k] = timed[..., i, :]
        pushing = self.pushing(mode)
        for k in self.by_stroke:
            force = positive_part(self.stroke_force(k, bodies, params))
            forces[k] = jnp.where(pushing[k], force, 0.0)
        return forces

    def wrenches(
        self, timed: Lanes, bodies: BodyState, params: BatchParameters, mode: Mode
    ) -> Wrench:
        """Return the wrenches of all springs on the bodies; see `forces`."""
        pairs: dict[tuple[int, int], list[Push]] = {}
        for k, force in enumerate(self.forces(timed, bodies, params, mode)):
            pad = pick(params.p_BoPad_B, self.attachments[k])
            push = (force, pad, self._axis(k, params))
            pairs.setdefault(self._ends[k], []).append(push)
        total = WrenchSum(bodies)
        for (a, b), pushes in pairs.items():
            on_A, on_B = push_wrenches(pick(bodies, a), pick(bodies, b), pushes)
            total.add(a, on_A)
            total.add(b, on_B)
        return total.wrench


def _group(separation: Separation, laws: Sequence[PushLaw]) -> list[_Group]:
    alike: dict[Any, list[int]] = {}
    for k, (spring, law) in enumerate(zip(separation.springs, laws, strict=True)):
        alike.setdefault((type(spring), law), []).append(k)
    return [
        _Group(springs, law, type(values_of(law, separation.springs[springs[0]])))
        for (_, law), springs in alike.items()
    ]
