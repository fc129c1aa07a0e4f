"""Ports that docstrings list, and so the page, are those of the systems as built."""

import dataclasses
import math
import re

import port_tables
import pytest
from pydrake.common.value import AbstractValue
from pydrake.multibody.plant import ExternallyAppliedSpatialForce
from pydrake.systems.framework import DiagramBuilder, PortDataType, System
from pydrake.systems.primitives import ConstantValueSource
from separations import generic_pair

from drakesep.systems import Load, Orbit, Part, Recontact, add_separation
from drakesep.systems.diagram.joints import CfeBushing
from drakesep.systems.diagram.motion_analysis import MotionAnalysis
from drakesep.systems.diagram.on_your_plant import (
    _BodyMotion,
    _OtherWrenches,
    _SpatialForces,
)
from drakesep.systems.diagram.preload import Preload
from drakesep.systems.diagram.release import Release
from drakesep.systems.diagram.separation_forces import SeparationForces
from drakesep.systems.diagram.separation_system import (
    SeparationSystem,
    plant_of_bodies,
)
from drakesep.systems.diagram.springs import Springs
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.parts import Sphere


PLAIN = generic_pair()
LOAD = Load(name="gust", body="upper", times=(0.0, 0.1), forces=((0.0, 1.0, 0.0),) * 2)
FULL = dataclasses.replace(
    PLAIN,
    bodies=tuple(
        dataclasses.replace(
            body, parts=(Part(name=f"ball_{body.name}", shape=Sphere(radius=0.1)),)
        )
        for body in PLAIN.bodies
    ),
    loads=(LOAD,),
    orbit=Orbit(radius=7e6),
    recontact=Recontact(stiffness=1e6, without=(("ball_lower", "ball_upper"),)),
    attachments=(
        dataclasses.replace(PLAIN.attachments[0], spring=None),
        *PLAIN.attachments[1:],
    ),
)
"""With all that adds a port; of its four attachments three have springs."""
SIZES = {"m": 2, "n": 4, "k": 3, "s": 26}
EXPORTED = {
    "spring_forces": (Springs, "forces"),
    "spring_energy": (Springs, "energy"),
    "joint_loads": (CfeBushing, "loads"),
    "preloads": (Preload, "loads"),
    "joint_energy": (CfeBushing, "energy"),
    "released": (Release, "released"),
    "wrenches": (Springs, "wrenches"),
}
"""Ports that have other names, or several origins, inside."""


def systems() -> dict[str, System]:
    """All that have documented ports, as they are built, by the names of classes."""
    whole = SeparationSystem(FULL, external_wrenches=True, illustrated=True)
    builder = DiagramBuilder()
    plant = builder.AddSystem(plant_of_bodies(PLAIN))
    plant.Finalize()
    rigid = [
        dataclasses.replace(each, joint=Joint(rigid=True)) for each in PLAIN.attachments
    ]
    forces = builder.AddSystem(
        ConstantValueSource(AbstractValue.Make([ExternallyAppliedSpatialForce()]))
    )
    add_separation(
        builder,
        plant,
        dataclasses.replace(PLAIN, attachments=tuple(rigid)),
        other_forces=forces.get_output_port(),
    )
    of_plant = builder.Build()
    inner = [*whole.GetSystems(), *whole.forces.GetSystems(), *of_plant.GetSystems()]
    return {type(system).__name__: system for system in [*inner, whole, whole.forces]}


SYSTEMS = systems()


def ports(system: System, heading: str) -> dict[str, int | None]:
    """The ports of a system with their sizes; None of those without numbers."""
    kind = heading.split()[0].lower()
    count = getattr(system, f"num_{kind}_ports")()
    each = [getattr(system, f"get_{kind}_port")(i) for i in range(count)]
    return {
        port.get_name(): None
        if port.get_data_type() == PortDataType.kAbstractValued
        else port.size()
        for port in each
    }


def size_of(shape: str) -> int | None:
    if shape == port_tables.ABSTRACT:
        return None
    factors = re.fullmatch(r"\((.*),\)", shape)[1].split()
    return math.prod(SIZES[x] if x in SIZES else int(x) for x in factors)


@pytest.mark.parametrize("heading", ["Input ports", "Output ports"])
@pytest.mark.parametrize(
    "system",
    [*port_tables.SYSTEMS, _BodyMotion, _OtherWrenches, _SpatialForces],
    ids=lambda s: s.__name__,
)
def test_ports_are_those_of_the_docstring(system, heading):
    listed = port_tables.ports_of(system, heading)
    assert {name: size_of(port.shape) for name, port in listed.items()} == ports(
        SYSTEMS[system.__name__], heading
    )


@pytest.mark.parametrize("heading", ["Input ports", "Output ports"])
@pytest.mark.parametrize(
    "built", [SeparationSystem(PLAIN), SeparationSystem(PLAIN).forces]
)
def test_ports_that_are_not_always_there_say_so(built, heading):
    listed = port_tables.ports_of(type(built), heading)
    missing = set(listed) - set(ports(built, heading))
    assert missing == {name for name, port in listed.items() if "; if " in port.meaning}


def test_a_port_is_described_alike_wherever_it_is_exported():
    motion = port_tables.ports_of(MotionAnalysis, "Output ports")
    outer = port_tables.ports_of(SeparationForces, "Output ports")
    for name, port in outer.items():
        inside, inner_name = EXPORTED.get(name, (MotionAnalysis, name))
        assert port == port_tables.ports_of(inside, "Output ports")[inner_name]
    assert set(outer) == {*EXPORTED, *motion}
    whole = port_tables.ports_of(SeparationSystem, "Output ports")
    assert {n: p for n, p in whole.items() if n in outer} == {
        n: p for n, p in outer.items() if n != "wrenches"
    }
    for name in ("trigger", "triggers"):
        assert (
            port_tables.ports_of(SeparationSystem, "Input ports")[name]
            == (port_tables.ports_of(Release, "Input ports")[name])
        )


def test_units_of_ports_are_known():
    """Those of vectors in W, A or B, and those of numbers that have no frame."""
    units = set()
    for system in port_tables.SYSTEMS:
        for heading in ("Input ports", "Output ports"):
            for port in port_tables.ports_of(system, heading).values():
                units |= set(re.split(", | and ", port.unit)) - {""}
    assert units == {
        *("1", "m", "rad", "s", "rad/s", "m/s", "rad/s^2", "m/s^2", "N")
    } | {*("N m", "N s", "N m s", "J")}
