"""The motion of a separation over boxes of parameters, enclosed with its derivatives.

The equations and the theorem are those of docs/proof.md; numbers in comments are its.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from drakesep.analysis.bounds.box import Boxes, Mating
from drakesep.analysis.bounds.gravity import Disturbance
from drakesep.analysis.bounds.grid import Grid
from drakesep.analysis.bounds.intervals import Interval, total
from drakesep.analysis.bounds.inverse_inertia import inverse
from drakesep.analysis.bounds.jets import (
    Affine,
    Jet,
    added,
    cross,
    integrals,
    turned,
)
from drakesep.analysis.bounds.problem import BoundBody, BoundPair
from drakesep.analysis.bounds.pushes import NominalKernels, Pushes
from drakesep.analysis.bounds.rotations import (
    AffineVector,
    Matrix,
    affine_cross,
    constant,
    minus,
    plus,
    product,
    transposed,
)


@dataclass
class State:
    """What is enclosed; all of jets (1 + n, boxes, pieces)."""

    S: list[list[Jet]]
    """Change of I w of each body, in its axes, N m s."""
    Q: list[list[list[Jet]]]
    """R = R0 (1 + Q) is the orientation of each pair's B in its A."""
    U: list[list[Jet]]
    """Change of the velocity of each pair's B less that of A: of CGs, in A, m/s."""
    y: list[list[Jet]]
    """How far each pair's reference point, fixed in B, has moved in A, m."""
    P: list[list[list[Jet]]]
    """R = R(0) (1 + P) is the orientation of each pair's B in W, if it is asked for."""

    def jets(self) -> Iterator[Jet]:
        """Yield all of them."""
        for part in fields(self):
            yield from _flat(getattr(self, part.name))


def _flat(parts: object) -> Iterator[Jet]:
    if isinstance(parts, Jet):
        yield parts
    elif isinstance(parts, list):
        for part in parts:
            yield from _flat(part)


class _Start(NamedTuple):
    """How a pair moves as it lets go, over the boxes."""

    R0: Matrix
    """Orientation of B in A."""
    R_BA: Matrix
    """Its transpose."""
    place: AffineVector
    """Of B's CG from A's, in A."""
    reference: AffineVector
    """Of B's reference point from A's CG, in A."""
    arm: AffineVector
    """Of the reference point from B's CG, in B."""
    velocity: AffineVector
    """Of B's CG less that of A's, in A."""
    spin: AffineVector
    """Rate of B relative to A, in B."""
    swing: AffineVector
    """Velocity of B's CG as seen from A, in A."""
    reference_swing: AffineVector
    """The same of the reference point."""


class Enclosure:
    """The motion over boxes of parameters.

    Attributes:
        proven: (boxes,) whether the inclusion was shown; else nothing is known.
        state: what is enclosed.
    """

    def __init__(
        self,
        boxes: Boxes,
        grid: Grid,
        kernels: NominalKernels,
        gravity: Disturbance,
        *,
        attitudes: bool = False,
    ):
        """Enclose.

        Args:
            boxes: of the parameters, and by which derivatives are taken.
            grid: the pieces of time.
            kernels: of the springs' nominal laws, on the grid.
            gravity: what it does at most.
            attitudes: whether to enclose orientations in W, too.
        """
        self._boxes, self._gravity = boxes, gravity
        self.grid = grid
        self.problem = problem = boxes.problem
        self.rows = len(boxes.rows)
        self._pieces = len(grid.times) - 1
        self._attitudes = attitudes
        self._mated = [boxes.mating(pair) for pair in problem.pairs]
        self._inertia = [[boxes.affine(x) for x in b.inertia] for b in problem.bodies]
        self._G = [inverse([x.value for x in entries]) for entries in self._inertia]
        self.rate0 = boxes.rates()
        self._Iw0 = [
            _applied(entries, w)
            for entries, w in zip(self._inertia, self.rate0, strict=True)
        ]
        self._pushes = Pushes(boxes, grid, kernels, self._mated)
        self._starts = [
            self._start(pair, mated)
            for pair, mated in zip(problem.pairs, self._mated, strict=True)
        ]
        self.proven, self.state = self._enclose()

    def _start(self, pair: BoundPair, mated: Mating) -> _Start:
        boxes, bodies = self._boxes, self.problem.bodies
        cg_A, cg_B = (boxes.vector(bodies[b].cg) for b in (pair.A, pair.B))
        point = constant(pair.reference)
        place, reference = (
            minus(plus(mated.place, turned(mated.R0, x)), cg_A) for x in (cg_B, point)
        )
        swing = boxes.spinning(pair, cg_B)
        return _Start(
            R0=mated.R0,
            R_BA=transposed(mated.R0),
            place=place,
            reference=reference,
            arm=minus(point, cg_B),
            velocity=plus(affine_cross(self.rate0[pair.A], place), swing),
            spin=turned(transposed(mated.R0), boxes.spin(pair)),
            swing=swing,
            reference_swing=boxes.spinning(pair, point),
        )

    # ----------------------------------------------------------- the right sides

    def attitude(self, body: BoundBody) -> Matrix:
        """Return the orientation of a body in W before separation."""
        return product(self._boxes.attitude(), self._boxes.orientation(body))

    def rates(self, state: State) -> list[list[Jet]]:
        """Return the rate of each body, in its axes."""
        return [
            [x + w for x, w in zip(u, w0, strict=True)]
            for u, w0 in zip(self.changes(state), self.rate0, strict=True)
        ]

    def changes(self, state: State) -> list[list[Jet]]:
        """Return the change of the rate of each body, in its axes."""
        return [self._solved(b, S) for b, S in enumerate(state.S)]

    def _solved(self, b: int, S: Sequence[Jet]) -> list[Jet]:
        """Return u of I u = S, with its derivatives: (16)."""
        G, rows = self._G[b], S
        if self.rows:
            value = [_weighted(G[a], [s.value for s in S]) for a in range(3)]
            rows = self._without_inertia(b, S, value)
        return [_weighted(G[a], rows) for a in range(3)]

    def _without_inertia(
        self, b: int, S: Sequence[Jet], u: Sequence[Interval]
    ) -> list[Jet]:
        """Return S with I_i u taken from its derivatives."""
        rows = [Jet(s.lo.copy(), s.hi.copy()) for s in S]
        places = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
        for entry_, (a, c) in zip(self._inertia[b], places, strict=True):
            for i, slope in entry_.slopes.items():
                for row, column in {(a, c), (c, a)}:
                    x = rows[row].slopes[i] - u[column] * slope
                    rows[row].lo[1 + i], rows[row].hi[1 + i] = x.lo, x.hi
        return rows

    def relative_rate(self, state: State, u: list[list[Jet]], j: int) -> list[Jet]:
        """Return the rate of a pair's B relative to A, in B: (4)."""
        pair, start = self.problem.pairs[j], self._starts[j]
        changed = turned(start.R_BA, u[pair.A])
        rate = [x + w for x, w in zip(u[pair.A], self.rate0[pair.A], strict=True)]
        rate = turned(start.R_BA, rate)
        Q = state.Q[j]
        change = [
            u[pair.B][a] - changed[a] - total([Q[b][a] * rate[b] for b in range(3)])
            for a in range(3)
        ]
        return _raised(change, start.spin)

    def _gyroscopic(self, b: int, w: Sequence[Jet], S: Sequence[Jet]) -> list[Jet]:
        """Return w x I w, in both of its forms: (17)."""
        first = cross(w, [s + x for s, x in zip(S, self._Iw0[b], strict=True)])
        xx, yy, zz, xy, xz, yz = self._inertia[b]
        x, y, z = w
        squares = [x.squared(), y.squared(), z.squared()]
        mixed = {"yz": y * z, "xz": x * z, "xy": x * y}
        terms = (
            (
                (zz - yy, mixed["yz"]),
                (yz, squares[1] - squares[2]),
                (xz, mixed["xy"]),
                (-xy, mixed["xz"]),
            ),
            (
                (xx - zz, mixed["xz"]),
                (xz, squares[2] - squares[0]),
                (xy, mixed["yz"]),
                (-yz, mixed["xy"]),
            ),
            (
                (yy - xx, mixed["xy"]),
                (xy, squares[0] - squares[1]),
                (yz, mixed["xz"]),
                (-xz, mixed["yz"]),
            ),
        )
        second = [
            total([jet * factor for factor, jet in row if not factor.is_zero])
            for row in terms
        ]
        return [a.meet(b) for a, b in zip(first, second, strict=True)]

    def apply(self, X: State) -> State:
        """Return the right sides of (6) to (10) over what is enclosed."""
        u, w = self.changes(X), self.rates(X)
        rates = [self.relative_rate(X, u, j) for j in range(len(self.problem.pairs))]
        turning = [_turning(Q, W) for Q, W in zip(X.Q, rates, strict=True)]
        moving = [self._moving(X, u, w, j) for j in range(len(self.problem.pairs))]
        S = self._momenta(X, w, turning, moving)
        U = [self._given_velocity(X, w, j) for j in range(len(self.problem.pairs))]
        lengths = self.grid.lengths
        y = [[integrals(x, lengths) for x in moved] for moved in moving]
        Q = [[[integrals(x, lengths) for x in row] for row in T] for T in turning]
        P = [
            [
                [integrals(x, lengths) for x in row]
                for row in _turning(turn, w[self.problem.pairs[j].B])
            ]
            for j, turn in enumerate(X.P)
        ]
        return State(S=S, Q=Q, U=U, y=y, P=P)

    def _momenta(
        self,
        X: State,
        w: list[list[Jet]],
        turning: list[list[list[Jet]]],
        moving: list[list[Jet]],
    ) -> list[list[Jet]]:
        S = [
            added(p, [-x for x in q])
            for p, q in zip(self._pushes.on_B, self._pushes.on_A, strict=True)
        ]
        times = self.grid.times[1:]
        for b in range(len(S)):
            gyro = self._gyroscopic(b, w[b], X.S[b])
            for a in range(3):
                most = self._gravity.torque[b][a]
                late = Interval(-most, most) * Interval(times)
                S[b][a] = S[b][a] - integrals(gyro[a], self.grid.lengths) + late
        for j, pair in enumerate(self.problem.pairs):
            torques = self._pushes.torques(j, turning[j], moving[j])
            if torques is not None:
                on_A, on_B = torques
                S[pair.A] = [x - y for x, y in zip(S[pair.A], on_A, strict=True)]
                S[pair.B] = added(S[pair.B], on_B)
        return S

    def _given_velocity(self, X: State, w: list[list[Jet]], j: int) -> list[Jet]:
        """Return the change of a pair's relative velocity: (9)."""
        A = self.problem.pairs[j].A
        velocity = _raised(X.U[j], self._starts[j].velocity)
        turned_on = cross(w[A], velocity)
        most = self._gravity.acceleration[j]
        late = Interval(-most, most) * Interval(self.grid.times[1:])
        return [
            given - integrals(x, self.grid.lengths) + late
            for given, x in zip(self._pushes.speeds[j], turned_on, strict=True)
        ]

    def _moving(
        self, X: State, u: list[list[Jet]], w: list[list[Jet]], j: int
    ) -> list[Jet]:
        """Return how fast a pair's reference point moves in A: (10)."""
        pair, start = self.problem.pairs[j], self._starts[j]
        R0, arm = start.R0, start.arm
        y, Q = X.y[j], X.Q[j]
        place = [v + x for v, x in zip(y, start.reference, strict=True)]
        with_A = cross(u[pair.A], place)
        with_stack = cross(y, self.rate0[pair.A])
        with_B = turned(R0, cross(u[pair.B], arm))
        swung = cross(w[pair.B], arm)
        turned_on = turned(
            R0, [total([Q[i][a] * swung[a] for a in range(3)]) for i in range(3)]
        )
        change = [
            U - a + b + c + d
            for U, a, b, c, d in zip(
                X.U[j], with_A, with_stack, with_B, turned_on, strict=True
            )
        ]
        return _raised(change, start.reference_swing)

    def displacement(self, state: State, j: int) -> list[Jet]:
        """Return how far the CG of a pair's B has moved, as seen from A: (11)."""
        Q, arm = state.Q[j], self._starts[j].arm
        turned_arm = [total([Q[i][a] * arm[a] for a in range(3)]) for i in range(3)]
        back = turned(self._starts[j].R0, turned_arm)
        return [x - y for x, y in zip(state.y[j], back, strict=True)]

    def velocity(self, state: State, j: int) -> list[Jet]:
        """Return the velocity of the CG of a pair's B, as seen from A: (11)."""
        A, start = self.problem.pairs[j].A, self._starts[j]
        moved = self.displacement(state, j)
        place = [x + r for x, r in zip(moved, start.place, strict=True)]
        with_A = cross(self._solved(A, state.S[A]), place)
        with_stack = cross(moved, self.rate0[A])
        change = [
            U - a + b for U, a, b in zip(state.U[j], with_A, with_stack, strict=True)
        ]
        return _raised(change, start.swing)

    def accelerations(self) -> list[list[Jet]]:
        """Return the derivative of the rate of each body by time, without springs.

        It is the motion's after the push.
        """
        w = self.rates(self.state)
        return [self._acceleration(b, w[b]) for b in range(len(w))]

    def _acceleration(self, b: int, w: list[Jet]) -> list[Jet]:
        torque = []
        gyro = self._gyroscopic(b, w, self.state.S[b])
        for x, most in zip(gyro, self._gravity.torque[b], strict=True):
            torque.append(-x + Interval(-most, most))
        return self._solved(b, torque)

    def relative_acceleration(self, j: int) -> list[Jet]:
        """Return the derivative of a pair's relative rate by time: (19), too."""
        pair, R_BA = self.problem.pairs[j], self._starts[j].R_BA
        Q, u = self.state.Q[j], self.changes(self.state)
        changes = self.accelerations()
        of_A = turned(R_BA, changes[pair.A])
        rate = turned(R_BA, self.rates(self.state)[pair.A])
        turning = _turning(Q, self.relative_rate(self.state, u, j))
        return [
            changes[pair.B][a]
            - of_A[a]
            - total([turning[b][a] * rate[b] + Q[b][a] * of_A[b] for b in range(3)])
            for a in range(3)
        ]

    # ------------------------------------------------------------- the inclusion

    def _zero(self) -> Jet:
        return Jet.zeros(self.rows, self._boxes.count, self._pieces)

    def _zero_vector(self) -> list[Jet]:
        return [self._zero() for _ in range(3)]

    def _still(self) -> State:
        pairs = range(len(self.problem.pairs))
        return State(
            S=[self._zero_vector() for _ in self.problem.bodies],
            Q=[[self._zero_vector() for _ in range(3)] for _ in pairs],
            U=[self._zero_vector() for _ in pairs],
            y=[self._zero_vector() for _ in pairs],
            P=[
                [self._zero_vector() for _ in range(3)]
                for _ in pairs
                if self._attitudes
            ],
        )

    def _enclose(self) -> tuple[NDArray[np.bool_], State]:
        """Return where the inclusion holds, and what is enclosed there."""
        X = self._still()
        for _ in range(SWEEPS):
            X = self.apply(X)
        proven = np.zeros(self._boxes.count, dtype=bool)
        for _ in range(TRIES):
            for jet in X.jets():
                _widen(jet)
            Y = self.apply(X)
            inside = [
                y.within(x).all(axis=(0, 2))
                for x, y in zip(X.jets(), Y.jets(), strict=True)
            ]
            proven |= np.logical_and.reduce(inside)
            X = Y
            if proven.all():
                break
        return proven, self.apply(X)


SWEEPS = 3
"""From no change at all, before an inclusion is tried."""
TRIES = 8
_WIDER = 0.02


def _widen(jet: Jet) -> None:
    """Widen a jet, in place: what comes of it is to lie within."""
    largest = np.maximum(np.abs(jet.lo), np.abs(jet.hi)).max(axis=-1, keepdims=True)
    by = (jet.hi - jet.lo) * _WIDER + 1e-12 * largest + 1e-14
    jet.lo -= by
    jet.hi += by


def _turning(Q: list[list[Jet]], rate: Sequence[Jet]) -> list[list[Jet]]:
    """Return (1 + Q) [rate]x, row by row: each is its row times the rate."""
    x, y, z = rate
    units = ((None, -z, y), (z, None, -x), (-y, x, None))
    rows = []
    for row, unit in zip(Q, units, strict=True):
        moved = cross(row, rate)
        rows.append(
            [m if e is None else m + e for m, e in zip(moved, unit, strict=True)]
        )
    return rows


_Terms = TypeVar("_Terms", bound=Interval)


def _weighted(weights: Sequence[Interval], terms: Sequence[_Terms]) -> _Terms:
    return total([t * w for w, t in zip(weights, terms, strict=True)])


def _applied(entries: Sequence[Affine], w: AffineVector) -> AffineVector:
    """Return I w of an inertia by its entries."""
    xx, yy, zz, xy, xz, yz = entries
    return [
        total([x * y for x, y in zip(row, w, strict=True)])
        for row in ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
    ]


def _raised(vector: Sequence[Jet], by: AffineVector) -> list[Jet]:
    """Return a vector with an affine one added; entries of exactly 0 cost nothing."""
    return [x if y.is_zero else x + y for x, y in zip(vector, by, strict=True)]
