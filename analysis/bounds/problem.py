"""What a bound is proven of: a separation and a box of parameters, as plain numbers.

They stand alone, so that a certificate can hold them and a second program read them.
What is not covered is refused by name.
"""

import functools
import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.systems.checks import InputError, Vector3
from drakesep.systems.equations.mated_stack import nominal_place
from drakesep.systems.equations.pushers import from_x_axis, push_place
from drakesep.systems.model.carriers import carriers
from drakesep.systems.model.magnitudes import MAGNITUDES
from drakesep.systems.model.orbit import Orbit
from drakesep.systems.model.parameter_table import ROLL_PITCH_YAW, XYZ, with_axis
from drakesep.systems.model.parameters import (
    MATED,
    names_of,
    parameters,
    places_of_parts,
)
from drakesep.systems.model.separation import STACK, Attachment, Body, Separation
from drakesep.systems.model.springs import Spring
from drakesep.systems.vectors import Rotation, rotation_matrix


class NotCovered(InputError):
    """Something of which no bound can be proven; the message says what and why."""


class Number(NamedTuple):
    """A number of the problem: constant, or one parameter."""

    value: float
    """In SI; of a parameter its nominal value."""
    parameter: int | None = None
    """Its place among the parameters."""


Vector: TypeAlias = tuple[Number, Number, Number]


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxParameter:
    """A parameter p = nominal + scale s."""

    name: str
    nominal: float
    scale: float
    lower: float
    """Least s."""
    upper: float
    """Greatest s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BoundBody:
    """A body as it moves."""

    name: str
    mass: Number
    cg: Vector
    """From its origin, in its axes."""
    inertia: tuple[Number, ...]
    """About the CG, entries xx, yy, zz, xy, xz, yz."""
    orientation: Rotation
    """Meant in the stack, row by row; entries other than 0, 1 and -1 are rounded."""
    turn: Vector
    """Roll, pitch and yaw from there, in its own axes."""
    place: Vector3
    """Where its origin is meant to be in the stack."""
    offset: Vector
    """From there, in the stack."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BoundSpin:
    """How a body spins while mated, relative to its carrier."""

    rate: Number
    axis: Vector3
    """In A; rounded, as `BoundBody.orientation`."""
    place: Vector
    """Of a point of the axis in A."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BoundPair:
    """A carrier and a body that leaves it, by their places among the bodies."""

    A: int
    B: int
    reference: Vector3
    """Any point fixed in B, best where it is pushed; in B, from its origin, m."""
    spin: BoundSpin | None


@dataclass(frozen=True, slots=True, kw_only=True)
class BoundSpring:
    """A spring of Eq. 5 that pushes the B of a pair."""

    name: str
    pair: int
    force_max: Number
    stroke: Number
    design_mass: Number
    lost_stroke: Number
    """Part of the stroke before which it is stuck."""
    place: Vector
    """Of its pad in A."""
    frame: Rotation
    """In A, of axes whose x axis is that along which it pushes if it is not tilted;
    rounded, as `BoundBody.orientation`."""
    tilt: tuple[Number, Number]
    """By which angles it is, about the y axis of its frame, and then about z."""

    @property
    def law(self) -> tuple[Number, Number, Number, Number]:
        """What its force over time depends on."""
        return self.force_max, self.stroke, self.design_mass, self.lost_stroke


@dataclass(frozen=True, slots=True, kw_only=True)
class Gravity:
    """The field in which the bodies fall."""

    mu: float
    least_radius: float
    """A distance from the centre of the Earth that W's origin surely keeps, m."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BoundProblem:
    """A separation and its box of parameters."""

    duration: float
    parameters: tuple[BoxParameter, ...]
    bodies: tuple[BoundBody, ...]
    """The first one carries the axes of the stack."""
    pairs: tuple[BoundPair, ...]
    """The first is that of the separation."""
    springs: tuple[BoundSpring, ...]
    attitude: Vector
    """Roll, pitch and yaw of the stack in W; nothing but angles in W depends on it."""
    rate: Vector
    """Of the stack, in its axes."""
    gravity: Gravity | None


def problem_of(separation: Separation, box: ToleranceBox) -> BoundProblem:
    """Return the problem of a separation and a box of its parameters.

    Raises:
        NotCovered: something of it is.
    """
    _check_separation(separation)
    still = places_of_parts(separation)
    moving = [d for d in box.dispersions if d.name not in still]
    indices = {d.name: i for i, d in enumerate(moving)}
    _check_displaced(separation, indices)
    read = _read(separation)
    for name in indices:
        if name not in read:
            raise NotCovered(f"{name}: bounds do not cover its tolerance")
    columns = [box.names.index(name) for name in indices]
    number = functools.partial(_number, parameters(separation), indices)
    bodies = sorted(separation.bodies, key=lambda body: body.name != separation.A)
    names = [body.name for body in bodies]
    pairs = _pairs(separation)
    _check_carriers(separation, pairs, number)
    pushing = [(a, s) for a, s in separation.pushing if isinstance(s, Spring)]
    problem = BoundProblem(
        duration=separation.duration,
        parameters=tuple(
            BoxParameter(
                name=d.name,
                nominal=d.nominal,
                scale=float(box.tolerance[k]),
                lower=float(box.lower[k]),
                upper=float(box.upper[k]),
            )
            for d, k in zip(moving, columns, strict=True)
        ),
        bodies=tuple(
            _body(body, number, displaced=body.name != separation.A) for body in bodies
        ),
        pairs=tuple(
            BoundPair(
                A=names.index(A),
                B=names.index(B),
                reference=_reference(separation, A, B),
                spin=_spin(separation, A, B, number),
            )
            for A, B in pairs
        ),
        springs=tuple(
            BoundSpring(
                name=s.name,
                pair=pairs.index((a.A, a.B)),
                force_max=number(f"{s.name}.force_max"),
                stroke=number(f"{s.name}.stroke"),
                design_mass=number(f"{s.name}.design_mass"),
                lost_stroke=number(f"{s.name}.lost_stroke"),
                place=_vector(number, f"{a.name}.position"),
                frame=from_x_axis(s.axis_A),
                tilt=(number(f"{s.name}.tilt_y"), number(f"{s.name}.tilt_z")),
            )
            for a, s in pushing
        ),
        attitude=_vector(number, f"{STACK}.attitude", ROLL_PITCH_YAW),
        rate=_vector(number, f"{STACK}.rate"),
        gravity=_gravity(separation.orbit),
    )
    _check_springs(problem)
    return problem


def _number(
    values: Mapping[str, float], indices: Mapping[str, int], name: str
) -> Number:
    return Number(values[name], indices.get(name))


def _vector(
    number: functools.partial[Number], stem: str, axes: tuple[str, ...] = XYZ
) -> Vector:
    x, y, z = (number(with_axis(stem, axis)) for axis in axes)
    return x, y, z


def _body(
    body: Body, number: functools.partial[Number], *, displaced: bool
) -> BoundBody:
    place = nominal_place(body)
    entries = ("xx", "yy", "zz", "xy", "xz", "yz")
    turn = offset = (Number(0.0),) * 3
    if displaced:
        turn = _vector(number, f"{body.name}.mated_misalignment", ROLL_PITCH_YAW)
        offset = _vector(number, f"{body.name}.mated_offset")
    return BoundBody(
        name=body.name,
        mass=number(f"{body.name}.mass"),
        cg=_vector(number, f"{body.name}.cg"),
        inertia=tuple(number(f"{body.name}.inertia_{e}") for e in entries),
        orientation=rotation_matrix(place.q_SB),
        turn=turn,
        place=place.p_SBo,
        offset=offset,
    )


def _spin(
    separation: Separation, A: str, B: str, number: functools.partial[Number]
) -> BoundSpin | None:
    """Return how a body spins on its carrier; None if it does not."""
    attachment = separation.spins_on(separation.body(B))
    if attachment is None or number(f"{B}.spin") == Number(0.0):
        return None
    if (attachment.A, attachment.B) != (A, B):
        raise NotCovered(f"{B}: bounds cover bodies that spin on what pushes them")
    return BoundSpin(
        rate=number(f"{B}.spin"),
        axis=attachment.joint.x_axis_A,
        place=_vector(number, f"{attachment.name}.position"),
    )


def _check_carriers(
    separation: Separation,
    pairs: Collection[tuple[str, str]],
    number: functools.partial[Number],
) -> None:
    """Refuse carriers that spin: what they carry does not spin with them."""
    for A, _ in pairs:
        may_spin = separation.spins_on(separation.body(A)) is not None
        if may_spin and number(f"{A}.spin") != Number(0.0):
            raise NotCovered(f"{A}: bounds do not cover the spin of what others leave")


def _reference(separation: Separation, A: str, B: str) -> Vector3:
    """Return the middle of the pads on a body, in its axes."""
    pads = [
        push_place(separation, a, s).p_BoPad_B
        for a, s in separation.pushing
        if (a.A, a.B) == (A, B)
    ]
    if not pads:
        return (0.0, 0.0, 0.0)
    x, y, z = (sum(float(p[i]) for p in pads) / len(pads) for i in range(3))
    return x, y, z


_BODY = ("mass", "cg_", "inertia_", "mated_", "spin")
_SPRING = ("force_max", "stroke", "design_mass", "lost_stroke", "tilt_")


def _read(separation: Separation) -> set[str]:
    """Return the names of the parameters that a problem may vary."""
    owned: dict[str, tuple[str, ...]] = {body.name: _BODY for body in separation.bodies}
    owned |= {spring.name: _SPRING for spring in separation.springs}
    owned |= {a.name: ("position_",) for a in separation.attachments}
    owned[STACK] = ("attitude_", "rate_")
    found = set()
    for name in parameters(separation):
        owner, _, quantity = name.rpartition(".")
        if quantity.startswith(owned.get(owner, ())):
            found.add(name)
    return found


def _pairs(separation: Separation) -> list[tuple[str, str]]:
    """Return carriers and what leaves them: the separation's pairs, and springs'."""
    asked = [(pair.A, pair.B) for pair in separation.pairs]
    pushed = [(a.A, a.B) for a, _ in separation.pushing]
    pairs = list(dict.fromkeys([*asked, *pushed]))
    carriers = {A for A, _ in pairs}
    leaving = [B for _, B in pairs]
    for body in leaving:
        if leaving.count(body) > 1 or body in carriers:
            raise NotCovered(
                f"{body}: bounds cover bodies that leave one carrier and carry none"
            )
    return pairs


def _check_separation(separation: Separation) -> None:
    if separation.recontact is not None:
        raise NotCovered("recontact: bounds do not cover contact")
    for load in separation.loads:
        raise NotCovered(f"{load.name}: bounds do not cover loads")
    for attachment in separation.attachments:
        _check_attachment(attachment)


def _check_displaced(separation: Separation, varied: Collection[str]) -> None:
    """Refuse bodies that hang on a displaced one: they move with it."""
    displaced = {
        body.name
        for body in separation.bodies
        if any((*body.mated_offset, *body.mated_misalignment))
        or not set(names_of([body], MATED)).isdisjoint(varied)
    }
    for name, carrier in carriers(separation).items():
        if carrier in displaced:
            raise NotCovered(
                f"{name}: bounds do not cover what hangs on a body that is displaced"
            )


def _check_attachment(attachment: Attachment) -> None:
    if attachment.release_time != 0.0:
        raise NotCovered(
            f"{attachment.name}: bounds cover attachments that let go at t = 0"
        )
    spring = attachment.spring
    if spring is not None and not isinstance(spring, Spring):
        raise NotCovered(f"{spring.name}: bounds cover springs of Eq. 5 alone")


def _check_springs(problem: BoundProblem) -> None:
    """Refuse springs that may not push, or whose strokes may not end in the run."""
    for spring in problem.springs:
        ends = [_ends(problem, number) for number in spring.law]
        pushes = ends[0][0] >= MAGNITUDES["force"].least
        for (least, _), number in zip(ends[:3], spring.law, strict=False):
            pushes &= least > _MARGIN * abs(number.value)
        if not pushes:
            raise NotCovered(f"{spring.name}: bounds cover springs that all push")
        (force, _), (_, stroke), (_, mass), (lost, most_lost) = ends
        if not -_MARGIN < lost <= most_lost < 1.0:
            raise NotCovered(
                f"{spring.name}: bounds cover lost parts of strokes from 0 to below 1"
            )
        last = math.acos(max(lost, 0.0)) * math.sqrt(mass * stroke / force)
        if not last < problem.duration * (1.0 - _MARGIN):
            raise NotCovered(
                f"{spring.name}: bounds cover springs whose strokes end within the run"
            )


def _ends(problem: BoundProblem, number: Number) -> tuple[float, float]:
    """Return the least and the greatest value of a number."""
    if number.parameter is None:
        return number.value, number.value
    p = problem.parameters[number.parameter]
    return p.nominal + p.scale * p.lower, p.nominal + p.scale * p.upper


_MARGIN = 1e-6
"""Relative: far more than rounding."""


def _gravity(orbit: Orbit | None) -> Gravity | None:
    if orbit is None:
        return None
    perigee = orbit.semi_major_axis * (1.0 - orbit.eccentricity)
    return Gravity(mu=orbit.mu, least_radius=perigee * (1.0 - _MARGIN))
