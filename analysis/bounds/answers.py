"""What is proven of each requirement and objective, beside the worst that was found."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.bounds.branch_and_bound import Progress, Proof
from drakesep.analysis.bounds.claims import Side, claim_name, side_of
from drakesep.analysis.bounds.problem import NotCovered, problem_of
from drakesep.analysis.bounds.proving import (
    Bound,
    Bounds,
    ProofSettings,
    prove_bounds,
)
from drakesep.analysis.metrics.functions import FunctionRequirement
from drakesep.analysis.metrics.objectives import OBJECTIVES, Objective
from drakesep.analysis.metrics.registry import find_metric
from drakesep.analysis.metrics.requirements import Requirement


PROVEN_MET, NOT_PROVEN, NOT_COVERED = "proven met", "not proven", "not covered"
"""Of a requirement: its bound is within the limit, or is not; or there is none."""
BOUNDED = "bounded"
"""Of an objective, which has no limit: there is a bound."""
CONTRADICTED = "contradicted"
"""A run is beyond the bound: one of the two is wrong."""
_ROUNDING = 1e-12
"""In SI: what runs and enclosures make of zero is nearer to it."""
BY_ENCLOSURE = "enclosure"
"""That told what is surely attained, where no run is at hand."""


class Question(NamedTuple):
    """What is to be bounded."""

    metric: str
    side: Side
    requirement: Requirement | None = None
    objective: str = ""
    """Its name, of what is no requirement."""
    refused: str = ""
    """Why no bound can be asked for."""

    @property
    def claim(self) -> str:
        """The name of the claim that answers it."""
        return claim_name(self.metric, self.side)


class Found(NamedTuple):
    """The worst that runs have shown."""

    value: float
    """In SI."""
    run: str
    """Label of the run."""
    within: float
    """By how much it may be off."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ProvenAnswer:
    """What is proven of a requirement or an objective."""

    question: Question
    bound: Bound | None = None
    uncovered: str = ""
    """Why there is no bound."""
    run: Found | None = None
    """The worst within the tolerances that was flown; None: nothing was."""

    @property
    def value(self) -> float:
        """The bound, in SI; NaN: there is none."""
        return math.nan if self.bound is None else self.bound.value

    @property
    def found(self) -> float:
        """The worst found, in SI: in a run, or as enclosures show it; NaN: none."""
        if self.run is not None:
            return self.run.value
        return math.nan if self.bound is None else self.bound.found

    @property
    def found_by(self) -> str:
        """Label of that run; or `BY_ENCLOSURE`; empty: there is none."""
        if self.run is not None:
            return self.run.run
        return "" if self.bound is None else BY_ENCLOSURE

    @property
    def gap(self) -> float:
        """By how much the bound is beyond the worst found, as a share of that.

        NaN: there is no bound, or what is found is zero but for rounding.
        """
        if self.bound is None or abs(self.found) < _ROUNDING:
            return math.nan
        return self._beyond(self.value, self.found) / abs(self.found)

    def _beyond(self, value: float, than: float) -> float:
        """Return how far a value is beyond another, to the side that is bounded."""
        return value - than if self.question.side == "highest" else than - value

    @property
    def is_contradicted(self) -> bool:
        """Whether a run is beyond the bound, by more than it may be off."""
        if self.run is None or self.bound is None:
            return False
        return self._beyond(self.run.value, self.bound.value) > self.run.within

    @property
    def verdict(self) -> str:
        """What is proven, in words; a run beyond a limit is never proven away."""
        requirement = self.question.requirement
        if self.bound is None:
            return NOT_COVERED
        if self.is_contradicted:
            return CONTRADICTED
        if requirement is None:
            return BOUNDED
        kept = requirement.keeps(requirement.margin(self.found))
        return PROVEN_MET if kept and self.bound.meets(requirement) else NOT_PROVEN

    @property
    def reason(self) -> str:
        """Why no more than that is proven; empty if all is."""
        if self.bound is None:
            return self.uncovered
        match self.verdict:
            case verdict if verdict == CONTRADICTED:
                return f"{self.found_by} is beyond the bound"
            case verdict if verdict == NOT_PROVEN:
                return self._why_not_proven(self.bound)
        if self.bound.proof.finished:
            return ""
        return "time was over at this gap"

    def _why_not_proven(self, bound: Bound) -> str:
        requirement = self.question.requirement
        assert requirement is not None
        for value, what in ((self.found, self.found_by), (bound.found, BY_ENCLOSURE)):
            if not requirement.keeps(requirement.margin(value)):
                where = "a point of the box" if what == BY_ENCLOSURE else what
                return f"beyond the limit in {where}"
        if not bound.proof.finished:
            return "time was over before the bound was within the limit"
        return "the limit is nearer to what is attained than the gap that was asked for"


def questions_of(
    case: AnalysisCase,
    objectives: Iterable[Objective] = (),
    functions: Iterable[FunctionRequirement] = (),
) -> tuple[Question, ...]:
    """Return what is to be bounded of a case: its requirements, then objectives.

    Args:
        case: with the requirements.
        objectives: beside these; what leads out of requirements is left out.
        functions: that are required beside the case's requirements.
    """
    uncovered = _why_not_covered(case)
    required = [*functions]
    of_functions = [limit for function in required for limit in function.limits]
    limits = (*case.requirements, *of_functions)
    questions = [_of_requirement(requirement, uncovered) for requirement in limits]
    of_limits = (objective for f in required for objective in f.objectives)
    leads = {one.name for one in (*case.requirement_objectives, *of_limits)}
    asked = {question.claim for question in questions}
    for objective in objectives:
        question = _of_objective(objective, uncovered)
        if objective.name not in leads and question.claim not in asked:
            questions.append(question)
    return tuple(questions)


def claims_of(questions: Iterable[Question]) -> list[str]:
    """Return names of the claims that answer questions, each once, in their order."""
    return list(dict.fromkeys(one.claim for one in questions if not one.refused))


def _why_not_covered(case: AnalysisCase) -> str:
    """Return why there is no bound of a case at all; empty if there may be some."""
    try:
        problem_of(case.separation, case.box)
    except NotCovered as why:
        return str(why)
    return ""


def _of_requirement(requirement: Requirement, refused: str) -> Question:
    if find_metric(requirement.metric) is None:
        refused = refused or f"{requirement.metric}: bounds do not cover functions"
    elif requirement.measured_apart:
        refused = refused or f"{requirement.metric}: bounds do not cover clearance"
    return Question(
        requirement.judged_by, side_of(requirement), requirement, refused=refused
    )


def _of_objective(objective: Objective, refused: str) -> Question:
    told = objective.shown_as
    if told is not None:
        side: Side = "highest" if told.sign > 0.0 else "lowest"
        if objective.name in (*OBJECTIVES, claim_name(told.name, side)):
            return Question(told.name, side, objective=objective.name, refused=refused)
    refused = f"{objective.name}: bounds cover metrics over their own windows alone"
    return Question(
        objective.name, "highest", objective=objective.name, refused=refused
    )


def proven_answers(
    case: AnalysisCase,
    questions: Sequence[Question],
    settings: ProofSettings,
    *,
    starts: Iterable[Mapping[str, float]] = (),
    runs: Mapping[str, Found] | None = None,
    known: Mapping[str, Proof] | None = None,
    on_proof: Callable[[str, Proof], None] = lambda *_: None,
    on_progress: Callable[[str, Progress], None] = lambda *_: None,
) -> tuple[Bounds, tuple[ProvenAnswer, ...]]:
    """Return bounds, and what they say of each question.

    Args:
        case: with the separation and the tolerances.
        questions: of the case.
        settings: how hard to try, for each bound.
        starts: as `prove_bounds` takes them.
        runs: the worst that was flown within the tolerances, by the claims.
        known: as `prove_bounds` takes them.
        on_proof: as `prove_bounds` takes it.
        on_progress: as `prove_bounds` takes it.
    """
    asked = dict.fromkeys((q.metric, q.side) for q in questions if not q.refused)
    bounds = prove_bounds(
        case,
        [*asked],
        settings,
        starts=starts,
        known=known,
        on_proof=on_proof,
        on_progress=on_progress,
    )
    found = runs or {}
    return bounds, tuple(
        ProvenAnswer(
            question=q,
            bound=None if q.refused else bounds.proven.get(q.claim),
            uncovered=q.refused or bounds.not_covered.get(q.claim, ""),
            run=found.get(q.claim),
        )
        for q in questions
    )
