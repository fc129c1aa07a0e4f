"""Gravity in the freely falling world."""

import math
from typing import NamedTuple

from pydrake.systems.framework import Context, LeafSystem

from drakesep.systems.diagram.rows import Rows
from drakesep.systems.diagram.state_layout import BodyStates, StateLayout
from drakesep.systems.diagram.wrenches import Forces, WrenchSum
from drakesep.systems.equations.gravity import gravity_wrench
from drakesep.systems.equations.kepler import Ellipse, ellipse, orbit_position
from drakesep.systems.equations.relative_motion import BodyState, Wrench
from drakesep.systems.equations.straight_line import LINE_OPS, straight_line
from drakesep.systems.model.parameters import names_of
from drakesep.systems.model.separation import Separation
from drakesep.systems.vectors import Symmetric, Vector


class OrbitRow(NamedTuple):
    """The orbit in a Context."""

    mu: float
    """Gravitational parameter, m^3/s^2."""
    radius: float
    """At t = 0, m."""
    horizontal_speed: float
    """At t = 0, across the radius, m/s."""
    climb_rate: float
    """At t = 0, away from the centre, m/s."""


class MassRow(NamedTuple):
    """A body in a Context."""

    mass: float
    """kg."""
    p_BoBcm_B: Vector
    """CG, m."""
    I_BBcm_B: Symmetric
    """Central inertia: xx, yy, zz, xy, xz, yz, kg m^2."""


class _Field(NamedTuple):
    """The field about W's origin, on bodies."""

    mu: float
    orbit: Ellipse
    masses: list[MassRow]

    def __call__(self, bodies: BodyStates, t: float, total: WrenchSum) -> None:
        r_W = orbit_position(t, self.orbit, math)
        on_body = straight_line(_on_body)
        for i, row in enumerate(self.masses):
            total.add(i, on_body(bodies[i], row, r_W, self.mu))


def _on_body(body: BodyState, row: MassRow, r_W: Vector, mu: float) -> Wrench:
    return gravity_wrench(body, *row, r_W, mu, LINE_OPS)


class Gravity(LeafSystem):
    """The inverse-square field, less its value at W's origin, on every body.

    Acts at each CG, with the gravity-gradient torque. W's origin moves along the
    reference orbit; its axes do not turn.

    Input ports:
        plant_state: (s,) 1, m, rad/s and m/s in W: state of the plant, in which the
            layout finds the motion of each body.

    Output ports:
        acting: abstract: what acts until a parameter changes it, for a `ForceSum`.
        wrenches: (6 m,) N m and N in W: torque about the origin, then force, on each of
            the m bodies.

    Parameters:
        0: an `OrbitRow`.
        1: for each body a `MassRow`.
    """

    def __init__(self, separation: Separation, layout: StateLayout):
        super().__init__()
        state = self.DeclareVectorInputPort("plant_state", layout.size)
        self._orbit = Rows(self, _orbit_rows(separation))
        self._mass_properties = Rows(self, _mass_rows(separation))
        Forces(self, state, layout, self._find_acting, {self.all_parameters_ticket()})

    def set_gravity(self, context: Context, separation: Separation) -> None:
        """Write the orbit and the mass properties into this system's Context."""
        self._orbit.write(context, _orbit_rows(separation))
        self._mass_properties.write(context, _mass_rows(separation))

    def parameters_read(self, separation: Separation) -> set[str]:
        """Return the names of the parameters that the rows are made of."""
        return {*names_of(separation.bodies, MassRow._fields)}

    def _find_acting(self, context: Context) -> list[_Field]:
        [row] = self._orbit.read(context)
        masses = self._mass_properties.read(context)
        return [_Field(row.mu, ellipse(*row), masses)]


def _orbit_rows(separation: Separation) -> list[OrbitRow]:
    orbit = separation.orbit
    assert orbit is not None  # the structure of SeparationForces
    return [OrbitRow(*orbit.start)]


def _mass_rows(separation: Separation) -> list[MassRow]:
    return [
        MassRow(body.mass, body.p_BoBcm_B, body.I_BBcm_B) for body in separation.bodies
    ]
