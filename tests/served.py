"""The page as `drakesep ui` serves it, in a process of its own."""

import contextlib
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from browser import Browser, browser


_COMMAND = (sys.executable, "-c", "from drakesep.cli.entry import main; main()")


READY = """window.did_handshake
  && [...document.querySelectorAll("[role=tabpanel]")].some(e => e.textContent)"""
"""What is true once the page can be used."""


class Served(NamedTuple):
    """A server that runs."""

    address: str
    """With the token."""
    process: subprocess.Popen[str]

    @property
    def token(self) -> str:
        return self.address.partition("token=")[2]

    @property
    def port(self) -> int:
        found = re.search(r":(\d+)/", self.address)
        assert found
        return int(found[1])


@contextlib.contextmanager
def served(folder: Path, *arguments: str) -> Iterator[Served]:
    """Start `drakesep ui` in a folder; it ends as it does by Ctrl-C."""
    process = subprocess.Popen(
        [*_COMMAND, "ui", "--no-browser", *arguments],
        cwd=folder,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout is not None
        found = re.search(r"http://\S+", process.stdout.readline())
        assert found, "no address"
        yield Served(found[0], process)
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(timeout=10)
        assert process.stdout is not None
        process.stdout.close()


@contextlib.contextmanager
def opened(folder: Path, *arguments: str) -> Iterator[Browser]:
    """Open the page of `drakesep ui` in a browser, and wait until it can be used."""
    with served(folder, *arguments) as server, browser() as page:
        page.open(server.address, 1280, 800)
        page.wait(READY)
        yield page
