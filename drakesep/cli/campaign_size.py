"""The command that tells how many runs a campaign needs: campaign size."""

from typing import Annotated

import typer

from drakesep.cli.answer import Answer
from drakesep.cli.options import JsonOption, QuietOption


_MOST_FAILURES = 5
"""Up to so many are told, if nothing is said of failures or runs."""


def size(
    share: Annotated[
        float,
        typer.Option(
            help="Of launches that must be within the limit, such as 0.99865: 3 sigma "
            "of a normal distribution to one side; to two it is 0.9973."
        ),
    ],
    confidence: Annotated[
        float,
        typer.Option(help="At which that is to be shown: 1 less the consumer's risk."),
    ] = 0.9,
    failures: Annotated[
        int | None,
        typer.Option(help="Runs that may be beyond the limit; 0 to 5 if not given."),
    ] = None,
    runs: Annotated[
        int | None,
        typer.Option(help="Of the campaign; what it shows is told instead."),
    ] = None,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Tell how many runs show a share of launches, or what so many runs show.

    Nothing is flown. Exits with 1 if so few runs show nothing, even without a failure.
    """
    with Answer("campaign size", quiet=quiet, as_json=as_json) as answer:
        from drakesep.analysis.campaigns.order_statistics import (
            CampaignSize,
            runs_needed,
        )
        from drakesep.cli.console import print_frame
        from drakesep.systems.checks import InputError
        from drakesep.tables.campaign_sizes import sizes_table

        if failures is not None and runs is not None:
            raise InputError("--failures and --runs: must be one of them, got both")
        allowed = range(_MOST_FAILURES + 1) if failures is None else [failures]
        wanted = (
            [runs_needed(share, confidence, each) for each in allowed]
            if runs is None
            else [runs]
        )
        sizes = [
            CampaignSize(share=share, confidence=confidence, runs=each)
            for each in wanted
        ]
        table = sizes_table(sizes)
        rows = table.astype(object).where(table.notna(), None).to_dict("records")
        answer.add(share=share, confidence=confidence, sizes=rows)
        per_cent, surely = f"{100.0 * share:.10g} %", f"{100.0 * confidence:.10g} %"
        if sizes[0].allowed is None:
            least = runs_needed(share, confidence)
            answer.itself.print(
                f"{runs} runs show nothing of {per_cent} of launches at a confidence "
                f"of {surely}: {least} are needed, of which none may fail."
            )
            answer.not_well()
            return
        title = f"Runs that show {per_cent} of launches at a confidence of {surely}"
        print_frame(answer.itself, title, table, digits=8)
        answer.itself.print(
            f"A design with share_that_passes passes with a chance of {surely}."
        )
