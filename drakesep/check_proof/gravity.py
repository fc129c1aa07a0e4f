"""How much gravity can do, once for the whole box (Eq. 11 and 12)."""

from flint import arb

from .boxes import Constants
from .certificate import Body, Problem
from .impulses import law_of
from .intervals import (
    ZERO,
    Interval,
    NotVerified,
    Vector,
    cross,
    jet_square,
    magnitude,
    vector_minus,
)


class Disturbance:
    """Bounds of the torque on each body and of the differences of accelerations."""

    def __init__(self, problem: Problem):
        self.torque: list[list[arb]] = [[ZERO] * 3 for _ in problem.bodies]
        self.acceleration = ZERO
        if problem.gravity is None:
            return
        constants = Constants(problem, problem.root, [])
        reach = _reach(problem, constants)
        least = arb(problem.gravity.least_radius) - reach
        gradient = arb(problem.gravity.mu) / least**3
        self.torque = [_torque(body, constants, gradient) for body in problem.bodies]
        self.acceleration = 4 * gradient * reach


def _torque(body: Body, constants: Constants, gradient: arb) -> list[arb]:
    """Eq. 12."""
    xx, yy, zz, xy, xz, yz = (constants.interval(value) for value in body.inertia)
    half = arb(1) / 2

    def bound(
        b: Interval, c: Interval, bc: Interval, ab: Interval, ac: Interval
    ) -> arb:
        difference = (c[0] - b[1], c[1] - b[0])
        near = half * (magnitude(difference) + magnitude(ab) + magnitude(ac))
        return 3 * gradient * (near + magnitude(bc))

    return [
        bound(yy, zz, yz, xy, xz),
        bound(zz, xx, xz, yz, xy),
        bound(xx, yy, xy, xz, yz),
    ]


def _reach(problem: Problem, constants: Constants) -> arb:
    """Return a distance from W's origin that no CG reaches (Eq. 11), m."""
    assert problem.gravity is not None
    duration = arb(problem.grid[-1])
    moved = [
        _moved(b, problem, constants, duration) for b in range(len(problem.bodies))
    ]
    reach = ZERO
    for _ in range(20):
        least = arb(problem.gravity.least_radius) - reach
        if not least > ZERO:
            break
        pull = duration**2 * 2 * arb(problem.gravity.mu) * reach / least**3
        needed = [distance + pull for distance in moved]
        if all(distance < reach for distance in needed):
            return reach
        reach = arb(max(float(distance.upper()) for distance in needed) * (1 + 1e-9))
    raise NotVerified("gravity: bodies may go too far for its bound (Eq. 11)")


def _moved(b: int, problem: Problem, constants: Constants, duration: arb) -> arb:
    """Return how far from W's origin a CG may be but for gravity."""
    assert problem.gravity is not None
    body, first = problem.bodies[b], problem.bodies[0]
    place, at_rest = (constants.cg(x) for x in (body, first))
    velocity = cross(constants.vector(problem.rate), vector_minus(place, at_rest))
    speed = _length(velocity)
    for pair in problem.pairs:
        if b == pair.leaver:
            speed += _length(constants.swing(pair, constants.vector(body.cg)))
    impulse = ZERO
    for spring in problem.springs:
        pair = problem.pairs[spring.pair]
        if b in (pair.carrier, pair.leaver):
            force, stroke, mass, _ = law_of(spring, constants)
            impulse += (force[1] * stroke[1] * mass[1]).sqrt()
    push = impulse / constants.interval(body.mass)[0]
    return _length(place) + duration * (speed + push)


def _length(x: Vector) -> arb:
    return sum((jet_square(jet)[0][1] for jet in x), ZERO).sqrt()
