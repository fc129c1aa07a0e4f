"""The command that proves what nothing within the tolerances is beyond: prove."""

from functools import partial
from typing import Annotated

import typer

from drakesep.cli.answer import Answer
from drakesep.cli.options import (
    CaseArgument,
    JsonOption,
    OutputOption,
    ProofSecondsOption,
    QuietOption,
    ResumeOption,
)
from drakesep.cli.results_folder import load, results_folder, say


def prove(
    case: CaseArgument,
    objectives: Annotated[
        list[str] | None,
        typer.Option(
            "--objective",
            help="Bounded beside the requirements: L1, L2, Linf, PM, or highest_ or "
            "lowest_ and a metric; can be repeated.",
        ),
    ] = None,
    gap_percent: Annotated[
        float | None,
        typer.Option(
            help="Of a bound beyond what is attained, at which it is good enough; 0.5 "
            "if not given."
        ),
    ] = None,
    proof_seconds: ProofSecondsOption = None,
    resume: ResumeOption = False,
    output: OutputOption = None,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Prove what nothing within the tolerances is beyond: proofs.csv, proof.json.

    Exits with 1 unless every requirement is proven to be met. What no bound covers is
    named, with its reason.
    """
    with Answer("prove", quiet=quiet, as_json=as_json) as answer:
        loaded = load(answer, case)
        from drakesep.cli.progress import progress_bar
        from drakesep.cli.proof_lines import print_proofs, print_proven
        from drakesep.cli.summaries import of_proofs
        from drakesep.studies import prove as studies

        given = {"gap_percent": gap_percent, "proof_seconds": proof_seconds}
        with (
            results_folder(output, loaded.name, "prove") as folder,
            progress_bar(answer.aside) as on_progress,
        ):
            study = studies.prove(
                loaded,
                objectives or (),
                output=folder,
                resume=resume,
                on_progress=on_progress,
                **{name: x for name, x in given.items() if x is not None},
            )
        summary = of_proofs(study, folder.path)
        say(answer, folder, summary, partial(print_proofs, study=study))
        print_proven(answer.console, study)
        if study.verdict not in (None, studies.PROVEN_MET):
            answer.not_well()
