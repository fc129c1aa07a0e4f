"""The command that flies variants: sweep."""

import math
from functools import partial
from typing import Annotated

import typer

from drakesep.cli.answer import Answer
from drakesep.cli.options import (
    CaseArgument,
    JsonOption,
    OutputOption,
    QuietOption,
    WorkersOption,
    number,
)
from drakesep.cli.results_folder import load, results_folder, say
from drakesep.systems.checks import InputError, check_finite


def sweep(
    case: CaseArgument,
    swept: Annotated[
        list[str],
        typer.Argument(
            metavar="NAME=VALUES",
            help="A parameter and its values, FROM:TO:N or with commas between; of "
            "several parameters, all combinations are flown. `show` lists the names.",
        ),
    ],
    engine: Annotated[
        str | None,
        typer.Option(
            help="drake or batch. If not given: Drake for at most 100 variants, and "
            "for what the batch engine cannot fly."
        ),
    ] = None,
    output: OutputOption = None,
    workers: WorkersOption = None,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Fly variants, one run each: sweep.csv; a plot, if one parameter varies.

    Exits with 4 if a run failed.
    """
    with Answer("sweep", quiet=quiet, as_json=as_json) as answer:
        values = parse_swept(swept)
        loaded = load(answer, case)
        from drakesep.cli.progress import progress_bar
        from drakesep.cli.results import print_sweep
        from drakesep.cli.summaries import of_sweep
        from drakesep.studies import sweep

        with (
            results_folder(output, loaded.name, "sweep") as folder,
            progress_bar(answer.aside) as on_progress,
        ):
            study = sweep.sweep(
                loaded,
                values,
                engine=sweep.engine_named(engine),
                output=folder,
                workers=workers,
                on_progress=on_progress,
            )
        summary = of_sweep(study, folder.path)
        say(answer, folder, summary, partial(print_sweep, study=study))
        if not study.completed:
            answer.fail(study.failure)


def parse_swept(texts: list[str]) -> dict[str, list[float]]:
    """Return values by parameter name, from NAME=FROM:TO:N or NAME=1,2,3.

    Raises:
        ValueError: one is neither, or a name stands twice.
    """
    values: dict[str, list[float]] = {}
    for text in texts:
        name, equals, said = text.partition("=")
        if not equals:
            raise InputError(
                f"{text}: must be NAME=FROM:TO:N or NAME=VALUE,VALUE,..., got no ="
            )
        if name in values:
            raise InputError(f"{name}: must stand once, got it twice")
        if ":" in said:
            values[name] = _between(name, said)
        else:
            values[name] = [number(name, one) for one in said.split(",")]
    return values


def _between(name: str, said: str) -> list[float]:
    """Return evenly spaced values, the ends among them, from FROM:TO:N."""
    from drakesep.studies.sweep import MOST

    parts = said.split(":")
    if len(parts) != 3:
        raise InputError(f"{name}: must be FROM:TO:N, got {said!r}")
    first, last = (number(name, part) for part in parts[:2])
    check_finite(name, first, last)
    if not math.isfinite(last - first):
        raise InputError(
            f"{name}: FROM and TO must differ by a number that a computer can hold, "
            f"got {said!r}"
        )
    if not parts[2].isdecimal() or int(parts[2]) < 2:
        raise InputError(
            f"{name}: N must be a whole number of 2 or more, got {parts[2]!r}"
        )
    # Before they are made: all of them may not fit into memory.
    if float(parts[2]) > MOST:
        raise InputError(f"{name}: must make at most {MOST} variants, got {parts[2]}")
    steps = int(parts[2]) - 1
    return [*(first + (last - first) * k / steps for k in range(steps)), last]
