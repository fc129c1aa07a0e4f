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

from drakesep.systems import laws
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
    step. Witness functions end a step where one becomes due, within a hundredth of
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
        self._witnesses = [self._make_witness(i) for i in range(n)]

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
        return any(
            math.isinf(released) and self._has_turned(context, i)
            for i, released in enumerate(self._get_released(context))
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
        limit = self._get(context, self._angles)[i]
        if math.isinf(limit):
            return False
        x = self._state.Eval(context).tolist()
        a, b = self._ends[i]
        p = self._get(context, self._joints)[_JOINT_FIELDS * i :]
        angle = laws.twist_angle(
            self._layout.read_one(x, a).q_WB,
            self._layout.read_one(x, b).q_WB,
            (p[0], p[1], p[2], p[3]),
            (p[4], p[5], p[6]),
            math,
        )
        return angle >= limit

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
            if math.isinf(after[i]) and self._has_turned(context, i):
                after[i] = now
        holds = any(map(math.isinf, after))
        if after == before and math.isfinite(start) and not (command and holds):
            return EventStatus.DidNothing()  # spares a new evaluation of the forces
        update.set_value(0, after)
        update.set_value(self._step_start, [now])
        return EventStatus.Succeeded()

    def _make_witness(self, i: int) -> WitnessFunction:
        def calc(context: Context) -> float:
            return 1.0 if self._is_overdue(context, i) else -1.0

        return self.MakeWitnessFunction(
            f"release {i}", WitnessFunctionDirection.kNegativeThenNonNegative, calc
        )

    def _is_overdue(self, context: Context, i: int) -> bool:
        """Return whether the step must end for a release.

        A step that ends at the scheduled time needs no search, and Drake ends the
        process when the crossing that it searches lies at the end of AdvanceTo: so the
        sign changes just after that time. A trigger that is up from the start of a step
        on, as one set by an event is, has no crossing: so the step must have an age.
        """
        if math.isfinite(self._get_released(context)[i]):
            return False
        now = context.get_time()
        command = self._get_command(context)
        if command is None:
            overdue = now > self._get(context, self._schedule)[i]
        else:
            age = now - context.get_discrete_state(self._step_start)[0]
            overdue = command[i] and age > _STEP_MIN
        return overdue or self._has_turned(context, i)

    def DoGetWitnessFunctions(self, context: Context) -> list[WitnessFunction]:
        """Return all witnesses: Drake does not ask again after every step."""
        return self._witnesses
