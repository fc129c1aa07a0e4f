"""Commands that fly single runs: simulate, clearance, animate."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from drakesep.cli.answer import Answer
from drakesep.cli.options import (
    CaseArgument,
    ChangesOption,
    JsonOption,
    OutputOption,
    QuietOption,
    parse_changes,
)
from drakesep.cli.results_folder import load, results_folder, say
from drakesep.systems.checks import InputError


def simulate(
    case: CaseArgument,
    changes: ChangesOption = None,
    output: OutputOption = None,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Fly a case once: motion.csv, summary.csv, plots; contacts.csv if any."""
    with Answer("simulate", quiet=quiet, as_json=as_json) as answer:
        values = parse_changes(changes or [])
        loaded = load(answer, case)
        from drakesep.cli.results import print_simulated
        from drakesep.cli.summaries import of_simulated
        from drakesep.studies import simulate

        with (
            results_folder(output, loaded.name, "simulate") as folder,
            answer.aside.status("flying"),
        ):
            result = simulate.simulate(loaded, values, output=folder)
        summary = of_simulated(result, folder.path)
        say(answer, folder, summary, partial(print_simulated, result=result))
        if not result.completed:
            answer.fail(result.labelled.status)


def clearance(
    case: CaseArgument,
    changes: ChangesOption = None,
    output: OutputOption = None,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Measure how near bodies come: clearance_summary.csv, clearance.csv, a plot.

    Exits with 1 if anything touches.
    """
    with Answer("clearance", quiet=quiet, as_json=as_json) as answer:
        values = parse_changes(changes or [])
        loaded = load(answer, case)
        from drakesep.cli.progress import steps
        from drakesep.cli.results import print_clearances
        from drakesep.cli.summaries import of_clearances
        from drakesep.studies import clearance

        with (
            results_folder(output, loaded.name, "clearance") as folder,
            steps(answer.aside) as tell,
        ):
            study = clearance.clearance(loaded, values, output=folder, on_progress=tell)
        summary = of_clearances(study, folder.path)
        say(answer, folder, summary, partial(print_clearances, study=study))
        if not study.clear:
            answer.not_met("there is contact; see clearance_summary.csv")


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
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Animate the nominal run and worst cases in one HTML page, for a browser.

    Of a folder of results, the runs that it keeps: nothing is flown.
    """
    with Answer("animate", quiet=quiet, as_json=as_json) as answer:
        from drakesep.case_file.reader import builtin_cases

        if Path(case).is_dir() and case not in builtin_cases():
            _animate_folder(answer, Path(case), labels, output, runs)
        else:
            _animate_case(answer, case, labels, output, runs)


def _animate_case(
    answer: Answer,
    case: str,
    labels: list[str] | None,
    output: Path | None,
    runs: Path | None,
) -> None:
    loaded = load(answer, case)
    from drakesep.studies import animate
    from drakesep.tables.run_tables import read_runs

    if labels and runs is None:
        raise InputError("--run: needs --runs, the table that has it")
    chosen = None if runs is None else read_runs(runs, labels)
    file = output or Path("results") / loaded.name / "animate.html"
    with answer.aside.status("flying and measuring"):
        shown = animate.animate(loaded, chosen, output=file)
    _say_animated(answer, file, shown)


def _animate_folder(
    answer: Answer,
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
    with answer.aside.status("measuring"):
        results = read_results(folder)
        answer.add(case=results.case.name)
        shown = animate.animate_results(results, labels, output=file)
    _say_animated(answer, file, shown)


def _say_animated(answer: Answer, file: Path, shown: list[str]) -> None:
    answer.add(file=str(file.absolute()), runs=shown)
    say = answer.console.print
    say(f"The animation is {file}: open it in a browser", markup=False)
    say(f"It shows {', '.join(shown)}", markup=False)
