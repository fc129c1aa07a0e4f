"""Tables of requirements, with margins, verdicts, and tolerances that violate them."""

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

import pandas as pd

from drakesep.analysis.metrics.clearances import CLEARANCE, NO_CONTACT
from drakesep.analysis.metrics.functions import FunctionRequirement
from drakesep.analysis.metrics.registry import find_metric
from drakesep.analysis.metrics.requirements import Finding, Requirement, Verdict
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.tables.proven_columns import beside_requirement
from drakesep.units import Unit, unit_of, with_unit


if TYPE_CHECKING:  # JAX comes with them
    from drakesep.analysis.bounds.answers import ProvenAnswer
    from drakesep.analysis.margins.tolerance_margins import Growth


def requirements_table(
    findings: Sequence[Finding],
    growths: "Sequence[tuple[Requirement, Growth]]" = (),
    single_growths: "Sequence[tuple[Requirement, Growth]]" = (),
    box: ToleranceBox | None = None,
    bodies: Sequence[str] = ("",),
    functions: Sequence[FunctionRequirement] = (),
    proven: "Mapping[Requirement, ProvenAnswer]" = MappingProxyType({}),
) -> pd.DataFrame:
    """Return a row for each requirement and axis, with its margins and verdict.

    Args:
        findings: of each requirement.
        growths: of all tolerances together.
        single_growths: of single tolerances.
        box: the tolerances, if they grow.
        bodies: names of those that leave; that of the first pair is the first.
        functions: that are required, some of the findings are of them.
        proven: what is proven of requirements, if that was asked for.
    """
    of_all = dict(growths)
    rows = []
    for finding in findings:
        requirement = finding.requirement
        unit = unit_of_limit(requirement, functions)
        growth = of_all.get(requirement)
        rows.append(
            {
                **limit_columns(requirement, unit),
                "nominal": unit.from_si(finding.nominal),
                "worst": unit.from_si(finding.worst),
                "which_run": finding.run,
                "margin": unit.from_si(finding.margin),
                "growth_factor": math.nan if growth is None else growth.factor,
                "growth_by": _how(growth),
                "looked_up_to": math.nan if growth is None else growth.looked_up_to,
                **_first_tolerance(finding, single_growths, box),
                **beside_requirement(requirement, unit, proven),
                "verdict": finding.verdict.value,
                **identity_columns(requirement, bodies),
            }
        )
    return pd.DataFrame(rows)


def limits_table(
    requirements: Sequence[Requirement], bodies: Sequence[str]
) -> pd.DataFrame:
    """Return a row for each requirement and axis, with its limit.

    Args:
        requirements: of a case.
        bodies: as `requirements_table` takes them.
    """
    return pd.DataFrame(
        {
            **limit_columns(requirement, unit_of(requirement.metric)),
            **identity_columns(requirement, bodies),
        }
        for requirement in requirements
    )


def requirements_of_run_table(
    findings: Sequence[Finding], bodies: Sequence[str]
) -> pd.DataFrame:
    """Return a row for each requirement and axis, with how one run alone fares.

    Args:
        findings: of each requirement in that run.
        bodies: names of those that leave; that of the first pair is the first.
    """
    rows = []
    for finding in findings:
        requirement = finding.requirement
        unit = unit_of(requirement.metric)
        rows.append(
            {
                **limit_columns(requirement, unit),
                "value": unit.from_si(finding.worst),
                "margin": unit.from_si(finding.margin),
                "verdict": finding.verdict_on_runs.value,
                **identity_columns(requirement, bodies),
            }
        )
    return pd.DataFrame(rows)


def tolerances_table(
    growths: "Sequence[tuple[Requirement, Growth]]",
    box: ToleranceBox,
    bodies: Sequence[str] = ("",),
    functions: Sequence[FunctionRequirement] = (),
) -> pd.DataFrame:
    """Return for each requirement and parameter the tolerance that would violate it.

    The others keep theirs. Infinite where no tolerance that was looked at does.

    Args:
        growths: of single tolerances.
        box: the tolerances.
        bodies: as `requirements_table` takes them.
        functions: that are required, some of the requirements are on them.
    """
    rows = []
    for requirement, growth in growths:
        i = growth.limit.parameter
        assert i is not None
        sides, from_si = box.dispersions[i].sides, unit_of(box.names[i]).from_si
        each = {"minus": from_si(sides.minus), "plus": from_si(sides.plus)}
        rows.append(
            {
                **limit_columns(requirement, unit_of_limit(requirement, functions)),
                "parameter": with_unit(box.names[i]),
                **each,
                # A side that is none stays so, however large the factor.
                **{
                    f"violated_{side}": size and size * growth.factor
                    for side, size in each.items()
                },
                "factor": growth.factor,
                "looked_up_to": growth.looked_up_to,
                "status": _how(growth) if math.isnan(growth.factor) else "",
                **identity_columns(requirement, bodies),
            }
        )
    return pd.DataFrame(rows)


def unit_of_limit(
    requirement: Requirement, functions: Sequence[FunctionRequirement]
) -> Unit:
    """Return the unit of a requirement's limit: of its function, or of its metric."""
    own = {function.name: Unit("", function.unit) for function in functions}
    return own.get(requirement.metric) or unit_of(requirement.metric)


def _how(growth: "Growth | None") -> str:
    """Return how it was looked how far tolerances may grow."""
    if growth is None or (math.isnan(growth.factor) and not growth.message):
        return Verdict.NOT_LOOKED_AT.value
    if math.isnan(growth.factor):
        return f"failed: {growth.message}"
    return "ray" if growth.along_ray else "search"


def limit_columns(requirement: Requirement, unit: Unit) -> dict[str, str | float]:
    """Return what a row says of a requirement first: what is limited, and how."""
    return {
        "requirement": _named(requirement),
        "axis": requirement.quantity[1],
        "unit": unit.symbol,
        "sense": requirement.sense,
        "limit": unit.from_si(requirement.limit),
        "share": math.nan if requirement.share is None else requirement.share,
        "confidence": (
            math.nan if requirement.confidence is None else requirement.confidence
        ),
        "sides": requirement.sides if requirement.statistical else "",
    }


def identity_columns(requirement: Requirement, bodies: Sequence[str]) -> dict[str, str]:
    """Return what a row says of a requirement last: whose it is, and where from."""
    return {
        "pair": _whose(requirement, bodies),
        "id": requirement.id,
        "source": requirement.source,
    }


def _whose(requirement: Requirement, bodies: Sequence[str]) -> str:
    """Return whose a requirement's metric is; empty if it is not that of one alone."""
    found = find_metric(requirement.metric)
    if found is None:  # a function of a run
        return ""
    metric, _ = found
    if not metric.of_every_run and not metric.to:
        return bodies[0] if len(bodies) == 1 else ""
    return metric.pair or bodies[0]


def _named(requirement: Requirement) -> str:
    """Return what is limited, in words: its quantity, or that nothing touches."""
    stem, _ = requirement.quantity
    if requirement.forbids_contact:
        stem = stem.replace(CLEARANCE, NO_CONTACT, 1)
    return stem.replace("_", " ").replace("+", " and ")


def _first_tolerance(
    finding: Finding,
    growths: "Sequence[tuple[Requirement, Growth]]",
    box: ToleranceBox | None,
) -> dict[str, str | float]:
    """Return the tolerance that violates a requirement with the least growth.

    Of one that is violated, the tolerance that restores it by shrinking least.
    """
    mine = [growth for r, growth in growths if r == finding.requirement]
    first = min(mine, key=lambda growth: growth.order, default=None)
    if first is None or box is None or math.isnan(first.factor):
        not_looked_at = Verdict.NOT_LOOKED_AT.value
        return {"first_tolerance": not_looked_at, "its_growth_factor": math.nan}
    if finding.verdict_on_runs is Verdict.NOT_MET:
        told = [growth for growth in mine if not math.isnan(growth.factor)]
        first = max(told, key=lambda growth: growth.factor)
        if not first.factor > 0.0:  # shrinking one is not enough
            return {"first_tolerance": "", "its_growth_factor": math.nan}
    name = ""
    if math.isfinite(first.factor) and first.limit.parameter is not None:
        name = with_unit(box.names[first.limit.parameter])
    return {"first_tolerance": name, "its_growth_factor": first.factor}
