"""What the command line prints of a study: tables, what failed, the verdict."""

import math
from collections import Counter

import pandas as pd
from rich.console import Console

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.metrics.requirements import Verdict
from drakesep.cli.campaign_lines import NOT_SHOWN, print_answers
from drakesep.cli.console import print_frame, print_notes
from drakesep.cli.proof_lines import print_proofs, print_proven
from drakesep.cli.requirement_lines import growth_lines, requirement_lines
from drakesep.studies.clearance import Clearances
from drakesep.studies.remarks import notes_of
from drakesep.studies.simulate import Simulated
from drakesep.studies.sweep import Sweep
from drakesep.studies.verified import Verification
from drakesep.studies.worst_case.result import WorstCases
from drakesep.tables.labelled_run import nominal_of
from drakesep.tables.run_tables import metrics_table
from drakesep.units import with_unit


_VARIANTS = 50
"""Rows of a sweep that are printed."""
# Columns that are printed; the others are in the file.
_CLEARANCE = (
    *("first", "second", "clearance_mm", "time_s", "separation_mm"),
    *("contact_time_s", "closing_speed_m_s", "status"),
)
_EVIDENCE = (
    *("objective", "unit", "worst", "difference", "found_by", "run_by_run"),
    *("sqp", "vertices"),
    *("samples", "starts", "ended_there", "at_bounds", "optimality_residual"),
)


def print_simulated(console: Console, result: Simulated) -> None:
    """Print a run that did not fail: metrics, requirements, contacts, remarks."""
    if not result.completed:
        return
    metrics = metrics_table(result.labelled.metrics)
    print_frame(console, "Metrics of the run", metrics)
    if len(result.requirements):
        title = "Requirements in this run alone; over the tolerances, `verify` looks"
        lines = requirement_lines(result.requirements, _bodies(result.case))
        print_frame(console, title, lines, whole=True)
    if len(result.contacts):
        print_frame(console, "Parts that touch again", result.contacts)
    print_notes(console, notes_of(result.remarks, result.labelled.label))


def print_clearances(console: Console, study: Clearances) -> None:
    """Print how near the parts come, and remarks."""
    summary = study.summary
    shown = [name for name in _CLEARANCE if name in summary]
    print_frame(console, "Smallest clearances of the run", summary[shown])
    print_notes(console, notes_of(study.remarks, study.labelled.label))


def print_sweep(console: Console, study: Sweep) -> None:
    """Print the variants, with what is required of them, and remarks."""
    table = study.table
    required = [with_unit(r.judged_by) for r in study.case.requirements]
    shown = ["variant", *study.values, *required, "verdict"]
    if not required:
        shown = [str(name) for name in table if name not in ("verdict", "violated")]
    if not study.completed:
        shown.append("status")
    known = [name for name in dict.fromkeys(shown) if name in table]
    title = "Variants, one run each, without tolerances"
    if len(table) > _VARIANTS:
        title += f": the first {_VARIANTS} of {len(table)}; all are in sweep.csv"
    first = table[known].head(_VARIANTS)
    print_frame(console, title, first, index=1 + len(study.values))
    print_notes(console, notes_of(study.remarks, plain=""))


def print_worst_cases(console: Console, study: WorstCases) -> None:
    """Print the worst cases, with the evidence, and what failed."""
    if not study.comparison.empty:
        print_frame(console, "The paper's objectives", study.comparison)
    if study.looks_at_paper:
        print_frame(
            console,
            "Runs in the form of the paper's Table 4: M maximum, m minimum, Nom nominal"
            + ("; published values in parentheses" if study.case.published else ""),
            study.table_4,
        )
    if study.worst:
        print_frame(console, "Searches", study.searches)
        evidence = study.evidence
        shown = [name for name in _EVIDENCE if name in evidence]
        print_frame(console, "Worst cases, with the evidence", evidence[shown])
        if study.share_unphysical:
            console.print(
                f"{study.share_unphysical:.1%} of the tolerances are inertias that no "
                "body can have; no search goes there."
            )
    for one in study.runs:
        if not one.outcome.as_wanted:
            console.print(f"{one.label}: {one.status}", markup=False)
    for failed in study.failed_searches:
        console.print(failed, markup=False)
    print_notes(console, notes_of(study.remarks, nominal_of(study.runs).label))


def print_requirements(console: Console, study: Verification) -> None:
    """Print the worst cases, and the requirements with their margins."""
    print_worst_cases(console, study)
    frame, bodies = study.requirements, _bodies(study.case)
    if study.campaign is None:
        title = "Requirements over the tolerances"
        print_frame(console, title, requirement_lines(frame, bodies), whole=True)
    else:
        print_answers(console, study.answers, study.campaign)
    if study.proofs is not None:
        print_proofs(console, study.proofs)
    if study.growths:
        title = "How far tolerances may grow until a requirement is violated"
        print_frame(console, title, growth_lines(frame, bodies), whole=True)
    print_failure_cases(console, study)


_FAILURES = (
    *("failure_case", "verdict", "not_met", "beyond", "nearest", "worst", "limit"),
)


def print_failure_cases(console: Console, study: Verification) -> None:
    """Print what came of the failure cases, beside the design."""
    if not study.failed_cases:
        return
    frame = study.failure_cases
    names = frame[["nearest_requirement", "nearest_axis", "nearest_pair"]]
    bodies = _bodies(study.case)
    shown = frame.assign(
        nearest=[
            " ".join(filter(None, (what, axis)))
            + (f", {whose}" if whose and len(bodies) > 1 else "")
            for what, axis, whose in names.itertuples(index=False)
        ],
        worst=_with_units(frame, "nearest_worst"),
        limit=_with_units(frame, "nearest_limit"),
        not_met=[
            f"{n} of {m}"
            for n, m in zip(frame["not_met"], frame["requirements"], strict=True)
        ],
        beyond=[
            f"{n} of {m}"
            for n, m in zip(frame["beyond"], frame["requirements"], strict=True)
        ],
    )
    title = "Failure cases, with the requirement of the least margin in each"
    print_frame(console, title, shown[[*_FAILURES]], whole=True)
    shares = sum(one.requirement.statistical for one in study.findings)
    if shares:
        console.print(
            f"In a failure case {shares} of {len(study.findings)} requirements are not "
            "looked at: they are of a share of launches, which a campaign judges, that "
            "draws failures as probable as they are. `beyond` counts the limits beyond "
            "which the worst is that was flown."
        )


def _with_units(frame: pd.DataFrame, column: str) -> list[str]:
    """Return values with their units; nothing of none."""
    values = zip(frame[column], frame["nearest_unit"], strict=True)
    return ["" if math.isnan(x) else f"{x:.5g} {unit}".strip() for x, unit in values]


def _bodies(case: AnalysisCase) -> list[str]:
    """Return the names of the bodies that leave."""
    return [pair.B for pair in case.separation.pairs]


def print_verdict(console: Console, study: Verification) -> None:
    """Print the verdict, and what was not looked at."""
    if study.case.has_clearance and not study.clearances:
        console.print(
            "There is geometry, and no requirement of clearance_mm or no_contact: "
            "whether anything touches was not looked at."
        )
    if study.worst and not study.growths:
        console.print("How far tolerances may grow was not looked for: see --growth.")
    if study.case.failure_cases and not study.failed_cases:
        count = len(study.case.failure_cases)
        console.print(f"Failure cases were not looked at: {count}; see --failures.")
    if study.proofs is not None:
        print_proven(console, study.proofs)
    match study.verdict:
        case Verdict.MET.value:
            console.print(f"[bold green]Every requirement is met[/]{_how(study)}.")
        case Verdict.NOT_MET.value:
            console.print(f"[bold red]Not every requirement is met{_where(study)}.[/]")
        case Verdict.NOT_SHOWN.value:
            console.print(f"[bold red]{NOT_SHOWN}[/].")
        case Verdict.NOT_LOOKED_AT.value:
            console.print(
                f"[bold red]Not every requirement was looked at[/]: {_why_not(study)}"
            )
        case None:
            console.print(
                "[bold red]No verdict[/]: no run is beyond a limit, and not all could "
                "be flown or confirmed."
            )


def _how(study: Verification) -> str:
    """Return what shows that every requirement is met."""
    shown = sum(one.decided_by_campaign for one in study.findings)
    runs = (
        f" in all {len(study.runs)} runs flown in Drake, the worst cases of each among "
        f"them{_in_failures_too(study)}"
    )
    if not shown:
        return runs
    assert study.campaign is not None
    draws = f": the share of launches is shown of {shown} by {study.campaign.plan.runs}"
    others = len(study.findings) - shown
    return f"{draws} draws" + (
        f"; of the other {others} they are{runs}" if others else ""
    )


def _why_not(study: Verification) -> str:
    """Return why there is a requirement that was not looked at."""
    total = len(study.findings)
    unknown = sum(
        one.decided_by_campaign and one.verdict is Verdict.NOT_LOOKED_AT
        for one in study.findings
    )
    if not unknown:
        return "no run is beyond a limit, and some do not tell."
    if study.campaign is not None:
        return (
            f"of {unknown} of {total}, which are of a share of launches, no draw tells."
        )
    return (
        f"{unknown} of {total} are of a share of launches. The worst that was found of "
        "these is above; --campaign tells whether they are met."
    )


def _in_failures_too(study: Verification) -> str:
    count = len(study.failed_cases)
    return f", and in all {count} failure cases" if count else ""


def _where(study: Verification) -> str:
    """Return where not, if failure cases were looked at."""
    if not study.failed_cases:
        return ""
    verdicts = [one.verdict or "without verdict" for one in study.failed_cases]
    counts = ", ".join(f"{n} {verdict}" for verdict, n in Counter(verdicts).items())
    design = study.design_verdict or "without verdict"
    return f": the design is {design}; of {len(verdicts)} failure cases {counts}"
