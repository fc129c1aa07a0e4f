"""The springs of a batch, and whatever else pushes, on lanes."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

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
    """Springs of one kind and design between the same bodies, on an axis of lanes."""

    springs: list[int]
    law: PushLaw
    values: type[Any]
    """Named tuple of what the law reads."""
    ends: tuple[int, int]
    """Indices of the bodies pushed from, and pushed away."""
    tilted: bool
    """Whether they may push along axes of their own, not along A's x axis."""


class BatchSprings:
    """The forces of a separation's springs, on lanes.

    Springs are counted in the order of their attachments.

    Attributes:
        count: of the springs, k.
        attachments: (k,) index of each spring's attachment.
        known_end: (k, 1) whether the time at which each ends follows from its release.
        timed: springs that push for a time.
        by_stroke: (k_s,) springs whose displacement ends the push.
        corners: (c,) of each corner of their forces, spring after spring, the spring,
            by its place in `by_stroke`, and the part of its stroke.
        may_lift: springs whose pad may lift off before the end of the stroke, by their
            place in `by_stroke`.
        ways: (e, 1) of those: 1 if they push, -1 if they pull.
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
        self._laws = laws = [law_of(spring) for spring in self._springs]

        def may_be(k: int, fields: Sequence[str]) -> bool:
            """Return whether some parameters of a spring vary, or are not zero."""
            spring = self._springs[k]
            names = names_of([spring], fields)
            return any(getattr(spring, field) != 0.0 for field in fields) or any(
                name in varied for name in names
            )

        self._tilted = [
            spring.axis_A != X_AXIS or may_be(k, AXIS)
            for k, spring in enumerate(self._springs)
        ]
        self._groups = self._group()
        # Group by group, as their forces come.
        in_order = [k for group in self._groups for k in group.springs]
        self.timed = [k for k in in_order if laws[k].by_time]
        self.by_stroke = [k for k in in_order if not laws[k].by_time]
        self.known_end = np.array([law.by_time for law in laws], bool)[:, None]
        self.corners = [
            (i, part) for i, k in enumerate(self.by_stroke) for part in laws[k].corners
        ]
        self.may_lift = [
            i
            for i, k in enumerate(self.by_stroke)
            if laws[k].way and (laws[k].may_lift or may_be(k, laws[k].dampers))
        ]
        ways = [laws[self.by_stroke[i]].way for i in self.may_lift]
        self.ways = np.array(ways, float)[:, None]

    def _group(self) -> list[_Group]:
        alike: dict[Any, list[int]] = {}
        for k, (spring, law) in enumerate(zip(self._springs, self._laws, strict=True)):
            key = type(spring), law, self._ends[k], self._tilted[k]
            alike.setdefault(key, []).append(k)
        return [
            _Group(springs, law, type(values_of(law, self._springs[springs[0]])), *rest)
            for (_, law, *rest), springs in alike.items()
        ]

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

    def ends(self, params: BatchParameters) -> Lanes:
        """Return (k_s, n) the displacements that end the pushes of `by_stroke`, m."""
        return self._lengths(params, lambda law: law.end)

    def strokes(self, params: BatchParameters) -> Lanes:
        """Return (k_s, n) those of which their corners are parts, m."""
        return self._lengths(params, lambda law: law.stroke)

    def _lengths(
        self, params: BatchParameters, of: Callable[[PushLaw], Callable[..., Lanes]]
    ) -> Lanes:
        _, n = params.mass.shape
        lengths = [
            jnp.broadcast_to(of(group.law)(values, jnp), (len(group.springs), n))
            for group, values in self._stroke_groups(params)
        ]
        return jnp.concatenate(lengths)

    def fastest(
        self, params: BatchParameters, mass: Lanes, mode: Mode, *, by_time: bool
    ) -> Lanes:
        """Return (n,) how fast the motion is that springs drive, rad/s.

        Args:
            params: of the batch.
            mass: (m, n) of the bodies, with what moves as one with them, kg.
            mode: what has happened.
            by_time: whether of those that push for a time; else of `by_stroke`.
        """
        acts, fastest = self._acts(mode), jnp.zeros_like(mass[0])
        for group, values in zip(self._groups, params.springs, strict=True):
            if group.law.by_time is by_time:
                a, b = group.ends
                together = self._ends.count(group.ends)
                lightness = 1.0 / mass[a] + 1.0 / mass[b]
                frequency = group.law.frequency(values, together, lightness, jnp)
                each = jnp.where(acts[np.array(group.springs)], frequency, 0.0)
                fastest = jnp.maximum(fastest, each.max(axis=0))
        return fastest

    def _released(self, mode: Mode) -> Lanes:
        """Return (k, n) when the springs' attachments let go, s."""
        return mode.released[jnp.array(self.attachments, dtype=int)]

    def pushing(self, mode: Mode) -> Lanes:
        """Return (k, n) whether springs are released, and have not let go."""
        return jnp.isfinite(self._released(mode)) & ~mode.spent

    def _acts(self, mode: Mode) -> Lanes:
        """Return (k, n) whether springs push, and their pads have not lifted off."""
        return self.pushing(mode) & ~mode.lifted

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
                    force = group.law.force(values, at, 0.0, (), jnp)
                    parts.append(jnp.broadcast_to(force, at.shape))
            return jnp.where(pushing, jnp.concatenate(parts, axis=-2), 0.0)

        if not self.timed:
            return jnp.zeros(shape)
        return lax.cond(pushing.any(), forces, lambda _: jnp.zeros(shape), None)

    def _stroke_groups(self, params: BatchParameters) -> list[tuple[_Group, Any]]:
        """Return the groups of `by_stroke`, and what their laws read."""
        return [
            (group, values)
            for group, values in zip(self._groups, params.springs, strict=True)
            if not group.law.by_time
        ]

    def _displacements(
        self, group: _Group, bodies: BodyState, params: BatchParameters
    ) -> tuple[Lanes, Lanes]:
        """Return how far, m, and how fast, m/s, pads have moved, of (..., k_g, n)."""
        a, b = group.ends
        index = np.array(group.springs)
        pads = np.array(self.attachments)[index]
        return push_displacement(
            pick(bodies, slice(a, a + 1)),
            pick(bodies, slice(b, b + 1)),
            pick(params.p_AoPad_A, pads),
            pick(params.p_BoPad_B, pads),
            pick(params.push_axis_A, index) if group.tilted else None,
        )

    def displacements(self, bodies: BodyState, params: BatchParameters) -> Lanes:
        """Return (..., k_s, n) how far the pads of `by_stroke` have moved, m."""
        return jnp.concatenate(
            [
                self._displacements(group, bodies, params)[0]
                for group, _ in self._stroke_groups(params)
            ],
            axis=-2,
        )

    def stroke_forces(
        self, bodies: BodyState, params: BatchParameters, mode: Mode
    ) -> Lanes:
        """Return (..., k_s, n) the forces of `by_stroke`, were they to push or pull, N.

        They are smooth in the bodies' motion: corners, ends and whether a pad has
        lifted off change them through the mode alone.
        """
        forces, first = [], 0
        for group, values in self._stroke_groups(params):
            count, corners = len(group.springs), len(group.law.corners)
            last = first + count * corners
            # Spring after spring, and of each its corners.
            passed = [mode.corners[first + i : last : corners] for i in range(corners)]
            first = last
            at, speed = self._displacements(group, bodies, params)
            force = group.law.force(values, at, speed, passed, jnp)
            forces.append(jnp.broadcast_to(force, at.shape))
        return jnp.concatenate(forces, axis=-2)

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
        forces = [jnp.zeros(())] * self.count
        for i, k in enumerate(self.timed):
            forces[k] = timed[..., i, :]
        if self.by_stroke:
            acts = self._acts(mode)[np.array(self.by_stroke)]
            # Most of a run nothing pushes.
            shape = (*bodies.p_WBo[0].shape[:-2], *acts.shape)
            each = lax.cond(
                acts.any(),
                lambda: jnp.where(acts, self.stroke_forces(bodies, params, mode), 0.0),
                lambda: jnp.zeros(shape),
            )
            for i, k in enumerate(self.by_stroke):
                forces[k] = each[..., i, :]
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
