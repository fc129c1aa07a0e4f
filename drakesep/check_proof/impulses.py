"""Impulses of springs of Eq. 5, their derivatives, and the kernels made of them.

With sigma(theta) = sin(min(theta, end)), an impulse is J = A sigma(omega t); the end is
arccos of the lost part of the stroke, pi/2 if none is.
"""

from itertools import pairwise

from flint import arb

from .boxes import Constants
from .certificate import Problem, Spring
from .intervals import (
    ZERO,
    Interval,
    Jet,
    hull,
    intersection,
    minus,
    plus,
    point,
    product,
)
from .kernels import PositiveKernel


HALF_TURN = arb.pi() / 2
Law = tuple[Interval, Interval, Interval, Interval]


def falling(theta: arb) -> arb:
    """Return sin - theta cos, which grows from 0 to 1."""
    return theta.sin() - theta * theta.cos()


def rising(theta: arb) -> arb:
    """Return sin + theta cos, which grows until `TOP` and then falls to 1."""
    return theta.sin() + theta * theta.cos()


def _top() -> arb:
    """Enclose where the derivative of `rising`, 2 cos - theta sin, turns negative."""
    low, high = arb("1.0768739"), arb("1.0768740")
    low, high = low - arb("1e-6"), high + arb("1e-6")
    assert 2 * low.cos() > low * low.sin() and 2 * high.cos() < high * high.sin()
    return low.union(high)


TOP = _top()


def rising_on(low: arb, high: arb) -> Interval:
    """Enclose `rising` between two angles."""
    ends = hull(point(rising(low)), point(rising(high)))
    if high < TOP or low > TOP:
        return ends
    return ends[0], ends[1].max(rising(TOP))


def root(a: Interval, b: Interval, c: Interval) -> Interval:
    """Return sqrt(a b / c) of positive intervals."""
    return (a[0] * b[0] / c[1]).sqrt(), (a[1] * b[1] / c[0]).sqrt()


class Phase:
    """The angle omega t from one time to another, and where the push ends."""

    def __init__(self, law: Law, start: float, end: float):
        force, stroke, mass, lost = law
        self.low = (force[0] / (mass[1] * stroke[1])).sqrt() * arb(start)
        self.high = (force[1] / (mass[0] * stroke[0])).sqrt() * arb(end)
        self.ends = last_angle(lost)
        self.first = self.low.min(self.ends[0])  # of what pushes, the least
        self.last = self.high.min(self.ends[1])
        self.pushes = not self.low > self.ends[1]  # perhaps
        self.over = not self.high < self.ends[0]

    @property
    def sigma(self) -> Interval:
        """Enclose sigma, which grows."""
        return self.first.sin(), self.last.sin()

    @property
    def after(self) -> Interval:
        """Enclose sigma after the push."""
        return self.ends[0].sin(), self.ends[1].sin()

    @property
    def fall(self) -> Interval:
        """Enclose sigma - theta sigma'; it grows, by a jump where a spring is stuck."""
        return (
            falling(self.first) if self.pushes else self.after[0],
            self.after[1] if self.over else falling(self.last),
        )

    @property
    def rise(self) -> Interval:
        """Enclose sigma + theta sigma'; it falls by a jump where a spring is stuck."""
        if not self.pushes:
            return self.after
        pushing = rising_on(self.first, self.last)
        return hull(pushing, self.after) if self.over else pushing


def last_angle(lost: Interval) -> Interval:
    """Enclose arccos of what is lost of a stroke."""
    low, high = (_arccosine(x) for x in lost)
    return high, low


def _arccosine(x: arb) -> arb:
    return HALF_TURN if x.is_zero() else x.max(ZERO).acos()


def impulse(law: Law, start: float, end: float) -> Interval:
    """Eq. 2."""
    force, stroke, mass, _ = law
    low, high = Phase(law, start, end).sigma
    return (
        (force[0] * stroke[0] * mass[0]).sqrt() * low,
        (force[1] * stroke[1] * mass[1]).sqrt() * high,
    )


def slopes(law: Law, start: float, end: float) -> Law:
    """Eq. 3: by force, stroke, mass and lost part; A / F is sqrt(m L / F)."""
    force, stroke, mass, _ = law
    phase = Phase(law, start, end)
    fall, rise = ((low / 2, high / 2) for low, high in (phase.fall, phase.rise))
    return (
        product(root(mass, stroke, force), rise),
        product(root(force, mass, stroke), fall),
        product(root(force, stroke, mass), fall),
        _by_lost(law, phase),
    )


def _by_lost(law: Law, phase: Phase) -> Interval:
    """Return less A cot(end), once the push is over."""
    if not phase.over:
        return ZERO, ZERO
    force, stroke, mass, lost = law
    low, high = (x.max(ZERO) / (1 - x.max(ZERO) ** 2).sqrt() for x in lost)
    least = -((force[1] * stroke[1] * mass[1]).sqrt() * high)
    most = -((force[0] * stroke[0] * mass[0]).sqrt() * low)
    return least, ZERO if phase.pushes else most


def end_of_stroke(law: Law) -> Interval:
    """Enclose the angle of the end over omega."""
    force, stroke, mass, lost = law
    low, high = last_angle(lost)
    return (
        low * (mass[0] * stroke[0] / force[1]).sqrt(),
        high * (mass[1] * stroke[1] / force[0]).sqrt(),
    )


def law_of(spring: Spring, constants: Constants) -> Law:
    """Enclose force, stroke, mass and lost part of a spring."""
    force, stroke, mass, lost = (constants.interval(value) for value in spring.law)
    return force, stroke, mass, lost


def _by_parameters(
    spring: Spring, constants: Constants, start: float, end: float
) -> dict[int | None, Interval]:
    """Return the derivatives of an impulse by the parameters that it depends on."""
    out: dict[int | None, Interval] = {}
    by_law = slopes(law_of(spring, constants), start, end)
    for value, slope in zip(spring.law, by_law, strict=True):
        if value.parameter is not None:
            i = value.parameter
            slope = product(constants.scale(value), slope)
            out[i] = plus(out[i], slope) if i in out else slope
    return out


class SpringImpulse:
    """J of one spring on each piece, and how it deviates from nominal (Eq. 13)."""

    def __init__(self, spring: Spring, constants: Constants, nominal: "NominalImpulse"):
        grid = constants.problem.grid
        self.impulse: list[Jet] = []
        self.deviation: list[Jet] = []
        wide = constants.with_nominal
        pieces = zip(grid, grid[1:], nominal.impulse, strict=False)
        for start, end, nominally in pieces:
            by = _by_parameters(spring, constants, start, end) if constants.live else {}
            value = impulse(law_of(spring, constants), start, end)
            self.impulse.append(constants.jet_of(value, by))
            deviation = (ZERO, ZERO)
            for i, slope in _by_parameters(spring, wide, start, end).items():
                assert i is not None
                deviation = plus(deviation, product(slope, constants.box.interval(i)))
            deviation = intersection(deviation, minus(value, nominally))
            self.deviation.append(constants.jet_of(deviation, by))
        self.varies = any(value.parameter is not None for value in spring.law)


def _held(theta: arb, end: arb) -> arb:
    """Return the integral of sigma from 0 to theta."""
    capped = theta.min(end)
    return 1 - capped.cos() + (theta - capped) * end.sin()


class NominalImpulse:
    """J_g of a group of springs at nominal values, and its kernel (Eq. 14).

    The last row of the kernel is for all times after the first `push` pieces.
    """

    def __init__(self, problem: Problem, spring: Spring, push: int):
        law: Law = tuple(point(value.value) for value in spring.law)  # type: ignore
        (force, _), (stroke, _), (mass, _), lost = law
        turn, _ = last_angle(lost)
        omega, most = (force / (mass * stroke)).sqrt(), (force * mass * stroke).sqrt()
        at = [most * (omega * arb(t)).min(turn).sin() for t in problem.grid]
        ends = list(pairwise(at))
        self.impulse: list[Interval] = ends
        held = [_held(omega * arb(t), turn) for t in problem.grid]
        means = []
        for m, length in enumerate(problem.lengths):
            mean = most / (omega * length) * (held[m + 1] - held[m])
            means.append(intersection(point(mean), ends[m]))
        rows = [
            [((low - mean[1]).max(ZERO), high - mean[0]) for mean in means[:n]]
            + [(ZERO, high - means[n][0])]
            for n, (low, high) in enumerate(ends[:push])
        ]
        last = most * turn.sin()
        rows.append([((last - b).max(ZERO), last - a) for a, b in means[:push]])
        self.kernel = PositiveKernel(rows)


def pieces_of_push(problem: Problem) -> int:
    """Return how many pieces there are until all strokes end, on the whole box."""
    whole = Constants(problem, problem.root, []).with_nominal
    laws = [law_of(spring, whole) for spring in problem.springs]
    return sum(
        any(not end_of_stroke(law)[1] <= arb(start) for law in laws)
        for start in problem.grid[:-1]
    )
