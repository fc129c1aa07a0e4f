"""What the command line prints of a campaign."""

import pandas as pd
from rich.console import Console

from drakesep.analysis.metrics.requirements import Verdict
from drakesep.cli.console import print_frame
from drakesep.cli.requirement_lines import requirement_names_and_limits
from drakesep.studies.campaign.result import Campaign


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
    for one in study.findings:
        if one.measured is not None:
            console.print(
                f"{one.requirement.metric}: measured in {one.measured} draws; the "
                "others are proven not to come as near as decides it.",
                markup=False,
            )
    failed = len(study.failures)
    if failed:
        first = next(iter(study.failures.items()))
        console.print(
            f"{failed} runs failed, and count as beyond every limit; first draw "
            f"{first[0]}: {first[1]}",
            markup=False,
        )
    again = study.flown.attempts.sum() / (study.flown.attempts.sum() + len(study.flown))
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
            console.print(
                "[bold red]Not shown of every requirement[/]: neither that it is met, "
                "nor that it is not."
            )
        case Verdict.NOT_LOOKED_AT.value:
            console.print("[bold red]Not every requirement was looked at.[/]")
