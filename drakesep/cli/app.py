"""The command line. Imports that take time wait until a command needs them."""

import contextlib
import errno
import os
import signal
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn, TextIO, cast

import typer

from drakesep.systems.checks import InputError


if TYPE_CHECKING:
    from rich.console import Console

    from drakesep.analysis.search.effort import Effort
    from drakesep.results.folder import ResultsFolder


app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

CaseArgument = Annotated[
    str, typer.Argument(help="A case file, or the name of a built-in case.")
]
OutputOption = Annotated[
    Path | None,
    typer.Option(
        "--output",
        "-o",
        help="Folder for the results; results/CASE/COMMAND if not given.",
    ),
]
ChangesOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        help="Change a parameter; can be repeated. `show` lists the names.",
    ),
]
WorkersOption = Annotated[
    int | None,
    typer.Option(
        min=1, help="Processes; one per core if not given; 1: this one alone."
    ),
]

FAILED, BAD_INPUT, INTERRUPTED, TERMINATED = 1, 2, 130, 143


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        from drakesep.version import __version__

        print(f"drakesep {__version__}, Drake {version('drake')}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool,
        typer.Option(
            "--version",
            callback=_print_version,
            is_eager=True,
            help="Tell the versions of drakesep and Drake.",
        ),
    ] = False,
) -> None:
    """How badly can a launch vehicle separation go, and is that within limits?"""


@app.command()
def cases() -> None:
    """List the built-in cases."""
    from drakesep.case_file.reader import builtin_cases, load_case
    from drakesep.cli.console import print_cases

    print_cases(_console(), map(load_case, builtin_cases()))


@app.command()
def show(case: CaseArgument) -> None:
    """Show bodies, springs, dispersions and requirements of a case."""
    from drakesep.case_file.reader import load_case
    from drakesep.cli.console import print_case

    print_case(_console(), load_case(case))


@app.command()
def simulate(
    case: CaseArgument,
    changes: ChangesOption = None,
    output: OutputOption = None,
) -> None:
    """Fly a case once: motion.csv, summary.csv, plots; contacts.csv if any."""
    values = _parse_changes(changes or [])
    from drakesep.case_file.reader import load_case
    from drakesep.cli.results import print_simulated
    from drakesep.studies import simulate

    console = _console()
    loaded = load_case(case)
    with (
        _results(output, loaded.name, "simulate") as folder,
        console.status("flying"),
    ):
        result = simulate.simulate(loaded, values, output=folder)
    if not result.completed:
        _fail(FAILED, result.labelled.status)
    print_simulated(console, result)
    _say_where(console, folder)


@app.command()
def clearance(
    case: CaseArgument,
    changes: ChangesOption = None,
    output: OutputOption = None,
) -> None:
    """Measure how near bodies come: clearance_summary.csv, clearance.csv, a plot.

    Exits with 1 if anything touches.
    """
    values = _parse_changes(changes or [])
    from drakesep.case_file.reader import load_case
    from drakesep.cli.results import print_clearances
    from drakesep.studies import clearance

    console = _console()
    loaded = load_case(case)
    with (
        _results(output, loaded.name, "clearance") as folder,
        console.status("flying and measuring"),
    ):
        study = clearance.clearance(loaded, values, output=folder)
    print_clearances(console, study)
    _say_where(console, folder)
    if not study.clear:
        _fail(FAILED, "there is contact; see clearance_summary.csv")


@app.command()
def animate(
    case: Annotated[
        str,
        typer.Argument(
            help="A case file, the name of a built-in case, or a folder of results."
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="The page; results/CASE/animate.html if not given, or of a folder "
            "FOLDER.html beside it.",
        ),
    ] = None,
    runs: Annotated[
        Path | None,
        typer.Option(
            help="worst_cases.csv of a study, whose runs are shown; those published "
            "with the case if not given."
        ),
    ] = None,
    labels: Annotated[
        list[str] | None,
        typer.Option(
            "--run",
            help="Label of a run of that table; can be repeated; if not given, all "
            "worst cases of the paper's objectives and of the clearance, or all worst "
            "cases if there are none of these objectives.",
        ),
    ] = None,
) -> None:
    """Animate the nominal run and worst cases in one HTML page, for a browser.

    Of a folder of results, the runs that it keeps: nothing is flown.
    """
    from drakesep.case_file.reader import builtin_cases, load_case
    from drakesep.studies import animate
    from drakesep.tables.run_tables import read_runs

    console = _console()
    if Path(case).is_dir() and case not in builtin_cases():
        _animate_folder(console, Path(case), labels, output, runs)
        return
    loaded = load_case(case)
    if labels and runs is None:
        raise InputError("--run: needs --runs, the table that has it")
    chosen = None if runs is None else read_runs(runs, labels)
    file = output or Path("results") / loaded.name / "animate.html"
    with console.status("flying and measuring"):
        shown = animate.animate(loaded, chosen, output=file)
    _say_animated(console, file, shown)


def _animate_folder(
    console: "Console",
    folder: Path,
    labels: list[str] | None,
    output: Path | None,
    runs: Path | None,
) -> None:
    from drakesep.results.reading import read_results
    from drakesep.studies import animate

    if runs is not None:
        raise InputError(f"--runs: {folder} has its own runs; name them with --run")
    file = output or folder.parent / f"{folder.resolve().name}.html"
    with console.status("measuring"):
        results = read_results(folder)
        shown = animate.animate_results(results, labels, output=file)
    _say_animated(console, file, shown)


def _say_animated(console: "Console", file: Path, shown: list[str]) -> None:
    console.print(f"The animation is {file}: open it in a browser", markup=False)
    console.print(f"It shows {', '.join(shown)}", markup=False)


SearchOption = Annotated[
    list[str] | None,
    typer.Option(
        "--search",
        help="sqp, multistart, vertices, corners, samples, evolution, in their order; "
        "or drake alone; can be repeated. If not given: samples, vertices, sqp, "
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


_OBJECTIVE = (
    "L1, L2, Linf, PM, one of a requirement, or highest_ or lowest_ and a metric"
)


@app.command("worst-case")
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
    output: OutputOption = None,
    workers: WorkersOption = None,
) -> None:
    """Find the worst cases: worst_cases.csv, evidence.csv, plots and more."""
    from drakesep.case_file.reader import load_case
    from drakesep.cli.progress import progress_bar
    from drakesep.cli.results import print_worst_cases
    from drakesep.studies.worst_case import procedure

    console = _console()
    loaded = load_case(case)
    folder = _results(output, loaded.name, "worst-case")
    with _interruptible(folder), folder, progress_bar(console) as on_progress:
        study = procedure.worst_case(
            loaded,
            objectives,
            searches=search,
            output=folder,
            workers=workers,
            on_progress=on_progress,
            **_given(
                starts=starts,
                samples=samples,
                vertices=vertices,
                flips=flips,
                seed=seed,
            ),
        )
    print_worst_cases(console, study)
    _say_where(console, folder)
    if not study.completed:
        _fail(FAILED, _WHAT_FAILED)


def _given(**effort: int | None) -> "Effort":
    return cast("Effort", {k: v for k, v in effort.items() if v is not None})


_WHAT_FAILED = "a run or a search failed; see status in worst_cases.csv"


@app.command()
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
    growth: Annotated[
        bool | None,
        typer.Option(
            "--growth/--no-growth",
            help="Find how far tolerances may grow; if not given, where a study with "
            "it takes less than ten minutes.",
        ),
    ] = None,
    corners: Annotated[
        int | None,
        typer.Option(help="Drawn at random, to look how far tolerances may grow."),
    ] = None,
    output: OutputOption = None,
    workers: WorkersOption = None,
) -> None:
    """Find the worst cases and hold them against the requirements.

    Exits with 1 if a requirement is not met.
    """
    from drakesep.case_file.reader import load_case
    from drakesep.studies.background_process import BackgroundProcess
    from drakesep.studies.worst_case.searches import WantedSearches

    console = _console()
    loaded = load_case(case)
    folder = _results(output, loaded.name, "verify")
    alone = WantedSearches.named(search).drake_alone or not loaded.dispersions
    # It is started now, to import what it draws with while we import the engines.
    with BackgroundProcess(1 if alone else workers) as background:
        from drakesep.cli.progress import progress_bar
        from drakesep.studies import verification

        with _interruptible(folder), folder, contextlib.ExitStack() as stack:
            stack.callback(background.end)  # before the folder is left
            on_progress = stack.enter_context(progress_bar(console))
            study = verification.verify(
                loaded,
                objectives=objectives or (),
                searches=search,
                growth=growth,
                output=folder,
                workers=workers,
                on_progress=on_progress,
                background=background,
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

    print_requirements(console, study)
    _say_where(console, folder)
    if not study.completed:
        _fail(FAILED, _WHAT_FAILED)
    print_verdict(console, study)
    if not study.passed:
        raise typer.Exit(FAILED)


@contextlib.contextmanager
def _interruptible(folder: "ResultsFolder") -> Iterator[None]:
    """End in one line if the user interrupts."""
    try:
        yield
    except KeyboardInterrupt:
        done = f"; what was done is in {folder.directory}" if folder.begun else ""
        _fail(INTERRUPTED, f"interrupted{done}")


def _say_where(console: "Console", folder: "ResultsFolder") -> None:
    console.print(f"Tables and plots are in {folder.directory}", markup=False)


def _parse_changes(texts: list[str]) -> dict[str, float]:
    values: dict[str, float] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals:
            raise InputError(f"--set: must be NAME=VALUE, got {text!r}")
        if name in values:
            raise InputError(f"--set {name}: must stand once, got it twice")
        try:
            values[name] = float(value)
        except ValueError:
            raise InputError(f"--set {name}: must be a number, got {value!r}") from None
    return values


def _console() -> "Console":
    from rich.console import Console

    console = Console()
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console = Console(width=200)  # a file has no edge
    return console


def _results(output: Path | None, case: str, command: str) -> "ResultsFolder":
    from drakesep.results.folder import ResultsFolder

    directory = output or Path("results") / case / command
    return ResultsFolder(directory, command, command=sys.argv[1:])


def _fail(code: int, message: str) -> NoReturn:
    for line in message.splitlines():
        print(f"drakesep: {line}", file=sys.stderr)
    sys.exit(code)


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    print(f"drakesep: warning: {message}", file=sys.stderr)


def main() -> None:
    """Run the command line; bad input ends in one line for each error."""
    # XLA says on standard error what concerns its developers, and calls it errors:
    # that it compiles slowly, say. What is fatal it still says. JAX reads this when it
    # is imported.
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
    # So that leaving ends the workers, as it does for an interrupt.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(TERMINATED))
    warnings.showwarning = _show_warning
    try:
        app()
    except InputError as error:
        _fail(BAD_INPUT, str(error))
    except OSError as error:
        disk = error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
        _fail(FAILED if disk else BAD_INPUT, f"{error.filename}: {error.strerror}")
    except RuntimeError as error:
        _fail(FAILED, str(error))
