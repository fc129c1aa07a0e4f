"""Impulses of springs of Eq. 5, their derivatives, and the kernels made of them.

With sigma(theta) = sin(min(theta, pi/2)), an impulse is J = A sigma(omega t).
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
Law = tuple[Interval, Interval, Interval]


def sigma(theta: arb) -> arb:
    """Return sin(min(theta, pi/2))."""
    return theta.min(HALF_TURN).sin()


def falling(theta: arb) -> arb:
    """Return sigma - theta sigma', which grows from 0 to 1."""
    capped = theta.min(HALF_TURN)
    return capped.sin() - capped * capped.cos()


def rising(theta: arb) -> arb:
    """Return sigma + theta sigma', which grows until `TOP` and then falls to 1."""
    capped = theta.min(HALF_TURN)
    return capped.sin() + capped * capped.cos()


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


def angles(law: Law, start: float, end: float) -> Interval:
    """Enclose omega t from one time to another."""
    force, stroke, mass = law
    low = (force[0] / (mass[1] * stroke[1])).sqrt() * arb(start)
    high = (force[1] / (mass[0] * stroke[0])).sqrt() * arb(end)
    return low, high


def impulse(law: Law, start: float, end: float) -> Interval:
    """Eq. 2."""
    force, stroke, mass = law
    low, high = angles(law, start, end)
    return (
        (force[0] * stroke[0] * mass[0]).sqrt() * sigma(low),
        (force[1] * stroke[1] * mass[1]).sqrt() * sigma(high),
    )


def slopes(law: Law, start: float, end: float) -> Law:
    """Eq. 3: by force, stroke and mass; A / F is sqrt(m L / F)."""
    force, stroke, mass = law
    low, high = angles(law, start, end)
    fall = (falling(low) / 2, falling(high) / 2)
    rise_low, rise_high = rising_on(low, high)
    return (
        product(root(mass, stroke, force), (rise_low / 2, rise_high / 2)),
        product(root(force, mass, stroke), fall),
        product(root(force, stroke, mass), fall),
    )


def end_of_stroke(law: Law) -> Interval:
    """Enclose pi / (2 omega)."""
    force, stroke, mass = law
    quarter = HALF_TURN
    return (
        quarter * (mass[0] * stroke[0] / force[1]).sqrt(),
        quarter * (mass[1] * stroke[1] / force[0]).sqrt(),
    )


def law_of(spring: Spring, constants: Constants) -> Law:
    """Enclose force, stroke and mass of a spring."""
    force, stroke, mass = (constants.interval(value) for value in spring.law)
    return force, stroke, mass


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


def _held(theta: arb) -> arb:
    """Return the integral of sigma from 0 to theta."""
    capped = theta.min(HALF_TURN)
    return 1 - capped.cos() + (theta - capped)


class NominalImpulse:
    """J_g of a group of springs at nominal values, and its kernel (Eq. 14).

    The last row of the kernel is for all times after the first `push` pieces.
    """

    def __init__(self, problem: Problem, spring: Spring, push: int):
        law: Law = tuple(point(value.value) for value in spring.law)  # type: ignore
        (force, _), (stroke, _), (mass, _) = law
        omega, most = (force / (mass * stroke)).sqrt(), (force * mass * stroke).sqrt()
        at = [most * sigma(omega * arb(t)) for t in problem.grid]
        ends = list(pairwise(at))
        self.impulse: list[Interval] = ends
        held = [_held(omega * arb(t)) for t in problem.grid]
        means = []
        for m, length in enumerate(problem.lengths):
            mean = most / (omega * length) * (held[m + 1] - held[m])
            means.append(intersection(point(mean), ends[m]))
        rows = [
            [((low - mean[1]).max(ZERO), high - mean[0]) for mean in means[:n]]
            + [(ZERO, high - means[n][0])]
            for n, (low, high) in enumerate(ends[:push])
        ]
        rows.append([((most - b).max(ZERO), most - a) for a, b in means[:push]])
        self.kernel = PositiveKernel(rows)


def pieces_of_push(problem: Problem) -> int:
    """Return how many pieces there are until all strokes end, on the whole box."""
    whole = Constants(problem, problem.root, []).with_nominal
    laws = [law_of(spring, whole) for spring in problem.springs]
    return sum(
        any(not end_of_stroke(law)[1] <= arb(start) for law in laws)
        for start in problem.grid[:-1]
    )
