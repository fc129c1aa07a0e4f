"""Commands of campaigns: fly one at once; or plan it, fly its chunks, merge them."""

import contextlib
from collections.abc import Iterator
from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from drakesep.cli.answer import Answer
from drakesep.cli.campaign_distributions import rare_events, sensitivity
from drakesep.cli.campaign_size import size
from drakesep.cli.options import (
    CaseArgument,
    ConfidenceOption,
    JsonOption,
    OutputOption,
    QuietOption,
    ShareOption,
)
from drakesep.cli.results_folder import load, results_folder, say


if TYPE_CHECKING:
    from drakesep.studies.campaign.result import Campaign


RUN = "run"


class RunByDefault(TyperGroup):
    """A group of commands, of which `run` is meant where none of them is named."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Put `run` before what is no command of the group."""
        if args and args[0] not in (*self.commands, "--help"):
            args = [RUN, *args]
        return super().parse_args(ctx, args)


campaign = typer.Typer(cls=RunByDefault, no_args_is_help=True)
campaign.command()(size)
campaign.command()(sensitivity)
campaign.command("rare-events")(rare_events)

RunsOption = Annotated[
    int | None,
    typer.Option(
        help="Draws; 100000 if not given. Their number is fixed beforehand: to fly on "
        "until the verdict pleases would void its confidence."
    ),
]
SeedOption = Annotated[int, typer.Option(min=0, help="Of the draws.")]
MetricOption = Annotated[
    list[str] | None,
    typer.Option(
        "--metric",
        help="A metric that is kept beside those of the requirements; can be repeated.",
    ),
]
KeepOption = Annotated[
    str | None,
    typer.Option(
        metavar="rows|worst",
        help="Of draws: the metrics of each; or counts, exact sums, histograms and the "
        "worst that decide. If not given, rows of up to ten million.",
    ),
]
ChunkOption = Annotated[
    int | None,
    typer.Option(min=1, help="Draws of a chunk; 32768 if not given."),
]
FolderArgument = Annotated[
    Path, typer.Argument(metavar="DIR", help="The folder of a campaign.")
]
DrakeWorkersOption = Annotated[
    int | None,
    typer.Option(min=1, help="Processes that fly Drake; one per core if not given."),
]


@campaign.command(RUN)
def run(
    case: CaseArgument,
    runs: RunsOption = None,
    seed: SeedOption = 0,
    share: ShareOption = None,
    confidence: ConfidenceOption = None,
    metrics: MetricOption = None,
    keep: KeepOption = None,
    chunk: ChunkOption = None,
    resume: Annotated[
        bool,
        typer.Option(
            "--resume",
            help="Go on from the chunks that the same campaign has left in its folder.",
        ),
    ] = False,
    dask: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            help="Of a Dask scheduler, whose workers fly; needs drakesep\\[cluster].",
        ),
    ] = None,
    output: OutputOption = None,
    workers: Annotated[
        int | None,
        typer.Option(
            min=1,
            help="Processes, each with one core; if not given, this one flies on all "
            "cores.",
        ),
    ] = None,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Tell what share of launches meets the requirements: campaign.csv, a plot.

    Exits with 1 unless the share is shown of every requirement.
    """
    settings = _given(
        runs=runs,
        seed=seed,
        share=share,
        confidence=confidence,
        metrics=metrics,
        keep=keep,
        chunk=chunk,
    )
    with Answer("campaign", quiet=quiet, as_json=as_json) as answer:
        loaded = load(answer, case)
        from drakesep.cli.progress import progress_bar
        from drakesep.studies.campaign import procedure

        with (
            results_folder(output, loaded.name, "campaign") as folder,
            _executor(workers, dask) as executor,
            progress_bar(answer.aside) as on_progress,
        ):
            study = procedure.campaign(
                loaded,
                executor=executor,
                output=folder,
                resume=resume,
                workers=workers,
                on_progress=on_progress,
                **settings,
            )
        _say(answer, folder, study)


@campaign.command()
def plan(
    case: CaseArgument,
    runs: RunsOption = None,
    seed: SeedOption = 0,
    share: ShareOption = None,
    confidence: ConfidenceOption = None,
    metrics: MetricOption = None,
    keep: KeepOption = None,
    chunk: ChunkOption = None,
    output: OutputOption = None,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Write the plan of a campaign, whose chunks others fly: plan.json."""
    settings = _given(
        runs=runs,
        seed=seed,
        share=share,
        confidence=confidence,
        metrics=metrics,
        keep=keep,
        chunk=chunk,
    )
    with Answer("campaign plan", quiet=quiet, as_json=as_json) as answer:
        loaded = load(answer, case)
        from drakesep.studies.campaign import procedure

        with (
            results_folder(output, loaded.name, "campaign") as folder,
            answer.aside.status("planning"),
        ):
            recorded = procedure.plan_campaign(loaded, output=folder, **settings)
        chunks = recorded.plan.chunks
        answer.add(folder=str(folder.path), runs=recorded.plan.runs, chunks=chunks)
        answer.console.print(
            f"{recorded.plan.runs} draws in {chunks} chunks, 0 to {chunks - 1}: "
            f"`drakesep campaign run-chunk {folder.directory} I` flies one, "
            f"`drakesep campaign merge {folder.directory}` tells what came of all",
            markup=False,
        )


@campaign.command("run-chunk")
def run_chunk(
    directory: FolderArgument,
    chunks: Annotated[
        list[int], typer.Argument(metavar="I...", help="Numbers of chunks, from 0.")
    ],
    again: Annotated[
        bool, typer.Option("--again", help="Fly them although they are there.")
    ] = False,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Fly chunks of a campaign that is planned; those that are there stay."""
    with Answer("campaign run-chunk", quiet=quiet, as_json=as_json) as answer:
        from drakesep.studies.campaign import procedure

        flown = []
        for number in chunks:
            with answer.aside.status(f"flying chunk {number}"):
                if procedure.run_chunk(directory, number, again=again):
                    flown.append(number)
        answer.add(folder=str(directory.absolute()), chunks=flown)
        there = "; the others were there" if len(flown) < len(chunks) else ""
        answer.console.print(f"Flown: {len(flown)} of {len(chunks)} chunks{there}")


@campaign.command()
def merge(
    directory: FolderArgument,
    workers: DrakeWorkersOption = None,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Tell what came of a campaign whose chunks have been flown, as `run` does.

    Exits with 4 if a chunk is missing, and says which.
    """
    with Answer("campaign merge", quiet=quiet, as_json=as_json) as answer:
        from drakesep.cli.progress import progress_bar
        from drakesep.studies.campaign import procedure

        with (
            results_folder(directory, "", "campaign") as folder,
            progress_bar(answer.aside) as on_progress,
        ):
            study = procedure.merge_campaign(
                folder, workers=workers, on_progress=on_progress
            )
        answer.add(case=study.case.name)
        _say(answer, folder, study)


@campaign.command()
def slurm(
    directory: FolderArgument,
    tasks: Annotated[
        int, typer.Option(min=1, help="Of the array at most, as its queue allows.")
    ] = 1000,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Print a script that flies the chunks of a planned campaign as a Slurm array."""
    with Answer("campaign slurm", quiet=quiet, as_json=as_json) as answer:
        from drakesep.studies.campaign.slurm import array_script

        script = array_script(directory, tasks)
        answer.add(folder=str(directory.absolute()), script=script)
        answer.itself.out(script, end="", highlight=False)


def replay(
    directory: FolderArgument,
    number: Annotated[
        int, typer.Option("--run", min=0, help="Number of the draw, from 0.")
    ],
    animation: Annotated[
        bool,
        typer.Option(
            "--animation/--no-animation",
            help="Write a page that a browser plays, FOLDER.html beside the results.",
        ),
    ] = True,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="Folder for the results; results/CASE/replay_NUMBER if not given.",
        ),
    ] = None,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Fly a draw of a campaign in Drake: what `simulate` writes, and an animation."""
    with Answer("replay", quiet=quiet, as_json=as_json) as answer:
        from drakesep.cli.results import print_simulated
        from drakesep.cli.summaries import of_simulated
        from drakesep.results.campaign_files import RecordedPlan
        from drakesep.studies.campaign.replay import replay

        name = RecordedPlan.read(directory).plan.case.name
        answer.add(case=name)
        where = output or Path("results") / name / f"replay_{number}"
        with (
            results_folder(where, name, "simulate") as folder,
            answer.aside.status("flying"),
        ):
            result = replay(directory, number, output=folder)
        if animation and result.completed:
            with answer.aside.status("measuring"):
                _animate(where)
        summary = of_simulated(result, folder.path)
        say(answer, folder, summary, partial(print_simulated, result=result))
        if not result.completed:
            answer.fail(result.labelled.status)


def _given(**settings: Any) -> dict[str, Any]:
    """Return the settings that were given, as `campaign` takes them."""
    return {name: value for name, value in settings.items() if value is not None}


def _animate(folder: Path) -> None:
    """Write the page of a folder's runs beside it."""
    from drakesep.results.reading import read_results
    from drakesep.studies.animate import animate_results

    page = folder.parent / f"{folder.resolve().name}.html"
    animate_results(read_results(folder), output=page)


def _say(answer: Answer, folder: Any, study: "Campaign") -> None:
    """Say what a campaign has shown, and end with its exit code."""
    from drakesep.cli.campaign_lines import print_campaign, print_shown
    from drakesep.cli.summaries import of_campaign

    summary = of_campaign(study, folder.path)
    say(answer, folder, summary, partial(print_campaign, study=study))
    print_shown(answer.console, study)
    if study.failure and study.verdict != "not met":
        answer.fail(study.failure)
    if study.failure:
        answer.not_met(study.failure)
    if study.verdict is not None and not study.passed:
        answer.not_well()


@contextlib.contextmanager
def _executor(workers: int | None, dask: str | None) -> Iterator[Executor | None]:
    """Give what flies; None: this process."""
    from drakesep.studies.campaign.executors import dask_cluster, own_processes

    if dask is not None:
        with dask_cluster(dask) as executor:
            yield executor
    elif workers is not None and workers > 1:
        with own_processes(workers) as executor:
            yield executor
    else:
        yield None
