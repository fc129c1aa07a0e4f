"""What `--json` says of what a command has done: of each, the keys and their meaning.

Rows of tables are objects by the columns of the CSV files, whose meaning is that of
`drakesep.results.catalogue`.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import pandas as pd

from drakesep.analysis.tolerances.box import Dispersion
from drakesep.case_file.case import Case
from drakesep.reports.compare import Comparison
from drakesep.studies.campaign.result import Campaign
from drakesep.studies.clearance import Clearances
from drakesep.studies.proof_check import ProofCheck
from drakesep.studies.proofs import CERTIFICATE, Proofs
from drakesep.studies.rare_events import RareEvents
from drakesep.studies.remarks import notes_of
from drakesep.studies.sensitivity import Sensitivity
from drakesep.studies.simulate import Simulated
from drakesep.studies.sweep import Sweep
from drakesep.studies.verified import Verification
from drakesep.studies.worst_case.result import WorstCases
from drakesep.systems.model.parameters import parameters
from drakesep.tables.columns import distribution_text, in_units
from drakesep.tables.failure_tables import changed_text
from drakesep.tables.labelled_run import nominal_of
from drakesep.units import unit_of, with_unit


Row: TypeAlias = dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class CasesSummary:
    """Of `cases`."""

    cases: list[Row]
    """`case` and `description` of each."""


@dataclass(frozen=True, kw_only=True)
class NewSummary:
    """Of `new`."""

    case: str
    """Its name."""
    file: str
    """That has been written."""


@dataclass(frozen=True, kw_only=True)
class ShowSummary:
    """Of `show`."""

    case: str
    """Its name."""
    description: str
    """A line."""
    pairs: list[Row]
    """`A`, `B` and `direction` of each."""
    bodies: list[str]
    """Their names."""
    attachments: list[Row]
    """`attachment`, `A`, `B`, `joint` and `spring` of each; null: it has no spring."""
    parameters: list[Row]
    """`parameter`, `value`, `tolerance` and `distribution` of each, in the unit of its
    name; the last two are null of what is not dispersed."""
    correlations: list[Row]
    """`of` and `rank` of each, of dispersed parameters in a campaign."""
    requirements: list[Row]
    """`quantity`, `sense`, `limit`, `share`, `confidence`, `sides` and `id` of each
    limit; a share of null: every run must be within it."""
    failure_cases: list[Row]
    """`failure_case`, `changed` and `probability` of each; null: it does not happen in
    a campaign."""
    notes: list[str]
    """What should be known of it."""


@dataclass(frozen=True, kw_only=True)
class StudySummary:
    """Of every study."""

    case: str
    """Its name."""
    folder: str
    """That has the results."""
    verdict: str | None
    """`met`, `not met`, `not shown`, `not looked at`; `clear`, `contact`; `proven met`,
    `not proven`; null: there is none."""
    notes: list[str]
    """What should be known of the runs; each begins with the label of another run than
    the nominal, or than the one that was flown."""


@dataclass(frozen=True, kw_only=True)
class SimulateSummary(StudySummary):
    """Of `simulate`, and of `replay`."""

    status: str
    """How the run ended."""
    metrics: dict[str, float | None]
    """Of the run, by names with units; null: not a number."""
    requirements: list[Row]
    """Rows of requirements_of_run.csv."""
    contacts: list[Row]
    """Rows of contacts.csv."""


@dataclass(frozen=True, kw_only=True)
class SweepSummary(StudySummary):
    """Of `sweep`."""

    engine: str
    """`drake` or `batch`: that has flown the variants."""
    variants: list[Row]
    """Rows of sweep.csv."""


@dataclass(frozen=True, kw_only=True)
class ClearanceSummary(StudySummary):
    """Of `clearance`."""

    clearances: list[Row]
    """Rows of clearance_summary.csv."""


@dataclass(frozen=True, kw_only=True)
class WorstCaseSummary(StudySummary):
    """Of `worst-case`."""

    worst_cases: list[Row]
    """Rows of evidence.csv."""
    runs: list[Row]
    """Rows of worst_cases.csv."""


@dataclass(frozen=True, kw_only=True)
class VerifySummary(WorstCaseSummary):
    """Of `verify`."""

    requirements: list[Row]
    """Rows of requirements.csv."""
    answers: list[Row]
    """Rows of answers.csv; empty if no campaign was flown."""
    proofs: list[Row]
    """Rows of proofs.csv; empty without `--prove`."""
    failure_cases: list[Row]
    """Rows of failure_cases.csv; empty if they were not looked at."""
    report: str | None
    """The page that `--report` asks for; null: it was not asked for."""


@dataclass(frozen=True, kw_only=True)
class ProveSummary(StudySummary):
    """Of `prove`."""

    proofs: list[Row]
    """Rows of proofs.csv."""
    certificate: str | None
    """That `drakesep check-proof` checks; null: nothing is proven."""


@dataclass(frozen=True, kw_only=True)
class CampaignSummary(StudySummary):
    """Of `campaign`, and of `campaign merge`."""

    runs: int
    """Draws."""
    failed: int
    """Of them, that failed and count as beyond every limit."""
    requirements: list[Row]
    """Rows of campaign.csv."""


@dataclass(frozen=True, kw_only=True)
class SensitivitySummary(StudySummary):
    """Of `campaign sensitivity`."""

    runs: int
    """That it took."""
    indices: list[Row]
    """Rows of sobol_indices.csv."""


@dataclass(frozen=True, kw_only=True)
class RareEventsSummary(StudySummary):
    """Of `campaign rare-events`."""

    rare_events: list[Row]
    """Rows of rare_events.csv."""


@dataclass(frozen=True, kw_only=True)
class AnimateSummary:
    """Of `animate`."""

    case: str
    """Its name."""
    file: str
    """The page."""
    runs: list[str]
    """Labels of what it shows."""


@dataclass(frozen=True, kw_only=True)
class CheckProofSummary:
    """Of `check-proof`."""

    certificate: str
    """The file."""
    verified: bool
    """Whether every claim is."""
    claims: list[Row]
    """`claim`, `says` (in words, with bound and unit), `bound`, `reaches` (what is
    surely attained), `nodes` and `failure` of each, in SI; a failure of null: it is
    verified."""
    parameters: list[Row]
    """`parameter`, `from` and `to` of each, in SI: the claims are of all values
    together."""


@dataclass(frozen=True, kw_only=True)
class CompareSummary:
    """Of `compare`."""

    first: str
    """Folder of the one study."""
    second: str
    """Folder of the other."""
    same: bool
    """Whether no answer differs by more than the tolerance; without one, at all."""
    inputs: list[Row]
    """What changed in what was asked: `where`, `row`, `column`, `first`, `second`, of
    numbers `difference` and `relative_difference`, and `beyond`, whether that is more
    than is tolerated."""
    answers: list[Row]
    """What changed in what was found, likewise."""


@dataclass(frozen=True, kw_only=True)
class ReportSummary:
    """Of `report`."""

    case: str
    """Its name."""
    file: str
    """The page."""
    pdf: str | None
    """The page as PDF; null: it was not asked for."""
    folders: list[str]
    """That it tells of."""
    verdict: str
    """On everything that it tells of: `met`, `not met`, `not shown`, `not looked at`,
    `no verdict`."""
    checked: list[Row]
    """`folder`, `same` and `differences` of each, done again with `--check`; empty if
    that was not asked for."""


@dataclass(frozen=True, kw_only=True)
class ExportSummary:
    """Of `export`."""

    files: list[str]
    """That have been written; the last is the table of the handover."""


SUMMARIES: dict[str, type[Any]] = {
    "cases": CasesSummary,
    "new": NewSummary,
    "show": ShowSummary,
    "simulate": SimulateSummary,
    "sweep": SweepSummary,
    "clearance": ClearanceSummary,
    "campaign": CampaignSummary,
    "campaign sensitivity": SensitivitySummary,
    "campaign rare-events": RareEventsSummary,
    "replay": SimulateSummary,
    "animate": AnimateSummary,
    "worst-case": WorstCaseSummary,
    "verify": VerifySummary,
    "prove": ProveSummary,
    "check-proof": CheckProofSummary,
    "compare": CompareSummary,
    "report": ReportSummary,
    "export": ExportSummary,
}
"""By commands."""


def of_cases(cases: Iterable[Case]) -> CasesSummary:
    """Return the summary of built-in cases."""
    rows = [{"case": one.name, "description": one.description} for one in cases]
    return CasesSummary(cases=rows)


def _tolerance(dispersion: Dispersion) -> float | dict[str, float]:
    """Return a tolerance in its unit; both sides, where they differ."""
    sides, from_si = dispersion.sides, unit_of(dispersion.name).from_si
    if sides.symmetric:
        return from_si(sides.plus)
    return {"minus": from_si(sides.minus), "plus": from_si(sides.plus)}


def of_case(case: Case) -> ShowSummary:
    """Return the summary of a case; without notes."""
    separation, record = case.separation, case.in_si()
    dispersed = {with_unit(d.name): d for d in case.box.dispersions}
    tolerances = {name: _tolerance(d) for name, d in dispersed.items()}
    distributions = {name: distribution_text(d) for name, d in dispersed.items()}
    values = in_units(parameters(separation))
    return ShowSummary(
        case=case.name,
        description=case.description,
        pairs=[
            {"A": pair.A, "B": pair.B, "direction": pair.direction}
            for pair in separation.pairs
        ],
        bodies=[body.name for body in separation.bodies],
        attachments=[
            {
                "attachment": one.name,
                "A": one.A,
                "B": one.B,
                "joint": one.joint.type,
                "spring": one.spring.name if one.spring else None,
            }
            for one in separation.attachments
        ],
        parameters=[
            {
                "parameter": name,
                "value": value,
                "tolerance": tolerances.get(name),
                "distribution": distributions.get(name),
            }
            for name, value in values.items()
        ],
        correlations=[
            {"of": [with_unit(name) for name in one.names], "rank": one.rank}
            for one in record.correlations
        ],
        requirements=[
            {
                "quantity": with_unit(one.metric),
                "sense": one.sense,
                "limit": unit_of(one.metric).from_si(one.limit),
                "share": one.share,
                "confidence": one.confidence,
                "sides": one.sides if one.statistical else "",
                "id": one.id,
            }
            for one in case.limits
        ],
        failure_cases=[
            {
                "failure_case": one.name,
                "changed": changed_text(one.values),
                "probability": record.failure_probabilities.get(one.name),
            }
            for one in record.failure_cases
        ],
        notes=[],
    )


def of_simulated(result: Simulated, folder: Path) -> SimulateSummary:
    """Return the summary of a run."""
    return SimulateSummary(
        case=result.case.name,
        folder=str(folder),
        verdict=None,
        notes=notes_of(result.remarks, result.labelled.label),
        status=result.labelled.status,
        metrics=dict(in_units(result.labelled.metrics)),
        requirements=_rows(result.requirements),
        contacts=_rows(result.contacts) if result.completed else [],
    )


def of_sweep(study: Sweep, folder: Path) -> SweepSummary:
    """Return the summary of variants."""
    return SweepSummary(
        case=study.case.name,
        folder=str(folder),
        verdict=None,
        notes=notes_of(study.remarks, plain=""),
        engine=study.engine,
        variants=_rows(study.table),
    )


def of_campaign(study: Campaign, folder: Path) -> CampaignSummary:
    """Return the summary of a campaign."""
    return CampaignSummary(
        case=study.case.name,
        folder=str(folder),
        verdict=study.verdict,
        notes=[],
        runs=study.plan.runs,
        failed=study.flown.failed,
        requirements=_rows(study.requirements),
    )


def of_sensitivity(study: Sensitivity, folder: Path) -> SensitivitySummary:
    """Return the summary of Sobol' indices."""
    return SensitivitySummary(
        case=study.case.name,
        folder=str(folder),
        verdict=None,
        notes=[],
        runs=study.indices.runs,
        indices=_rows(study.table),
    )


def of_rare_events(study: RareEvents, folder: Path) -> RareEventsSummary:
    """Return the summary of rare events."""
    return RareEventsSummary(
        case=study.case.name,
        folder=str(folder),
        verdict=None,
        notes=[],
        rare_events=_rows(study.table),
    )


def of_proofs(study: Proofs, folder: Path) -> ProveSummary:
    """Return the summary of what is proven."""
    file = folder / CERTIFICATE
    return ProveSummary(
        case=study.case.name,
        folder=str(folder),
        verdict=study.verdict,
        notes=[],
        proofs=_rows(study.table),
        certificate=str(file) if file.exists() else None,
    )


def of_proof_check(found: ProofCheck) -> CheckProofSummary:
    """Return the summary of a certificate that was checked."""
    claims = [
        {**vars(claim), "failure": claim.failure or None} for claim in found.claims
    ]
    return CheckProofSummary(
        certificate=str(found.certificate),
        verified=found.verified,
        claims=claims,
        parameters=_rows(found.parameters),
    )


def of_clearances(study: Clearances, folder: Path) -> ClearanceSummary:
    """Return the summary of how near parts come."""
    return ClearanceSummary(
        case=study.case.name,
        folder=str(folder),
        verdict="clear" if study.clear else "contact",
        notes=notes_of(study.remarks, study.labelled.label),
        clearances=_rows(study.summary),
    )


def of_worst_cases(study: WorstCases, folder: Path) -> WorstCaseSummary:
    """Return the summary of worst cases."""
    return WorstCaseSummary(
        case=study.case.name,
        folder=str(folder),
        verdict=study.verdict,
        notes=notes_of(study.remarks, nominal_of(study.runs).label),
        worst_cases=_rows(study.evidence) if study.worst else [],
        runs=_rows(study.table),
    )


def of_verification(
    study: Verification, folder: Path, report: Path | None = None
) -> VerifySummary:
    """Return the summary of a verdict."""
    return VerifySummary(
        **vars(of_worst_cases(study, folder)),
        requirements=_rows(study.requirements),
        answers=_rows(study.answers) if study.campaign else [],
        proofs=_rows(study.proofs.table) if study.proofs else [],
        failure_cases=_rows(study.failure_cases) if study.failed_cases else [],
        report=None if report is None else str(report),
    )


def of_comparison(found: Comparison) -> CompareSummary:
    """Return the summary of what changed."""
    return CompareSummary(
        first=str(found.first),
        second=str(found.second),
        same=found.same,
        inputs=_rows(found.inputs.drop(columns="kind")),
        answers=_rows(found.answers.drop(columns="kind")),
    )


def _rows(frame: pd.DataFrame) -> list[Row]:
    """Return the rows of a table; None where it is empty."""
    filled = frame.astype(object).where(frame.notna(), None)
    return [{str(k): x for k, x in row.items()} for row in filled.to_dict("records")]
