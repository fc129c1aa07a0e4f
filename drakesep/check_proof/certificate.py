"""The certificate, read with care: the problem, its grid, its claims."""

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

from flint import arb

from .intervals import (
    MINUS,
    NONE,
    ONE,
    ZERO,
    Interval,
    Matrix,
    cross,
    dot,
    square,
)


FORMAT = "drakesep proof 2"
ROUNDED = 1e-9
ENTRY = arb(10) ** -15  # by which entries of rotations are widened


class Unreadable(Exception):
    """The certificate is not of the form, or of what it should be."""


def number(text: object, name: str) -> float:
    """Return a real number, which stands as a hexadecimal float."""
    try:
        value = float.fromhex(text)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        raise Unreadable(f"{name}: wanted a hexadecimal float, got {text!r}") from None
    if not math.isfinite(value):
        raise Unreadable(f"{name}: wanted a finite number, got {text!r}")
    return value


def positive(text: object, name: str) -> float:
    """Return a number, which must be above zero."""
    value = number(text, name)
    if value <= 0:
        raise Unreadable(f"{name}: wanted more than 0, got {value!r}")
    return value


def keys(record: object, name: str, wanted: str, optional: str = "") -> dict[str, Any]:
    """Return a record with the wanted keys and, besides these, only optional ones."""
    if not isinstance(record, dict):
        raise Unreadable(f"{name}: wanted a record, got {type(record).__name__}")
    if missing := set(wanted.split()) - set(record):
        raise Unreadable(f"{name}: wanted also {', '.join(sorted(missing))}")
    if unknown := set(record) - set(wanted.split()) - set(optional.split()):
        raise Unreadable(f"{name}: not known are {', '.join(sorted(unknown))}")
    return record


def items(values: object, name: str, count: int | None = None) -> list[Any]:
    """Return a list, of so many items if a count is given."""
    if not isinstance(values, list) or count not in (None, len(values)):
        wanted = "a list" if count is None else f"a list of {count}"
        raise Unreadable(f"{name}: wanted {wanted}, got {values!r:.60}")
    return values


def index(value: object, name: str, count: int) -> int:
    """Return a whole number from 0 on, below a count."""
    if type(value) is not int or not 0 <= value < count:
        raise Unreadable(f"{name}: wanted a whole number below {count}, got {value!r}")
    return value


def text(value: object, name: str) -> str:
    """Return a text."""
    if not isinstance(value, str):
        raise Unreadable(f"{name}: wanted a text, got {value!r:.60}")
    return value


def entry(value: object, name: str) -> Interval:
    """Return an entry of a rotation or of a unit vector."""
    x = number(value, name)
    exact = {0.0: NONE, 1.0: ONE, -1.0: MINUS}
    return exact[x] if x in exact else (arb(x) - ENTRY, arb(x) + ENTRY)


def unit_vector(values: object, name: str) -> list[Interval]:
    """Return three entries, which may be a unit vector."""
    vector = [entry(x, name) for x in items(values, name, 3)]
    length = sum((square(x)[0] for x in vector), ZERO).union(
        sum((square(x)[1] for x in vector), ZERO)
    )
    if not length.contains(1):
        raise Unreadable(f"{name}: its length is not 1")
    return vector


def rotation(values: object, name: str) -> Matrix:
    """Return a matrix that may be a rotation."""
    entries = items(values, name, 9)
    rows = [unit_vector(entries[a : a + 3], name) for a in (0, 3, 6)]
    jets = [[[x] for x in row] for row in rows]
    for [got], [wanted] in zip(cross(jets[0], jets[1]), jets[2], strict=True):
        if not got[0] <= wanted[1] or not wanted[0] <= got[1]:
            raise Unreadable(f"{name}: is not a rotation")
    for a, b in ((0, 1), (1, 2), (2, 0)):
        low, high = dot(jets[a], jets[b])[0]
        if low > ZERO or high < ZERO:
            raise Unreadable(f"{name}: is not a rotation")
    return rows


@dataclass(frozen=True)
class Parameter:
    """What varies: nominal + scale * s, for s from lower to upper."""

    name: str
    nominal: float
    scale: float
    lower: float
    upper: float


@dataclass(frozen=True)
class Value:
    """A constant, or one parameter of the box."""

    value: float
    parameter: int | None


@dataclass(frozen=True)
class Body:
    """Mass, CG and inertia (xx, yy, zz, xy, xz, yz) about it, in its own axes."""

    name: str
    mass: Value
    cg: list[Value]
    inertia: list[Value]
    R_S: Matrix  # as it is meant to stand in the stack
    turn: list[Value]  # roll, pitch and yaw from there
    origin_S: list[float]
    offset: list[Value]  # from there, in the stack


@dataclass(frozen=True)
class Spin:
    """How a body spins on its carrier before it lets go."""

    rate: Value
    axis: list[Interval]  # in the carrier
    place: list[Value]  # of a point of the axis, in the carrier


@dataclass(frozen=True)
class Pair:
    """A carrier and the body that leaves it."""

    carrier: int
    leaver: int
    reference: list[float]
    spin: Spin | None


@dataclass(frozen=True)
class Spring:
    """A spring of Eq. 5, and where it stands in the carrier."""

    name: str
    pair: int
    force: Value
    stroke: Value
    mass: Value
    lost: Value  # part of the stroke before which it is stuck
    place: list[Value]
    frame: Matrix  # its x axis is that of the push if it is not tilted
    tilt: list[Value]  # about y of the frame, then about z

    @property
    def law(self) -> tuple[Value, Value, Value, Value]:
        """Force, stroke, mass and what is lost of the stroke."""
        return self.force, self.stroke, self.mass, self.lost

    def depends_on(self, i: int) -> bool:
        """Whether its impulse varies with a parameter."""
        return any(value.parameter == i for value in self.law)


@dataclass(frozen=True)
class Gravity:
    """Gravitational parameter and the least radius of the orbit."""

    mu: float
    least_radius: float


@dataclass(frozen=True)
class Problem:
    """A separation, a box of its parameters, and a grid of times."""

    parameters: list[Parameter]
    bodies: list[Body]
    pairs: list[Pair]
    springs: list[Spring]
    attitude: list[Value]
    rate: list[Value]
    gravity: Gravity | None
    grid: list[float]

    @property
    def pieces(self) -> int:
        """How many pieces of time there are."""
        return len(self.grid) - 1

    @cached_property
    def lengths(self) -> list[arb]:
        """The lengths of the pieces, s."""
        return [arb(b) - arb(a) for a, b in zip(self.grid, self.grid[1:], strict=False)]

    @cached_property
    def groups(self) -> list[list[int]]:
        """The springs of a pair that push alike at nominal values."""
        alike: dict[Any, list[int]] = {}
        for k, spring in enumerate(self.springs):
            law = tuple(value.value for value in spring.law)
            alike.setdefault((spring.pair, law), []).append(k)
        return list(alike.values())

    @property
    def root(self) -> "Box":
        """The whole box."""
        return Box(
            tuple(p.lower for p in self.parameters),
            tuple(p.upper for p in self.parameters),
        )


@dataclass(frozen=True)
class Box:
    """A box of s."""

    lower: tuple[float, ...]
    upper: tuple[float, ...]

    @property
    def live(self) -> list[int]:
        """The coordinates that vary."""
        return [i for i, s in enumerate(self.lower) if s < self.upper[i]]

    def replaced(self, i: int, lower: float, upper: float) -> "Box":
        """Return the box with other ends of one coordinate."""
        return Box(
            (*self.lower[:i], lower, *self.lower[i + 1 :]),
            (*self.upper[:i], upper, *self.upper[i + 1 :]),
        )

    def interval(self, i: int) -> Interval:
        """Return a side of the box."""
        return arb(self.lower[i]), arb(self.upper[i])


@dataclass(frozen=True)
class Term:
    """A law of a signal: its peak over pieces of time and signs, or its integral."""

    field: str
    pair: int
    law: str
    component: int | None
    vector: list[Interval] | None
    signs: list[int]
    pieces: range
    blocks: list[range]  # of pieces, from the first of the window on
    coast: int | None  # piece from which on an integral is looked at as a whole
    levels: list[float]  # between which the mean of what is squared lies


@dataclass(frozen=True)
class Claim:
    """A quantity, what it is said not to exceed, and the tree that shows it."""

    name: str
    kind: str
    terms: list[Term]
    bound: float
    found: float
    at: list[float]
    tree: list[Any]


@dataclass(frozen=True)
class Certificate:
    """What is claimed, of what."""

    problem: Problem
    claims: list[Claim]


FIELDS = ("rate", "relative_rate", "relative_velocity", "relative_position", "angle")
RATES = ("rate", "relative_rate")
LAWS = ("component", "along", "length_squared", "across_squared")
KINDS = ("peak", "integral_of_magnitude", "integral_of_square")


def certificate(record: object) -> Certificate:
    """Read a certificate.

    Raises:
        Unreadable: names the field, what was wanted and what was got.
    """
    top = keys(record, "certificate", "format problem grid claims", "made_by method")
    if top["format"] != FORMAT:
        raise Unreadable(f"format: wanted {FORMAT!r}, got {top['format']!r}")
    times = items(keys(top["grid"], "grid", "times", "push")["times"], "grid.times")
    grid = [number(t, f"grid.times[{n}]") for n, t in enumerate(times)]
    problem = _problem(top["problem"], grid)
    claims = [
        _claim(claim, f"claims[{c}]", problem)
        for c, claim in enumerate(items(top["claims"], "claims"))
    ]
    if not claims:
        raise Unreadable("claims: none")
    if len({claim.name for claim in claims}) < len(claims):
        raise Unreadable("claims: two have the same name")
    return Certificate(problem, claims)


def _problem(record: object, grid: list[float]) -> Problem:
    wanted = "duration parameters bodies pairs springs attitude rate gravity"
    top = keys(record, "problem", wanted)
    duration = positive(top["duration"], "problem.duration")
    if len(grid) < 2 or grid[0] != 0 or grid[-1] != duration:
        raise Unreadable(f"grid: wanted times from 0 to the duration, {duration!r} s")
    if any(b <= a for a, b in pairwise(grid)):
        raise Unreadable("grid: its times must grow")
    parameters = [
        _parameter(p, f"problem.parameters[{i}]")
        for i, p in enumerate(items(top["parameters"], "problem.parameters"))
    ]
    if len({p.name for p in parameters}) < len(parameters):
        raise Unreadable("problem.parameters: two have the same name")
    bodies = _bodies(top, parameters)
    _check_first(bodies)
    pairs = [
        _pair(p, f"problem.pairs[{j}]", parameters, len(bodies))
        for j, p in enumerate(items(top["pairs"], "problem.pairs"))
    ]
    springs = [
        _spring(s, f"problem.springs[{k}]", parameters, len(pairs))
        for k, s in enumerate(items(top["springs"], "problem.springs"))
    ]
    rate = _values(top["rate"], "problem.rate", parameters, 3)
    gravity = None
    if top["gravity"] is not None:
        g = keys(top["gravity"], "problem.gravity", "mu least_radius")
        gravity = Gravity(
            positive(g["mu"], "problem.gravity.mu"),
            positive(g["least_radius"], "problem.gravity.least_radius"),
        )
    attitude = _values(top["attitude"], "problem.attitude", parameters, 3)
    problem = Problem(parameters, bodies, pairs, springs, attitude, rate, gravity, grid)
    _check_pairs(problem)
    return problem


def _parameter(record: object, name: str) -> Parameter:
    p = keys(record, name, "name nominal scale lower upper")
    lower, upper = (
        number(p["lower"], f"{name}.lower"),
        number(p["upper"], f"{name}.upper"),
    )
    if not -1 <= lower < upper <= 1:
        raise Unreadable(
            f"{name}: wanted -1 <= lower < upper <= 1, got {lower!r} and {upper!r}"
        )
    return Parameter(
        text(p["name"], f"{name}.name"),
        number(p["nominal"], f"{name}.nominal"),
        positive(p["scale"], f"{name}.scale"),
        lower,
        upper,
    )


def _value(
    record: object, name: str, parameters: list[Parameter], above_zero: bool = False
) -> Value:
    """Return a value, which is more than zero over the whole box if that is wanted."""
    v = keys(record, name, "value", "parameter")
    value = number(v["value"], f"{name}.value")
    i = None
    least = value
    if "parameter" in v:
        i = index(v["parameter"], f"{name}.parameter", len(parameters))
        if parameters[i].nominal != value:
            raise Unreadable(
                f"{name}: its value is not the nominal one of its parameter"
            )
        least = value - parameters[i].scale * (1 + ROUNDED)
    if above_zero and not least > 0:
        raise Unreadable(f"{name}: wanted more than 0 over the box, got {least!r}")
    return Value(value, i)


def _values(
    values: object, name: str, parameters: list[Parameter], count: int
) -> list[Value]:
    return [
        _value(v, f"{name}[{i}]", parameters)
        for i, v in enumerate(items(values, name, count))
    ]


def _bodies(top: dict[str, Any], parameters: list[Parameter]) -> list[Body]:
    bodies = []
    for b, record in enumerate(items(top["bodies"], "problem.bodies")):
        name = f"problem.bodies[{b}]"
        r = keys(record, name, "name mass cg inertia orientation turn place offset")
        place = items(r["place"], f"{name}.place", 3)
        bodies.append(
            Body(
                text(r["name"], f"{name}.name"),
                _value(r["mass"], f"{name}.mass", parameters, above_zero=True),
                _values(r["cg"], f"{name}.cg", parameters, 3),
                _values(r["inertia"], f"{name}.inertia", parameters, 6),
                rotation(r["orientation"], f"{name}.orientation"),
                _values(r["turn"], f"{name}.turn", parameters, 3),
                [number(x, f"{name}.place") for x in place],
                _values(r["offset"], f"{name}.offset", parameters, 3),
            )
        )
    return bodies


def _check_first(bodies: list[Body]) -> None:
    """The stack is placed in the axes of its first body (section 8)."""
    if not bodies:
        raise Unreadable("problem.bodies: none")
    first = bodies[0]
    upright = all(
        x is (ONE if a == b else NONE)
        for a, row in enumerate(first.R_S)
        for b, x in enumerate(row)
    )
    still = all(v == Value(0.0, None) for v in (*first.turn, *first.offset))
    if not (upright and still) or any(first.origin_S):
        raise Unreadable(
            "problem.bodies[0]: wanted one that stands where the stack does, got one"
            " with a place or a turn of its own"
        )


def _pair(record: object, name: str, parameters: list[Parameter], bodies: int) -> Pair:
    p = keys(record, name, "A B reference spin")
    return Pair(
        index(p["A"], f"{name}.A", bodies),
        index(p["B"], f"{name}.B", bodies),
        [number(x, f"{name}.reference") for x in items(p["reference"], name, 3)],
        None if p["spin"] is None else _spin(p["spin"], f"{name}.spin", parameters),
    )


def _spin(record: object, name: str, parameters: list[Parameter]) -> Spin:
    s = keys(record, name, "rate axis place")
    return Spin(
        _value(s["rate"], f"{name}.rate", parameters),
        unit_vector(s["axis"], f"{name}.axis"),
        _values(s["place"], f"{name}.place", parameters, 3),
    )


def _spring(
    record: object, name: str, parameters: list[Parameter], pairs: int
) -> Spring:
    wanted = "name pair force_max stroke design_mass lost_stroke place frame tilt"
    s = keys(record, name, wanted)
    force, stroke, mass = (
        _value(s[key], f"{name}.{key}", parameters, above_zero=True)
        for key in ("force_max", "stroke", "design_mass")
    )
    return Spring(
        text(s["name"], f"{name}.name"),
        index(s["pair"], f"{name}.pair", pairs),
        force,
        stroke,
        mass,
        _part(s["lost_stroke"], f"{name}.lost_stroke", parameters),
        _values(s["place"], f"{name}.place", parameters, 3),
        rotation(s["frame"], f"{name}.frame"),
        _values(s["tilt"], f"{name}.tilt", parameters, 2),
    )


def _part(record: object, name: str, parameters: list[Parameter]) -> Value:
    """Return a part of something: from 0 on, below 1, over the whole box."""
    part = _value(record, name, parameters)
    low, high = part.value, part.value
    if part.parameter is not None:
        p = parameters[part.parameter]
        low, high = (part.value + p.scale * s for s in (p.lower, p.upper))
    if not (low >= -ROUNDED and high < 1 - ROUNDED):
        raise Unreadable(f"{name}: wanted from 0 to below 1, got {low!r} to {high!r}")
    return part


def _check_pairs(problem: Problem) -> None:
    """Each body leaves at most one carrier, and carriers leave none (section 1)."""
    leavers = [pair.leaver for pair in problem.pairs]
    carriers = {pair.carrier for pair in problem.pairs}
    if not problem.pairs or len(set(leavers)) < len(leavers) or carriers & set(leavers):
        raise Unreadable(
            "problem.pairs: each body may leave one carrier, that leaves none"
        )


def _claim(record: object, name: str, problem: Problem) -> Claim:
    c = keys(record, name, "name quantity bound found at tree")
    q = keys(c["quantity"], f"{name}.quantity", "kind terms")
    if q["kind"] not in KINDS:
        raise Unreadable(
            f"{name}.quantity.kind: wanted one of {KINDS}, got {q['kind']!r}"
        )
    terms = [
        _term(term, f"{name}.quantity.terms[{a}]", problem, q["kind"])
        for a, term in enumerate(items(q["terms"], f"{name}.quantity.terms"))
    ]
    if not terms:
        raise Unreadable(f"{name}.quantity.terms: none")
    bound = number(c["bound"], f"{name}.bound")
    found = number(c["found"], f"{name}.found")
    if found > bound:
        raise Unreadable(
            f"{name}: what was found, {found!r}, is above its bound, {bound!r}"
        )
    count = len(problem.parameters)
    at = [number(s, f"{name}.at") for s in items(c["at"], f"{name}.at", count)]
    for i, (s, p) in enumerate(zip(at, problem.parameters, strict=True)):
        if not p.lower <= s <= p.upper:
            raise Unreadable(f"{name}.at[{i}]: is outside the box")
    tree = items(c["tree"], f"{name}.tree")
    named = text(c["name"], f"{name}.name")
    return Claim(named, q["kind"], terms, bound, found, at, tree)


def _term(record: object, name: str, problem: Problem, kind: str) -> Term:
    t = keys(
        record,
        name,
        "field pair law",
        "vector component signs pieces blocks coast levels",
    )
    for key, allowed in (("field", FIELDS), ("law", LAWS)):
        if t[key] not in allowed:
            raise Unreadable(f"{name}.{key}: wanted one of {allowed}, got {t[key]!r}")
    component, vector = None, None
    if t["law"] == "component":
        component = index(t.get("component"), f"{name}.component", 3)
    elif t["law"] == "along":
        values = items(t.get("vector"), f"{name}.vector", 3)
        vector = [entry(x, f"{name}.vector") for x in values]
    elif t["law"] == "across_squared":
        vector = unit_vector(t.get("vector"), f"{name}.vector")
    signs = items(t.get("signs"), f"{name}.signs") if kind == "peak" else [1]
    if not signs or any(type(s) is not int or s not in (1, -1, 0) for s in signs):
        raise Unreadable(f"{name}.signs: wanted some of 1, -1 and 0, got {signs!r}")
    if len(set(signs)) < len(signs):
        raise Unreadable(f"{name}.signs: wanted each once, got {signs!r}")
    first, last = items(t.get("pieces"), f"{name}.pieces", 2)
    index(first, f"{name}.pieces", problem.pieces)
    index(last, f"{name}.pieces", problem.pieces)
    if first > last:
        raise Unreadable(f"{name}.pieces: are none")
    pieces = range(first, last + 1)
    if kind != "peak" and len(pieces) < problem.pieces:
        raise Unreadable(f"{name}.pieces: an integral is over the whole time")
    coast, levels = _coast(t, name, problem, kind)
    return Term(
        t["field"],
        index(t["pair"], f"{name}.pair", len(problem.pairs)),
        t["law"],
        component,
        vector,
        signs,
        pieces,
        _blocks(t.get("blocks"), f"{name}.blocks", len(pieces)),
        coast,
        levels,
    )


def _coast(
    t: dict[str, Any], name: str, problem: Problem, kind: str
) -> tuple[int | None, list[float]]:
    """Return from which piece on an integral is looked at as a whole, and levels."""
    coast = t.get("coast")
    levels = [
        number(x, f"{name}.levels")
        for x in items(t.get("levels") or [], f"{name}.levels")
    ]
    if any(b <= a for a, b in pairwise(levels)):
        raise Unreadable(f"{name}.levels: must grow")
    if coast is None and not levels:
        return None, []
    if kind == "peak" or (levels and kind != "integral_of_square"):
        raise Unreadable(f"{name}: {kind} has no coast, or no levels")
    if kind == "integral_of_square" and (
        t["law"] != "component" or t["field"] not in RATES
    ):
        raise Unreadable(f"{name}.coast: squares have one of components of rates alone")
    return index(coast, f"{name}.coast", problem.pieces), levels


def _blocks(bounds: object, name: str, count: int) -> list[range]:
    """Return stretches of pieces that make a window together; one, if none are told."""
    ends = items(bounds or [], name) or [0, count]
    for end in ends:
        index(end, name, count + 1)
    rising = all(a < b for a, b in pairwise(ends))
    if len(ends) < 2 or ends[0] != 0 or ends[-1] != count or not rising:
        raise Unreadable(f"{name}: wanted to rise from 0 to {count}, got {ends!r}")
    return [range(a, b) for a, b in pairwise(ends)]
