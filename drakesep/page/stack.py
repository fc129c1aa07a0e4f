"""What is drawn of the mated stack in 3-D: solids, pads, springs, centres of mass.

All in the frame of the stack, that of A, in m.
"""

import base64
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeAlias

from drakesep.systems.equations.mated_stack import (
    Place,
    mated_places,
    place_in_stack,
)
from drakesep.systems.geometry.colours import colour_of
from drakesep.systems.model.parts import Box, Capsule, Cone, Mesh, Part, Sphere
from drakesep.systems.model.separation import Attachment, Body, Separation
from drakesep.systems.vectors import (
    Vector,
    add,
    multiply,
    quaternion,
    rotate,
    rotation_matrix,
    scale,
)


Kind: TypeAlias = Literal["box", "sphere", "cylinder", "mesh"]

_Y_TO_X = quaternion((0.0, 0.0, -0.5 * math.pi), math)
"""Cylinders of the browser are along y, ours along x."""


@dataclass(frozen=True, slots=True)
class Solid:
    """A shape as it is drawn.

    Attributes:
        kind: of the shape.
        sizes: edges; a radius; of a cylinder its radii at +y and -y and its length; of
            a mesh its scale.
        place: of its frame.
        colour: red, green and blue in hexadecimal.
        opacity: below 1 of what lets one see through.
        mesh: as an address that holds it, STL.
    """

    kind: Kind
    sizes: tuple[float, ...]
    place: Place
    colour: str
    opacity: float
    mesh: str = ""


class Spring(NamedTuple):
    """A spring: from its pad along its axis, as long as its stroke."""

    start: Vector
    end: Vector


@dataclass(frozen=True, slots=True)
class Stack:
    """What is drawn of a stack.

    Attributes:
        solids: parts of all bodies.
        pads: where bodies are held together.
        springs: what pushes.
        centres: of mass, by the names of bodies.
    """

    solids: tuple[Solid, ...]
    pads: tuple[Vector, ...]
    springs: tuple[Spring, ...]
    centres: dict[str, Vector]

    def extent(self) -> tuple[Vector, float]:
        """Return the middle of all that is drawn, and the radius about it, m."""
        points = [*self.pads, *self.centres.values()]
        reach = [(p, 0.0) for p in points]
        reach += [(solid.place.p_SBo, _radius(solid)) for solid in self.solids]
        low = [min(p[i] - r for p, r in reach) for i in range(3)]
        high = [max(p[i] + r for p, r in reach) for i in range(3)]
        middle = tuple(0.5 * (a + b) for a, b in zip(low, high, strict=True))
        return (middle[0], middle[1], middle[2]), max(0.5 * math.dist(low, high), 0.1)


def stack_of(separation: Separation) -> Stack:
    """Return what is drawn of a separation's mated stack.

    Raises:
        ValueError: a mesh cannot be read.
    """
    places = mated_places(separation)
    attachments = separation.attachments
    return Stack(
        solids=tuple(
            solid
            for body in separation.bodies
            for part in body.parts
            for solid in _solids(part, body, places[body.name], separation)
        ),
        pads=tuple(_pad(a, places) for a in attachments),
        springs=tuple(_springs(separation, places)),
        centres={
            body.name: place_in_stack(places[body.name], body.p_BoBcm_B)
            for body in separation.bodies
        },
    )


def _pad(attachment: Attachment, places: dict[str, Place]) -> Vector:
    return place_in_stack(places[attachment.A], attachment.p_AoPad_A)


def _springs(separation: Separation, places: dict[str, Place]) -> Iterator[Spring]:
    for attachment in separation.attachments:
        spring = attachment.spring
        if spring is not None:
            start = _pad(attachment, places)
            R = rotation_matrix(places[attachment.A].q_SB)
            length = getattr(spring, "stroke", None) or 0.1
            yield Spring(start, add(start, scale(length, rotate(R, spring.axis_A))))


def _solids(
    part: Part, body: Body, place: Place, separation: Separation
) -> Iterator[Solid]:
    *rgb, opacity = colour_of(part, body, separation)
    colour = "#" + "".join(f"{round(255 * c):02x}" for c in rgb)
    turned = multiply(place.q_SB, quaternion(part.rpy_BG, math))
    frame = Place(turned, place_in_stack(place, part.p_BoGo_B))
    for kind, sizes, at, mesh in _pieces(part, frame):
        yield Solid(kind, sizes, at, colour, opacity, mesh)


def _pieces(
    part: Part, frame: Place
) -> Iterator[tuple[Kind, tuple[float, ...], Place, str]]:
    """Yield the shapes that a part is drawn as."""
    shape: Any = part.shape
    along = Place(multiply(frame.q_SB, _Y_TO_X), frame.p_SBo)
    match shape:
        case Box():
            yield "box", shape.size, frame, ""
        case Sphere():
            yield "sphere", (shape.radius,), frame, ""
        case Capsule():
            radius, length = shape.radius, shape.length
            yield "cylinder", (radius, radius, length), along, ""
            for side in (0.5, -0.5):
                end = place_in_stack(frame, (side * length, 0.0, 0.0))
                yield "sphere", (radius,), Place(frame.q_SB, end), ""
        case Cone():
            sizes = (shape.radius_fore, shape.radius_aft, shape.length)
            yield "cylinder", sizes, along, ""
        case Mesh():
            yield "mesh", (shape.scale,), frame, _stl(shape)


def _stl(shape: Mesh) -> str:
    from drakesep.systems.geometry.meshes import read_mesh

    data: Any = read_mesh(shape.file).export(file_type="stl")
    return f"data:model/stl;base64,{base64.b64encode(data).decode()}"


def _radius(solid: Solid) -> float:
    match solid.kind:
        case "box":
            return 0.5 * math.hypot(*solid.sizes)
        case "sphere":
            return solid.sizes[0]
        case "cylinder":
            return math.hypot(max(solid.sizes[:2]), 0.5 * solid.sizes[2])
    return 1.0
