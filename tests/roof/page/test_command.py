"""What `drakesep ui` refuses before it serves."""

import importlib.util
import socket

import pytest
import typer
from command_line import run

from drakesep.cli.app import app
from drakesep.page.server import serve
from drakesep.systems.checks import InputError


def test_its_options():
    command = typer.main.get_command(app).commands["ui"]
    options = [p for p in command.params if p.param_type_name == "option"]
    assert {name for p in options for name in p.opts} == {"--port", "--no-browser"}


def test_a_case_that_is_not_there(capsys, monkeypatch):
    code, _, err = run(capsys, monkeypatch, "ui", "nowhere.yaml", "--no-browser")
    assert code == 2
    assert err.startswith("drakesep: nowhere.yaml: must be a readable case file")
    assert len(err.splitlines()) == 1


def test_a_port_that_no_machine_has(capsys, monkeypatch):
    code, _, err = run(capsys, monkeypatch, "ui", "--port", "70000")
    assert code == 2 and "'--port'" in err and "65535" in err


def test_without_nicegui(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"pip install 'drakesep\[ui\]'"):
        serve("vega")


def test_a_port_that_is_taken(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: object())
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=f"must be free, got {port}"):
            serve(None, port=port)
