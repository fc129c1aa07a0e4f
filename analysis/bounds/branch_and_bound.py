"""Branch and bound over boxes of parameters: section 7 of docs/proof.md.

A claim F <= U is shown box by box. Where F grows one way with a parameter over all of a
box, only that face is looked at; else the box is cut.
"""

import dataclasses
import heapq
import itertools
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drakesep.analysis.bounds.box import Boxes, whole_box
from drakesep.analysis.bounds.gravity import disturbance
from drakesep.analysis.bounds.grid import Grid, stroke_ends
from drakesep.analysis.bounds.intervals import Interval, up
from drakesep.analysis.bounds.motion import Enclosure
from drakesep.analysis.bounds.options import Options
from drakesep.analysis.bounds.problem import BoundProblem
from drakesep.analysis.bounds.pushes import NominalKernels
from drakesep.analysis.bounds.quantities import (
    Quantity,
    Term,
    least,
    means,
    options,
)
from drakesep.systems.arrays import Array


SLACK = 1e-6
"""Part of a claim, and of a derivative, by which they are shown with something to spare
for another arithmetic."""


@dataclass(slots=True, eq=False)
class Node:
    """A box, and what was done with it."""

    lower: Array
    upper: Array
    bound: float = np.inf
    """F is at most this on the box."""
    faces: dict[int, bool] = field(default_factory=dict)
    """Coordinates that are moved to a face, and whether to the upper one."""
    cut: tuple[int, float] | None = None
    """The coordinate along which it is cut, and where."""
    centre: Array | None = None
    """Of what is bounded there: the point of its mean value."""
    chosen: NDArray[np.bool_] | None = None
    """(choices,) those that are looked at; all if None."""
    split: bool = False
    """Whether each child looks at some of the choices on the same box."""
    children: list["Node"] = field(default_factory=list)
    parent: "Node | None" = field(default=None, repr=False)

    def grow(self, children: list["Node"]) -> None:
        """Take children."""
        self.children = children
        for child in children:
            child.parent = self

    def close(self) -> None:
        """Be a leaf."""
        self.children, self.faces, self.cut, self.split = [], {}, None, False


class Look(NamedTuple):
    """What is known of a quantity over boxes."""

    options: Options
    least: Array
    """(boxes,) what the quantity surely is, all over a box."""
    proven: NDArray[np.bool_]
    """(boxes,) whether it is; else nothing is known."""


class Progress(NamedTuple):
    """How far a proof is."""

    boxes: int
    """Looked at."""
    pending: int
    found: float
    """The largest value that is surely attained."""
    bound: float
    """That is being shown, or is known."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Effort:
    """How hard to try."""

    gap: float = 0.005
    """Of the bound above the largest value found, relative, at which to stop; more
    where the pieces of time are too long for it."""
    seconds: float = 600.0
    """After which what is left is bounded as it is."""
    boxes: int = 100_000
    """After which it is, too."""
    batch: int = 32
    """Boxes that are enclosed together."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Proof:
    """A claim that is shown."""

    quantity: Quantity
    bound: float
    """F is at most this."""
    found: float
    """F is at least this somewhere in the box."""
    at: tuple[float, ...]
    """Where that is."""
    tree: Node | Sequence[Any]
    """Its root; of a proof that was kept, its nodes as certificates list them."""
    boxes: int
    seconds: float
    finished: bool
    """Whether all boxes were shown; the gap may be larger than was asked for where
    pieces of time are too long."""


class Prover:
    """Encloses quantities of one problem on one grid."""

    def __init__(self, problem: BoundProblem, grid: Grid):
        self.problem, self.grid = problem, grid
        self._kernels = NominalKernels(problem, grid)
        self._gravity = disturbance(problem)
        self.enclosed = 0

    def look(
        self,
        quantity: Quantity,
        lower: Array,
        upper: Array,
        slopes: NDArray[np.bool_],
    ) -> Look:
        """Return what is known of a quantity over boxes.

        Args:
            quantity: in question.
            lower: (boxes, n) ends of s.
            upper: (boxes, n) the others.
            slopes: (n,) by which parameters derivatives are taken; others' are zero.
        """
        chosen = np.flatnonzero(slopes).tolist()
        enclosure = self._enclosure(quantity, lower, upper, chosen)
        found = options(enclosure, self.grid, quantity)
        every = np.zeros((2, len(slopes), *found.value.lo.shape))
        every[:, chosen] = found.slopes.lo, found.slopes.hi
        return Look(
            found._replace(slopes=Interval(*every)),
            least(enclosure, self.grid, quantity, found),
            enclosure.proven,
        )

    def _enclosure(
        self, quantity: Quantity, lower: Array, upper: Array, slopes: Sequence[int] = ()
    ) -> Enclosure:
        return Enclosure(
            Boxes(self.problem, lower, upper, slopes),
            self.grid,
            self._kernels,
            self._gravity,
            attitudes=quantity.attitudes,
        )

    def with_choices(self, quantity: Quantity) -> Quantity:
        """Return a quantity whose integrals are looked at as a whole after the push.

        It stays as it is where little is lost by pieces of time, such as of what turns
        far after the push.
        """
        coast = self.grid.push
        if not quantity.may_coast or coast + 1 >= len(self.grid.times):
            return quantity
        whole = whole_box(self.problem)
        over = self._enclosure(quantity, whole.lower, whole.upper)

        def coasting(term: Term) -> Term:
            levels: tuple[float, ...] = ()
            if quantity.kind == "integral_of_square" and over.proven[0]:
                mean = means(over, self.grid, term, coast)
                ends = np.linspace(mean.lo[0, 0], mean.hi[0, 0], _CELLS + 1)
                levels = tuple(sorted({float(x) for x in ends[1:-1]}))
            return dataclasses.replace(term, coast=coast, levels=levels)

        new = dataclasses.replace(
            quantity, terms=tuple(coasting(term) for term in quantity.terms)
        )
        some = np.concatenate([whole.lower, 0.5 * (whole.lower + whole.upper)])
        some = np.concatenate([some, whole.upper])
        nothing = np.zeros(some.shape[1], dtype=bool)
        before, after = (self.look(q, some, some, nothing) for q in (quantity, new))
        most = [
            np.where(x.proven, x.options.value.hi.max(-1), -np.inf).max()
            for x in (before, after)
        ]
        return new if most[1] <= most[0] * (1.0 + _LOST) else quantity

    @np.errstate(over="ignore", invalid="ignore")  # what is not finite proves nothing
    def prove(
        self,
        quantity: Quantity,
        effort: Effort | None = None,
        starts: Sequence[Array] = (),
        on_progress: Callable[[Progress], None] = lambda _: None,
    ) -> Proof:
        """Return a proven bound of a quantity, as near to what is attained as asked.

        Args:
            quantity: that is bounded from above.
            effort: how hard to try.
            starts: points (n,) of s where it may be large.
            on_progress: called as it goes on; what it raises ends it.
        """
        quantity = self.with_choices(quantity)
        return _Search(self, quantity, effort or Effort(), starts, on_progress).run()


_CELLS = 8
"""In which the mean of a signal may lie."""
_LOST = 0.02
"""Part of what an integral is at a point, that looking at it as a whole may lose."""


class _Search:
    """One proof on its way."""

    def __init__(
        self,
        prover: Prover,
        quantity: Quantity,
        effort: Effort,
        starts: Sequence[Array],
        on_progress: Callable[[Progress], None],
    ):
        self._prover, self._quantity, self._effort = prover, quantity, effort
        self._starts, self._on_progress = starts, on_progress
        root = whole_box(prover.problem)
        self._root = Node(root.lower[0], root.upper[0])
        self._all = np.ones(len(root.lower[0]), dtype=bool)
        self._order = itertools.count()
        self._queue: list[tuple[float, int, Node]] = []
        self._found, self._at = -np.inf, self._root.lower
        self._aim = -np.inf
        self._boxes = 0
        self._begun = time.monotonic()

    def run(self) -> Proof:
        self._climb()
        self._push(self._root)
        while self._queue:  # the whole box is looked at, however little time there is
            count = min(self._effort.batch, len(self._queue))
            self._look([heapq.heappop(self._queue)[2] for _ in range(count)])
            self._report()
            if self._exhausted:
                break
        left = [node.bound for _, _, node in self._queue]
        aim = max([self._aim, *left])
        for _, _, node in self._queue:
            _close_above(node)
        return Proof(
            quantity=self._quantity,
            bound=aim + SLACK * abs(aim),
            found=self._found,
            at=tuple(float(x) for x in self._at),
            tree=self._root,
            boxes=self._boxes,
            seconds=time.monotonic() - self._begun,
            finished=not left,
        )

    @property
    def _exhausted(self) -> bool:
        spent = time.monotonic() - self._begun > self._effort.seconds
        return spent or self._boxes >= self._effort.boxes

    def _report(self) -> None:
        bound = max([self._aim, *(node.bound for _, _, node in self._queue)])
        self._on_progress(Progress(self._boxes, len(self._queue), self._found, bound))

    def _push(self, node: Node) -> None:
        heapq.heappush(self._queue, (-node.bound, next(self._order), node))

    # ------------------------------------------------------------ what is attained

    def _attained(self, points: Array, look: Look, known: NDArray[np.bool_]) -> None:
        """Take note of values that are attained at points, of which some are known."""
        value = look.options.value
        least = np.where(known, self._least(points, look), -np.inf)
        best = int(np.argmax(least))
        if least[best] > self._found:
            self._found, self._at = float(least[best]), points[best].copy()
        if self._found == -np.inf:
            return
        # Pieces of time are as they are: no box with a point is below what that is.
        most = np.where(known, value.hi.max(-1), -np.inf).max()
        room = self._effort.gap * abs(self._found)
        wanted = max(self._found + room, float(most) + _LEAST_ROOM * room)
        # What is shown of a lower aim holds for a higher one.
        self._aim = max(self._aim, wanted - 2.0 * SLACK * abs(wanted))

    def _least(self, points: Array, look: Look) -> Array:
        """Return what the quantity surely is at points."""
        term, *others = self._quantity.terms
        if self._quantity.kind != "peak" or others or term.window:
            return look.least
        value = look.options.value
        boxes = Boxes(self._prover.problem, points, points)
        may, does = _sure(term, boxes, self._prover.grid)
        by_sign = value.lo.reshape(len(points), len(term.signs), -1)
        if term.moment:  # in one of the pieces in which it may be
            least = np.where(may[:, None], by_sign, np.inf).min(-1)
        else:
            least = np.where(does[:, None], by_sign, -np.inf).max(-1)
        most = least.max(-1)
        return np.asarray(
            np.maximum(most, 0.0) if _MAGNITUDE <= {*term.signs} else most
        )

    def _climb(self) -> None:
        """Go from corner to corner to where the quantity is large."""
        lower, upper = self._root.lower, self._root.upper
        points = [*self._starts, *self._first_corners()]
        seen: set[bytes] = set()
        for _ in range(_CLIMBS):
            new = []
            for point in points:
                if point.tobytes() not in seen:
                    seen.add(point.tobytes())
                    new.append(point)
            if not new or self._exhausted:
                break
            at = np.array(new[: self._effort.batch])
            look = self._prover.look(self._quantity, at, at, self._all)
            found = look.options
            self._boxes += len(at)
            self._attained(at, look, look.proven)
            points = []
            for b in range(len(at)):
                best = int(np.argmax(found.value.hi[b]))
                slope = found.slopes.lo[:, b, best] + found.slopes.hi[:, b, best]
                points.append(np.where(slope > 0.0, upper, lower))

    def _first_corners(self) -> list[Array]:
        """Return corners to which the options grow from the middle, the best first."""
        lower, upper = self._root.lower, self._root.upper
        middle = 0.5 * (lower + upper)[None]
        look = self._prover.look(self._quantity, middle, middle, self._all)
        if not look.proven[0]:
            return []
        self._attained(middle, look, look.proven)
        found = look.options
        slopes = 0.5 * (found.slopes.lo + found.slopes.hi)[:, 0]
        value = found.value.hi[0] + np.abs(slopes).T @ (0.5 * (upper - lower))
        corners = []
        for o in np.argsort(-value)[:: max(1, len(value) // _CORNERS)]:
            corners.append(np.where(slopes[:, o] > 0.0, upper, lower))
        if len(value) == 1:
            corners += [np.where(corners[0] == upper, lower, upper)]
        return corners

    # -------------------------------------------------------------- what is bounded

    def _look(self, nodes: list[Node]) -> None:
        """Bound some boxes, and cut those that are not shown."""
        lower = np.array([node.lower for node in nodes])
        upper = np.array([node.upper for node in nodes])
        varying = np.asarray((upper > lower).any(axis=0))
        found, _, proven = self._prover.look(self._quantity, lower, upper, varying)
        self._boxes += len(nodes)
        known = proven & np.isfinite(found.value.hi).all(-1)
        known &= np.isfinite(found.slopes.hi - found.slopes.lo).all((0, 2))
        asked = _asked(nodes, found.choice)
        live = asked & (found.value.hi > self._aim)
        hull = _hull(found.slopes, live)
        centres = _centres(hull, lower, upper)
        at = self._prover.look(self._quantity, centres, centres, ~self._all)
        self._attained(centres, at, at.proven & known)
        by_mean = at.options.value.hi + _beyond(found.slopes, lower, upper, centres)
        by_mean = np.where(
            at.proven[:, None] & np.isfinite(by_mean), up(by_mean), np.inf
        )
        bounds = np.where(asked, np.minimum(found.value.hi, by_mean), -np.inf)
        for b, node in enumerate(nodes):
            if not known[b]:
                self._cut(node, upper[b] - lower[b])
                continue
            node.bound = min(node.bound, float(bounds[b].max()))
            node.centre = centres[b]
            if node.bound > self._aim:
                self._divide(node, _Known(bounds[b], live[b], found, b))

    def _divide(self, node: Node, known: "_Known") -> None:
        """Move a box to faces, look at some choices at a time, or cut it."""
        asked = _asked([node], known.choice)[0]
        open_ = asked & known.live & (known.bounds > self._aim)
        choices = np.unique(known.choice[open_])
        # Of a choice that is looked at all that live count, also what is bounded by its
        # mean value: a certificate leaves out whole choices.
        counted = asked & known.live & np.isin(known.choice, choices)
        slopes = known.slopes(counted)
        faces = _faces(node, slopes)
        if faces or len(choices) == 1:
            # What is bounded by its mean value would hide what the others' slopes are.
            if (asked & known.live & ~counted).any():
                [node] = self._split(node, [choices], known)
            self._branch(node, faces, slopes)
            return
        for child in self._split(node, _halves(node, choices, open_, known), known):
            self._divide(child, known)

    def _split(
        self, node: Node, groups: Sequence[Array], known: "_Known"
    ) -> list[Node]:
        """Return nodes that look at groups of choices, on the same box."""
        node.split = True
        children = []
        for group in groups:
            chosen = np.isin(np.arange(math.prod(known.shape)), group)
            bound = float(known.bounds[chosen[known.choice]].max())
            children.append(
                Node(
                    node.lower,
                    node.upper,
                    bound,
                    centre=node.centre,
                    chosen=chosen,
                )
            )
        node.grow(children)
        return children

    def _branch(self, node: Node, faces: dict[int, bool], slopes: Interval) -> None:
        """Move a box to faces, or cut it if there are none."""
        if not faces:
            self._cut(node, slopes.magnitude() * (node.upper - node.lower))
            return
        node.faces = faces
        lower, upper = node.lower.copy(), node.upper.copy()
        for i, rises in faces.items():
            lower[i] = upper[i] = node.upper[i] if rises else node.lower[i]
        child = Node(lower, upper, node.bound, chosen=node.chosen)
        node.grow([child])
        self._push(child)

    def _cut(self, node: Node, effect: Array) -> None:
        i = int(np.argmax(effect))
        if not node.upper[i] > node.lower[i]:
            i = int(np.argmax(node.upper - node.lower))
        x = float(0.5 * (node.lower[i] + node.upper[i]))
        below, above = node.upper.copy(), node.lower.copy()
        below[i] = above[i] = x
        node.cut = (i, x)
        node.grow(
            [
                Node(node.lower, below, node.bound, chosen=node.chosen),
                Node(above, node.upper, node.bound, chosen=node.chosen),
            ]
        )
        for child in node.children:
            self._push(child)


def _close_above(node: Node) -> None:
    """Make a leaf of the box in which one lies that was not looked at.

    What is known of the one is what is known of the other; of a box whose motion was
    not enclosed, nothing is.
    """
    above = node.parent
    while above is not None and above.centre is None:
        above = above.parent
    if above is not None:
        above.close()


_MAGNITUDE = {1, -1}
"""Signs with which a peak is one of a magnitude, and never below zero."""
_LEAST_ROOM = 0.1
"""Part of the gap that is left for boxes, above what points have."""
_CLIMBS = 6
_CORNERS = 6


def _sure(
    term: Term, boxes: Boxes, grid: Grid
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which pieces (boxes, pieces) a term may, and surely does, look at."""
    pieces = np.arange(term.first, term.last + 1)
    starts, ends = grid.times[pieces], grid.times[pieces + 1]
    if (term.since, term.until) == ("first", "last"):
        every = np.ones((boxes.count, len(pieces)), dtype=bool)
        return every, every
    separation = stroke_ends(boxes, [term.signal.pair])
    early, late = separation.lo[:, None], separation.hi[:, None]
    if term.moment:
        may = (ends >= early) & (starts <= late)
        return may, may
    if term.until == "separation":
        return starts <= late, ends <= early
    return ends >= early, starts >= late


def _asked(nodes: Sequence[Node], choice: Array) -> NDArray[np.bool_]:
    """Return which options (nodes, options) nodes look at."""
    return np.array(
        [
            np.full(len(choice), True) if node.chosen is None else node.chosen[choice]
            for node in nodes
        ]
    )


class _Known(NamedTuple):
    """What is known on one box."""

    bounds: Array
    """(options,) of each option."""
    live: NDArray[np.bool_]
    """(options,) those whose upper ends are above the aim."""
    found: Options
    box: int
    """Which of their boxes it is."""

    @property
    def choice(self) -> Array:
        """(options,) to which options belong."""
        return self.found.choice

    @property
    def shape(self) -> tuple[int, ...]:
        """How many choices there are of each term."""
        return self.found.shape

    def slopes(self, options: NDArray[np.bool_]) -> Interval:
        """Return the hull (n,) of the derivatives of some options."""
        return _hull(self.found.slopes[:, self.box], options)


def _faces(node: Node, slopes: Interval) -> dict[int, bool]:
    """Return the coordinates that a quantity grows with, and whether upward."""
    clear = SLACK * slopes.magnitude().max()
    wide = node.upper > node.lower
    grows, falls = wide & (slopes.lo > clear), wide & (slopes.hi < -clear)
    return {int(i): bool(grows[i]) for i in np.flatnonzero(grows | falls)}


def _halves(
    node: Node, choices: Array, open_: NDArray[np.bool_], known: _Known
) -> list[Array]:
    """Return choices in two groups, by those of one term.

    Of all such the one after which least is unknown of how the quantity grows.
    """
    of_term = np.array(np.unravel_index(choices.astype(int), known.shape))

    def unknown(group: Array) -> float:
        slopes = known.slopes(open_ & np.isin(known.choice, group))
        both = np.minimum(np.maximum(slopes.hi, 0.0), np.maximum(-slopes.lo, 0.0))
        return float((both * (node.upper - node.lower)).sum())

    ways = [
        [choices[term < begin], choices[term >= begin]]
        for term in of_term
        for begin in np.unique(term)[1:]
    ]
    return min(ways, key=lambda groups: sum(unknown(group) for group in groups))


def _hull(slopes: Interval, live: NDArray[np.bool_]) -> Interval:
    """Return the hull (n, boxes) of derivatives over live options; 0 without one."""
    lo = np.where(live, slopes.lo, np.inf).min(-1)
    hi = np.where(live, slopes.hi, -np.inf).max(-1)
    none = ~live.any(-1)
    return Interval(np.where(none, 0.0, lo), np.where(none, 0.0, hi))


def _centres(hull: Interval, lower: Array, upper: Array) -> Array:
    """Return the points (boxes, n) about which mean values say most (Baumann)."""
    rises, falls = np.maximum(hull.hi, 0.0).T, np.maximum(-hull.lo, 0.0).T
    both = rises + falls
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(both > 0.0, rises / both, 0.5)
    share = np.where(np.isfinite(share), share, 0.5)
    return np.clip(lower + share * (upper - lower), lower, upper)


def _beyond(slopes: Interval, lower: Array, upper: Array, centres: Array) -> Array:
    """Return by how much options (boxes, options) may exceed those at the centres."""
    above, under = up(upper - centres).T[..., None], up(centres - lower).T[..., None]
    rises = np.maximum(up(slopes.hi * above), up(-slopes.lo * under))
    rises = np.maximum(rises, 0.0)
    n = len(rises)
    return np.asarray(rises.sum(0) * (1.0 + (n + 2) * 2.0**-52))
