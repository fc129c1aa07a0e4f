"""The tree of a claim, walked: that it covers the box, and that each node holds."""

from dataclasses import dataclass
from functools import lru_cache

from flint import arb

from .certificate import Box, Claim, Problem, Unreadable, index, items, number
from .intervals import ZERO, Interval, Jet, NotVerified, hull
from .motion import Motion, Setting
from .quantities import options


@dataclass(frozen=True)
class Outcome:
    """What came of a claim: the first node that fails and why, if one does."""

    failure: str | None
    nodes: int
    least: float  # what the quantity reaches at the point of the certificate


class Motions:
    """Motions on boxes, of which the last are kept: claims share boxes."""

    def __init__(self, problem: Problem):
        self.setting = Setting(problem)
        self.on = lru_cache(maxsize=8)(self._on)

    def _on(self, box: Box, with_slopes: bool) -> Motion:
        if not with_slopes:
            return Motion(self.setting, box, [])
        return Motion(self.setting, box, box.live, start=self.on(box, False))


class Walk:
    """A walk through the tree of one claim."""

    def __init__(self, claim: Claim, motions: Motions):
        self.claim = claim
        self.motions = motions
        self.problem = motions.setting.problem
        self.bound = arb(claim.bound)
        self.nodes = iter(claim.tree)
        self.count = 0

    def verify(self) -> None:
        """Raise NotVerified at the first node that does not hold."""
        waiting: list[tuple[Box, str]] = [(self.problem.root, "root")]
        while waiting:
            box, path = waiting.pop()
            try:
                node = next(self.nodes)
            except StopIteration:
                raise NotVerified(f"{path}: a node is missing") from None
            self.count += 1
            try:
                waiting += self._visited(node, box, path)
            except (NotVerified, Unreadable) as failure:
                name = node[0] if isinstance(node, list) and node else node
                raise NotVerified(
                    f"node {self.count} ({path} > {name}): {failure}"
                ) from None
        if next(self.nodes, None) is not None:
            raise NotVerified(f"after node {self.count}: nodes that belong to no box")

    def _visited(self, node: object, box: Box, path: str) -> list[tuple[Box, str]]:
        """Look whether a node holds; return the boxes below it, the last one first."""
        kind, *rest = items(node, "node") or [None]
        if kind == "leaf" and len(rest) == 1:
            self._leaf(box, rest[0])
            return []
        if kind == "collapse" and len(rest) == 1:
            child = self._collapsed(box, rest[0])
            return [(child, path + " > collapse")]
        if kind == "cut" and len(rest) == 2:
            i = index(rest[0], "coordinate", len(self.problem.parameters))
            x = number(rest[1], "place of the cut")
            if not box.lower[i] < x < box.upper[i]:
                raise NotVerified("the cut is not inside the box")
            where = f"{self.problem.parameters[i].name} {{}} {x:g}"
            return [
                (box.replaced(i, x, box.upper[i]), f"{path} > {where.format('above')}"),
                (box.replaced(i, box.lower[i], x), f"{path} > {where.format('below')}"),
            ]
        raise Unreadable(f"wanted a leaf, a collapse or a cut, got {node!r:.60}")

    def _options(self, box: Box, with_slopes: bool) -> list[Jet]:
        return options(self.claim, self.motions.on(box, with_slopes))

    def _leaf(self, box: Box, point: object) -> None:
        star = self._star(box, point)
        reached = largest(self._options(box, False))
        if reached <= self.bound:
            return
        if box.live:
            there = self._options(Box(star, star), False)
            reached = self._mean_value(box, star, there, self._options(box, True))
            if reached <= self.bound:
                return
        raise NotVerified(
            f"its bound is {float(reached):.10g}, above what is claimed,"
            f" {self.claim.bound:.10g}"
        )

    def _star(self, box: Box, point: object) -> tuple[float, ...]:
        """Return s* of a leaf; its centre if none is given."""
        sides = list(zip(box.lower, box.upper, strict=True))
        if point is None:
            return tuple((low + high) / 2 for low, high in sides)
        star = tuple(number(s, "s*") for s in items(point, "s*", len(sides)))
        if any(not low <= s <= high for s, (low, high) in zip(star, sides, strict=True)):
            raise NotVerified("s* is outside the box")
        return star

    def _mean_value(
        self, box: Box, star: tuple[float, ...], there: list[Jet], on: list[Jet]
    ) -> arb:
        """Return the largest of the options' bounds, each the lesser of two (Eq. 18)."""
        reached = []
        for at_star, jet in zip(there, on, strict=True):
            bound = at_star[0][1]
            for i, (low, high) in zip(box.live, jet[1:], strict=True):
                up = high * (arb(box.upper[i]) - arb(star[i]))
                down = -low * (arb(star[i]) - arb(box.lower[i]))
                bound += up.max(down).max(ZERO)
            reached.append(bound.min(jet[0][1]))
        return most(reached)

    def _collapsed(self, box: Box, faces: object) -> Box:
        """Look whether the quantity grows to the given faces; return what is left."""
        if not isinstance(faces, dict) or not faces:
            raise Unreadable(f"wanted faces by coordinate, got {faces!r:.60}")
        slopes = self._slopes_above_bound(box)
        child = box
        for key, face in faces.items():
            i = int(key) if isinstance(key, str) and key.isdecimal() else -1
            if i not in box.live:
                raise NotVerified(f"coordinate {key} does not vary in the box")
            name = self.problem.parameters[i].name
            if face not in ("lower", "upper"):
                raise Unreadable(f"face of {name}: wanted lower or upper, got {face!r}")
            if slopes is not None:
                low, high = slopes[box.live.index(i)]
                if not (low > ZERO if face == "upper" else high < ZERO):
                    raise NotVerified(
                        f"the quantity may not grow to the {face} face of {name}: its"
                        f" derivative is in [{float(low):.6g}, {float(high):.6g}]"
                    )
            s = box.lower[i] if face == "lower" else box.upper[i]
            child = child.replaced(i, s, s)
        return child

    def _slopes_above_bound(self, box: Box) -> list[Interval] | None:
        """Return the derivatives of max(F, U); None if F is nowhere above U."""
        alive = [jet for jet in self._options(box, True) if not jet[0][1] <= self.bound]
        if not alive:
            return None
        slopes = alive[0][1:]
        for jet in alive[1:]:
            slopes = [hull(a, b) for a, b in zip(slopes, jet[1:], strict=True)]
        return slopes


def most(values: list[arb]) -> arb:
    first = values[0]
    for value in values[1:]:
        first = first.max(value)
    return first


def largest(of: list[Jet]) -> arb:
    """Return the upper end of the largest of options."""
    return most([jet[0][1] for jet in of])


def checked(claim: Claim, motions: Motions) -> Outcome:
    """Walk through the tree of a claim."""
    walk = Walk(claim, motions)
    failure = None
    least = float("-inf")
    try:
        there = options(claim, motions.on(Box(tuple(claim.at), tuple(claim.at)), False))
        least = float(most([jet[0][0] for jet in there]).lower())
        if largest(there) < claim.found:
            raise NotVerified(
                f"what is said to be found, {claim.found:.10g}, is not reached at its"
                f" point: at most {float(largest(there)):.10g}"
            )
        walk.verify()
    except NotVerified as error:
        failure = str(error)
    return Outcome(failure, walk.count, least)
