"""Gravity in the freely falling world."""

import math

from pydrake.systems.framework import BasicVector, Context, LeafSystem

from drakesep.systems.diagram.state_layout import StateLayout
from drakesep.systems.diagram.wrenches import WrenchSum
from drakesep.systems.equations import gravity as gravity_laws
from drakesep.systems.model.separation import Separation


_FIELDS = 10
"""Of a body's parameters: mass, CG and inertia."""


class Gravity(LeafSystem):
    """The inverse-square field, less its value at W's origin, on every body.

    Acts at each CG, with the gravity-gradient torque. W's origin moves along a
    circular orbit; its axes do not turn.

    Input port:
        plant_state: state of the plant.

    Output port:
        wrenches: (6 m,) torque about the origin, N m, and force, N, in W, on each
            of the m bodies.

    Parameters:
        0: (2,) gravitational parameter, m^3/s^2, and radius of the orbit, m.
        1: (10 m,) mass, CG and inertia (xx, yy, zz, xy, xz, yz) of each body.
    """

    def __init__(self, separation: Separation, layout: StateLayout):
        super().__init__()
        self._count = len(separation.bodies)
        self._layout = layout
        self._state = self.DeclareVectorInputPort("plant_state", layout.size)
        self._orbit = self.DeclareNumericParameter(BasicVector(2))
        self._mass_properties = self.DeclareNumericParameter(
            BasicVector(_FIELDS * self._count)
        )
        self.DeclareVectorOutputPort("wrenches", 6 * self._count, self._calc_wrenches)

    def set_gravity(self, context: Context, separation: Separation) -> None:
        """Write the orbit and the mass properties into this system's Context."""
        orbit = separation.orbit
        assert orbit is not None  # the structure of SeparationForces
        context.get_mutable_numeric_parameter(self._orbit).SetFromVector(
            [orbit.mu, orbit.radius]
        )
        rows: list[float] = []
        for body in separation.bodies:
            rows += [body.mass, *body.p_BoBcm_B, *body.I_BBcm_B]
        context.get_mutable_numeric_parameter(self._mass_properties).SetFromVector(rows)

    def _calc_wrenches(self, context: Context, output: BasicVector) -> None:
        total = WrenchSum(self._count)
        mu, radius = context.get_numeric_parameter(self._orbit).value().tolist()
        mean_motion = math.sqrt(mu / radius**3)
        r_W = gravity_laws.orbit_position(context.get_time(), radius, mean_motion, math)
        bodies = self._layout.read(self._state.Eval(context).tolist())
        rows = context.get_numeric_parameter(self._mass_properties).value().tolist()
        for i, body in enumerate(bodies):
            row = rows[_FIELDS * i : _FIELDS * (i + 1)]
            wrench = gravity_laws.gravity_wrench(
                body, row[0], row[1:4], row[4:], r_W, mu, math
            )
            total.add(i, wrench)
        total.write(output)
