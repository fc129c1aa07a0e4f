"""Where the command begins: signals first, then what takes time to import."""

from drakesep.cli import signals, streams


def main() -> None:
    """Run the command line."""
    streams.prepare()
    signals.listen()
    from drakesep.cli.app import main as command_line

    command_line()
