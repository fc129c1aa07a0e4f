"""What the command line prints of a campaign."""

from collections.abc import Sequence

import pandas as pd
from rich.console import Console

from drakesep.analysis.campaigns.shares import ShareFinding
from drakesep.analysis.metrics.requirements import Verdict
from drakesep.cli.console import print_frame
from drakesep.cli.requirement_lines import requirement_names_and_limits
from drakesep.studies.campaign.result import Campaign


NOT_SHOWN = "Not shown of every requirement: neither that it is met, nor that it is not"


TOGETHER = (
    "the share is between two limits, which are counted together: failures, allowed, "
    "share shown and verdict are of both, bound and worst draw of each by itself."
)


def together(findings: Sequence[ShareFinding]) -> list[str]:
    """Return what is required between two limits together, by names, each once."""
    return list(
        dict.fromkeys(one.requirement.metric for one in findings if one.together)
    )


def worst_in(study: Campaign) -> dict[str, list[str]]:
    """Return the requirements whose worst draws are of failure cases, by these."""
    found: dict[str, list[str]] = {}
    for requirement, case in study.worst_failure_cases.items():
        names = found.setdefault(case, [])
        if requirement.metric not in names:
            names.append(requirement.metric)
    return found


def print_answers(console: Console, frame: pd.DataFrame, study: Campaign) -> None:
    """Print what draws and worst cases say of each requirement, side by side.

    Args:
        console: of the command.
        frame: as `answers_table` has it.
        study: the campaign.
    """
    bodies = [pair.B for pair in study.case.separation.pairs]
    lines = pd.DataFrame(
        {
            **requirement_names_and_limits(frame, bodies),
            "nominal": frame["nominal"],
            "bound": frame["bound"],
            "worst draw": frame["worst_of_draws"],
            "worst case": frame["worst_case_found"],
            "by draws": frame["by_campaign"],
            "by worst case": frame["by_worst_case"],
            "decides": frame["decided_by"],
        }
    )
    title = (
        f"Requirements: the bound by {study.plan.runs} draws, and the worst case found"
    )
    print_frame(console, title, lines, whole=True)
    print_oddities(console, study)
    kinds = {(one.size.share, one.size.confidence) for one in study.findings}
    for share, confidence in sorted(kinds):
        console.print(
            f"Bound: at a confidence of {100.0 * confidence:.10g} %, "
            f"{100.0 * share:.10g} % of launches are no worse. Worst case: the worst "
            "that searches have found within the tolerances."
        )


def print_campaign(console: Console, study: Campaign) -> None:
    """Print what share is shown of each requirement, and the verdict."""
    bodies = [pair.B for pair in study.case.separation.pairs]
    frame = study.requirements
    if len(frame):
        lines = pd.DataFrame(
            {
                **requirement_names_and_limits(frame, bodies),
                "share": frame["share"],
                "failures": frame["failures"],
                "allowed": frame["allowed"],
                "shown": frame["share_shown"],
                "bound": frame["bound"],
                "worst": frame["worst"],
                "verdict": frame["verdict"],
            }
        )
        title = f"Shares of launches within limits, by {study.plan.runs} draws"
        print_frame(console, title, lines, whole=True)
    print_oddities(console, study)


def print_oddities(console: Console, study: Campaign) -> None:
    """Print what is counted together and measured, what failed, and what cannot be."""
    for name in together(study.findings):
        console.print(f"{name}: {TOGETHER}", markup=False)
    for one in study.findings:
        if one.measured is not None:
            console.print(
                f"{one.requirement.metric}: measured in {one.measured} draws; the "
                "others are proven not to come as near as decides it.",
                markup=False,
            )
    for case, names in worst_in(study).items():
        console.print(
            f"In the worst draws the failure case {case} happens, of: "
            f"{', '.join(names)}; the design's worst case is without failures.",
            markup=False,
        )
    failed = study.flown.failed
    if failed:
        first = next(iter(study.failures.items()))
        console.print(
            f"{failed} runs failed, and count as beyond every limit; first draw "
            f"{first[0]}: {first[1]}",
            markup=False,
        )
    again = study.flown.again / (study.flown.again + len(study.flown))
    if again:
        console.print(
            f"{again:.1%} of all values drawn cannot be, and were drawn again."
        )


def print_shown(console: Console, study: Campaign) -> None:
    """Print the verdict, and what no campaign can show."""
    if study.of_every_run:
        console.print(
            f"Of every run are {study.of_every_run} of {len(study.findings)} "
            "requirements, which no campaign shows: `verify` looks for the worst; "
            "--share 0.99865 --confidence 0.9 asks for three sigma."
        )
    flown = len({one.draw for one in study.confirmed})
    match study.verdict:
        case Verdict.MET.value:
            console.print(
                "[bold green]The share is shown of every requirement[/]; Drake "
                f"confirms {flown} draws, those that decide among them."
            )
        case Verdict.NOT_MET.value:
            console.print("[bold red]Not every requirement is met.[/]")
        case Verdict.NOT_SHOWN.value:
            console.print(f"[bold red]{NOT_SHOWN}[/].")
        case Verdict.NOT_LOOKED_AT.value:
            console.print("[bold red]Not every requirement was looked at.[/]")
