"""How strong gravity is at most: a disturbance of the motion, whatever the attitude.

Numbers in brackets are those of docs/proof.md.
"""

from dataclasses import dataclass

from drakesep.analysis.bounds.box import Boxes, whole_box
from drakesep.analysis.bounds.intervals import Interval, total
from drakesep.analysis.bounds.jets import turned
from drakesep.analysis.bounds.problem import BoundProblem, NotCovered


@dataclass(frozen=True)
class Disturbance:
    """What gravity does at most, over the whole box."""

    torque: tuple[tuple[float, float, float], ...]
    """Of each body, in its axes, N m."""
    acceleration: tuple[float, ...]
    """Of each pair: of B less that of A, in any direction, m/s^2."""


def disturbance(problem: BoundProblem) -> Disturbance:
    """Return what gravity does at most.

    Raises:
        NotCovered: the bodies get so far that nothing is known.
    """
    if problem.gravity is None:
        none = (0.0, 0.0, 0.0)
        return Disturbance((none,) * len(problem.bodies), (0.0,) * len(problem.pairs))
    boxes = whole_box(problem)
    reach = _reach(boxes)
    mu, radius = problem.gravity.mu, problem.gravity.least_radius
    gradient = _gradient(mu, radius, reach)  # mu / r^3
    torques = []
    for body in problem.bodies:
        inertia = [boxes.affine(x).value for x in body.inertia]
        x, y, z = (_torque(inertia, gradient, axis) for axis in range(3))
        torques.append((x, y, z))
    apart = float((gradient * (4.0 * reach)).hi)
    return Disturbance(tuple(torques), (apart,) * len(problem.pairs))


def _gradient(mu: float, radius: float, reach: float) -> Interval:
    if not reach < 0.5 * radius:
        raise NotCovered("duration: the bodies get too far for bounds")
    near = Interval(radius) - Interval(reach)
    return Interval(mu) / (near * near * near)


def _torque(inertia: list[Interval], gradient: Interval, axis: int) -> float:
    """Return the largest torque about an axis, N m: (12)."""
    xx_yy_zz, (xy, xz, yz) = inertia[:3], inertia[3:]
    j, k = (axis + 1) % 3, (axis + 2) % 3
    product = {0: yz, 1: xz, 2: xy}
    size = (xx_yy_zz[k] - xx_yy_zz[j]).abs() * 0.5 + product[axis].abs()
    size = size + (product[j].abs() + product[k].abs()) * 0.5
    return float((gradient * size * 3.0).hi.max())


def _reach(boxes: Boxes) -> float:
    """Return within which distance of W's origin all CGs stay, m: (11)."""
    problem = boxes.problem
    assert problem.gravity is not None
    T = Interval(problem.duration)
    starts, speeds = zip(
        *(_start_and_speed(boxes, b) for b in range(len(problem.bodies))), strict=True
    )
    reach = (
        2.0
        * max(float((p + T * v).hi.max()) for p, v in zip(starts, speeds, strict=True))
        + 1.0
    )
    gradient = _gradient(problem.gravity.mu, problem.gravity.least_radius, reach)
    fall = T * T * gradient * (2.0 * reach)
    for p, v in zip(starts, speeds, strict=True):
        if not (p + T * v + fall).hi.max() < reach:
            raise NotCovered("duration: gravity moves the bodies too far for bounds")
    return reach


def _start_and_speed(boxes: Boxes, b: int) -> tuple[Interval, Interval]:
    """Return how far a body's CG is from W's origin at first, and its largest speed."""
    problem = boxes.problem
    start = _in_stack(boxes, b)
    from_A = [x - y for x, y in zip(start, _in_stack(boxes, 0), strict=True)]
    w = _length([x.value for x in boxes.vector(problem.rate)])
    given = [
        boxes.law(spring).amplitude
        for spring in problem.springs
        if b in (problem.pairs[spring.pair].A, problem.pairs[spring.pair].B)
    ]
    speed = w * _length(from_A) + _spun(boxes, b)
    if given:
        speed = speed + total(given) / boxes.affine(problem.bodies[b].mass).value
    return _length(start), speed


def _in_stack(boxes: Boxes, b: int) -> list[Interval]:
    """Return where a body's CG is in the stack."""
    body = boxes.problem.bodies[b]
    cg = turned(boxes.orientation(body), boxes.vector(body.cg))
    return [(x + o).value for x, o in zip(cg, boxes.place(body), strict=True)]


def _spun(boxes: Boxes, b: int) -> Interval:
    """Return the speed that spins give to a body's CG while it is mated."""
    speed = Interval(0.0)
    for pair in boxes.problem.pairs:
        if pair.B == b and pair.spin is not None:
            cg = boxes.vector(boxes.problem.bodies[b].cg)
            speed = speed + _length([x.value for x in boxes.spinning(pair, cg)])
    return speed


def _length(vector: list[Interval]) -> Interval:
    return total([x.square() for x in vector]).sqrt()
