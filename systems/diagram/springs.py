"""The separation springs, and whatever else pushes."""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias

from pydrake.systems.framework import BasicVector, Context, WitnessFunction

from drakesep.systems.checks import X_AXIS
from drakesep.systems.diagram.event_latch import LatchingSystem
from drakesep.systems.diagram.rows import Rows
from drakesep.systems.diagram.state_layout import BodyStates, StateLayout
from drakesep.systems.diagram.wrenches import Forces, WrenchSum
from drakesep.systems.equations.pushers import (
    AXIS,
    Pushing,
    PushLaw,
    is_push_over,
    push_displacement,
    push_force,
    push_place,
    push_progress,
    push_wrenches,
    time_to_go,
    values_of,
)
from drakesep.systems.equations.relative_motion import BodyState, Wrench
from drakesep.systems.equations.springs import law_of
from drakesep.systems.equations.straight_line import (
    LINE_OPS,
    line_if_straight,
    straight_line,
)
from drakesep.systems.model.parameters import names_of
from drakesep.systems.model.separation import Separation
from drakesep.systems.sampling import NANOSECOND
from drakesep.systems.vectors import Ops, Vector


_SOON, _WELL_BEFORE = 1e-4, 0.9
"""A lift-off, foreseen by a line, is approached to so much of the time until it, until
it is within a tenth of a millisecond: forces curve."""


class PushRow(NamedTuple):
    """A pusher in a Context."""

    values: Any
    """Its parameters, as its law takes them."""
    p_AoPad_A: Vector
    """Place of its pad in A, while mated, m."""
    p_BoPad_B: Vector
    """Place of its pad in B, m."""
    axis_A: Vector

    @property
    def place(self) -> tuple[Vector, Vector, Vector | None]:
        """Where it pushes; its axis is None if it is A's x axis."""
        axis = None if self.axis_A == X_AXIS else self.axis_A
        return self.p_AoPad_A, self.p_BoPad_B, axis


class _Push(NamedTuple):
    """A spring that pushes."""

    number: int
    """Of all springs."""
    a: int
    b: int
    law: PushLaw
    jumps: bool
    """Whether it is one by time that ends in a jump."""
    now: Pushing

    @property
    def foreseen(self) -> "_Foreseen":
        """Return what it comes to, as one by displacement."""
        law, values = self.law, self.now.values
        damped = any(getattr(values, name) for name in law.dampers)
        kinks = [law.stroke(values, math) * corner for corner in law.corners]
        abrupt = law.ends_in_jump(values)
        if not abrupt:
            kinks.append(self.now.end)
        along_x = self.now.axis_A is None
        return _Foreseen(
            self.a,
            self.b,
            law,
            self.now,
            kinks,
            abrupt,
            bool(law.way) and (damped or law.may_lift),
            straight_line(_paces, along_x),
        )

    def force(self, bodies: BodyStates, t: float) -> float:
        """Return its force, N; nothing from the end of its stroke on."""
        A, B = bodies[self.a], bodies[self.b]
        return float(push_force(self.law, self.jumps, self.now, A, B, t, math))


class _Foreseen(NamedTuple):
    """What a spring by displacement comes to, foreseen from how its pad moves."""

    a: int
    b: int
    law: PushLaw
    now: Pushing
    kinks: list[float]
    """Places of its force's kinks, m: corners of its profile, the end of its stroke."""
    ends_in_jump: bool
    lifts: bool
    """Whether its pad may lift off before its end."""
    paces: Callable[..., tuple[float, float, float, float]]

    def times(
        self, bodies: BodyStates, later: BodyStates, moment: float
    ) -> tuple[float, float]:
        """Return until the next kink of its force, s, and until a jump that ends it.

        By parabolas; of a lift-off by the line of its force. Within a nanosecond of a
        kink a step has ended there.
        """
        a, b, push = self.a, self.b, self.now
        place = push.p_AoPad_A, push.p_BoPad_B, push.axis_A
        paces = self.paces(bodies[a], bodies[b], later[a], later[b], place)
        at, speed, at_later, speed_later = paces
        acceleration = (speed_later - speed) / moment
        times = [time_to_go(kink - at, speed, acceleration) for kink in self.kinks]
        if self.lifts:
            passed = self.law.passed(push.values, at, math)
            force, force_later = (
                self.law.force(push.values, *pace, passed, math)
                for pace in ((at, speed), (at_later, speed_later))
            )
            if (gone := force - force_later) != 0.0:
                lift = force * moment / gone
                times.append(lift if lift < _SOON else _WELL_BEFORE * lift)
        kink = min((t for t in times if t > NANOSECOND), default=math.inf)
        if not self.ends_in_jump:
            return kink, math.inf
        return kink, time_to_go(push.end - at, speed, acceleration)


def _paces(
    along_x: bool,
    A: BodyState,
    B: BodyState,
    A_later: BodyState,
    B_later: BodyState,
    place: tuple[Vector, Vector, Vector | None],
) -> tuple[float, float, float, float]:
    """Return how far a pad has gone, m, and how fast, m/s; and so a moment later."""
    return (
        *push_displacement(A, B, *place),
        *push_displacement(A_later, B_later, *place),
    )


class _Pushes(NamedTuple):
    """The springs that push one body from another."""

    a: int
    b: int
    springs: list[_Push]
    now: tuple[Pushing, ...]
    line: Callable[..., tuple[Wrench, Wrench]]
    over: Callable[..., tuple[bool, ...]]
    foreseen: list[_Foreseen]
    """Of those by displacement."""

    @classmethod
    def of(cls, a: int, b: int, springs: list[_Push]) -> "_Pushes":
        """Return them together."""
        kinds = tuple((s.law, s.jumps, s.now.axis_A is None) for s in springs)
        line = line_if_straight(_pushed, kinds, LINE_OPS)
        over = line_if_straight(_over, kinds)
        foreseen = [s.foreseen for s in springs if not s.law.by_time]
        return cls(a, b, springs, tuple(s.now for s in springs), line, over, foreseen)

    def __call__(self, bodies: BodyStates, t: float, total: WrenchSum) -> None:
        on_A, on_B = self.line(bodies[self.a], bodies[self.b], t, self.now)
        total.add(self.a, on_A)
        total.add(self.b, on_B)

    def are_over(self, bodies: BodyStates, t: float) -> tuple[bool, ...]:
        """Return whether the stroke of each has been reached."""
        return self.over(bodies[self.a], bodies[self.b], t, self.now)


_Kinds: TypeAlias = tuple[tuple[PushLaw, bool, bool], ...]
"""Of springs: the law, whether it jumps, and whether it pushes along A's x axis."""


def _pushed(
    kinds: _Kinds,
    ops: Ops,
    A: BodyState,
    B: BodyState,
    t: float,
    pushes: Sequence[Pushing],
) -> tuple[Wrench, Wrench]:
    forces = [
        (push_force(law, jumps, push, A, B, t, ops), push.p_BoPad_B, push.axis_A)
        for (law, jumps, _), push in zip(kinds, pushes, strict=True)
    ]
    return push_wrenches(A, B, forces)


def _over(
    kinds: _Kinds, A: BodyState, B: BodyState, t: float, pushes: Sequence[Pushing]
) -> tuple[bool, ...]:
    return tuple(
        is_push_over(law, push, push_progress(law, push, A, B, t)[0], t)
        for (law, _, _), push in zip(kinds, pushes, strict=True)
    )


class Springs(LatchingSystem):
    """Pushes B from A by the spring of each released attachment.

    Its law says how, see `PushLaw`: a `Spring` is driven by time (Eq. 5), a
    `DisplacementSpring` by the displacement of its pad along its axis, tilted if it is
    misaligned. The force acts on B at the pad fixed in B, along that
    axis; the reaction acts on A at the same point in space. A spring whose stroke was
    reached has let go of its pad: it does not push again, wherever the bodies go.

    Input ports:
        plant_state: (s,) 1, m, rad/s and m/s in W: state of the plant, in which the
            layout finds the motion of each body.
        released: (n,) s: time of each attachment's release; infinite while it holds.

    Output ports:
        acting: abstract: what acts until an event changes it, for a `ForceSum`.
        wrenches: (6 m,) N m and N in W: torque about the origin, then force, on each of
            the m bodies.
        forces: (k,) N: force of each spring.
        energy: (1,) J: energy that the springs driven by displacement store.

    Discrete state:
        (k,) 1 for each spring that has let go of its pad; and the step's start.

    Parameters:
        0: for each spring a `PushRow`.
    """

    def __init__(self, separation: Separation, layout: StateLayout):
        super().__init__([0.0] * len(separation.springs))
        attachments = [attachment for attachment, _ in separation.pushing]
        self._attachments = [separation.attachments.index(a) for a in attachments]
        self._ends = [separation.ends(attachment) for attachment in attachments]
        state = self.DeclareVectorInputPort("plant_state", layout.size)
        self._released = self.DeclareVectorInputPort(
            "released", len(separation.attachments)
        )
        self._laws = [law_of(spring) for spring in separation.springs]
        self._by_stroke = [k for k, law in enumerate(self._laws) if not law.by_time]
        self._rows = Rows(self, self._rows_of(separation))
        self._forces = Forces(
            self,
            state,
            layout,
            self._find_acting,
            {
                self._latched_ticket,
                self._released.ticket(),
                self.all_parameters_ticket(),
            },
        )
        self.DeclareVectorOutputPort("forces", len(self._laws), self._calc_forces)
        self.DeclareVectorOutputPort("energy", 1, self._calc_energy)

    def set_springs(self, context: Context, separation: Separation) -> None:
        """Write the springs of a separation, and that none has let go of its pad."""
        self._reset(context)
        self._rows.write(context, self._rows_of(separation))

    def _rows_of(self, separation: Separation) -> list[PushRow]:
        return [
            PushRow(values_of(law, spring), *push_place(separation, attachment, spring))
            for law, (attachment, spring) in zip(
                self._laws, separation.pushing, strict=True
            )
        ]

    def parameters_read(self, separation: Separation) -> set[str]:
        """Return the names of the parameters that the rows are made of."""
        names: set[str] = set()
        for row, (attachment, spring) in zip(
            self._rows_of(separation), separation.pushing, strict=True
        ):
            names |= {*names_of([attachment], ["p_AoPad_A"])}
            names |= {*names_of([spring], [*row.values._fields, *AXIS])}
        return names

    def _find_acting(self, context: Context) -> list[_Pushes]:
        """Return the springs that are released, and have not let go of their pad."""
        released = self._released.Eval(context).tolist()
        spent, rows = self._get_latched(context), self._rows.read(context)
        pushing: dict[tuple[int, int], list[_Push]] = {}
        for k, (law, (a, b)) in enumerate(zip(self._laws, self._ends, strict=True)):
            release = released[self._attachments[k]]
            if math.isfinite(release) and not spent[k]:
                values = rows[k].values
                now = Pushing(values, law.end(values, math), release, *rows[k].place)
                jumps = law.by_time and law.ends_in_jump(values)
                push = _Push(k, a, b, law, jumps, now)
                pushing.setdefault((a, b), []).append(push)
        return [_Pushes.of(a, b, springs) for (a, b), springs in pushing.items()]

    def _pushing(self, context: Context) -> tuple[list[_Push], BodyStates]:
        """Return the springs that push, and the bodies."""
        pushing = [
            push for pushes in self._forces.eval(context) for push in pushes.springs
        ]
        return pushing, self._forces.read_bodies(context)

    def _is_waiting(self, latched: list[float]) -> bool:
        return not all(latched)

    def _needs_age(self, context: Context) -> bool:
        return bool(self._jumping(context))

    def _jumping(self, context: Context) -> list[int]:
        """Return which springs will end with force left: a step ends at that jump."""
        rows, spent = self._rows.read(context), self._get_latched(context)
        return [
            k
            for k, (law, row) in enumerate(zip(self._laws, rows, strict=True))
            if not spent[k] and law.ends_in_jump(row.values)
        ]

    def _is_due(self, context: Context, latched: list[float], t: float) -> bool:
        """Return whether a spring has ended in a jump: no other end ends a step."""
        due = self._due(context, latched, t)
        return any(due[k] != latched[k] for k in self._jumping(context))

    def DoGetWitnessFunctions(self, context: Context) -> list[WitnessFunction]:
        """Return that of strokes, if one of them ends in a jump."""
        witnesses = super().DoGetWitnessFunctions(context)
        return witnesses if self._needs_age(context) else []

    def _due(self, context: Context, latched: list[float], t: float) -> list[float]:
        """Return 1 for each spring whose stroke has been reached."""
        spent, bodies = [*latched], self._forces.read_bodies(context)
        for pushes in self._forces.eval(context):
            over = pushes.are_over(bodies, t)
            for push, it in zip(pushes.springs, over, strict=True):
                spent[push.number] = float(it)
        return spent

    def times_to_kinks(
        self, context: Context, later: BodyStates, moment: float
    ) -> tuple[float, float]:
        """Return in which time the next pad reaches a kink of its spring's force, s.

        A corner of its profile, the end of its stroke, or where it lifts off; infinite
        if none does. Of springs by displacement, as bodies move now and a moment later.

        Args:
            context: of this system.
            later: the bodies then.
            moment: s.

        Returns:
            Of kinks, and of ends that are jumps.
        """
        bodies = self._forces.read_bodies(context)
        times = [
            foreseen.times(bodies, later, moment)
            for pushes in self._forces.eval(context)
            for foreseen in pushes.foreseen
        ]
        kinks, jumps = zip(*times, strict=True) if times else ((), ())
        return min(kinks, default=math.inf), min(jumps, default=math.inf)

    def _calc_forces(self, context: Context, output: BasicVector) -> None:
        forces = [0.0] * len(self._laws)
        pushing, bodies = self._pushing(context)
        for push in pushing:
            forces[push.number] = push.force(bodies, context.get_time())
        output.SetFromVector(forces)

    def _calc_energy(self, context: Context, output: BasicVector) -> None:
        energy = 0.0
        bodies, rows = self._forces.read_bodies(context), self._rows.read(context)
        spent = self._get_latched(context)
        for k in self._by_stroke:
            law, values = self._laws[k], rows[k].values
            a, b = self._ends[k]
            place = rows[k].place
            displacement, _ = push_displacement(bodies[a], bodies[b], *place)
            if displacement < law.end(values, math) and not spent[k]:
                energy += law.energy(values, displacement)
        output.SetFromVector([energy])
