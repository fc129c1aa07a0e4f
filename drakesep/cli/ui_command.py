"""The command that serves the page: ui."""

from typing import Annotated

import typer

from drakesep.cli.answer import Answer


def ui(
    case: Annotated[
        str | None,
        typer.Argument(
            help="A case file, or the name of a built-in case; a new case if not given."
        ),
    ] = None,
    port: Annotated[
        int | None,
        typer.Option(min=1, max=65535, help="Of 127.0.0.1; a free one if not given."),
    ] = None,
    no_browser: Annotated[
        bool, typer.Option("--no-browser", help="Print the address, open nothing.")
    ] = False,
) -> None:
    """Work on a case in the browser: edit it, play with it, search its worst cases.

    The page is served to this machine alone, to who has the address with its token,
    until the command is interrupted.
    """
    with Answer("ui", quiet=False, as_json=False) as answer:
        from drakesep.page.server import serve

        def say(address: str) -> None:
            answer.console.print(
                "The page is at", address, markup=False, soft_wrap=True
            )

        serve(case, port=port, opens_browser=not no_browser, say=say)
