"""The statistical, the found and the proven answer, side by side, never confused."""

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

import pandas as pd

from drakesep.analysis.campaigns.shares import ShareFinding
from drakesep.analysis.metrics.functions import FunctionRequirement
from drakesep.analysis.metrics.requirements import Finding, Requirement
from drakesep.tables.proven_columns import beside_requirement
from drakesep.tables.requirement_tables import (
    identity_columns,
    limit_columns,
    unit_of_limit,
)
from drakesep.units import Unit


if TYPE_CHECKING:
    from drakesep.analysis.bounds.answers import ProvenAnswer


BY_CAMPAIGN, BY_WORST_CASE = "campaign", "worst case"
"""Whose verdict on a requirement it is."""


def answers_table(
    findings: Sequence[Finding],
    shares: Sequence[ShareFinding],
    missed: Mapping[Requirement, int],
    bodies: Sequence[str],
    functions: Sequence[FunctionRequirement] = (),
    failure_cases: Mapping[Requirement, str] = MappingProxyType({}),
    proven: "Mapping[Requirement, ProvenAnswer]" = MappingProxyType({}),
) -> pd.DataFrame:
    """Return a row for each requirement and axis: what draws, searches, proofs say.

    Args:
        findings: over the runs that searches have led to.
        shares: over the draws of a campaign; of functions of a run there is none.
        missed: draws that are worse than the worst case found, though searched.
        bodies: names of those that leave; that of the first pair is the first.
        functions: that are required, some of the findings are of them.
        failure_cases: of which the worst draws are, where something fails in them.
        proven: what is proven of requirements, if that was asked for.
    """
    by_draws = {one.requirement: one for one in shares}
    rows = []
    for finding in findings:
        requirement = finding.requirement
        unit = unit_of_limit(requirement, functions)
        rows.append(
            {
                **limit_columns(requirement, unit),
                "nominal": unit.from_si(finding.nominal),
                **_of_draws(
                    *(by_draws.get(requirement), finding, unit),
                    failure_cases.get(requirement, ""),
                ),
                "worst_case_found": unit.from_si(finding.worst),
                "which_run": finding.run,
                "missed_draw": missed.get(requirement),
                "by_worst_case": finding.verdict_on_runs.value,
                **beside_requirement(requirement, unit, proven),
                "decided_by": (
                    BY_CAMPAIGN if finding.decided_by_campaign else BY_WORST_CASE
                ),
                "verdict": finding.verdict.value,
                **identity_columns(requirement, bodies),
            }
        )
    frame = pd.DataFrame(rows)
    return frame.astype(dict.fromkeys(_WHOLE, "Int64"))


_WHOLE = ("failures", "allowed", "worst_draw", "missed_draw")
"""Columns of whole numbers that may be empty."""


def _of_draws(
    share: ShareFinding | None, finding: Finding, unit: Unit, failure_case: str
) -> dict[str, object]:
    """Return what a campaign says of a requirement; empty of what it does not judge."""
    if share is None:
        nothing = dict.fromkeys(("bound_of", "at_confidence", "bound"), math.nan)
        counts = dict.fromkeys(("failures", "allowed", "worst_draw"), None)
        rest = dict.fromkeys(("worst_of_draws", "worst_case_beyond_bound"), math.nan)
        words = {"worst_failure_case": "", "by_campaign": ""}
        return {**nothing, **counts, **rest, **words}
    sign = 1.0 if finding.requirement.from_above else -1.0
    return {
        "bound_of": share.size.share,
        "at_confidence": share.size.confidence,
        "bound": unit.from_si(share.bound),
        "failures": share.beyond,
        "allowed": share.size.allowed if finding.requirement.statistical else 0,
        "worst_of_draws": unit.from_si(share.worst),
        "worst_draw": share.draw_of_rank(1) if share.ranked else None,
        "worst_failure_case": failure_case,
        "worst_case_beyond_bound": unit.from_si(sign * (finding.worst - share.bound)),
        "by_campaign": share.verdict.value,
    }
