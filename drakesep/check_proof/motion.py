"""The motion on a box of parameters: enclosed by the theorem of docs/proof.md."""

from dataclasses import dataclass, replace
from typing import Any

from flint import arb

from .boxes import Constants
from .certificate import Box, Pair, Problem
from .gravity import Disturbance
from .impulses import NominalImpulse, SpringImpulse
from .intervals import (
    ONE,
    ZERO,
    Interval,
    Jet,
    Matrix,
    NotVerified,
    Vector,
    cross,
    intersection,
    inverse,
    jet_negative,
    jet_product,
    jet_square,
    jet_sum,
    jet_minus,
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
from .kernels import Columns, Kernel, difference_kernel, integrated


Rows = list[Vector]  # three rows of a matrix
WIDER = arb(1) / 10000  # by how much of its width an interval is widened to be entered
FIRST, ROUNDS, TRIES = 2, 2, 8


class Setting:
    """What is the same on all boxes: nominal impulses, their kernels, gravity."""

    def __init__(self, problem: Problem):
        self.problem = problem
        self.disturbance = Disturbance(problem)
        self.nominal = [
            NominalImpulse(problem, problem.springs[group[0]])
            for group in problem.groups
        ]
        self.kernels = [Kernel(nominal.kernel) for nominal in self.nominal]


@dataclass
class State:
    """What the theorem encloses, on each piece of time.

    Of each pair a point of the body that leaves, amid its pads, is followed instead of
    its CG: as seen from the carrier it is at b with the velocity v (see `_velocity`).
    """

    S: list[list[Vector]]  # of each body
    Q: list[list[Rows]]  # of each pair
    v: list[list[Vector]]
    moved: list[list[Vector]]  # b - b(0)

    @property
    def parts(self) -> "Nested":
        """All intervals, in lists."""
        return [self.S, self.Q, self.v, self.moved]

    def without_slopes(self, slopes: list[Interval]) -> "State":
        """Return the values, with other derivatives."""

        def vectors(x: list[list[Vector]]) -> list[list[Vector]]:
            return [[[[jet[0], *slopes] for jet in v] for v in pieces] for pieces in x]

        Q = [[[[[j[0], *slopes] for j in v] for v in rows] for rows in p] for p in self.Q]
        return State(vectors(self.S), Q, vectors(self.v), vectors(self.moved))


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
    more = (high - low) * wider + arb(10) ** -30
    return (low - more).lower(), (high + more).upper()


def included(inner: Nested, outer: Nested) -> bool:
    """Whether each interval of the one is in that of the other."""
    if isinstance(inner, list):
        return all(included(x, y) for x, y in zip(inner, outer, strict=True))
    return bool(outer[0] <= inner[0] and inner[1] <= outer[1])


def by_vector(rows: Rows, x: Vector) -> Vector:
    """Return a matrix of jets times a vector of jets."""
    return [
        jet_sum(*(jet_product(a, b) for a, b in zip(row, x, strict=True)))
        for row in rows
    ]


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
        self.mated_rate = constants.constant(constants.problem.rates[b])
        self.mated_momentum = by_vector(self.inertia, self.mated_rate)

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


def _inverse(I: Matrix) -> Matrix:
    """Enclose the inverses of symmetric matrices (Eq. 16)."""
    G: list[list[Interval]] = [[(ZERO, ZERO)] * 3 for _ in range(3)]
    forms: dict[tuple[int, int], list[Interval]] = {}
    for a, b, c in ((0, 1, 2), (0, 2, 1), (1, 2, 0), (1, 0, 2), (2, 0, 1), (2, 1, 0)):
        by_c = _positive_inverse(I[c][c])
        pivot = _positive_inverse(minus(I[b][b], product(square(I[b][c]), by_c)))
        rest = minus(I[a][b], product(product(I[b][c], I[a][c]), by_c))
        diagonal = minus(I[a][a], product(square(I[a][c]), by_c))
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
        self.R0 = pair.R0
        self.R0T = transposed(pair.R0)
        origin = constants.constant(pair.origin)
        cg_B = constants.vector(problem.bodies[pair.leaver].cg)
        self.cg_A = constants.vector(problem.bodies[pair.carrier].cg)
        self.groups = [
            (g, group)
            for g, group in enumerate(problem.groups)
            if problem.springs[group[0]].pair == j
        ]
        self.springs = [k for _, group in self.groups for k in group]
        places = {k: constants.vector(problem.springs[k].place) for k in self.springs}
        point_A = constants.constant(_amid(problem, self.springs))
        self.kappa = vector_minus(
            scaled(self.R0T, vector_minus(point_A, origin)), cg_B
        )  # from the CG of B, in B
        self.at_start = vector_minus(point_A, self.cg_A)  # b(0)
        self.arms = {
            k: scaled(self.R0T, vector_minus(place, point_A))
            for k, place in places.items()
        }
        axes = {k: constants.constant(problem.springs[k].axis) for k in self.springs}
        axes_B = {k: scaled(self.R0T, axis) for k, axis in axes.items()}
        self.axes, self.axes_B = axes, axes_B
        self.e = {
            k: vector_minus(scaled(self.R0T, vector_minus(place, origin)), cg_B)
            for k, place in places.items()
        }
        self.impulses = {
            k: SpringImpulse(problem.springs[k], constants) for k in self.springs
        }
        levers_B = {k: cross(self.e[k], axes_B[k]) for k in self.springs}
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
        self.kernels = {
            k: difference_kernel([jet[0] for jet in x.deviation], x.ended)
            for k, x in self.impulses.items()
            if x.varies
        }
        self.slope_kernels = {
            (k, i): difference_kernel([jet[i] for jet in x.deviation], x.ended)
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
        self, X: list[Rows], v: list[Vector], setting: Setting
    ) -> tuple[list[Vector], list[Vector]]:
        """Return, of Eq. 6 and 7, the sums with q, by piece: on B, and less on A."""
        lengths = setting.problem.lengths
        size = len(v[0][0])
        functions = [
            [jet for row in rows for jet in row] + vector
            for rows, vector in zip(X, v, strict=True)
        ]
        columns = Columns(
            [
                [jets[c][i] for jets in functions]
                for i in range(size)
                for c in range(12)
            ],
            lengths,
        )
        values = Columns([[jets[c][0] for jets in functions] for c in range(12)], lengths)
        on_B: list[list[Vector]] = []
        on_A: list[list[Vector]] = []

        def act(q: list[list[Interval]], group: list[int]) -> None:
            k, count = group[0], len(group)
            e = vector_sum(*(self.e[i] for i in group))
            arms = vector_sum(*(self.arms[i] for i in group))
            vectors_B, vectors_A = [], []
            for n in range(setting.problem.pieces):
                jets = [
                    [q[i * 12 + c][n] for i in range(size)] for c in range(12)
                ]
                rows = [jets[0:3], jets[3:6], jets[6:9]]
                pushed = by_vector(transposed(rows), self.axes_B[k])
                vectors_B.append(cross(e, pushed))
                moved = scaled(self.R0, by_vector(rows, arms))
                many = [times(point(count), jet) for jet in jets[9:]]
                vectors_A.append(cross(vector_sum(many, moved), self.axes[k]))
            on_B.append(vectors_B)
            on_A.append(vectors_A)

        for g, group in self.groups:
            q = setting.kernels[g](columns)
            act(q, group)
        for k, kernel in self.kernels.items():
            q = kernel(columns)
            for i in range(1, size):
                if (k, i) in self.slope_kernels:
                    more = self.slope_kernels[k, i](values)
                    for c in range(12):
                        q[i * 12 + c] = [
                            plus(a, b)
                            for a, b in zip(q[i * 12 + c], more[c], strict=True)
                        ]
            act(q, [k])
        return (
            [vector_sum(*vectors) for vectors in zip(*on_B, strict=True)],
            [vector_sum(*vectors) for vectors in zip(*on_A, strict=True)],
        )


def _intersected(x: Vector, y: Vector) -> Vector:
    return [jets_intersected(a, b) for a, b in zip(x, y, strict=True)]


def _amid(problem: Problem, springs: list[int]) -> list[Interval]:
    """Return the mean of the nominal places of springs."""
    places = [[value.value for value in problem.springs[k].place] for k in springs]
    return [point(sum(axis) / max(len(places), 1)) for axis in zip(*places, strict=True)]


@dataclass
class Kinematics:
    """Rates of all bodies and of all pairs on each piece."""

    u: list[list[Vector]]
    w: list[list[Vector]]
    relative: list[list[Vector]]


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
        self.kinematics = self._kinematics(self.state)

    def _enclosed(self, state: State) -> State:
        """Return an enclosure by the theorem; how it is come by is no part of the proof."""
        for _ in range(FIRST):
            state = self._swept(state)
        for _ in range(TRIES):
            outer = self._swept(state, WIDER)
            state = self._applied(outer)
            if included(state.parts, outer.parts):
                return state
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
        relative = []
        for j, pushing in enumerate(self.pushing):
            a, b = pushing.pair.carrier, pushing.pair.leaver
            rates = []
            for n, Q in enumerate(x.Q[j]):
                seen = by_vector(transposed(Q), scaled(pushing.R0T, w[a][n]))
                change = vector_minus(u[b][n], scaled(pushing.R0T, u[a][n]))
                rates.append(vector_minus(change, seen))  # Eq. 4
            relative.append(rates)
        return Kinematics(u, w, relative)

    def _applied(self, x: State) -> State:
        """Return the enclosure of the right sides of Eq. 6 to 9."""
        k = self._kinematics(x)
        return State(
            self._momenta(x, k, self._pushed(x, k)),
            self._orientations(x, k),
            self._velocities(x, k),
            self._ways(x),
        )

    def _swept(self, x: State, wider: arb = ZERO) -> State:
        """Return the same in turn, each from what came before, and each widened.

        This is a guess that is good sooner. What is an integral alone is wider than what
        it is an integral of, so that the guess holds.
        """
        pushed = self._pushed(x, self._kinematics(x))
        for _ in range(ROUNDS):
            S = self._momenta(x, self._kinematics(x), pushed)
            x = replace(x, S=widened(S, wider))
            Q = self._orientations(x, self._kinematics(x))
            x = replace(x, Q=widened(Q, wider))
            v = self._velocities(x, self._kinematics(x))
            x = replace(x, v=widened(v, wider))
            x = replace(x, moved=widened(self._ways(x), wider))
        return x

    def _momenta(
        self, x: State, k: Kinematics, pushed: list[list[Vector]]
    ) -> list[list[Vector]]:
        """Eq. 6 and 7."""
        return [
            [
                vector_sum(*v)
                for v in zip(self._less_gyroscopic(b, x.S[b], k.w[b]), push, strict=True)
            ]
            for b, push in enumerate(pushed)
        ]

    def _pushed(self, x: State, k: Kinematics) -> list[list[Vector]]:
        """Return the angular impulses of springs of Eq. 6 and 7."""
        nothing = [[self.constants.zero] * 3] * self.problem.pieces
        S = [nothing for _ in self.bodies]
        for j, pushing in enumerate(self.pushing):
            a, b = pushing.pair.carrier, pushing.pair.leaver
            X = [turned(Q, w) for Q, w in zip(x.Q[j], k.relative[j], strict=True)]
            on_B, on_A = pushing.delayed(X, x.v[j], self.setting)
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

    def _ways(self, x: State) -> list[list[Vector]]:
        """Return b - b(0), as r - r(0) in Eq. 8."""
        return [integral(v, self.lengths) for v in x.v]

    def _velocities(self, x: State, k: Kinematics) -> list[list[Vector]]:
        return [self._velocity(j, x, k) for j in range(len(self.pushing))]

    def _less_gyroscopic(self, b: int, S: list[Vector], w: list[Vector]) -> list[Vector]:
        """Return the integral of the torques but for those of springs."""
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
        return integral(torques, self.lengths)

    def _velocity(self, j: int, x: State, k: Kinematics) -> list[Vector]:
        """Return v, in the manner of Eq. 9.

        With y = rho + w x r, the difference of the CGs' velocities in W, v = y - w x b
        + R (w_B x kappa). Where u of the carrier stands, what cancels has been left out.
        """
        pushing = self.pushing[j]
        a, b = pushing.pair.carrier, pushing.pair.leaver
        mated = self.bodies[a].mated_rate
        still = [
            vector_minus(
                vector_minus(pushed, cross(k.u[a][n], self._place(j, n, x))),
                cross(mated, x.moved[j][n]),
            )
            for n, pushed in enumerate(self._pushed_apart(j, x, k))
        ]
        out = []
        for n, rest in enumerate(still):
            swung = cross(k.w[b][n], pushing.kappa)
            change = vector_sum(
                cross(k.u[b][n], pushing.kappa), by_vector(x.Q[j][n], swung)
            )
            out.append(vector_sum(rest, scaled(pushing.R0, change)))
        return out

    def _place(self, j: int, n: int, x: State) -> Vector:
        """Return b."""
        return vector_sum(self.pushing[j].at_start, x.moved[j][n])

    def _pushed_apart(self, j: int, x: State, k: Kinematics) -> list[Vector]:
        """Return y - y(0), by Newton's law in the carrier's axes."""
        pushing = self.pushing[j]
        a, b = pushing.pair.carrier, pushing.pair.leaver
        gravity = symmetric(self.setting.disturbance.acceleration)
        of_A = [p for p in self.pushing if p.pair.carrier == a]
        turning, now = [], []
        for n in range(self.problem.pieces):
            w = k.w[a][n]
            swung = cross(k.w[b][n], pushing.kappa)
            swung = vector_sum(swung, by_vector(x.Q[j][n], swung))
            y = vector_minus(
                vector_sum(x.v[j][n], cross(w, self._place(j, n, x))),
                scaled(pushing.R0, swung),
            )
            turning.append(
                [[minus(gravity, jet[0]), *jet_negative(jet[1:])] for jet in cross(w, y)]
            )
            all_of_A = vector_sum(*(p.along[n] for p in of_A))
            now.append(
                vector_sum(
                    [
                        jet_product(self.bodies[b].inverse_mass, f)
                        for f in pushing.along[n]
                    ],
                    [jet_product(self.bodies[a].inverse_mass, f) for f in all_of_A],
                )
            )
        later = integral(turning, self.lengths)
        return [vector_sum(*v) for v in zip(now, later, strict=True)]

    def of_cg(self, j: int) -> tuple[list[Vector], list[Vector]]:
        """Enclose rho and r - r(0), each in two ways."""
        x, k, pushing = self.state, self.kinematics, self.pushing[j]
        a = pushing.pair.carrier
        mated = self.bodies[a].mated_rate
        velocities, ways = [], []
        start = vector_minus(pushing.at_start, scaled(pushing.R0, pushing.kappa))
        for n, pushed in enumerate(self._pushed_apart(j, x, k)):
            turn = scaled(pushing.R0, by_vector(x.Q[j][n], pushing.kappa))
            way = vector_minus(x.moved[j][n], turn)
            X = turned(x.Q[j][n], k.relative[j][n])
            swing = scaled(pushing.R0, by_vector(X, pushing.kappa))
            carried = vector_sum(
                cross(k.u[a][n], vector_sum(start, way)), cross(mated, way)
            )
            velocities.append(
                _intersected(
                    vector_minus(pushed, carried), vector_minus(x.v[j][n], swing)
                )
            )
            ways.append(way)
        integrals = integral(velocities, self.lengths)
        both = zip(ways, integrals, strict=True)
        return velocities, [_intersected(way, other) for way, other in both]

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
