"""The command line. Imports that take time wait until a command needs them."""

import contextlib
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer


if TYPE_CHECKING:
    from rich.console import Console

    from drakesep.studies import Progress, WorstCases


app = typer.Typer(
    help="How badly can a launch vehicle separation go, and is that within limits?",
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
        "--output", "-o", help="Folder for the results; results/CASE if not given."
    ),
]
WorkersOption = Annotated[
    int | None, typer.Option(min=1, help="Processes; one per core if not given.")
]

FAILED, BAD_INPUT, INTERRUPTED = 1, 2, 130


@app.command()
def cases() -> None:
    """List the built-in cases."""
    from drakesep.case_file import builtin_cases, load_case
    from drakesep.console import print_cases

    print_cases(_console(), map(load_case, builtin_cases()))


@app.command()
def show(case: CaseArgument) -> None:
    """Show bodies, springs, dispersions and requirements of a case."""
    from drakesep.case_file import load_case
    from drakesep.console import print_case

    print_case(_console(), load_case(case))


@app.command()
def simulate(
    case: CaseArgument,
    changes: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="Change a parameter."),
    ] = None,
    output: OutputOption = None,
) -> None:
    """Fly a case once: motion.csv, summary.csv and figures."""
    values = dict(map(_parse_change, changes or []))
    from drakesep import studies, tables
    from drakesep.case_file import load_case
    from drakesep.console import print_frame

    console = _console()
    loaded = load_case(case)
    folder = studies.writable_folder(output or Path("results") / loaded.name)
    result = studies.simulate(loaded, values)
    result.save(folder)
    if not result.completed:
        _fail(FAILED, result.flight.status)
    print_frame(console, "Figures of the run", tables.figures_table(result.flight))
    console.print(f"Tables and figures are in {folder}")


@app.command("worst-case")
def worst_case(
    case: CaseArgument,
    objectives: Annotated[
        list[str] | None,
        typer.Option(
            "--objective", help="L1, L2, Linf or PM; can be repeated; all if not given."
        ),
    ] = None,
    output: OutputOption = None,
    workers: WorkersOption = None,
) -> None:
    """Find the worst cases: worst_cases.csv, history.csv and figures."""
    from drakesep import studies
    from drakesep.case_file import load_case

    console = _console()
    loaded = load_case(case)
    folder = studies.writable_folder(output or Path("results") / loaded.name)
    with _progress(console, folder) as on_progress:
        study = studies.worst_case(
            loaded, objectives, output=folder, workers=workers, on_progress=on_progress
        )
    _print_worst_cases(console, study)
    console.print(f"Tables and figures are in {folder}")
    if not study.completed:
        _fail(FAILED, "a run or a search failed; see worst_cases.csv")


@app.command()
def verify(
    case: CaseArgument,
    output: OutputOption = None,
    workers: WorkersOption = None,
) -> None:
    """Find the worst cases and hold them against the requirements.

    Exits with 1 if a requirement is not met.
    """
    from drakesep import studies
    from drakesep.case_file import load_case
    from drakesep.console import print_frame

    console = _console()
    loaded = load_case(case)
    folder = studies.writable_folder(output or Path("results") / loaded.name)
    with _progress(console, folder) as on_progress:
        study = studies.verify(
            loaded, output=folder, workers=workers, on_progress=on_progress
        )
    _print_worst_cases(console, study)
    print_frame(console, "Requirements", study.requirements)
    console.print(f"Tables and figures are in {folder}")
    if not study.completed:
        _fail(FAILED, "a run or a search failed; see worst_cases.csv")
    if not study.passed:
        console.print("[bold red]Not every requirement is met.[/]")
        raise typer.Exit(FAILED)
    console.print("[bold green]Every requirement is met.[/]")


def _print_worst_cases(console: "Console", study: "WorstCases") -> None:
    from drakesep.console import print_frame

    print_frame(console, "Worst cases", study.comparison)
    print_frame(
        console,
        "In the form of the paper's Table 4 (its printed values in parentheses)",
        study.table_4,
    )


@contextlib.contextmanager
def _progress(
    console: "Console", folder: Path
) -> "Iterator[Callable[[Progress], None]]":
    from rich import progress as rich_progress

    from drakesep.units import unit_of

    bar = rich_progress.Progress(
        rich_progress.TextColumn("{task.description}"),
        rich_progress.BarColumn(),
        rich_progress.TimeElapsedColumn(),
        console=console,
        transient=True,
    )
    task = bar.add_task("starting", total=None)

    def show_progress(progress: "Progress") -> None:
        name = f"G_{progress.objective}"
        unit = unit_of(name)
        bar.update(
            task,
            total=progress.searches,
            completed=progress.done,
            description=f"{name}: iteration {progress.iteration.number}, "
            f"{unit.from_si(progress.iteration.value):.5g} {unit.symbol}, "
            f"{progress.iteration.evaluations} runs",
        )

    try:
        with bar:
            yield show_progress
    except KeyboardInterrupt:
        _fail(INTERRUPTED, f"interrupted; what was done is in {folder}")


def _parse_change(text: str) -> tuple[str, float]:
    name, equals, value = text.partition("=")
    if not equals:
        raise ValueError(f"--set: must be NAME=VALUE, got {text!r}")
    try:
        return name.strip(), float(value)
    except ValueError:
        raise ValueError(f"--set {name}: must be a number, got {value!r}") from None


def _console() -> "Console":
    from rich.console import Console

    return Console()


def _fail(code: int, message: str) -> NoReturn:
    for line in message.splitlines():
        print(f"drakesep: {line}", file=sys.stderr)
    raise typer.Exit(code)


def main() -> None:
    """Run the command line; bad input ends in one line for each error."""
    try:
        app()
    except (ValueError, RuntimeError) as error:
        bad_input = isinstance(error, ValueError)
        for line in str(error).splitlines():
            print(f"drakesep: {line}", file=sys.stderr)
        sys.exit(BAD_INPUT if bad_input else FAILED)
