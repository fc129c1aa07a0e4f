"""The release of the attachments, held as discrete state."""

import math

from pydrake.systems.framework import BasicVector, Context

from drakesep.systems.diagram.event_latch import LatchingSystem
from drakesep.systems.diagram.state_layout import StateLayout
from drakesep.systems.equations import joints as joint_laws
from drakesep.systems.equations.mated_stack import mated_orientation
from drakesep.systems.model.separation import Separation


_UP = 0.5
"""A trigger above this commands the release."""
_JOINT_FIELDS = 7
"""Of a joint: the mated orientation q_AB, and its x axis in A."""


class Release(LatchingSystem):
    """Lets go of each attachment at its time, at a command, or at its joint's angle.

    If one of the triggers is connected, an attachment lets go when its trigger rises
    above 0.5, and the scheduled times are not used. An attachment with a release angle
    lets go also when its joint has turned by it.

    Exact to event isolation, see `LatchingSystem`; the recorded time of a scheduled
    release is the scheduled.

    Input ports:
        plant_state: state of the plant.
        trigger: (1,) commands the release of all attachments; optional.
        triggers: (n,) command the release of each attachment; optional.

    Output port:
        released: (n,) time at which each attachment was released, s; infinite
            while it holds.

    Parameters:
        0: (n,) scheduled times, s; infinite for none.
        1: (n,) release angles, rad; infinite for none.
        2: (7 n,) for each attachment the mated orientation q_AB and its joint's x axis
            in A.
    """

    def __init__(self, separation: Separation, layout: StateLayout):
        n = len(separation.attachments)
        super().__init__([math.inf] * n)
        self._ends = [separation.ends(a) for a in separation.attachments]
        self._hinged = [
            i
            for i, a in enumerate(separation.attachments)
            if math.isfinite(a.release_angle)
        ]
        self._layout = layout
        self._state = self.DeclareVectorInputPort("plant_state", layout.size)
        self._trigger = self.DeclareVectorInputPort("trigger", 1)
        self._triggers = self.DeclareVectorInputPort("triggers", n)
        self._schedule = self.DeclareNumericParameter(BasicVector(n))
        self._angles = self.DeclareNumericParameter(BasicVector(n))
        self._joints = self.DeclareNumericParameter(BasicVector(_JOINT_FIELDS * n))
        self.DeclareStateOutputPort("released", self._latched)

    def set_schedule(self, context: Context, separation: Separation) -> None:
        """Write when a separation's attachments let go, and that none has yet."""
        self._reset(context)
        attachments = separation.attachments
        joints: list[float] = []
        for a in attachments:
            joints += mated_orientation(separation.body(a.A), separation.body(a.B))
            joints += a.joint.x_axis_A
        for parameter, values in (
            (self._schedule, [a.release_time for a in attachments]),
            (self._angles, [a.release_angle for a in attachments]),
            (self._joints, joints),
        ):
            context.get_mutable_numeric_parameter(parameter).SetFromVector(values)

    def is_due_by_angle(self, context: Context) -> bool:
        """Return whether an attachment holds that has turned by its release angle."""
        released = self._get_latched(context)
        return any(
            math.isinf(released[i]) and self._has_turned(context, i)
            for i in self._hinged
        )

    def _get(self, context: Context, parameter: int) -> list[float]:
        return context.get_numeric_parameter(parameter).value().tolist()

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

    def _has_turned(self, context: Context, i: int) -> bool:
        return abs(self._angle(context, i)) >= self._get(context, self._angles)[i]

    def _angle(self, context: Context, i: int) -> float:
        """Return by how much an attachment's joint has turned about its x axis, rad."""
        x = self._state.Eval(context).tolist()
        a, b = self._ends[i]
        p = self._get(context, self._joints)[_JOINT_FIELDS * i :]
        return joint_laws.twist_angle(
            self._layout.read_one(x, a).q_WB,
            self._layout.read_one(x, b).q_WB,
            (p[0], p[1], p[2], p[3]),
            (p[4], p[5], p[6]),
            math,
        )

    def _needs_age(self, context: Context) -> bool:
        # A command may come from an event of this instant.
        return self._get_command(context) is not None

    def _due(self, context: Context, t: float) -> list[float]:
        released = self._get_latched(context)
        if all(map(math.isfinite, released)):
            return released
        command = self._get_command(context)
        schedule = self._get(context, self._schedule)
        for i, before in enumerate(released):
            if not math.isinf(before):
                continue
            if command is None:
                if schedule[i] <= t:
                    # What was due before the run's start happens at its start.
                    released[i] = t if self._is_starting(context) else schedule[i]
            elif command[i]:
                released[i] = t
            hinged = i in self._hinged and math.isinf(released[i])
            if hinged and self._has_turned(context, i):
                released[i] = t
        return released
