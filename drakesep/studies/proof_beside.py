"""Proofs beside worst cases: what cannot be exceeded, on the same requirements."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.bounds.answers import (
    Found,
    Question,
    claims_of,
    proven_answers,
    questions_of,
)
from drakesep.analysis.bounds.branch_and_bound import Progress
from drakesep.analysis.bounds.proving import ProofSettings
from drakesep.analysis.metrics.functions import FunctionRequirement
from drakesep.analysis.metrics.objectives import highest
from drakesep.analysis.metrics.of_run import metric_of_run
from drakesep.analysis.metrics.registry import find_metric
from drakesep.studies.kept_proofs import KeptProofs
from drakesep.studies.proofs import Proofs
from drakesep.studies.verified import Verification
from drakesep.studies.worst_case.confirmation import may_differ
from drakesep.studies.worst_case.effort import PROOF
from drakesep.studies.worst_case.plan import StudyPlan
from drakesep.studies.worst_case.session import Session
from drakesep.systems.checks import InputError
from drakesep.tables.labelled_run import LabelledRun, nominal_of


def planned_with_proofs(
    plan: StudyPlan,
    settings: ProofSettings,
    functions: Sequence[FunctionRequirement] = (),
) -> StudyPlan:
    """Return a plan that tells how many bounds there will be.

    Args:
        plan: of the worst cases.
        settings: how hard to prove.
        functions: that are required beside the case's requirements.

    Raises:
        ValueError: nothing varies.
    """
    if not plan.case.tolerances:
        raise InputError("dispersions: a bound needs some, got none")
    questions = questions_of(plan.case, plan.objectives, functions)
    return replace(plan, proofs=len(claims_of(questions)), proof_settings=settings)


def with_proofs(study: Verification, under_way: Session) -> Verification:
    """Return a study with what is proven, from the worst cases that it has found.

    Args:
        study: with its worst cases, and their runs in Drake.
        under_way: the session that has found them.
    """
    plan = under_way.plan
    if plan.proof_settings is None:
        return study
    case = study.case
    questions = questions_of(case, study.objectives, study.functions)
    order = claims_of(questions)
    tell = under_way.telling(PROOF)

    def told(claim: str, _: Progress) -> None:
        tell(order.index(claim), len(order))

    kept = KeptProofs(plan.folder, order)
    bounds, answers = proven_answers(
        case,
        questions,
        plan.proof_settings,
        known=kept.known,
        on_proof=kept.keep,
        starts=[one.values for one in study.worst],
        runs=worst_of_runs(case, questions, study.runs),
        on_progress=told,
    )
    proofs = Proofs(
        asked=study.asked, answers=answers, bounds=bounds, functions=study.functions
    )
    return replace(study, proofs=proofs)


def worst_of_runs(
    case: AnalysisCase, questions: Sequence[Question], runs: Sequence[LabelledRun]
) -> Mapping[str, Found]:
    """Return the worst that runs within the tolerances have shown, by the claims.

    Published runs may be beyond the tolerances, and are left out.

    Args:
        case: that was flown.
        questions: of the case.
        runs: in Drake.
    """
    flown = [o for o in runs if o.run.motion is not None and o.published is None]
    nominal = nominal_of(runs)
    found = {}
    for question in questions:
        metric = find_metric(question.metric)
        if question.refused or metric is None or not metric[0].of_every_run:
            continue
        told = {one.label: _value(case, question.metric, one) for one in flown}
        values = {label: value for label, value in told.items() if math.isfinite(value)}
        if not values:
            continue
        farthest = max if question.side == "highest" else min
        label = farthest(values, key=values.__getitem__)
        value, objective = values[label], highest(question.metric)
        within = may_differ(objective, case, value, told[nominal.label])
        found[question.claim] = Found(value, label, within)
    return found


def _value(case: AnalysisCase, metric: str, one: LabelledRun) -> float:
    if metric in one.metrics:
        return one.metrics[metric]
    return metric_of_run(one.run, metric, case.limits_of_pairs)
