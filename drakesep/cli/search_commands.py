"""Commands that search worst cases: worst-case, verify."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from drakesep.cli.answer import Answer
from drakesep.cli.options import (
    CaseArgument,
    ConfidenceOption,
    JsonOption,
    OutputOption,
    ProofSecondsOption,
    QuietOption,
    ResumeOption,
    ShareOption,
    WorkersOption,
)
from drakesep.cli.report_command import say_written
from drakesep.cli.results_folder import load, results_folder, say


if TYPE_CHECKING:
    from drakesep.analysis.search.effort import Effort


SearchOption = Annotated[
    list[str] | None,
    typer.Option(
        "--search",
        help="sqp, multistart, best, vertices, corners, samples, evolution, in their "
        "order; or drake alone; can be repeated. If not given: samples, vertices, sqp, "
        "multistart; corners where there are too many vertices.",
    ),
]
StartsOption = Annotated[
    int | None,
    typer.Option(help="Of the ascent from many starts, for each objective."),
]
SamplesOption = Annotated[int | None, typer.Option(help="Drawn at random.")]
VerticesOption = Annotated[int | None, typer.Option(help="That may be flown at most.")]
FlipsOption = Annotated[
    int | None,
    typer.Option(
        help="Corners that may be flown for each objective, where all are too many."
    ),
]
SeedOption = Annotated[
    int | None, typer.Option(min=0, help="Of what is drawn at random.")
]
MinutesOption = Annotated[
    float | None,
    typer.Option(
        help="That the study may take; if not given, 10, or as long as searches take "
        "that are named. What takes longer is left out, or refused.",
    ),
]
_OBJECTIVE = (
    "L1, L2, Linf, PM, one of a requirement, or highest_ or lowest_ and a metric"
)
_WHAT_FAILED = (
    "a run or a search failed; see status in worst_cases.csv and failed in searches.csv"
)


def worst_case(
    case: CaseArgument,
    objectives: Annotated[
        list[str] | None,
        typer.Option(
            "--objective",
            help=f"{_OBJECTIVE}; can be repeated. If not given: those of the case's "
            "requirements, and L1 to PM if it says `objectives: paper`.",
        ),
    ] = None,
    search: SearchOption = None,
    starts: StartsOption = None,
    samples: SamplesOption = None,
    vertices: VerticesOption = None,
    flips: FlipsOption = None,
    seed: SeedOption = None,
    minutes: MinutesOption = None,
    resume: ResumeOption = False,
    output: OutputOption = None,
    workers: WorkersOption = None,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Find the worst cases: worst_cases.csv, evidence.csv, plots and more."""
    with Answer("worst-case", quiet=quiet, as_json=as_json) as answer:
        loaded = load(answer, case)
        from drakesep.cli.progress import progress_bar
        from drakesep.cli.results import print_worst_cases
        from drakesep.cli.summaries import of_worst_cases
        from drakesep.studies.worst_case import procedure

        with (
            results_folder(output, loaded.name, "worst-case") as folder,
            progress_bar(answer.aside) as on_progress,
        ):
            study = procedure.worst_case(
                loaded,
                objectives,
                searches=search,
                output=folder,
                workers=workers,
                on_progress=on_progress,
                minutes=minutes,
                resume=resume,
                **_given(
                    starts=starts,
                    samples=samples,
                    vertices=vertices,
                    flips=flips,
                    seed=seed,
                ),
            )
        summary = of_worst_cases(study, folder.path)
        say(answer, folder, summary, partial(print_worst_cases, study=study))
        if not study.completed:
            answer.fail(_WHAT_FAILED)


def verify(
    case: CaseArgument,
    objectives: Annotated[
        list[str] | None,
        typer.Option(
            "--objective",
            help=f"Searched beside those of the case: {_OBJECTIVE}; can be repeated.",
        ),
    ] = None,
    search: SearchOption = None,
    starts: StartsOption = None,
    samples: SamplesOption = None,
    vertices: VerticesOption = None,
    flips: FlipsOption = None,
    seed: SeedOption = None,
    minutes: MinutesOption = None,
    resume: ResumeOption = False,
    growth: Annotated[
        bool | None,
        typer.Option(
            "--growth/--no-growth",
            help="Find how far tolerances may grow; if not given, where a study with "
            "it takes no longer than it may.",
        ),
    ] = None,
    corners: Annotated[
        int | None,
        typer.Option(help="Drawn at random, to look how far tolerances may grow."),
    ] = None,
    failures: Annotated[
        bool,
        typer.Option(
            "--failures", help="Verify the failure cases of the case, too, each alike."
        ),
    ] = False,
    campaign: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            help="Draw so many launches beside the worst cases: they decide what is "
            "required of a share of launches, and the worst cases the rest.",
        ),
    ] = None,
    share: ShareOption = None,
    confidence: ConfidenceOption = None,
    prove: Annotated[
        bool,
        typer.Option(
            "--prove",
            help="Prove what nothing within the tolerances is beyond, beside the worst "
            "found; what no bound covers is named.",
        ),
    ] = False,
    proof_seconds: ProofSecondsOption = None,
    page: Annotated[
        bool,
        typer.Option("--report", help="Make a report of the folder, as `report` does."),
    ] = False,
    output: OutputOption = None,
    workers: WorkersOption = None,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Find the worst cases and hold them against the requirements.

    Exits with 1 unless every requirement is met; with --failures, in every failure
    case, too.
    """
    with Answer("verify", quiet=quiet, as_json=as_json) as answer:
        loaded = load(answer, case)
        from drakesep.studies.background_process import BackgroundProcess
        from drakesep.studies.worst_case.searches import WantedSearches

        wanted = WantedSearches.named(search, loaded.separation)
        alone = wanted.drake_alone or not loaded.dispersions
        with (
            results_folder(output, loaded.name, "verify") as folder,
            # Started now, to import what it draws with while we import the engines.
            BackgroundProcess(1 if alone else workers) as background,
        ):
            from drakesep.cli.progress import progress_bar
            from drakesep.studies import verification

            with progress_bar(answer.aside) as on_progress:
                study = verification.verify(
                    loaded,
                    objectives=objectives or (),
                    searches=search,
                    growth=growth,
                    output=folder,
                    workers=workers,
                    on_progress=on_progress,
                    background=background,
                    minutes=minutes,
                    resume=resume,
                    failures=failures,
                    campaign=campaign,
                    share=share,
                    confidence=confidence,
                    prove=prove,
                    proof_seconds=proof_seconds,
                    **_given(
                        starts=starts,
                        samples=samples,
                        vertices=vertices,
                        flips=flips,
                        corners=corners,
                        seed=seed,
                    ),
                )
        from drakesep.cli.results import print_requirements, print_verdict
        from drakesep.cli.summaries import of_verification

        file = _reported(answer, folder.path) if page else None
        summary = of_verification(study, folder.path, file)
        say(answer, folder, summary, partial(print_requirements, study=study))
        if file is not None:
            say_written(answer, file)
        print_verdict(answer.console, study)
        if study.verdict is None:
            answer.fail(study.failure_beside or _WHAT_FAILED)
        if not study.completed:  # and yet a run is beyond a limit
            answer.not_met(study.failure_beside or _WHAT_FAILED)
        if not study.passed:
            answer.not_well()


def _reported(answer: Answer, folder: Path) -> Path:
    """Make the report of a folder; return its page."""
    from drakesep.reports.html import report as write_report

    with answer.aside.status("drawing"):
        return write_report(folder)


def _given(**effort: int | None) -> "Effort":
    return cast("Effort", {k: v for k, v in effort.items() if v is not None})
