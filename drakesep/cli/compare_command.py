"""The command that tells what changed between two results folders: compare."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drakesep.cli.answer import Answer
from drakesep.cli.options import JsonOption, QuietOption


if TYPE_CHECKING:
    import pandas as pd
    from rich.console import Console

    from drakesep.reports.compare import Comparison

_SHOWN = 8
"""Changes in a table that are printed, the greatest."""
_COLUMNS = ("row", "column", "first", "second", "difference", "relative_difference")


def compare(
    first: Annotated[Path, typer.Argument(help="A folder of results.")],
    second: Annotated[Path, typer.Argument(help="Another.")],
    tolerance: Annotated[
        float | None,
        typer.Option(
            help="By how much a number may differ, as a part of the larger magnitude, "
            "to be the same: exits with 1 if any answer differs by more."
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="A CSV file for the whole table."),
    ] = None,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Tell what changed between two folders, in inputs and in answers.

    Nothing is flown. With --tolerance it is a check: exits with 1 if they differ.
    """
    with Answer("compare", quiet=quiet, as_json=as_json) as answer:
        from drakesep.cli.summaries import of_comparison
        from drakesep.reports.compare import compare
        from drakesep.results.folder import writable_folder

        if output is not None:
            writable_folder(output.parent)
        found = compare(first, second, tolerance=tolerance)
        if output is not None:
            found.save(output)
        answer.add(**vars(of_comparison(found)))
        _print(answer.console, found)
        if output is not None:
            answer.console.print(f"All changes are in {output}", markup=False)
        if tolerance is not None and not found.same:
            answer.not_well()


def _print(console: "Console", found: "Comparison") -> None:
    _print_changes(console, "Inputs that changed", found.inputs)
    _print_changes(console, "Answers that changed", found.answers)
    if found.tolerance is None:
        return
    beyond = int(found.answers["beyond"].sum())
    differ = f"The answers differ: {beyond} by more than {found.tolerance:g}."
    console.print("The answers are the same." if found.same else differ)


def _print_changes(console: "Console", title: str, changes: "pd.DataFrame") -> None:
    from drakesep.cli.console import print_frame

    if changes.empty:
        console.print(f"{title}: none")
    for where, part in changes.groupby("where", sort=False):
        greatest = _greatest(part)
        told = [name for name in _COLUMNS if greatest[name].notna().any()]
        told = [name for name in told if (greatest[name] != "").any()]
        print_frame(console, f"{title}: {where}", greatest[told], digits=8, whole=True)
        if len(part) > _SHOWN:
            console.print(f"... and {len(part) - _SHOWN} more", markup=False)


def _greatest(changes: "pd.DataFrame") -> "pd.DataFrame":
    """Return the greatest changes of a table, in its order; texts go first."""
    ranked = changes.sort_values(
        "relative_difference", ascending=False, na_position="first", kind="stable"
    )
    return changes.loc[sorted(ranked.index[:_SHOWN])]
