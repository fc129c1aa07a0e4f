"""Commands on distributions of metrics: campaign sensitivity, campaign rare-events."""

from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from drakesep.cli.answer import Answer
from drakesep.cli.options import CaseArgument, JsonOption, OutputOption, QuietOption
from drakesep.cli.results_folder import load, results_folder, say


if TYPE_CHECKING:
    from rich.console import Console

    from drakesep.studies.rare_events import RareEvents
    from drakesep.studies.sensitivity import Sensitivity


SeedOption = Annotated[int, typer.Option(min=0, help="Of what is drawn at random.")]
_SHOWN = 0.01
"""Shares of the variance that are printed: of less, all are in the file."""


def sensitivity(
    case: CaseArgument,
    metrics: Annotated[
        list[str] | None,
        typer.Option(
            "--metric",
            help="Whose variance is shared out; can be repeated. If not given, those "
            "of the requirements.",
        ),
    ] = None,
    base: Annotated[
        int, typer.Option(help="Points of a replicate, a power of two.")
    ] = 512,
    replicates: Annotated[
        int, typer.Option(help="By what they differ, errors are told.")
    ] = 10,
    seed: SeedOption = 0,
    output: OutputOption = None,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Tell which parameters the variance of metrics comes from: sobol_indices.csv.

    Sobol' indices; of independent parameters alone.
    """
    with Answer("campaign sensitivity", quiet=quiet, as_json=as_json) as answer:
        loaded = load(answer, case)
        from drakesep.cli.progress import progress_bar
        from drakesep.cli.summaries import of_sensitivity
        from drakesep.studies import sensitivity as studies

        with (
            results_folder(output, loaded.name, "sensitivity") as folder,
            progress_bar(answer.aside) as on_progress,
        ):
            study = studies.sensitivity(
                loaded,
                metrics or (),
                base=base,
                replicates=replicates,
                seed=seed,
                output=folder,
                on_progress=on_progress,
            )
        summary = of_sensitivity(study, folder.path)
        say(answer, folder, summary, partial(_print_sensitivity, study=study))
        if study.failure:
            answer.fail(study.failure)


def rare_events(
    case: CaseArgument,
    requirements: Annotated[
        list[str] | None,
        typer.Option(
            "--requirement",
            help="By its id, or by the metric that judges it; can be repeated. If not "
            "given, all that runs tell.",
        ),
    ] = None,
    per_level: Annotated[
        int, typer.Option(help="Draws of each simulation at each level.")
    ] = 1800,
    replicates: Annotated[
        int, typer.Option(help="Simulations; by what they differ, errors are told.")
    ] = 10,
    least: Annotated[
        float, typer.Option(help="Probability below which none is looked for.")
    ] = 1e-9,
    seed: SeedOption = 0,
    output: OutputOption = None,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Tell how improbable it is to be beyond each limit: rare_events.csv.

    By subset simulation, where to count would take millions of launches.
    """
    with Answer("campaign rare-events", quiet=quiet, as_json=as_json) as answer:
        loaded = load(answer, case)
        from drakesep.cli.progress import progress_bar
        from drakesep.cli.summaries import of_rare_events
        from drakesep.studies import rare_events as studies

        with (
            results_folder(output, loaded.name, "rare-events") as folder,
            progress_bar(answer.aside) as on_progress,
        ):
            study = studies.rare_events(
                loaded,
                requirements or (),
                per_level=per_level,
                replicates=replicates,
                least=least,
                seed=seed,
                output=folder,
                on_progress=on_progress,
            )
        summary = of_rare_events(study, folder.path)
        say(answer, folder, summary, partial(_print_rare_events, study=study))
        if study.failure:
            answer.fail(study.failure)


def _print_sensitivity(console: "Console", study: "Sensitivity") -> None:
    """Print the shares that matter."""
    from drakesep.cli.console import print_frame

    frame = study.table
    title = (
        f"Sobol' indices by {study.indices.runs} runs: parameters with a total share "
        "of one per cent or more"
    )
    print_frame(console, title, frame[frame["total"] >= _SHOWN], whole=True)


def _print_rare_events(console: "Console", study: "RareEvents") -> None:
    """Print the probabilities, with their intervals."""
    import pandas as pd

    from drakesep.cli.console import print_frame
    from drakesep.cli.requirement_lines import requirement_names_and_limits

    frame = study.table
    bodies = [pair.B for pair in study.case.separation.pairs]
    lines = pd.DataFrame(
        {
            **requirement_names_and_limits(frame, bodies),
            **{name: frame[name] for name in ("probability", "from", "to")},
            "unreached": [
                f"{n} of {m}"
                for n, m in zip(frame["unreached"], frame["simulations"], strict=True)
            ],
            "runs": frame["runs"],
        }
    )
    title = "Probabilities to be beyond limits, with intervals at 95 %"
    print_frame(console, title, lines, digits=3, whole=True)
    if frame["unreached"].any():
        console.print(
            "What simulations have not reached is no more probable than told, as far "
            "as they have looked."
        )
