"""The tree of a claim, walked: that it covers the box, and that each node holds."""

from dataclasses import dataclass, replace
from functools import lru_cache

from flint import arb

from .certificate import Box, Claim, Problem, Unreadable, index, items, number
from .intervals import ZERO, Interval, Jet, NotVerified, hull
from .motion import Motion, Setting
from .quantities import Alternatives, alternatives, choices, enclosed, options


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
        self._values = lru_cache(maxsize=200)(self._with_values)
        self._slopes = lru_cache(maxsize=6)(self._with_slopes)

    def on(self, box: Box, by: tuple[int, ...] = (), more: int = 0) -> Motion:
        """Return the motion on a box, with its derivatives by some coordinates.

        What is enclosed is enclosed anew from there so many times more: each time it is
        no wider.
        """
        return self._slopes(box, by, more) if by else self._values(box, more)

    def _with_values(self, box: Box, more: int) -> Motion:
        return Motion(self.setting, box, [], more=more)

    def _with_slopes(self, box: Box, by: tuple[int, ...], more: int) -> Motion:
        start = self.on(box, more=more)
        return Motion(self.setting, box, [*by], start=start, more=more)


@dataclass(frozen=True)
class Place:
    """Where a walk is: a box, and which choices of options are looked at there."""

    box: Box
    path: str
    chosen: tuple[int, ...]

    def below(self, step: str, box: Box) -> "Place":
        """Return the place after a step of the walk."""
        return replace(self, box=box, path=f"{self.path} > {step}")


SHARPER = 4  # times that an enclosure is enclosed anew where it does not suffice


class Walk:
    """A walk through the tree of one claim."""

    def __init__(self, claim: Claim, motions: Motions):
        self.claim = claim
        self.motions = motions
        self.problem = motions.setting.problem
        self.bound = arb(claim.bound)
        self.nodes = iter(claim.tree)
        self.count = 0
        self.more = 0
        self._of_terms = lru_cache(maxsize=6)(self._alternatives)

    def verify(self) -> None:
        """Raise NotVerified at the first node that does not hold."""
        everything = tuple(range(choices(self.claim)))
        waiting = [Place(self.problem.root, "root", everything)]
        while waiting:
            place = waiting.pop()
            try:
                node = next(self.nodes)
            except StopIteration:
                raise NotVerified(f"{place.path}: a node is missing") from None
            self.count += 1
            try:
                waiting += self._visited_twice(node, place)
            except (NotVerified, Unreadable) as failure:
                name = node[0] if isinstance(node, list) and node else node
                raise NotVerified(
                    f"node {self.count} ({place.path} > {name}): {failure}"
                ) from None
        if next(self.nodes, None) is not None:
            raise NotVerified(f"after node {self.count}: nodes that belong to no box")

    def _visited_twice(self, node: object, place: Place) -> list[Place]:
        """Visit a node; once more, with sharper enclosures, if it does not hold."""
        try:
            return self._visited(node, place)
        except NotVerified:
            self.more = SHARPER
            return self._visited(node, place)
        finally:
            self.more = 0

    def _visited(self, node: object, place: Place) -> list[Place]:
        """Look whether a node holds; return the places below it, the last one first."""
        kind, *rest = items(node, "node") or [None]
        box = place.box
        if kind == "leaf" and len(rest) == 1:
            self._holds(place, self._star(box, rest[0]))
            return []
        if kind == "collapse" and len(rest) == 1:
            return [place.below("collapse", self._collapsed(place, rest[0]))]
        if kind == "split" and len(rest) == 2:
            return self._split(place, rest[0], self._star(box, rest[1]))
        if kind == "cut" and len(rest) == 2:
            i = index(rest[0], "coordinate", len(self.problem.parameters))
            x = number(rest[1], "place of the cut")
            if not box.lower[i] < x < box.upper[i]:
                raise NotVerified("the cut is not inside the box")
            name = self.problem.parameters[i].name
            return [
                place.below(f"{name} above {x:g}", box.replaced(i, x, box.upper[i])),
                place.below(f"{name} below {x:g}", box.replaced(i, box.lower[i], x)),
            ]
        raise Unreadable(f"wanted leaf, collapse, split or cut, got {node!r:.60}")

    def _options(self, place: Place, by: tuple[int, ...] = ()) -> list[Jet]:
        return options(self._of_terms(place.box, by, self.more), place.chosen)

    def _alternatives(
        self, box: Box, by: tuple[int, ...], more: int
    ) -> list[Alternatives]:
        return alternatives(self.claim, self.motions.on(box, by, more))

    def _holds(self, place: Place, star: tuple[float, ...]) -> None:
        """Raise NotVerified unless all options looked at are at most the bound."""
        reached = largest(self._options(place))
        if reached <= self.bound:
            return
        if place.box.live:
            there = self._options(replace(place, box=Box(star, star)))
            on = self._options(place, tuple(place.box.live))
            reached = self._mean_value(place.box, star, there, on)
            if reached <= self.bound:
                return
        raise NotVerified(
            f"its bound is {float(reached):.10g}, above what is claimed,"
            f" {self.claim.bound:.10g}"
        )

    def _split(
        self, place: Place, listed: object, star: tuple[float, ...]
    ) -> list[Place]:
        """Return places for each listed group of choices; the others must hold."""
        count = choices(self.claim)
        groups = [
            tuple(index(c, "choice", count) for c in items(group, "group of choices"))
            for group in items(listed, "groups of choices")
        ]
        if not all(groups):
            raise Unreadable("wanted choices in each group, got none in one")
        apart = {c for group in groups for c in group}
        rest = tuple(c for c in place.chosen if c not in apart)
        if rest:
            self._holds(replace(place, chosen=rest), star)
        out = []
        for group in reversed(groups):
            below = place.below(f"choices {_few(group)}", place.box)
            out.append(replace(below, chosen=group))
        return out

    def _star(self, box: Box, point: object) -> tuple[float, ...]:
        """Return s* of a leaf; its centre if none is given."""
        sides = list(zip(box.lower, box.upper, strict=True))
        if point is None:
            return tuple((low + high) / 2 for low, high in sides)
        star = tuple(number(s, "s*") for s in items(point, "s*", len(sides)))
        if any(
            not low <= s <= high for s, (low, high) in zip(star, sides, strict=True)
        ):
            raise NotVerified("s* is outside the box")
        return star

    def _mean_value(
        self, box: Box, star: tuple[float, ...], there: list[Jet], on: list[Jet]
    ) -> arb:
        """Return the largest of options' bounds, each the lesser of two (Eq. 18)."""
        reached = []
        for at_star, jet in zip(there, on, strict=True):
            bound = at_star[0][1]
            for i, (low, high) in zip(box.live, jet[1:], strict=True):
                up = high * (arb(box.upper[i]) - arb(star[i]))
                down = -low * (arb(star[i]) - arb(box.lower[i]))
                bound += up.max(down).max(ZERO)
            reached.append(bound.min(jet[0][1]))
        return most(reached)

    def _collapsed(self, place: Place, faces: object) -> Box:
        """Look whether the quantity grows to the given faces; return what is left."""
        if not isinstance(faces, dict) or not faces:
            raise Unreadable(f"wanted faces by coordinate, got {faces!r:.60}")
        child = box = place.box
        named = {str(i): i for i in box.live}
        if unknown := [key for key in faces if key not in named]:
            raise NotVerified(f"coordinate {unknown[0]:.20} does not vary in the box")
        moved = tuple(named[key] for key in faces)
        slopes = self._slopes_above_bound(place, moved)
        for k, (i, face) in enumerate(zip(moved, faces.values(), strict=True)):
            name = self.problem.parameters[i].name
            if face not in ("lower", "upper"):
                raise Unreadable(f"face of {name}: wanted lower or upper, got {face!r}")
            if slopes is not None:
                low, high = slopes[k]
                if not (low > ZERO if face == "upper" else high < ZERO):
                    raise NotVerified(
                        f"the quantity may not grow to the {face} face of {name}: its"
                        f" derivative is in [{float(low):.6g}, {float(high):.6g}]"
                    )
            s = box.lower[i] if face == "lower" else box.upper[i]
            child = child.replaced(i, s, s)
        return child

    def _slopes_above_bound(
        self, place: Place, by: tuple[int, ...]
    ) -> list[Interval] | None:
        """Return the derivatives of max(F, U); None if F is nowhere above U."""
        alive = [jet for jet in self._options(place, by) if not jet[0][1] <= self.bound]
        if not alive:
            return None
        slopes = alive[0][1:]
        for jet in alive[1:]:
            slopes = [hull(a, b) for a, b in zip(slopes, jet[1:], strict=True)]
        return slopes


def _few(group: tuple[int, ...]) -> str:
    return ", ".join(str(c) for c in group[:3]) + (", ..." if len(group) > 3 else "")


def most(values: list[arb]) -> arb:
    """Return the largest."""
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
        at = Box(tuple(claim.at), tuple(claim.at))
        low, high = enclosed(claim, motions.on(at))
        least = float(low.lower())
        if high < claim.found:
            raise NotVerified(
                f"what is said to be found, {claim.found:.10g}, is not reached at its"
                f" point: at most {float(high):.10g}"
            )
        walk.verify()
    except NotVerified as error:
        failure = str(error)
    return Outcome(failure, walk.count, least)
