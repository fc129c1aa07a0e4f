"""Where the command begins: signals first, then what takes time to import."""

import sys

from drakesep.cli import signals


def main() -> None:
    """Run the command line."""
    signals.listen()
    for stream in (sys.stdout, sys.stderr):
        # A console that cannot show a character shows another.
        if stream is not None and hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    from drakesep.cli.app import main as command_line

    command_line()
