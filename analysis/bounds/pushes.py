"""What springs do to the motion over boxes of parameters, enclosed with derivatives.

Numbers in comments are those of docs/proof.md.
"""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from drakesep.analysis.bounds.box import Boxes, Mating, nominal_law
from drakesep.analysis.bounds.grid import Grid
from drakesep.analysis.bounds.impulses import impulse
from drakesep.analysis.bounds.intervals import Interval, total
from drakesep.analysis.bounds.jets import (
    Affine,
    Jet,
    added,
    combined,
    stacked,
    turned,
)
from drakesep.analysis.bounds.kernels import DeviationKernel, NominalKernel
from drakesep.analysis.bounds.problem import BoundProblem, BoundSpring, Number
from drakesep.analysis.bounds.rotations import (
    AffineVector,
    affine_cross,
    constant,
    minus,
    plus,
    transposed,
)


class NominalKernels:
    """The kernels of the springs' nominal laws, made once for all boxes."""

    def __init__(self, problem: BoundProblem, grid: Grid):
        keys = [(s.pair, *(x.value for x in s.law)) for s in problem.springs]
        self.groups: list[tuple[NominalKernel, list[int]]] = []
        for key in dict.fromkeys(keys):
            members = [k for k, other in enumerate(keys) if other == key]
            law = nominal_law(problem.springs[members[0]])
            kernel = NominalKernel(law, grid.times, grid.push)
            self.groups.append((kernel, members))


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
    axis_A: AffineVector
    axis_B: AffineVector
    """The same in B while mated."""


class _Moments(NamedTuple):
    """What makes torques of springs out of integrals of Q' and y': (6), (7)."""

    of_rows: list[AffineVector]
    """For each axis of B while mated: sum of arms times the push along it, in B."""
    of_columns: list[AffineVector]
    """For each axis of B: sum of pushes times the pad's place along it, in B."""
    pushes: AffineVector
    """Sum of the axes, in A."""

    @classmethod
    def of(cls, springs: Sequence[_Spring]) -> "_Moments":
        """Return those of springs of a pair."""
        axes = range(3)
        return cls(
            [_summed(_scaled(s.arm, s.axis_B[i]) for s in springs) for i in axes],
            [_summed(_scaled(s.axis_B, s.beside[c]) for s in springs) for c in axes],
            _summed(s.axis_A for s in springs),
        )


class _Group(NamedTuple):
    """Springs of a pair with one nominal law."""

    kernel: NominalKernel
    springs: list[_Spring]
    moments: _Moments
    of_each: list[_Moments]
    """Of each spring alone."""


class Pushes:
    """What springs do over boxes, were nothing to turn, and where bodies turn.

    Attributes:
        on_B: of each body, the change of I w that springs give to it as a B, N m s.
        on_A: of each body, the change of I w that springs take from it as an A, N m s.
        speeds: of each pair, the change of relative velocity, in A, m/s.
    """

    def __init__(
        self,
        boxes: Boxes,
        grid: Grid,
        kernels: NominalKernels,
        mated: Sequence[Mating],
    ):
        """Take boxes, pieces of time, kernels on these, and how pairs are mated."""
        self._boxes, self._grid, self._mated = boxes, grid, mated
        self._problem = problem = boxes.problem
        self._pieces = len(grid.times) - 1
        self._groups = [self._group(*group) for group in kernels.groups]
        self.on_B = [self._zero_vector() for _ in problem.bodies]
        self.on_A = [self._zero_vector() for _ in problem.bodies]
        for group in self._groups:
            pair = problem.pairs[group.springs[0].pair]
            on_B = [affine_cross(s.arm, s.axis_B) for s in group.springs]
            on_A = [affine_cross(s.start, s.axis_A) for s in group.springs]
            self.on_B[pair.B] = added(self.on_B[pair.B], self._given(group, on_B))
            self.on_A[pair.A] = added(self.on_A[pair.A], self._given(group, on_A))
        self.speeds = [self._speed(j) for j in range(len(problem.pairs))]

    def torques(
        self, j: int, turning: list[list[Jet]], moving: list[Jet]
    ) -> tuple[list[Jet], list[Jet]] | None:
        """Return what q of (6) and (7) gives: to A, to be taken away, and to B.

        Args:
            j: the pair's place.
            turning: how Q changes.
            moving: how fast the reference point moves in A.

        Returns:
            None if no spring pushes the pair.
        """
        groups = [g for g in self._groups if g.springs[0].pair == j]
        if not groups:
            return None
        push = self._grid.push
        flat = [*(x for row in turning for x in row), *moving]
        moved = stacked([x[..., :push] for x in flat])
        on_A, on_B = [], []
        for group in groups:
            integrals = [(group.kernel(moved), group.moments)]
            integrals += [
                (s.deviation(moved), alone)
                for s, alone in zip(group.springs, group.of_each, strict=True)
            ]
            for q, moments in integrals:
                to_A, to_B = self._torques(j, self._spread(q), moments)
                on_A.append(to_A)
                on_B.append(to_B)
        return added(*on_A), added(*on_B)

    def _torques(
        self, j: int, q: list[Jet], moments: _Moments
    ) -> tuple[list[Jet], list[Jet]]:
        rows = [q[3 * i : 3 * i + 3] for i in range(3)]
        columns = [list(column) for column in zip(*rows, strict=True)]
        of_rows = _crosses(rows, moments.of_rows)
        of_columns = _crosses(columns, moments.of_columns)
        on_A = added(
            turned(self._mated[j].R0, of_columns),
            _crosses([q[9:]], [moments.pushes]),
        )
        return on_A, [-x for x in of_rows]

    def _spread(self, q: Jet) -> list[Jet]:
        """Return integrals over all pieces: after the push they stay as they are."""
        lo = np.repeat(q.lo[..., -1:], self._pieces - self._grid.push, -1)
        hi = np.repeat(q.hi[..., -1:], self._pieces - self._grid.push, -1)
        push = slice(0, self._grid.push)
        lo = np.concatenate([q.lo[..., push], lo], -1)
        hi = np.concatenate([q.hi[..., push], hi], -1)
        return [Jet(a, b) for a, b in zip(lo, hi, strict=True)]

    def _zero_vector(self) -> list[Jet]:
        boxes = self._boxes
        return [Jet.zeros(len(boxes.rows), boxes.count, self._pieces) for _ in range(3)]

    def _group(self, kernel: NominalKernel, members: Sequence[int]) -> _Group:
        springs = [self._spring(k, kernel) for k in members]
        of_each = [_Moments.of([spring]) for spring in springs]
        return _Group(kernel, springs, _Moments.of(springs), of_each)

    def _spring(self, k: int, kernel: NominalKernel) -> _Spring:
        boxes, spring = self._boxes, self._problem.springs[k]
        pair, mated = self._problem.pairs[spring.pair], self._mated[spring.pair]
        cg_A, cg_B = (
            boxes.vector(self._problem.bodies[b].cg) for b in (pair.A, pair.B)
        )
        R_BA = transposed(mated.R0)
        axis, pad = boxes.axis(spring), boxes.vector(spring.place)
        pad_B = turned(R_BA, minus(pad, mated.place))
        J, D = self._impulse(spring, kernel)
        times, push = self._grid.times, self._grid.push
        rows = [boxes.rows[i] for _, i in _varied(spring) if i in boxes.rows]
        return _Spring(
            pair=spring.pair,
            J=J,
            deviation=DeviationKernel(D[..., : push + 1], rows, times, push),
            D=D,
            arm=minus(pad_B, cg_B),
            beside=minus(pad_B, constant(pair.reference)),
            start=minus(pad, cg_A),
            axis_A=axis,
            axis_B=turned(R_BA, axis),
        )

    def _impulse(self, spring: BoundSpring, kernel: NominalKernel) -> tuple[Jet, Jet]:
        """Return an impulse, and what it differs by from the nominal: (13)."""
        boxes, times = self._boxes, self._grid.times
        pieces = Interval(times[:-1], times[1:])
        here = impulse(boxes.law(spring), pieces)
        wide = impulse(boxes.with_nominal.law(spring), pieces)
        apart = self._deviation(spring, wide.by).meet(here.value - kernel.range)
        J, D = (self._jet(spring, x, here.by) for x in (here.value, apart))
        return J, D

    def _jet(self, spring: BoundSpring, value: Interval, by: Sequence[Interval]) -> Jet:
        jet = Jet.zeros(len(self._boxes.rows), self._boxes.count, self._pieces)
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
        scale = [Interval(p.scale) for p in self._problem.parameters]
        return [(by[a] * scale[i], i) for a, i in _varied(spring)]

    def _deviation(self, spring: BoundSpring, by: Sequence[Interval]) -> Interval:
        """Return what an impulse differs by from the nominal: (13)."""
        boxes = self._boxes
        terms = [
            x * Interval(boxes.lower[:, i, None], boxes.upper[:, i, None])
            for x, i in self._slopes(spring, by)
        ]
        return total(terms) if terms else Interval(np.zeros((1, self._pieces)))

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
        return Jet.of(x, len(self._boxes.rows), self._boxes.count)

    def _speed(self, j: int) -> list[Jet]:
        """Return the relative velocity that impulses give to a pair: (9)."""
        pair = self._problem.pairs[j]
        lightness = [
            self._lightness(self._problem.bodies[b].mass) for b in (pair.A, pair.B)
        ]
        speed = self._zero_vector()
        for spring in (s for group in self._groups for s in group.springs):
            if self._problem.pairs[spring.pair].A != pair.A:
                continue
            light = lightness[0] + lightness[1] if spring.pair == j else lightness[0]
            given = spring.J * light
            for a, d in enumerate(spring.axis_A):
                if not d.is_zero:
                    speed[a] = speed[a] + given * d
        return speed

    def _lightness(self, mass: Number) -> Affine:
        m = self._boxes.affine(mass)
        light = m.value.inverse()
        return Affine(light, {i: -(light.square() * x) for i, x in m.slopes.items()})


def _crosses(vectors: Sequence[list[Jet]], by: Sequence[AffineVector]) -> list[Jet]:
    """Return the sum of vector products with affine vectors."""
    return [
        combined(
            [x for v in by for x in (v[b], -v[a])],
            [x for v in vectors for x in (v[a], v[b])],
        )
        for a, b in ((1, 2), (2, 0), (0, 1))
    ]


def _scaled(vector: AffineVector, by: Affine) -> AffineVector:
    return [combined([by], [x]) for x in vector]


def _summed(vectors: Iterable[AffineVector]) -> AffineVector:
    first, *others = vectors
    for vector in others:
        first = plus(first, vector)
    return first


def _varied(spring: BoundSpring) -> list[tuple[int, int]]:
    """Return which numbers of a spring's law are parameters, and which parameters."""
    return [
        (a, number.parameter)
        for a, number in enumerate(spring.law)
        if number.parameter is not None
    ]
