"""Variants of a case, one run each, and their table."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import pandas as pd

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.metrics.requirements import (
    Finding,
    Verdict,
    assess,
    verdict_on_all,
)
from drakesep.tables.columns import in_units
from drakesep.tables.roles import COMPLETED, Outcome
from drakesep.units import unit_of, with_unit


@dataclass(frozen=True, kw_only=True)
class Variant:
    """A run with other values of some parameters."""

    values: Mapping[str, float]
    """By parameter name, in SI."""
    metrics: Mapping[str, float] = field(default_factory=dict)
    """By name, in SI; empty if the run failed."""
    outcome: Outcome = COMPLETED
    """How it ended."""

    def findings(self, case: AnalysisCase) -> list[Finding]:
        """Return how the requirements of its case fare; none of a run that failed."""
        if self.outcome.failed:
            return []
        return assess(case.requirements, {_RUN: self.metrics}, _RUN)


_RUN = "variant"


def variants_table(variants: Sequence[Variant], case: AnalysisCase) -> pd.DataFrame:
    """Return a row for each variant: parameters, metrics, and how it fares.

    Args:
        variants: in their order.
        case: whose requirements they are held against.
    """
    told = next((v.metrics for v in variants if v.metrics), {})
    rows = []
    for number, variant in enumerate(variants, 1):
        findings = variant.findings(case)
        rows.append(
            {
                "variant": number,
                **in_units(variant.values),
                **in_units({k: variant.metrics.get(k, float("nan")) for k in told}),
                "verdict": _verdict(findings),
                "violated": "; ".join(map(_limit, _not_met(findings))),
                "status": str(variant.outcome),
            }
        )
    return pd.DataFrame(rows)


def _verdict(findings: Sequence[Finding]) -> str:
    """Return whether the run is within every limit."""
    if not findings:
        return ""
    return verdict_on_all(one.verdict_on_runs for one in findings).value


def _not_met(findings: Sequence[Finding]) -> list[Finding]:
    return [one for one in findings if one.verdict_on_runs is Verdict.NOT_MET]


def _limit(finding: Finding) -> str:
    """Return a limit in words."""
    required = finding.requirement
    limit = unit_of(required.metric).from_si(required.limit)
    return f"{with_unit(required.metric)} {required.sense} {limit:g}"
