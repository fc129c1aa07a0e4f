"""The command line, called as a user calls it."""

import sys

import pytest

from drakesep.cli import app


def run(capsys, monkeypatch, *arguments):
    """Exit code, standard output and standard error of a command."""
    monkeypatch.setattr(sys, "argv", ["drakesep", *map(str, arguments)])
    with pytest.raises(SystemExit) as exit_:
        app.main()
    captured = capsys.readouterr()
    return exit_.value.code, captured.out, captured.err
