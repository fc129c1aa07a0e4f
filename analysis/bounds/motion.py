"""The motion of a separation over boxes of parameters, enclosed with its derivatives.

The equations and the theorem are those of docs/proof.md; numbers in comments are its.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from drakesep.analysis.bounds.box import (
    AffineVector,
    Boxes,
    affine_cross,
    entry,
    is_zero,
    mating,
    matrix,
    nominal_law,
    transposed,
    turned,
)
from drakesep.analysis.bounds.gravity import Disturbance
from drakesep.analysis.bounds.impulses import impulse
from drakesep.analysis.bounds.intervals import Interval, total
from drakesep.analysis.bounds.inverse_inertia import inverse
from drakesep.analysis.bounds.jets import (
    Affine,
    Jet,
    added,
    combined,
    cross,
    integrals,
    rotated,
    stacked,
)
from drakesep.analysis.bounds.kernels import DeviationKernel, NominalKernel
from drakesep.analysis.bounds.problem import BoundProblem, BoundSpring, Number
from drakesep.systems.arrays import Array


class Grid(NamedTuple):
    """Pieces of time."""

    times: Array
    """(N + 1,) their ends, s."""
    push: int
    """Of them, those before all strokes have surely ended."""

    @property
    def lengths(self) -> Array:
        """(N,) s."""
        return np.diff(self.times)


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


class _Spring(NamedTuple):
    """A spring over the boxes."""

    pair: int
    J: Jet
    deviation: DeviationKernel
    D: Jet
    arm: AffineVector
    """Of the pad from B's CG, in B."""
    beside: AffineVector
    """The pad from the pair's reference point, in B."""
    start: AffineVector
    """Of the pad from A's CG at first, in A."""
    axis_A: list[Interval]
    axis_B: list[Interval]
    """The same in B while mated."""


class _Group(NamedTuple):
    """Springs of a pair with one axis and one nominal law."""

    kernel: NominalKernel
    springs: list[_Spring]


class NominalKernels:
    """The kernels of the springs' nominal laws, made once for all boxes."""

    def __init__(self, problem: BoundProblem, grid: Grid):
        keys = [
            (s.pair, s.axis, s.force_max.value, s.stroke.value, s.design_mass.value)
            for s in problem.springs
        ]
        self.groups: list[tuple[NominalKernel, list[int]]] = []
        for key in dict.fromkeys(keys):
            members = [k for k, other in enumerate(keys) if other == key]
            law = nominal_law(problem.springs[members[0]])
            kernel = NominalKernel(law, grid.times, grid.push)
            self.groups.append((kernel, members))


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
        self._mated = [mating(problem, pair) for pair in problem.pairs]
        self._inertia = [[boxes.affine(x) for x in b.inertia] for b in problem.bodies]
        self._G = [inverse([x.value for x in entries]) for entries in self._inertia]
        rate = boxes.vector(problem.rate)
        self.rate0 = [
            turned(transposed(matrix(b.orientation)), rate) for b in problem.bodies
        ]
        self._Iw0 = [
            _applied(entries, w)
            for entries, w in zip(self._inertia, self.rate0, strict=True)
        ]
        self._groups = self._make_groups(kernels)
        self._pushed, self._reacted = self._impulsive_torques()
        self._speeds = [self._given_speed(j) for j in range(len(problem.pairs))]
        self._place_pairs()
        self.proven, self.state = self._enclose()

    # ------------------------------------------------------------------ springs

    def _make_groups(self, kernels: NominalKernels) -> list[_Group]:
        return [
            _Group(kernel, [self._spring(k, kernel) for k in members])
            for kernel, members in kernels.groups
        ]

    def _spring(self, k: int, kernel: NominalKernel) -> _Spring:
        boxes, spring = self._boxes, self.problem.springs[k]
        pair = self.problem.pairs[spring.pair]
        times = self.grid.times
        pieces = Interval(times[:-1], times[1:])
        here = impulse(boxes.law(spring), pieces)
        J = self._jet(spring, here.value, here.by)
        wide = impulse(boxes.with_nominal.law(spring), pieces)
        D = self._jet(spring, self._deviation(spring, wide.by), here.by)
        value = D.value.meet(here.value - kernel.range)  # (13)
        D.lo[0], D.hi[0] = value.lo, value.hi
        push = self.grid.push
        rows = [self._boxes.rows[i] for _, i in _varied(spring) if i in boxes.rows]
        R0 = self._mated[spring.pair].R0
        pad_B = boxes.pad_in_B(spring)
        axis = [entry(x) for x in spring.axis]
        pad, cg_A, cg_B = (
            boxes.vector(x)
            for x in (
                spring.place,
                self.problem.bodies[pair.A].cg,
                self.problem.bodies[pair.B].cg,
            )
        )
        return _Spring(
            pair=spring.pair,
            J=J,
            deviation=DeviationKernel(D[..., : push + 1], rows, times, push),
            D=D,
            arm=[x - y for x, y in zip(pad_B, cg_B, strict=True)],
            beside=[
                x - Affine(Interval(y))
                for x, y in zip(pad_B, pair.reference, strict=True)
            ],
            start=[x - y for x, y in zip(pad, cg_A, strict=True)],
            axis_A=axis,
            axis_B=[
                _constant(x) for x in turned(transposed(R0), [Affine(x) for x in axis])
            ],
        )

    def _jet(self, spring: BoundSpring, value: Interval, by: Sequence[Interval]) -> Jet:
        jet = Jet.zeros(self.rows, self._boxes.count, self._pieces)
        jet.lo[0], jet.hi[0] = value.lo, value.hi
        for x, i in self._slopes(spring, by):
            if i in self._boxes.rows:
                row = 1 + self._boxes.rows[i]
                jet.lo[row], jet.hi[row] = x.lo, x.hi
        return jet

    def _slopes(
        self, spring: BoundSpring, by: Sequence[Interval]
    ) -> list[tuple[Interval, int]]:
        """Return the derivatives of an impulse by s, and of which parameters."""
        scale = [Interval(p.scale) for p in self.problem.parameters]
        return [(by[a] * scale[i], i) for a, i in _varied(spring)]

    def _deviation(self, spring: BoundSpring, by: Sequence[Interval]) -> Interval:
        """Return what an impulse differs by from the nominal: (13)."""
        boxes = self._boxes
        terms = [
            x * Interval(boxes.lower[:, i, None], boxes.upper[:, i, None])
            for x, i in self._slopes(spring, by)
        ]
        return total(terms) if terms else Interval(np.zeros((1, self._pieces)))

    def _impulsive_torques(self) -> tuple[list[list[Jet]], list[list[Jet]]]:
        """Return what springs give to I w of each body, were nothing to turn."""
        pushed = [self._zero_vector() for _ in self.problem.bodies]
        reacted = [self._zero_vector() for _ in self.problem.bodies]
        for group in self._groups:
            pair = self.problem.pairs[group.springs[0].pair]
            on_B = [affine_cross(s.arm, s.axis_B) for s in group.springs]
            on_A = [affine_cross(s.start, s.axis_A) for s in group.springs]
            pushed[pair.B] = added(pushed[pair.B], self._given(group, on_B))
            reacted[pair.A] = added(reacted[pair.A], self._given(group, on_A))
        return pushed, reacted

    def _given(self, group: _Group, arms: Sequence[AffineVector]) -> list[Jet]:
        """Return the sum of J times constant vectors, in both of its forms."""
        nominal = group.kernel.range
        vector = []
        for a in range(3):
            each = [(s, arm[a]) for s, arm in zip(group.springs, arms, strict=True)]
            direct = total([s.J * x for s, x in each])
            common = self._lifted(total([x for _, x in each])) * nominal
            apart = total([common, *(s.D * x for s, x in each)])
            vector.append(direct.meet(apart))
        return vector

    def _lifted(self, x: Affine) -> Jet:
        return Jet.of(x, self.rows, self._boxes.count)

    def _given_speed(self, j: int) -> list[Jet]:
        """Return the relative velocity that impulses give to a pair: (9)."""
        pair = self.problem.pairs[j]
        lightness = [
            self._lightness(self.problem.bodies[b].mass) for b in (pair.A, pair.B)
        ]
        speed = self._zero_vector()
        for spring in (s for group in self._groups for s in group.springs):
            if self.problem.pairs[spring.pair].A != pair.A:
                continue
            light = lightness[0] + lightness[1] if spring.pair == j else lightness[0]
            given = spring.J * light
            for a, d in enumerate(spring.axis_A):
                if not is_zero(d):
                    speed[a] = speed[a] + given * d
        return speed

    def _lightness(self, mass: Number) -> Affine:
        m = self._boxes.affine(mass)
        light = m.value.inverse()
        return Affine(light, {i: -(light.square() * x) for i, x in m.slopes.items()})

    def _place_pairs(self) -> None:
        """Set where B's CG and the reference point of each pair are at first."""
        self._start: list[AffineVector] = []
        self._reference: list[AffineVector] = []
        self._reference_arm: list[AffineVector] = []
        self._velocity0: list[AffineVector] = []
        for pair, mated in zip(self.problem.pairs, self._mated, strict=True):
            cg_A, cg_B = (
                self._boxes.vector(self.problem.bodies[b].cg) for b in (pair.A, pair.B)
            )
            point = [Affine(Interval(x)) for x in pair.reference]
            start, reference = (
                [
                    Affine(o) + x - y
                    for o, x, y in zip(
                        mated.place, turned(mated.R0, place), cg_A, strict=True
                    )
                ]
                for place in (cg_B, point)
            )
            self._start.append(start)
            self._reference.append(reference)
            self._reference_arm.append(
                [x - y for x, y in zip(point, cg_B, strict=True)]
            )
            self._velocity0.append(cross(self.rate0[pair.A], start))

    # ----------------------------------------------------------- the right sides

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
        pair, R_BA = self.problem.pairs[j], transposed(self._mated[j].R0)
        changed = rotated(R_BA, u[pair.A])
        rate = [x + w for x, w in zip(u[pair.A], self.rate0[pair.A], strict=True)]
        rate = rotated(R_BA, rate)
        Q = state.Q[j]
        return [
            u[pair.B][a] - changed[a] - total([Q[b][a] * rate[b] for b in range(3)])
            for a in range(3)
        ]

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
            for p, q in zip(self._pushed, self._reacted, strict=True)
        ]
        times = self.grid.times[1:]
        for b in range(len(S)):
            gyro = self._gyroscopic(b, w[b], X.S[b])
            for a in range(3):
                most = self._gravity.torque[b][a]
                late = Interval(-most, most) * Interval(times)
                S[b][a] = S[b][a] - integrals(gyro[a], self.grid.lengths) + late
        for j, pair in enumerate(self.problem.pairs):
            groups = [g for g in self._groups if g.springs[0].pair == j]
            if groups:
                on_A, on_B = self._turned_torques(turning[j], moving[j], j, groups)
                S[pair.A] = [x - y for x, y in zip(S[pair.A], on_A, strict=True)]
                S[pair.B] = added(S[pair.B], on_B)
        return S

    def _turned_torques(
        self,
        turning: list[list[Jet]],
        moving: list[Jet],
        j: int,
        groups: Sequence[_Group],
    ) -> tuple[list[Jet], list[Jet]]:
        """Return what q of (6) and (7) gives, to A (to be taken away) and to B."""
        push = self.grid.push
        flat = [*(x for row in turning for x in row), *moving]
        moved = stacked([x[..., :push] for x in flat])
        on_A, on_B = [], []
        for group in groups:
            first = group.springs[0]
            q = self._spread(group.kernel(moved))
            arm = _summed(s.arm for s in group.springs)
            beside = _summed(s.beside for s in group.springs)
            on_A.append(self._on_A(q, first, beside, j, float(len(group.springs))))
            on_B.append(self._on_B(q, first, arm))
            for spring in group.springs:
                q = self._spread(spring.deviation(moved))
                on_A.append(self._on_A(q, spring, spring.beside, j, 1.0))
                on_B.append(self._on_B(q, spring, spring.arm))
        return added(*on_A), added(*on_B)

    def _spread(self, q: Jet) -> list[Jet]:
        """Return integrals over all pieces: after the push they stay as they are."""
        lo = np.repeat(q.lo[..., -1:], self._pieces - self.grid.push, -1)
        hi = np.repeat(q.hi[..., -1:], self._pieces - self.grid.push, -1)
        push = slice(0, self.grid.push)
        lo = np.concatenate([q.lo[..., push], lo], -1)
        hi = np.concatenate([q.hi[..., push], hi], -1)
        return [Jet(a, b) for a, b in zip(lo, hi, strict=True)]

    def _on_B(self, q: list[Jet], spring: _Spring, arm: AffineVector) -> list[Jet]:
        columns = [[q[3 * i + a] for i in range(3)] for a in range(3)]
        moved = [combined(spring.axis_B, column) for column in columns]
        return [-x for x in cross(moved, arm)]

    def _on_A(
        self, q: list[Jet], spring: _Spring, arm: AffineVector, j: int, count: float
    ) -> list[Jet]:
        turned_arm = [
            total([q[3 * i + a] * arm[a] for a in range(3)]) for i in range(3)
        ]
        place = rotated(self._mated[j].R0, turned_arm)
        shift = [x + y * count for x, y in zip(place, q[9:], strict=True)]
        return cross(shift, [Affine(x) for x in spring.axis_A])

    def _given_velocity(self, X: State, w: list[list[Jet]], j: int) -> list[Jet]:
        """Return the change of a pair's relative velocity: (9)."""
        A = self.problem.pairs[j].A
        velocity = [x + v for x, v in zip(X.U[j], self._velocity0[j], strict=True)]
        turned_on = cross(w[A], velocity)
        most = self._gravity.acceleration[j]
        late = Interval(-most, most) * Interval(self.grid.times[1:])
        return [
            given - integrals(x, self.grid.lengths) + late
            for given, x in zip(self._speeds[j], turned_on, strict=True)
        ]

    def _moving(
        self, X: State, u: list[list[Jet]], w: list[list[Jet]], j: int
    ) -> list[Jet]:
        """Return how fast a pair's reference point moves in A: (10)."""
        pair, R0 = self.problem.pairs[j], self._mated[j].R0
        arm, start = self._reference_arm[j], self._reference[j]
        y, Q = X.y[j], X.Q[j]
        place = [v + x for v, x in zip(y, start, strict=True)]
        with_A = cross(u[pair.A], place)
        with_stack = cross(y, self.rate0[pair.A])
        with_B = rotated(R0, cross(u[pair.B], arm))
        swung = cross(w[pair.B], arm)
        turned_on = rotated(
            R0, [total([Q[i][a] * swung[a] for a in range(3)]) for i in range(3)]
        )
        return [
            U - a + b + c + d
            for U, a, b, c, d in zip(
                X.U[j], with_A, with_stack, with_B, turned_on, strict=True
            )
        ]

    def displacement(self, state: State, j: int) -> list[Jet]:
        """Return how far the CG of a pair's B has moved, as seen from A: (11)."""
        Q, arm = state.Q[j], self._reference_arm[j]
        turned_arm = [total([Q[i][a] * arm[a] for a in range(3)]) for i in range(3)]
        back = rotated(self._mated[j].R0, turned_arm)
        return [x - y for x, y in zip(state.y[j], back, strict=True)]

    def velocity(self, state: State, j: int) -> list[Jet]:
        """Return the velocity of the CG of a pair's B, as seen from A: (11)."""
        A = self.problem.pairs[j].A
        moved = self.displacement(state, j)
        place = [x + r for x, r in zip(moved, self._start[j], strict=True)]
        with_A = cross(self._solved(A, state.S[A]), place)
        with_stack = cross(moved, self.rate0[A])
        return [
            U - a + b for U, a, b in zip(state.U[j], with_A, with_stack, strict=True)
        ]

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
        pair, R_BA = self.problem.pairs[j], transposed(self._mated[j].R0)
        Q, u = self.state.Q[j], self.changes(self.state)
        changes = self.accelerations()
        of_A = rotated(R_BA, changes[pair.A])
        rate = rotated(R_BA, self.rates(self.state)[pair.A])
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


def _summed(vectors: Iterable[AffineVector]) -> AffineVector:
    return [total(each) for each in zip(*vectors, strict=True)]


def _constant(x: Affine) -> Interval:
    return x.value


def _varied(spring: BoundSpring) -> list[tuple[int, int]]:
    """Return which numbers of a spring's law are parameters, and which parameters."""
    numbers = (spring.force_max, spring.stroke, spring.design_mass)
    return [
        (a, number.parameter)
        for a, number in enumerate(numbers)
        if number.parameter is not None
    ]
