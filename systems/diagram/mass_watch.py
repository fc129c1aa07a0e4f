"""Accelerations held against the mass properties of a separation's bodies."""

import itertools
import math
import warnings
from collections.abc import Mapping

from pydrake.systems.framework import Context, EventStatus, LeafSystem

from drakesep.systems.checks import DrakesepWarning, InputError
from drakesep.systems.diagram.rows import Rows
from drakesep.systems.diagram.state_layout import StateLayout
from drakesep.systems.equations.articulated_inertia import Massive
from drakesep.systems.equations.relative_motion import BodyState, Wrench
from drakesep.systems.equations.rigid_body import accelerations, inverse
from drakesep.systems.model.separation import Body, Separation
from drakesep.systems.vectors import Vector, add, subtract


_APART = 1e-5
"""By which accelerations may differ, as a part of what makes them: a plant's mass
properties may be those of the separation to 1e-6."""
_EVERY = 8
"""Steps from look to look: one costs half as much as a step."""


class OtherMotion(DrakesepWarning):
    """A body moves otherwise than its mass properties and what acts on it say."""


class MassWatch(LeafSystem):
    """Tells when a plant's bodies have other mass properties than the separation.

    A plant's Context is seen by no other system. What it has for a body's mass, CG and
    inertia shows in how the body accelerates: at every eighth step that is held against
    Newton and Euler.

    Input ports:
        plant_state: (s,) 1, m, rad/s and m/s in W: state of the plant, in which the
            layout finds the motion of each body.
        plant_acceleration: (6 m,) rad/s^2 and m/s^2 in W: angular acceleration, then
            acceleration of the origin, of each of the m bodies.
        wrenches: (6 m,) N m and N in W: torque about the origin, then force, on each of
            the m bodies: all that acts but gravity.

    Parameters:
        0: for each watched body a `Massive`.
    """

    def __init__(
        self,
        separation: Separation,
        layout: StateLayout,
        watched: Mapping[str, Vector],
        *,
        refuses: bool,
    ):
        """Prepare.

        Args:
            separation: with the bodies.
            layout: where `plant_state` holds the motion of each body.
            watched: gravity in W, m/s^2, by the names of bodies on which nothing else
                acts that is not seen.
            refuses: whether another motion is an error: else it is a warning.
        """
        super().__init__()
        self._layout, self._watched, self._refuses = layout, watched, refuses
        self._places = [separation.bodies.index(b) for b in self._bodies(separation)]
        self._names = [separation.bodies[i].name for i in self._places]
        size = 6 * len(separation.bodies)
        self._state = self.DeclareVectorInputPort("plant_state", layout.size)
        self._acceleration = self.DeclareVectorInputPort("plant_acceleration", size)
        self._wrenches = self.DeclareVectorInputPort("wrenches", size)
        self._masses = Rows(self, self._mass_rows(separation))
        # No state of the Context: with a new one all is computed anew at each step.
        self._turns = itertools.cycle([True] + [False] * (_EVERY - 1))
        self.DeclarePerStepPublishEvent(self._look_in_turn)

    def set_bodies(self, context: Context, separation: Separation) -> None:
        """Write the mass properties into this system's Context."""
        self._masses.write(context, self._mass_rows(separation))

    def _bodies(self, separation: Separation) -> list[Body]:
        return [body for body in separation.bodies if body.name in self._watched]

    def _mass_rows(self, separation: Separation) -> list[Massive]:
        bodies = self._bodies(separation)
        return [Massive(b.mass, b.p_BoBcm_B, tuple(b.I_BBcm_B)) for b in bodies]

    def _look_in_turn(self, context: Context) -> EventStatus:
        if next(self._turns):
            self._look(context)
        return EventStatus.Succeeded()

    def _look(self, context: Context) -> None:
        x = self._state.Eval(context).tolist()
        entries = self._wrenches.Eval(context).tolist()
        got = self._acceleration.Eval(context).tolist()
        rows = self._masses.read(context)
        for name, i, row in zip(self._names, self._places, rows, strict=True):
            torque, force, alpha, a = (
                tuple(values[k : k + 3])
                for values in (entries, got)
                for k in (6 * i, 6 * i + 3)
            )
            body, wrench = self._layout.read_one(x, i), Wrench(torque, force)
            if not _follows(body, row, wrench, self._watched[name], (alpha, a)):
                self._tell(name)

    def _tell(self, name: str) -> None:
        # Without numbers, so that Python shows it once.
        text = (
            f"{name}: must move as its mass properties in the separation and the "
            "forces that are seen say, got another acceleration from the plant: either "
            "its mass, CG or inertia was changed in the plant's Context alone, and "
            "set_separation and set_mass_properties write a varied one's into both, or "
            "the body is locked or something acts on it that was connected later"
        )
        if self._refuses:
            raise InputError(f"{text}; rigid joints must know all of this")
        warnings.warn(OtherMotion(text), stacklevel=2)


def _follows(
    body: BodyState,
    row: Massive,
    wrench: Wrench,
    gravity: Vector,
    got: tuple[Vector, Vector],
) -> bool:
    """Return whether accelerations in W are those that a wrench and gravity give.

    Args:
        body: the body.
        row: its mass properties.
        wrench: on it.
        gravity: m/s^2.
        got: angular acceleration, rad/s^2, and acceleration of the origin, m/s^2.
    """
    mass, c, inertia = row
    flexibility = inverse(inertia)
    alpha, a_Bo = accelerations(body, mass, c, inertia, flexibility, wrench)
    expected = alpha, add(a_Bo, gravity)
    # What they are made of, from above.
    arm, spin = math.hypot(*c), math.hypot(*body.w_WB) ** 2
    force = math.hypot(*wrench.force) + mass * math.hypot(*gravity)
    torque = math.hypot(*wrench.torque) + force * arm + sum(inertia[:3]) * spin
    angular = sum(flexibility[:3]) * torque
    made_of = angular, force / mass + arm * (angular + spin)
    return all(
        math.hypot(*subtract(one, other)) <= _APART * reach
        for one, other, reach in zip(got, expected, made_of, strict=True)
    )
