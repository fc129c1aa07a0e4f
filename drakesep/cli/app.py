"""The command line. Imports that take time wait until a command needs them."""

import os
import sys
from typing import Annotated

import typer

from drakesep.cli.answer import BAD_INPUT, MACHINE, print_json, say_error, words_of
from drakesep.cli.campaign_commands import campaign, replay
from drakesep.cli.case_commands import cases, new, show
from drakesep.cli.check_proof_command import check_proof
from drakesep.cli.compare_command import compare
from drakesep.cli.export_command import export
from drakesep.cli.prove_command import prove
from drakesep.cli.report_command import report
from drakesep.cli.run_commands import animate, clearance, simulate
from drakesep.cli.search_commands import verify, worst_case
from drakesep.cli.sweep_command import sweep
from drakesep.cli.ui_command import ui


app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


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


_COMMANDS = (
    *(cases, show, new),
    *(simulate, sweep, clearance, animate),
    *(worst_case, verify, prove, check_proof, replay),
    *(report, compare, export),
    ui,
)
for command in _COMMANDS:
    app.command(command.__name__.replace("_", "-"))(command)
app.add_typer(
    campaign, name="campaign", help="Tell what share of launches meets requirements."
)


def main() -> None:
    """Run the command line; bad input ends in one line for each error."""
    # XLA says on standard error what concerns its developers, and calls it errors:
    # that it compiles slowly, say. What is fatal it still says. JAX reads this when it
    # is imported.
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
    try:
        code = app(standalone_mode=False) or 0
        sys.stdout.flush()
    except OSError as error:  # help, or versions, cannot be written
        code = MACHINE
        say_error(words_of(error))
    except Exception as error:
        told = getattr(error, "format_message", None)
        if told is None:
            raise
        # The words of the command line make no sense: no command has begun.
        code, message = BAD_INPUT, told()
        context = getattr(error, "ctx", None)
        if message and context is not None:
            message = f"{message} (see `{context.command_path} --help`)"
        say_error(message)
        if "--json" in sys.argv:
            print_json(None, code, message, [], {})
    sys.exit(code)
