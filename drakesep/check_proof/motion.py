"""The motion on a box of parameters: enclosed by the theorem of docs/proof.md."""

from dataclasses import dataclass, replace
from typing import Any

from flint import arb

from .boxes import Constants
from .certificate import Box, Pair, Problem
from .gravity import Disturbance
from .impulses import NominalImpulse, SpringImpulse, pieces_of_push
from .intervals import (
    ONE,
    ZERO,
    Interval,
    Jet,
    Matrix,
    NotVerified,
    Rows,
    Vector,
    applied,
    cross,
    intersection,
    inverse,
    jet_minus,
    jet_negative,
    jet_product,
    jet_square,
    jet_sum,
    jets_intersected,
    minus,
    negative,
    plus,
    point,
    product,
    scaled,
    square,
    symmetric,
    times,
    transposed,
    vector_minus,
    vector_sum,
)
from .kernels import Columns, DifferenceKernel, integrated


WIDER = arb(1) / 4000  # by how much of its width an interval is widened to be entered
TINY = arb(10) ** -18
FIRST, ROUNDS, TRIES = 2, 2, 8


class Setting:
    """What is the same on all boxes: nominal impulses, their kernels, gravity."""

    def __init__(self, problem: Problem):
        self.problem = problem
        self.disturbance = Disturbance(problem)
        self.push = pieces_of_push(problem)
        self.nominal = [
            NominalImpulse(problem, problem.springs[group[0]], self.push)
            for group in problem.groups
        ]


@dataclass
class State:
    """What the theorem encloses, on each piece of time.

    `U` is what the difference of the CGs' velocities has changed by; `y` the way of a
    point of the body that leaves, the reference, as seen from the carrier.
    """

    S: list[list[Vector]]  # of each body
    Q: list[list[Rows]]  # of each pair
    U: list[list[Vector]]
    y: list[list[Vector]]

    @property
    def parts(self) -> "Nested":
        """All intervals, in lists."""
        return [self.S, self.Q, self.U, self.y]

    def without_slopes(self, slopes: list[Interval]) -> "State":
        """Return the values, with other derivatives."""

        def vectors(x: list[list[Vector]]) -> list[list[Vector]]:
            return [[[[jet[0], *slopes] for jet in v] for v in pieces] for pieces in x]

        Q = [
            [[[[j[0], *slopes] for j in v] for v in rows] for rows in p] for p in self.Q
        ]
        return State(vectors(self.S), Q, vectors(self.U), vectors(self.y))


def integral(x: list[Vector], lengths: list[arb]) -> list[Vector]:
    """Integrate vectors over time."""
    axes = (integrated(list(axis), lengths) for axis in zip(*x, strict=True))
    return [list(vector) for vector in zip(*axes, strict=True)]


Nested = Any  # lists in lists of intervals


def widened(x: Nested, wider: arb) -> Nested:
    """Return intervals with exact ends, each wider by some of its width."""
    if isinstance(x, list):
        return [widened(part, wider) for part in x]
    low, high = x
    more = (high - low) * wider + TINY
    return (low - more).lower(), (high + more).upper()


def grown(outer: Nested, inner: Nested) -> Nested:
    """Return the outer intervals, those that do not hold the inner ones grown."""
    if isinstance(inner, list):
        return [grown(x, y) for x, y in zip(outer, inner, strict=True)]
    (low, high), (a, b) = outer, inner
    more = 5 * WIDER * (high - low) + TINY
    return (
        low if low <= a else (a - more).lower(),
        high if high >= b else (b + more).upper(),
    )


def included(inner: Nested, outer: Nested) -> bool:
    """Whether each interval of the one is in that of the other."""
    if isinstance(inner, list):
        return all(included(x, y) for x, y in zip(inner, outer, strict=True))
    return bool(outer[0] <= inner[0] and inner[1] <= outer[1])


def turned(rows: Rows, rate: Vector) -> Rows:
    """Return (1 + Q) [rate]x."""
    out = []
    for a, row in enumerate(rows):
        with_one = list(row)
        with_one[a] = [plus(ONE, row[a][0]), *row[a][1:]]
        out.append(cross(with_one, rate))
    return out


def turned_by(Q: list[Rows], rates: list[Vector], lengths: list[arb]) -> list[Rows]:
    """Return the integral of (1 + Q) [rate]x."""
    X = [turned(rows, rate) for rows, rate in zip(Q, rates, strict=True)]
    flat = integral([[jet for row in rows for jet in row] for rows in X], lengths)
    return [[v[0:3], v[3:6], v[6:9]] for v in flat]


class MovingBody:
    """A body's inertia on a box, its inverse, and the rate of the mated stack."""

    def __init__(self, b: int, constants: Constants):
        body = constants.problem.bodies[b]
        xx, yy, zz, xy, xz, yz = constants.vector(body.inertia)
        self.inertia: Rows = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
        self.differences = [jet_minus(zz, yy), jet_minus(xx, zz), jet_minus(yy, xx)]
        self.off = [yz, xz, xy]
        self.inverse = _inverse([[jet[0] for jet in row] for row in self.inertia])
        mass = constants.jet(body.mass)
        inverse_mass = inverse(mass[0])
        slope = negative(square(inverse_mass))
        self.inverse_mass: Jet = [inverse_mass, *times(slope, mass[1:])]
        self.cg = constants.vector(body.cg)
        self.mated_rate = _mated_rate(b, constants)
        self.mated_momentum = applied(self.inertia, self.mated_rate)

    def change_of_rate(self, S: Vector) -> Vector:
        """Return u = G S, and its derivatives G (S_i - I_i u)."""
        u = [jet[0] for jet in self._solved([[jet[0]] for jet in S])]
        columns = [u]
        for i in range(1, len(S[0])):
            right = []
            for a, row in enumerate(self.inertia):
                rest = S[a][i]
                for jet, x in zip(row, u, strict=True):
                    rest = minus(rest, product(jet[i], x))
                right.append([rest])
            columns.append([jet[0] for jet in self._solved(right)])
        return [list(jet) for jet in zip(*columns, strict=True)]

    def _solved(self, right: Vector) -> Vector:
        return scaled(self.inverse, right)

    def gyroscopic(self, w: Vector, S: Vector) -> Vector:
        """Return w x I w: two forms of it, intersected (Eq. 17)."""
        first = cross(w, vector_sum(self.mated_momentum, S))
        squares = [jet_square(x) for x in w]
        products = [jet_product(w[b], w[c]) for b, c in ((1, 2), (2, 0), (0, 1))]
        second = []
        for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            terms = jet_sum(
                jet_product(self.differences[a], products[a]),
                jet_product(self.off[a], jet_minus(squares[b], squares[c])),
                jet_product(self.off[b], products[c]),
            )
            second.append(jet_minus(terms, jet_product(self.off[c], products[b])))
        return [jets_intersected(x, y) for x, y in zip(first, second, strict=True)]


def _mated_rate(b: int, constants: Constants) -> Vector:
    """Return the rate of a body before separation, in its axes."""
    problem = constants.problem
    R_S = constants.orientation(problem.bodies[b])
    rate = applied(transposed(R_S), constants.vector(problem.rate))
    for pair in problem.pairs:
        if pair.leaver == b and pair.spin is not None:
            R0, _ = constants.mating(pair)
            rate = vector_sum(rate, applied(transposed(R0), constants.spin(pair)))
    return rate


def _inverse(inertia: Matrix) -> Matrix:
    """Enclose the inverses of symmetric matrices (Eq. 16)."""
    G: list[list[Interval]] = [[(ZERO, ZERO)] * 3 for _ in range(3)]
    forms: dict[tuple[int, int], list[Interval]] = {}
    for a, b, c in ((0, 1, 2), (0, 2, 1), (1, 2, 0), (1, 0, 2), (2, 0, 1), (2, 1, 0)):
        by_c = _positive_inverse(inertia[c][c])
        pivot = _positive_inverse(
            minus(inertia[b][b], product(square(inertia[b][c]), by_c))
        )
        rest = minus(
            inertia[a][b], product(product(inertia[b][c], inertia[a][c]), by_c)
        )
        diagonal = minus(inertia[a][a], product(square(inertia[a][c]), by_c))
        diagonal = minus(diagonal, product(square(rest), pivot))
        forms.setdefault((a, a), []).append(_positive_inverse(diagonal))
        eta = product(rest, pivot)
        forms.setdefault((min(a, b), max(a, b)), []).append(eta)
    for a in range(3):
        G[a][a] = intersection(*forms[a, a])
    for a, b in ((0, 1), (0, 2), (1, 2)):
        from_a, from_b = forms[a, b]
        G[a][b] = G[b][a] = intersection(
            negative(product(G[a][a], from_a)), negative(product(G[b][b], from_b))
        )
    return G


def _positive_inverse(pivot: Interval) -> Interval:
    if not pivot[0] > ZERO:
        raise NotVerified("an inertia may not be positive definite")
    return inverse(pivot)


class Pushing:
    """A pair on a box: where its springs stand, and what their impulses do."""

    def __init__(self, j: int, setting: Setting, constants: Constants):
        problem = setting.problem
        pair: Pair = problem.pairs[j]
        self.pair = pair
        self.R0, origin = constants.mating(pair)
        self.R0T = transposed(self.R0)
        cg_B = constants.vector(problem.bodies[pair.leaver].cg)
        self.cg_A = constants.vector(problem.bodies[pair.carrier].cg)
        self.groups = [
            (g, group)
            for g, group in enumerate(problem.groups)
            if problem.springs[group[0]].pair == j
        ]
        self.springs = [k for _, group in self.groups for k in group]
        places = {k: constants.vector(problem.springs[k].place) for k in self.springs}
        reference = constants.constant([point(x) for x in pair.reference])
        self.epsilon = vector_minus(reference, cg_B)
        self.r0 = vector_minus(vector_sum(origin, applied(self.R0, cg_B)), self.cg_A)
        reference_A = vector_sum(origin, applied(self.R0, reference))
        self.b0 = vector_minus(reference_A, self.cg_A)
        self.spin = applied(self.R0T, constants.spin(pair))
        self.swing = constants.swing(pair, cg_B)
        self.reference_swing = constants.swing(pair, reference)
        pads = {
            k: applied(self.R0T, vector_minus(place, origin))
            for k, place in places.items()
        }
        axes = {k: constants.axis(problem.springs[k]) for k in self.springs}
        axes_B = {k: applied(self.R0T, axis) for k, axis in axes.items()}
        e = {k: vector_minus(pad, cg_B) for k, pad in pads.items()}
        arms = {k: vector_minus(pad, reference) for k, pad in pads.items()}
        self.moments = {
            group: Moments(
                [e[k] for k in group],
                [arms[k] for k in group],
                [axes[k] for k in group],
                [axes_B[k] for k in group],
            )
            for group in (
                *(tuple(group) for _, group in self.groups),
                *((k,) for k in self.springs),
            )
        }
        self.impulses = {
            k: SpringImpulse(problem.springs[k], constants, setting.nominal[g])
            for g, group in self.groups
            for k in group
        }
        levers_B = {k: cross(e[k], axes_B[k]) for k in self.springs}
        levers_A = {
            k: cross(vector_minus(places[k], self.cg_A), axes[k]) for k in self.springs
        }
        nothing = [constants.zero] * 3
        self.on_B: list[Vector] = []
        self.on_A: list[Vector] = []
        self.along: list[Vector] = []
        for n in range(problem.pieces):
            self.on_B.append(self._impulsive(n, levers_B, setting, constants))
            self.on_A.append(self._impulsive(n, levers_A, setting, constants))
            pushes = (
                [jet_product(self.impulses[k].impulse[n], d) for d in axes[k]]
                for k in self.springs
            )
            self.along.append(vector_sum(nothing, *pushes))
        push = setting.push
        self.kernels = {
            k: DifferenceKernel([jet[0] for jet in x.deviation], push)
            for k, x in self.impulses.items()
            if x.varies
        }
        self.slope_kernels = {
            (k, i): DifferenceKernel([jet[i] for jet in x.deviation], push)
            for k, x in self.impulses.items()
            for i in range(1, 1 + len(constants.live))
            if problem.springs[k].depends_on(constants.live[i - 1])
        }

    def _impulsive(
        self, n: int, levers: dict[int, Vector], setting: Setting, constants: Constants
    ) -> Vector:
        """Return the sum of J_k times levers, directly and apart, intersected."""
        nothing = [constants.zero] * 3
        directly, apart = nothing, nothing
        for g, group in self.groups:
            together = vector_sum(*(levers[k] for k in group))
            nominal = setting.nominal[g].impulse[n]
            apart = vector_sum(apart, [times(nominal, jet) for jet in together])
            for k in group:
                spring = self.impulses[k]
                lever = levers[k]
                directly = vector_sum(
                    directly, [jet_product(spring.impulse[n], x) for x in lever]
                )
                apart = vector_sum(
                    apart, [jet_product(spring.deviation[n], x) for x in lever]
                )
        return [jets_intersected(x, y) for x, y in zip(directly, apart, strict=True)]

    def delayed(
        self, X: list[Rows], Y: list[Vector], setting: Setting
    ) -> tuple[list[Vector], list[Vector]]:
        """Return, of Eq. 6 and 7, the sums with q, by piece: on B, and less on A."""
        push, size = setting.push, len(Y[0][0])
        lengths = setting.problem.lengths[:push]
        functions = [
            [jet for row in rows for jet in row] + vector
            for rows, vector in zip(X[:push], Y[:push], strict=True)
        ]
        by_slope = [
            [[jets[c][i] for jets in functions] for c in range(12)] for i in range(size)
        ]
        columns = Columns([column for part in by_slope for column in part], lengths)
        values = Columns(by_slope[0], lengths)
        acting = [
            self._acting(setting.nominal[g].kernel(columns), tuple(group))
            for g, group in self.groups
        ]
        for k, kernel in self.kernels.items():
            q = kernel(columns)
            for i in range(1, size):
                if (k, i) in self.slope_kernels:
                    for c, more in enumerate(self.slope_kernels[k, i](values), 12 * i):
                        q[c] = [plus(a, b) for a, b in zip(q[c], more, strict=True)]
            acting.append(self._acting(q, (k,)))
        both = []
        for at in zip(*acting, strict=True):
            on_B, on_A = zip(*at, strict=True)
            both.append((vector_sum(*on_B), vector_sum(*on_A)))
        later = setting.problem.pieces - push
        both = both[:push] + both[push:] * later
        return [on_B for on_B, _ in both], [on_A for _, on_A in both]

    def _acting(
        self, q: list[list[Interval]], group: tuple[int, ...]
    ) -> list[tuple[Vector, Vector]]:
        """Return what q of springs that are alike adds to the sums of `delayed`."""
        moments, out = self.moments[group], []
        for row in zip(*q, strict=True):
            jets = [list(row[c::12]) for c in range(12)]
            X = [jets[0:3], jets[3:6], jets[6:9]]
            on_B = moments.on_B(X)
            on_A = applied(self.R0, moments.turned_on_A(X))
            out.append((on_B, vector_sum(on_A, cross(jets[9:], moments.pushes))))
        return out


class Moments:
    """What makes torques of some springs out of q[X] and q[Y] (Eq. 6 and 7)."""

    def __init__(
        self,
        e: list[Vector],
        arms: list[Vector],
        axes: list[Vector],
        axes_B: list[Vector],
    ):
        self.of_rows = [_weighted([d[i] for d in axes_B], e) for i in range(3)]
        self.of_columns = [_weighted([x[c] for x in arms], axes_B) for c in range(3)]
        self.pushes = vector_sum(*axes)

    def on_B(self, X: Rows) -> Vector:
        """Return the sum of e times X^T d, in B."""
        return vector_sum(
            *(cross(m, row) for m, row in zip(self.of_rows, X, strict=True))
        )

    def turned_on_A(self, X: Rows) -> Vector:
        """Return the sum of X epsilon times d, in B while mated."""
        columns = transposed(X)
        return vector_sum(
            *(cross(x, n) for x, n in zip(columns, self.of_columns, strict=True))
        )


def _weighted(weights: list[Jet], vectors: list[Vector]) -> Vector:
    return vector_sum(
        *(
            [jet_product(weight, x) for x in vector]
            for weight, vector in zip(weights, vectors, strict=True)
        )
    )


@dataclass
class Kinematics:
    """Rates of all bodies and of all pairs on each piece."""

    u: list[list[Vector]]
    w: list[list[Vector]]
    relative: list[list[Vector]]  # Omega
    Y: list[list[Vector]]


class Motion:
    """The motion and its derivatives by `live` parameters, enclosed on a box.

    Raises:
        NotVerified: no enclosure was found that the theorem holds of.
    """

    def __init__(
        self,
        setting: Setting,
        box: Box,
        live: list[int],
        start: "Motion | None" = None,
        more: int = 0,
    ):
        self.setting = setting
        self.problem = setting.problem
        self.lengths = self.problem.lengths
        self.constants = Constants(self.problem, box, live)
        self.bodies = [
            MovingBody(b, self.constants) for b in range(len(self.problem.bodies))
        ]
        self.pushing = [
            Pushing(j, setting, self.constants) for j in range(len(self.problem.pairs))
        ]
        self.state = self._enclosed(self._start(start))
        for _ in range(more):
            self.state = self._applied(self.state)
        self.kinematics = self._kinematics(self.state)

    def _enclosed(self, state: State) -> State:
        """Return an enclosure by the theorem; how it is found proves nothing."""
        for _ in range(FIRST):
            state = self._swept(state)
        outer = self._swept(state, WIDER)
        for _ in range(TRIES):
            state = self._applied(outer)
            if included(state.parts, outer.parts):
                return state
            outer = State(*grown(outer.parts, state.parts))
        raise NotVerified("the motion could not be enclosed")

    def _start(self, of: "Motion | None") -> State:
        """Return values that are known, and derivatives of zero."""
        if of is None:
            return self._at_rest()
        return of.state.without_slopes(self.constants.zero[1:])

    def _at_rest(self) -> State:
        zero = self.constants.zero

        def still(count: int) -> list[list[Vector]]:
            return [[[zero] * 3] * self.problem.pieces for _ in range(count)]

        pairs = len(self.problem.pairs)
        rows = [[[[zero] * 3] * 3] * self.problem.pieces for _ in range(pairs)]
        return State(still(len(self.bodies)), rows, still(pairs), still(pairs))

    def _kinematics(self, x: State) -> Kinematics:
        u = [
            [body.change_of_rate(S) for S in pieces]
            for body, pieces in zip(self.bodies, x.S, strict=True)
        ]
        w = [
            [vector_sum(body.mated_rate, v) for v in pieces]
            for body, pieces in zip(self.bodies, u, strict=True)
        ]
        relative, Y = [], []
        for j, pushing in enumerate(self.pushing):
            a, b = pushing.pair.carrier, pushing.pair.leaver
            rates, velocities = [], []
            mated = self.bodies[a].mated_rate
            for n, Q in enumerate(x.Q[j]):
                seen = applied(transposed(Q), applied(pushing.R0T, w[a][n]))
                change = vector_minus(u[b][n], applied(pushing.R0T, u[a][n]))
                change = vector_sum(pushing.spin, change)
                rates.append(vector_minus(change, seen))  # (4)
                swing = cross(u[b][n], pushing.epsilon)
                turning = applied(Q, cross(w[b][n], pushing.epsilon))
                place = vector_sum(pushing.b0, x.y[j][n])
                carried = vector_sum(cross(u[a][n], place), cross(mated, x.y[j][n]))
                swing = applied(pushing.R0, vector_sum(swing, turning))
                swing = vector_sum(pushing.reference_swing, swing)
                velocity = vector_sum(vector_minus(x.U[j][n], carried), swing)
                velocities.append(velocity)  # (4a)
            relative.append(rates)
            Y.append(velocities)
        return Kinematics(u, w, relative, Y)

    def _applied(self, x: State) -> State:
        """Return the enclosure of the right sides of Eq. 6 to 9."""
        k = self._kinematics(x)
        return State(
            self._momenta(x, k, self._pushed(x, k)),
            self._orientations(x, k),
            self._velocities(x, k),
            self._ways(k),
        )

    def _swept(self, x: State, wider: arb = ZERO) -> State:
        """Return the same in turn, each from what came before, and each widened.

        This is a guess, and good sooner.
        """
        k = self._kinematics(x)
        pushed = self._pushed(x, k)
        for _ in range(ROUNDS):
            x = replace(x, S=widened(self._momenta(x, k, pushed), wider))
            k = self._kinematics(x)
            Q = widened(self._orientations(x, k), wider)
            x = replace(x, Q=Q, U=widened(self._velocities(x, k), wider))
            k = self._kinematics(x)
            x = replace(x, y=widened(self._ways(k), wider))
        return x

    def _momenta(
        self, x: State, k: Kinematics, pushed: list[list[Vector]]
    ) -> list[list[Vector]]:
        """Eq. 6 and 7."""
        return [
            [
                vector_sum(*v)
                for v in zip(
                    self._less_gyroscopic(b, x.S[b], k.w[b]), push, strict=True
                )
            ]
            for b, push in enumerate(pushed)
        ]

    def _pushed(self, x: State, k: Kinematics) -> list[list[Vector]]:
        """Return the angular impulses of springs of Eq. 6 and 7."""
        nothing = [[self.constants.zero] * 3] * self.problem.pieces
        S = [nothing for _ in self.bodies]
        for j, pushing in enumerate(self.pushing):
            if not pushing.springs:
                continue
            a, b = pushing.pair.carrier, pushing.pair.leaver
            X = [turned(Q, w) for Q, w in zip(x.Q[j], k.relative[j], strict=True)]
            on_B, on_A = pushing.delayed(X, k.Y[j], self.setting)
            S[b] = [vector_sum(*v) for v in zip(S[b], pushing.on_B, on_B, strict=True)]
            S[a] = [
                vector_minus(v, vector_sum(now, later))
                for v, now, later in zip(S[a], pushing.on_A, on_A, strict=True)
            ]
        return S

    def _orientations(self, x: State, k: Kinematics) -> list[list[Rows]]:
        """Return Q of Eq. 8."""
        return [
            turned_by(Q, relative, self.lengths)
            for Q, relative in zip(x.Q, k.relative, strict=True)
        ]

    def _ways(self, k: Kinematics) -> list[list[Vector]]:
        """Return y of Eq. 8."""
        return [integral(Y, self.lengths) for Y in k.Y]

    def _velocities(self, x: State, k: Kinematics) -> list[list[Vector]]:
        return [self._velocity(j, x, k) for j in range(len(self.pushing))]

    def _less_gyroscopic(
        self, b: int, S: list[Vector], w: list[Vector]
    ) -> list[Vector]:
        """Return the integral of the torques but for those of springs."""
        return integral(self._torques(b, S, w), self.lengths)

    def _torques(self, b: int, S: list[Vector], w: list[Vector]) -> list[Vector]:
        """Return the torques on a body, but for springs, less w x I w."""
        body = self.bodies[b]
        torque = [symmetric(x) for x in self.setting.disturbance.torque[b]]
        torques = []
        for S_n, w_n in zip(S, w, strict=True):
            gyroscopic = body.gyroscopic(w_n, S_n)
            torques.append(
                [
                    [minus(t, jet[0]), *jet_negative(jet[1:])]
                    for t, jet in zip(torque, gyroscopic, strict=True)
                ]
            )
        return torques

    def _velocity(self, j: int, x: State, k: Kinematics) -> list[Vector]:
        """Eq. 9."""
        pushing = self.pushing[j]
        a, b = pushing.pair.carrier, pushing.pair.leaver
        gravity = symmetric(self.setting.disturbance.acceleration)
        of_A = [p for p in self.pushing if p.pair.carrier == a]
        carried = cross(self.bodies[a].mated_rate, pushing.r0)
        at_start = vector_sum(carried, pushing.swing)
        turning, now = [], []
        for n in range(self.problem.pieces):
            bent = cross(k.w[a][n], vector_sum(at_start, x.U[j][n]))
            turning.append(
                [[minus(gravity, jet[0]), *jet_negative(jet[1:])] for jet in bent]
            )
            all_of_A = vector_sum(*(p.along[n] for p in of_A))
            by_B, by_A = self.bodies[b].inverse_mass, self.bodies[a].inverse_mass
            now.append(
                vector_sum(
                    [jet_product(by_B, f) for f in pushing.along[n]],
                    [jet_product(by_A, f) for f in all_of_A],
                )
            )
        later = integral(turning, self.lengths)
        return [vector_sum(*v) for v in zip(now, later, strict=True)]

    def way_of_cg(self, j: int) -> list[Vector]:
        """Return r - r(0) on each piece."""
        pushing = self.pushing[j]
        turns = (applied(Q, pushing.epsilon) for Q in self.state.Q[j])
        return [
            vector_minus(y, applied(pushing.R0, turn))
            for y, turn in zip(self.state.y[j], turns, strict=True)
        ]

    def velocity_of_cg(self, j: int) -> list[Vector]:
        """Return the velocity of B's CG as seen from A on each piece."""
        pushing = self.pushing[j]
        a = pushing.pair.carrier
        mated = self.bodies[a].mated_rate
        out = []
        for n, way in enumerate(self.way_of_cg(j)):
            place = vector_sum(pushing.r0, way)
            carried = vector_sum(
                cross(self.kinematics.u[a][n], place), cross(mated, way)
            )
            moved = vector_sum(pushing.swing, self.state.U[j][n])
            out.append(vector_minus(moved, carried))
        return out

    def change_of_rate(self, b: int) -> list[Vector]:
        """Return the derivative of a body's rate by time, where no spring pushes."""
        torques = self._torques(b, self.state.S[b], self.kinematics.w[b])
        return [self.bodies[b].change_of_rate(torque) for torque in torques]

    def change_of_relative_rate(self, j: int) -> list[Vector]:
        """Return the derivative of Omega by time, where no spring pushes (19)."""
        pushing = self.pushing[j]
        a, b = pushing.pair.carrier, pushing.pair.leaver
        R0T, out = pushing.R0T, []
        for n, (of_A, of_B) in enumerate(
            zip(self.change_of_rate(a), self.change_of_rate(b), strict=True)
        ):
            Q = self.state.Q[j][n]
            X = turned(Q, self.kinematics.relative[j][n])
            seen = applied(transposed(X), applied(R0T, self.kinematics.w[a][n]))
            of_A = applied(R0T, of_A)
            by_A = vector_sum(of_A, seen, applied(transposed(Q), of_A))
            out.append(vector_minus(of_B, by_A))
        return out

    def orientation(self, b: int) -> list[Rows]:
        """Enclose P of a body by the same theorem (Eq. 10)."""
        zero = self.constants.zero
        P: list[Rows] = [[[zero] * 3] * 3] * self.problem.pieces
        rates = self.kinematics.w[b]
        for attempt in range(FIRST + TRIES):
            outer = widened(P, WIDER)
            P = turned_by(outer, rates, self.lengths)
            if attempt >= FIRST and included(P, outer):
                return P
        raise NotVerified("the orientation could not be enclosed")
