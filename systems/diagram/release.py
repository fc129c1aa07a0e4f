"""The release of the attachments, held as discrete state."""

import math
from typing import NamedTuple

from pydrake.systems.framework import Context

from drakesep.systems.diagram.event_latch import LatchingSystem
from drakesep.systems.diagram.rows import Rows
from drakesep.systems.diagram.state_layout import StateLayout
from drakesep.systems.equations import joints as joint_laws
from drakesep.systems.equations.mated_stack import (
    mated_ends,
    mated_orientation,
    pad_on_B,
)
from drakesep.systems.equations.pushers import push_displacement
from drakesep.systems.equations.relative_motion import BodyState
from drakesep.systems.equations.straight_line import LINE_OPS, straight_line
from drakesep.systems.model.parameters import names_of
from drakesep.systems.model.separation import Separation
from drakesep.systems.vectors import Ops, Quaternion, Vector, dot, rotate, subtract


_UP = 0.5
"""A trigger above this commands the release."""


class ReleaseRow(NamedTuple):
    """When an attachment lets go, in a Context."""

    release_time: float
    """s; infinite: not by time."""
    release_angle: float
    """rad; infinite: not by angle."""
    release_travel: float
    """m; infinite: not by travel."""
    q_AB: Quaternion
    """Orientation of its B in its A while mated."""
    x_axis_A: Vector
    """About which its joint turns, and along which it slides."""
    p_AoPad_A: Vector
    """m."""
    p_BoPad_B: Vector
    """The pad on its B, m."""


class _Move(NamedTuple):
    """How a joint has moved in the direction that its type leaves free."""

    limit: float
    """At which it lets go, m or rad."""
    value: float
    """How far it has, m or rad."""
    rate: float
    """How fast it does."""

    @property
    def is_far_enough(self) -> bool:
        """Whether it is to let go."""
        return abs(self.value) >= self.limit

    @property
    def time_left(self) -> float:
        """How long until it will, as fast as it moves now, s."""
        if self.is_far_enough:
            return 0.0
        approach = math.copysign(self.rate, self.value * self.rate)
        return (self.limit - abs(self.value)) / approach if approach > 0.0 else math.inf


def _moves(
    ops: Ops, slides: bool, turns: bool, A: BodyState, B: BodyState, row: ReleaseRow
) -> tuple[_Move, ...]:
    """Return how far a joint has slid and turned, if it is to let go by that."""
    moves: tuple[_Move, ...] = ()
    axis_A = row.x_axis_A
    if slides:
        slid = push_displacement(A, B, row.p_AoPad_A, row.p_BoPad_B, axis_A)
        moves += (_Move(row.release_travel, *slid),)
    if turns:
        angle = joint_laws.twist_angle(A.q_WB, B.q_WB, row.q_AB, axis_A, ops)
        rate = dot(rotate(A.R_WB, axis_A), subtract(B.w_WB, A.w_WB))
        moves += (_Move(row.release_angle, angle, rate),)
    return moves


class Release(LatchingSystem):
    """Lets go of each attachment at its time, at a command, or by its joint's motion.

    If one of the triggers is connected, an attachment lets go when its trigger rises
    above 0.5, and the scheduled times are not used. An attachment with a release angle,
    or travel, lets go also when its joint has turned, or slid, by it.

    Exact to event isolation, see `LatchingSystem`; the recorded time of a scheduled
    release is the scheduled.

    Input ports:
        plant_state: (s,) 1, m, rad/s and m/s in W: state of the plant, in which the
            layout finds the motion of each body.
        trigger: (1,) 1: commands the release of all attachments where it rises above
            0.5; optional. With it, or the next, the scheduled times are not used.
        triggers: (n,) 1: command the release of each attachment likewise; optional.
            With both, an attachment lets go at the first of the two.

    Output ports:
        released: (n,) s: time of each attachment's release; infinite while it holds.

    Parameters:
        0: for each attachment a `ReleaseRow`.
    """

    def __init__(self, separation: Separation, layout: StateLayout):
        n = len(separation.attachments)
        super().__init__([math.inf] * n)
        self._ends = [separation.ends(a) for a in separation.attachments]
        self._by_motion = [
            i for i, a in enumerate(separation.attachments) if a.released_by_motion
        ]
        self._laws = [
            straight_line(
                _moves,
                LINE_OPS,
                math.isfinite(a.release_travel),
                math.isfinite(a.release_angle),
            )
            for a in separation.attachments
        ]
        self._layout = layout
        self._state = self.DeclareVectorInputPort("plant_state", layout.size)
        self._trigger = self.DeclareVectorInputPort("trigger", 1)
        self._triggers = self.DeclareVectorInputPort("triggers", n)
        self._rows = Rows(self, _rows_of(separation))
        self.DeclareStateOutputPort("released", self._latched)

    def set_schedule(self, context: Context, separation: Separation) -> None:
        """Write when a separation's attachments let go, and that none has yet."""
        self._reset(context)
        self._rows.write(context, _rows_of(separation))

    def parameters_read(self, separation: Separation) -> set[str]:
        """Return the names of the parameters that the rows are made of."""
        return {*names_of(separation.attachments, ReleaseRow._fields)}

    def time_left(self, context: Context) -> float:
        """Return when the next attachment will have moved far enough, s from now.

        As fast as its joint moves now; 0 if it has moved far enough, infinite if none
        that waits for it does so.
        """
        released = self._get_latched(context)
        waiting = [i for i in self._by_motion if math.isinf(released[i])]
        moves = [move for i in waiting for move in self._moves(context, i)]
        return min((move.time_left for move in moves), default=math.inf)

    def _get_command(self, context: Context) -> list[bool] | None:
        """Return which attachments are commanded to let go; None: by schedule."""
        n = len(self._ends)
        if self._triggers.HasValue(context):
            up = [value > _UP for value in self._triggers.Eval(context).tolist()]
        elif self._trigger.HasValue(context):
            up = [False] * n
        else:
            return None
        if self._trigger.HasValue(context) and self._trigger.Eval(context)[0] > _UP:
            up = [True] * n
        return up

    def _has_moved(self, context: Context, i: int) -> bool:
        """Return whether an attachment's joint has turned, or slid, far enough."""
        return any(move.is_far_enough for move in self._moves(context, i))

    def _moves(self, context: Context, i: int) -> tuple[_Move, ...]:
        """Return how far an attachment's joint has moved, by what lets go of it."""
        bodies = self._layout.bodies(self._state.Eval(context).tolist())
        A, B = (bodies[end] for end in self._ends[i])
        moves: tuple[_Move, ...] = self._laws[i](A, B, self._rows.read(context)[i])
        return moves

    def _is_waiting(self, latched: list[float]) -> bool:
        return any(map(math.isinf, latched))

    def _needs_age(self, context: Context) -> bool:
        # A command may come from an event of this instant.
        triggers = self._triggers, self._trigger
        return any(port.HasValue(context) for port in triggers)

    def _due(self, context: Context, latched: list[float], t: float) -> list[float]:
        released = [*latched]
        command = self._get_command(context)
        rows = self._rows.read(context)
        for i, before in enumerate(released):
            if not math.isinf(before):
                continue
            if command is None:
                scheduled = rows[i].release_time
                if scheduled <= t:
                    # What was due before the run's start happens at its start.
                    released[i] = t if self._is_starting(context) else scheduled
            elif command[i]:
                released[i] = t
            by_motion = i in self._by_motion and math.isinf(released[i])
            if by_motion and self._has_moved(context, i):
                released[i] = t
        return released


def _rows_of(separation: Separation) -> list[ReleaseRow]:
    rows = []
    for a in separation.attachments:
        ends = mated_ends(separation, a)
        rows.append(
            ReleaseRow(
                a.release_time,
                a.release_angle,
                a.release_travel,
                mated_orientation(*ends),
                a.joint.x_axis_A,
                a.p_AoPad_A,
                pad_on_B(*ends, a.p_AoPad_A),
            )
        )
    return rows
