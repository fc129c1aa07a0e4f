"""The release of the attachments, held as discrete state."""

import math

import numpy as np
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    EventStatus,
    LeafSystem,
    WitnessFunction,
    WitnessFunctionDirection,
)

from drakesep.systems import joint_laws
from drakesep.systems.geometry import mated_orientation
from drakesep.systems.model import Separation
from drakesep.systems.state_layout import StateLayout


_UP = 0.5
"""A trigger above this commands the release."""
_STEP_MIN = 1e-9
"""Age of a step, s, from which on it may be ended for a trigger that is up."""
_JOINT_FIELDS = 7
"""Of a joint: the mated orientation q_AB, and its x axis in A."""


class Release(LeafSystem):
    """Lets go of each attachment at its time, at a command, or at its joint's angle.

    If one of the triggers is connected, an attachment lets go when its trigger rises
    above 0.5, and the scheduled times are not used. An attachment with a release angle
    lets go also when its joint has turned by it.

    A release that is due is latched at the start of the simulation and of every
    step. A witness function ends a step where one becomes due, within a hundredth of
    the accuracy in seconds; the recorded time of a scheduled one is the scheduled. The
    Context of the whole diagram needs an accuracy (``context.SetAccuracy``).

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
        super().__init__()
        n = len(separation.attachments)
        index = {body.name: i for i, body in enumerate(separation.bodies)}
        self._ends = [(index[a.A], index[a.B]) for a in separation.attachments]
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
        released = self.DeclareDiscreteState(np.full(n, math.inf))
        self._step_start = self.DeclareDiscreteState([-math.inf])
        self.DeclareStateOutputPort("released", released)
        self.DeclareInitializationDiscreteUpdateEvent(self._update)
        self.DeclarePerStepDiscreteUpdateEvent(self._update)
        self._witness = self.MakeWitnessFunction(
            "release",
            WitnessFunctionDirection.kNegativeThenNonNegative,
            lambda context: 1.0 if self._is_overdue(context) else -1.0,
        )

    def set_schedule(self, context: Context, separation: Separation) -> None:
        """Write when a separation's attachments let go into this system's Context."""
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
        released = self._get_released(context)
        return any(
            math.isinf(released[i]) and self._has_turned(context, i)
            for i in self._hinged
        )

    def _get(self, context: Context, parameter: int) -> list[float]:
        return context.get_numeric_parameter(parameter).value().tolist()

    def _get_released(self, context: Context) -> list[float]:
        return context.get_discrete_state(0).value().tolist()

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
        return self._angle(context, i) >= self._get(context, self._angles)[i]

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

    def _update(self, context: Context, update: DiscreteValues) -> EventStatus:
        now = context.get_time()
        command = self._get_command(context)
        schedule = self._get(context, self._schedule)
        start = context.get_discrete_state(self._step_start)[0]
        before = self._get_released(context)
        after = list(before)
        for i, released in enumerate(before):
            if not math.isinf(released):
                continue
            if command is None:
                if schedule[i] <= now:
                    # What was due before the run's start happens at its start.
                    after[i] = schedule[i] if math.isfinite(start) else now
            elif command[i]:
                after[i] = now
            hinged = i in self._hinged and math.isinf(after[i])
            if hinged and self._has_turned(context, i):
                after[i] = now
        holds = any(map(math.isinf, after))
        if after == before and math.isfinite(start) and not (command and holds):
            return EventStatus.DidNothing()  # spares a new evaluation of the forces
        update.set_value(0, after)
        update.set_value(self._step_start, [now])
        return EventStatus.Succeeded()

    def _is_overdue(self, context: Context) -> bool:
        """Return whether the step must end for a release.

        A step that ends at the scheduled time needs no search, and Drake ends the
        process when the crossing that it searches lies at the end of AdvanceTo: so the
        sign changes just after that time. A trigger that is up from the start of a step
        on, as one set by an event is, has no crossing: so the step must have an age.
        """
        held = [i for i, t in enumerate(self._get_released(context)) if math.isinf(t)]
        if not held:
            return False
        now = context.get_time()
        command = self._get_command(context)
        if command is None:
            schedule = self._get(context, self._schedule)
            overdue = any(now > schedule[i] for i in held)
        else:
            age = now - context.get_discrete_state(self._step_start)[0]
            overdue = age > _STEP_MIN and any(command[i] for i in held)
        return overdue or self.is_due_by_angle(context)

    def DoGetWitnessFunctions(self, context: Context) -> list[WitnessFunction]:
        """Return one for all: Drake does not ask again after every step."""
        return [self._witness]
