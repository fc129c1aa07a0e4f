"""What a claim says, in words."""

from .boxes import Constants
from .certificate import Claim, Problem, Term
from .impulses import end_of_stroke, law_of
from .intervals import ZERO, Interval


UNITS = {
    "rate": "rad/s",
    "relative_rate": "rad/s",
    "relative_velocity": "m/s",
    "relative_position": "m",
    "angle": "rad",
}
OF_FIELD = {
    "rate": "rate of {B} in its axes",
    "relative_rate": "rate of {B} relative to {A}, in {B}'s axes",
    "relative_velocity": "velocity of {B}'s CG as seen from {A}, in {A}'s axes",
    "relative_position": "way of {B}'s CG as seen from {A}, in {A}'s axes",
    "angle": "angles of {B}",
}
OF_SIGNS = {
    (1,): "the largest value",
    (-1,): "less the smallest value",
    (-1, 1): "the largest magnitude",
    (0,): "less the smallest magnitude",
}
AXES = {"angle": ("roll", "pitch", "yaw")}


def in_words(claim: Claim, problem: Problem) -> str:
    """Say what quantity it is, of which body, when, in which unit, and its bound."""
    terms = " plus ".join(_term(claim, term, problem) for term in claim.terms)
    return f"{terms} is at most {claim.bound!r} {_unit(claim)}"


def _unit(claim: Claim) -> str:
    term = claim.terms[0]
    unit = UNITS[term.field]
    if term.law.endswith("squared"):
        unit = f"({unit})^2"
    return {
        "peak": unit,
        "integral_of_magnitude": f"{unit} s",
        "integral_of_square": f"({unit})^2 s",
    }[claim.kind]


def _term(claim: Claim, term: Term, problem: Problem) -> str:
    pair = problem.pairs[term.pair]
    A, B = (f'"{problem.bodies[b].name}"' for b in (pair.carrier, pair.leaver))
    signal = OF_FIELD[term.field].format(A=A, B=B)
    if term.component is not None:
        axis = AXES.get(term.field, ("x", "y", "z"))[term.component]
        signal = f"{axis} of the {signal}"
    elif term.law == "length_squared":
        signal = f"square of the length of the {signal}"
    else:
        assert term.vector is not None
        vector = ", ".join(f"{float(x[0].mid()):.9g}" for x in term.vector)
        how = "part along" if term.law == "along" else "square of the part across"
        signal = f"{how} ({vector}) of the {signal}"
    if claim.kind == "peak":
        return f"{_of_signs(term)} of the {signal} {_when(term, problem)}"
    of = "magnitude" if claim.kind == "integral_of_magnitude" else "square"
    return f"the integral from 0 to {problem.grid[-1]!r} s of the {of} of the {signal}"


def separation(term: Term, problem: Problem) -> Interval:
    """Enclose, over the box, when the last stroke of a pair ends."""
    constants = Constants(problem, problem.root, [])
    low, high = ZERO, ZERO
    for spring in problem.springs:
        if spring.pair == term.pair:
            end = end_of_stroke(law_of(spring, constants))
            low, high = low.max(end[0]), high.max(end[1])
    return low, high


def _when(term: Term, problem: Problem) -> str:
    grid, taken = problem.grid, term.pieces
    times = f"from {grid[taken.start]:.9g} to {grid[taken.stop]:.9g} s"
    if len(taken) == problem.pieces:
        return f"at any time, {times}"
    first, last = separation(term, problem)
    after = [n for n in range(problem.pieces) if not grid[n + 1] < first]
    during = [n for n in after if not grid[n] > last]
    if set(after) <= set(taken):
        return f"at any time after the last stroke ends, {times}"
    if set(during) <= set(taken):
        return f"when the last stroke ends, {times}"
    return times


def _of_signs(term: Term) -> str:
    signs = tuple(sorted(term.signs))
    return OF_SIGNS.get(signs, f"the largest, with the signs {signs},")
