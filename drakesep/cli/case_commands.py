"""Commands on cases: list them, show one, write a new one."""

from pathlib import Path
from typing import Annotated

import typer

from drakesep.cli.answer import Answer
from drakesep.cli.options import CaseArgument, JsonOption, QuietOption


def cases(quiet: QuietOption = False, as_json: JsonOption = False) -> None:
    """List the built-in cases."""
    with Answer("cases", quiet=quiet, as_json=as_json) as answer:
        from drakesep.case_file.reader import builtin_cases, load_case
        from drakesep.cli.console import print_cases
        from drakesep.cli.summaries import of_cases

        builtin = [load_case(name) for name in builtin_cases()]
        print_cases(answer.itself, builtin)
        answer.add(**vars(of_cases(builtin)))


def show(
    case: CaseArgument, quiet: QuietOption = False, as_json: JsonOption = False
) -> None:
    """Show a case: bodies, springs, dispersions, requirements, and what is wrong.

    What `verify` would refuse it refuses too, with the same words.
    """
    with Answer("show", quiet=quiet, as_json=as_json) as answer:
        from drakesep.case_file.reader import load_case
        from drakesep.cli.console import print_case, print_notes
        from drakesep.cli.summaries import of_case
        from drakesep.studies.before_flight import check_verifiable

        loaded = load_case(case)
        print_case(answer.itself, loaded)
        answer.add(**vars(of_case(loaded)))
        notes = check_verifiable(loaded)
        print_notes(answer.itself, notes)
        answer.add(notes=notes)


def new(
    name: Annotated[str, typer.Argument(help="Of the case.")],
    like: Annotated[
        str | None,
        typer.Option(
            "--from", help="A built-in case, whose text it has under the new name."
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="The file; NAME.yaml if not given."),
    ] = None,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Write a case file to start from: a small one, with comments.

    A file that is there is never overwritten.
    """
    with Answer("new", quiet=quiet, as_json=as_json) as answer:
        from drakesep.case_file.new_case import new_case

        file = new_case(name, like=like, file=output)
        answer.add(case=name, file=str(file.absolute()))
        answer.console.print(
            f"The case is {file}: see `drakesep show {file}`", markup=False
        )
