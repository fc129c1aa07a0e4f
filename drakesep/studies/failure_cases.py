"""Failure cases, each verified as the design is, by what has flown that.

They share its compiled programs and its diagram: what has failed is a number that these
hold. They share calls, too: some are searched side by side. Fewer starts and samples
do, since the design's worst cases are known; tolerances do not grow.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.engines.jax.together import Ask, flown_together
from drakesep.analysis.failure_cases import FailureCase
from drakesep.analysis.metrics.objectives import Objective
from drakesep.analysis.search.ask_tell import side_by_side
from drakesep.analysis.search.expensive_objectives import by_cost
from drakesep.analysis.search.judge import judge, search_for_worst
from drakesep.analysis.search.problem import FROM_BEST, Problem, Searched
from drakesep.studies.tolerance_growth import ways_out
from drakesep.studies.verified import FailedCase, Verification
from drakesep.studies.worst_case.confirmation import Fly, confirmed, functions_compared
from drakesep.studies.worst_case.effort import FAILURES, of_failure
from drakesep.studies.worst_case.procedure import told
from drakesep.studies.worst_case.result import better_directions
from drakesep.studies.worst_case.session import Session
from drakesep.systems.model.run import Run
from drakesep.tables.labelled_run import measured
from drakesep.tables.roles import Nominal


_TOGETHER = 8
"""Failure cases that are searched side by side: what each asks for fills a part of a
call."""
_BY_FAR = 0.1
"""Share of the worse direction's value."""


def failure_cases_verified(study: Verification, under_way: Session) -> Verification:
    """Return a study with the failure cases of its plan, verified.

    Some at a time, which the tables have as soon as they are finished.

    Args:
        study: of the design, with its worst cases.
        under_way: the session that has found them.
    """
    failures = [*under_way.plan.failures.items()]
    if not failures:
        return study
    tell = under_way.telling(FAILURES)
    tell(0, len(failures))
    for first in range(0, len(failures), _TOGETHER):
        some = failures[first : first + _TOGETHER]
        begun = [_begun(study, *one, under_way) for one in some]
        for one in _searched_together(begun, under_way, study):
            one = _confirmed(one, under_way)
            study = replace(study, failed_cases=(*study.failed_cases, one))
            tell(len(study.failed_cases), len(failures))
        under_way.write_down(study, Verification.write_failures)
    return study


def _begun(
    study: Verification, failure: FailureCase, case: AnalysisCase, under_way: Session
) -> FailedCase:
    """Return a failure case with its nominal run."""
    design = study.case
    [nominal] = _holding(failure, under_way)([{}], lambda *_: None)
    held = _held(design, nominal)
    # What is held for ever has no worst case: it does not separate whatever else is.
    objectives = () if held or not case.tolerances else _required(case, study)
    failed = replace(
        study,
        asked=replace(study.asked, case=case),
        objectives=objectives,
        runs=(measured(Nominal(), nominal, case, [*study.clearances.values()]),),
        searched=(),
        worst=(),
        growths=(),
        single_growths=(),
        failed_cases=(),
        campaign=None,
        missed={},
    )
    if not held:  # else of such a run a function may know nothing
        failed = told(failed)
    return FailedCase(failure=failure, study=failed, design=design, held=held)


def _is_searched(one: FailedCase) -> bool:
    """Return whether a failure case that has begun has worst cases."""
    return bool(one.study.objectives) and one.nominal.run.motion is not None


def _searched_together(
    begun: Sequence[FailedCase], under_way: Session, design: Verification
) -> list[FailedCase]:
    """Return failure cases with their worst cases, searched side by side."""
    searched = [one for one in begun if _is_searched(one)]
    kept = [under_way.kept(_part_of(one), Searched) for one in searched]
    if None in kept:  # round-off of a row is that of its place among all: all again
        kept = [None] * len(searched)
    found = side_by_side(
        [
            partial(_searched, one, under_way, design, known)
            for one, known in zip(searched, kept, strict=True)
        ],
        flown_together,
    )
    for one, known in zip(found, kept, strict=True):
        if known is None:
            under_way.keep(_part_of(one), one.study.searched)
    by_name = {one.failure.name: one for one in found}
    return [by_name.get(one.failure.name, one) for one in begun]


def _part_of(one: FailedCase) -> str:
    """Return the name of the part of a study that a failure case's searches are."""
    return f"failure_{one.failure.name}"


def _confirmed(one: FailedCase, under_way: Session) -> FailedCase:
    """Return a failure case with the runs in Drake of what may decide its verdict."""
    if not _is_searched(one):
        return one
    fly = _holding(one.failure, under_way)
    study = confirmed(one.study, fly, of=one.study.deciding)
    return replace(one, study=functions_compared(told(study)))


def _held(design: AnalysisCase, nominal: Run) -> tuple[str, ...]:
    """Return the bodies that leave in the design, and do not in a nominal run."""
    if nominal.motion is None:
        return ()
    separation, back = design.separation, nominal.held_back
    held = [
        attachment
        for attachment in separation.attachments
        if (attachment.lets_go and math.isinf(nominal.releases[attachment.name]))
        or (attachment.spring is not None and attachment.spring.name in back)
    ]
    return tuple(dict.fromkeys(map(separation.leaving_at, held)))


def _required(case: AnalysisCase, study: Verification) -> tuple[Objective, ...]:
    """Return the objectives that lead out of requirements, and ends of windows.

    Those that no run of the failure case tells are left out.
    """
    untold = {
        name
        for requirement in study.case.requirements
        if not requirement.measured_apart and not case.tells(requirement)
        for name in study.case.names_towards(requirement)
    }
    leads = {name for _, name in ways_out(study.case, study.functions)}
    leads |= {objective.name for objective in study.case.ends_of_windows}
    return tuple(o for o in study.objectives if o.name in leads - untold)


def _holding(failure: FailureCase, under_way: Session) -> Fly:
    """Return what flies variations of a failure case in Drake."""

    def fly(
        variations: Sequence[Mapping[str, float]],
        on_progress: Callable[[int, int], None],
    ) -> list[Run]:
        rows = [{**failure.values, **values} for values in variations]
        return under_way.pool.fly(rows, on_progress)

    return fly


def _worst_of_design(
    study: Verification, design: Verification
) -> dict[int, tuple[float, ...]]:
    """Return where each objective of a failure case is worst in the design, scaled.

    What has failed does not vary; the rest is drawn into the set that it leaves.
    """
    set_, names = study.case.tolerance_set, design.case.box.names
    free = [names.index(name) for name in set_.box.names]
    worst = {one.name: np.array(one.u)[free] for one in design.worst}
    return {
        k: tuple(set_.draw_back(worst[objective.name]).tolist())
        for k, objective in enumerate(study.objectives)
    }


def _searched(
    one: FailedCase,
    under_way: Session,
    design: Verification,
    known: Sequence[Searched] | None,
    ask: Ask,
) -> FailedCase:
    """Return a failure case with its worst cases.

    Args:
        one: with its nominal run.
        under_way: the session.
        design: with its worst cases.
        known: what came of the searches, if an earlier study has it.
        ask: flies what is searched.
    """
    study = one.study
    evaluator = under_way.evaluator_of(study.case, one.failure, study.objectives, ask)
    problem = Problem(
        tolerances=study.case.tolerance_set,
        evaluator=evaluator,
        likely=_worst_of_design(study, design),
    )
    names, settings = of_failure(
        under_way.effort.searches, under_way.settings, study.objectives
    )

    def search() -> Sequence[Searched]:
        sweeps = [name for name in names if name != FROM_BEST]
        done = search_for_worst(by_cost(problem)[0], sweeps, settings) if sweeps else []
        deciding = replace(problem, only=_deciding(study, problem, done))
        return search_for_worst(deciding, names, settings, finished=done)

    done = search() if known is None else known
    deciding = replace(problem, only=_deciding(study, problem, done))
    worst = judge(deciding, done)
    found = replace(study, searched=tuple(done), worst=tuple(worst))
    return replace(one, study=found)


def _deciding(
    study: Verification, problem: Problem, searched: Sequence[Searched]
) -> tuple[int, ...]:
    """Return the objectives that may decide a verdict, by what sweeps have found.

    Not the direction of a requirement in which it is by far from its limit: there it is
    followed to no end.
    """
    names = [objective.name for objective in study.objectives]
    values: dict[str, float] = {}
    for search in searched:
        for one in search.candidates if search.search != FROM_BEST else ():
            name = names[one.objective]
            values[name] = max(one.value, values.get(name, -math.inf))
    better = better_directions(study.case, values, _BY_FAR)
    return tuple(k for k in problem.asked if names[k] not in better)
