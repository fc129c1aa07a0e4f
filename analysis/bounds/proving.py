"""Bounds of a case's requirements and objectives, proven one by one."""

import functools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.bounds.branch_and_bound import (
    Effort,
    Progress,
    Proof,
    Prover,
)
from drakesep.analysis.bounds.certificate import write_certificate
from drakesep.analysis.bounds.claims import (
    Claim,
    Side,
    claim_name,
    claim_of,
    moments,
    side_of,
)
from drakesep.analysis.bounds.grid import Grid, make_grid
from drakesep.analysis.bounds.problem import BoundProblem, NotCovered, problem_of
from drakesep.analysis.metrics.registry import find_metric
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import check_positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Bound:
    """What a metric cannot exceed anywhere in the box of the tolerances."""

    claim: Claim
    value: float
    """The bound, in SI: the metric is at most this, or at least, if from below."""
    found: float
    """The farthest value that is known to be attained in the box."""
    proof: Proof

    @property
    def gap(self) -> float:
        """By how much the bound is beyond what is attained, relative to that."""
        beyond = abs(self.value - self.found)
        return beyond / abs(self.found) if self.found else math.inf

    def meets(self, requirement: Requirement) -> bool:
        """Return whether it proves that a requirement is met."""
        return (
            requirement.judged_by == self.claim.metric
            and side_of(requirement) == self.claim.side
            and requirement.keeps(requirement.margin(self.value))
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Bounds:
    """What is proven of a case."""

    problem: BoundProblem | None
    grid: Grid | None
    proven: Mapping[str, Bound]
    """By what is asked: ``highest_`` or ``lowest_`` and the metric."""
    not_covered: Mapping[str, str]
    """Why there is no bound, by what is asked."""

    def write_certificate(self, path: Path) -> tuple[str, ...]:
        """Write the certificate of what is proven, as far as it is not too long.

        Args:
            path: of the file; it is not written if no claim fits.

        Returns:
            Names of the claims that do not fit.

        Raises:
            ValueError: nothing is.
        """
        if self.problem is None or self.grid is None or not self.proven:
            raise NotCovered("certificate: nothing is proven")
        proofs = {name: bound.proof for name, bound in self.proven.items()}
        return write_certificate(path, self.problem, self.grid, proofs)


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class ProofSettings:
    """How hard to try.

    Raises:
        ValueError: a gap or a time is not positive, or there are fewer pieces of time
            than one.
    """

    gap: float = 0.005
    """Of a bound beyond what is attained, relative, at which to stop."""
    seconds: float = 60.0
    """For each bound; then what is known is its bound."""
    push: int = 56
    """Pieces of time while springs push."""
    coast: int = 12
    """Pieces of time after that."""

    def __post_init__(self) -> None:
        """Check the values."""
        check_positive("gap", self.gap)
        check_positive("seconds", self.seconds)
        check_positive("push", self.push)
        check_positive("coast", self.coast)


def asked_of(case: AnalysisCase) -> list[tuple[str, Side]]:
    """Return what limits of requirements ask for, and the paper's objectives."""
    asked: list[tuple[str, Side]] = [
        (r.judged_by, side_of(r)) for r in case.requirements
    ]
    for objective in case.paper_objectives:
        assert objective.shown_as is not None
        asked.append((objective.shown_as.name, "highest"))
    return list(dict.fromkeys(asked))


@typed
def prove_bounds(
    case: AnalysisCase,
    asked: Sequence[tuple[str, Side]] | None = None,
    settings: ProofSettings | None = None,
    *,
    starts: Iterable[Mapping[str, float]] = (),
    known: Mapping[str, Proof] | None = None,
    on_proof: Callable[[str, Proof], None] = lambda *_: None,
    on_progress: Callable[[str, Progress], None] = lambda *_: None,
) -> Bounds:
    """Prove what metrics cannot exceed, anywhere in the box of the tolerances.

    Inertias that no body can have, and what ellipsoids leave out, are in the box. See
    docs/proof.md.

    Args:
        case: with the separation and the tolerances.
        asked: metrics, and whether the highest or the lowest value is bounded; what the
            case asks for if None.
        settings: how hard to try.
        starts: points of the box by parameter values, in SI, where metrics may be far
            out, such as worst cases found.
        known: proofs of the same case and settings by the names of their claims, which
            are not proven again.
        on_proof: called with the name of each claim that was not known, and its proof,
            as soon as it is there.
        on_progress: called with the name of what is being proven, and how far it is;
            what it raises ends all.

    Returns:
        Bounds, and why there is none of what is not covered.

    Raises:
        ValueError: there is no such metric.
    """
    settings = settings or ProofSettings()
    asked = asked_of(case) if asked is None else asked
    names = [claim_name(metric, side) for metric, side in asked]
    of_runs = [metric for metric, _ in asked if not _measured_apart(metric)]
    try:
        problem = problem_of(case.separation, case.box)
        grid = make_grid(problem, settings.push, settings.coast, moments(of_runs))
        prover = Prover(problem, grid)
    except NotCovered as why:
        reasons = dict.fromkeys(names, str(why))
        return Bounds(problem=None, grid=None, proven={}, not_covered=reasons)
    return _proven(
        case, prover, asked, settings, starts, known or {}, on_proof, on_progress
    )


def _proven(
    case: AnalysisCase,
    prover: Prover,
    asked: Sequence[tuple[str, Side]],
    settings: ProofSettings,
    starts: Iterable[Mapping[str, float]],
    known: Mapping[str, Proof],
    on_proof: Callable[[str, Proof], None],
    on_progress: Callable[[str, Progress], None],
) -> Bounds:
    problem, grid, box = prover.problem, prover.grid, case.box
    columns = [box.names.index(p.name) for p in problem.parameters]
    points = [box.clipped(box.scaled(values))[columns] for values in starts]
    proven: dict[str, Bound] = {}
    not_covered: dict[str, str] = {}
    for metric, side in asked:
        name = claim_name(metric, side)
        try:
            if _measured_apart(metric):
                raise NotCovered(f"{metric}: bounds do not cover clearance")
            claim = claim_of(case.separation, problem, grid, metric, side)
        except NotCovered as why:
            not_covered[name] = str(why)
            continue
        if name in known:
            proof = known[name]
        else:
            told = functools.partial(on_progress, name)
            # A root's gap is half of that of what it is of.
            gap = settings.gap * (2.0 if claim.squared else 1.0)
            effort = Effort(gap=gap, seconds=settings.seconds)
            proof = prover.prove(claim.quantity, effort, points, told)
            on_proof(name, proof)
        if not math.isfinite(proof.bound):
            not_covered[name] = (
                f"{metric}: no enclosure of the motion was found in"
                f" {settings.seconds:g} s; there may be one in more time, or of"
                " narrower tolerances or a shorter run"
            )
            continue
        proven[name] = Bound(
            claim=claim,
            value=claim.value(proof.bound),
            found=claim.value(proof.found),
            proof=proof,
        )
    return Bounds(problem=problem, grid=grid, proven=proven, not_covered=not_covered)


def _measured_apart(metric: str) -> bool:
    found = find_metric(metric)
    return found is not None and not found[0].of_every_run
