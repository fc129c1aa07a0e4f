"""The command that checks a certificate of proven bounds: check-proof."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drakesep.cli.answer import Answer
from drakesep.cli.options import JsonOption, QuietOption, WorkersOption


if TYPE_CHECKING:
    from rich.console import Console

    from drakesep.studies.proof_check import ProofCheck


def check_proof(
    certificate: Annotated[
        Path,
        typer.Argument(metavar="FILE", help="A certificate: proof.json of a folder."),
    ],
    workers: WorkersOption = None,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Check a certificate of proven bounds, by code that the prover does not share.

    Exits with 1 unless every claim is verified. Needs python-flint, which the extra
    `proof` installs.
    """
    with Answer("check-proof", quiet=quiet, as_json=as_json) as answer:
        from drakesep.cli.progress import progress_bar
        from drakesep.cli.summaries import of_proof_check
        from drakesep.studies import proof_check

        with progress_bar(answer.aside) as on_progress:
            found = proof_check.check_certificate(
                certificate, workers=workers, on_progress=on_progress
            )
        answer.add(**vars(of_proof_check(found)))
        _print(answer.console, found)
        if not found.verified:
            answer.not_well()


def _print(console: "Console", found: "ProofCheck") -> None:
    from drakesep.cli.console import print_frame

    title = "For all values of these together, inertias that no body can have too (SI)"
    print_frame(console, title, found.parameters, digits=9, whole=True)
    for claim in found.claims:
        words = f"NOT VERIFIED: {claim.claim}: {claim.failure} ({claim.says})"
        if claim.verified:
            more = f"{claim.nodes} nodes; {claim.reaches:.9g} is reached"
            words = f"verified: {claim.claim}: {claim.says} ({more})"
        console.print(words, markup=False, highlight=False)
    if found.verified:
        console.print("[bold green]Every claim is verified.[/]")
        return
    verified = sum(claim.verified for claim in found.claims)
    console.print(f"[bold]{verified} of {len(found.claims)} claims are verified.[/]")
