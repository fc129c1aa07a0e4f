"""Commands that a page asks for by a click: a report, an animation."""

import asyncio
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from nicegui import app, context, ui

from drakesep.page import elements
from drakesep.page.study import SPARE


_LOOK = 0.05
_LONGEST = 600.0
"""That is waited, s."""


async def done(arguments: Sequence[str], where: Path) -> dict[str, Any] | None:
    """Return what `--json` says of a command; None of one that failed, which is said.

    Args:
        arguments: of the command line.
        where: folder in which it is run.
    """
    process = SPARE.take()
    process.run((*arguments, "--json", "--quiet"), where=where)
    end = time.monotonic() + _LONGEST
    while time.monotonic() < end:
        for event in process.events():
            if event["event"] == "ended":
                SPARE.ready()
                summary: dict[str, Any] = event["summary"]
                if error := summary.get("error"):
                    elements.say_wrong(str(error))
                    return None
                return summary
            if event["event"] in ("died", "stopped"):
                elements.say_wrong(event.get("reason", "stopped"))
                return None
        await asyncio.sleep(_LOOK)
    process.stop()
    elements.say_wrong(f"{arguments[0]}: took longer than {_LONGEST:.0f} s")
    return None


async def open_page(button: ui.button, arguments: Sequence[str], file: Path) -> None:
    """Let a command write a page, and open it.

    Args:
        button: that asks for it, and shows that it is under way.
        arguments: of the command line.
        file: that it writes.
    """
    button.props("loading")
    client = context.client  # which stays, where the button goes meanwhile
    try:
        with client:
            if await done(arguments, Path.cwd()) is not None:
                show_file(file)
    finally:
        button.props(remove="loading")


def show_file(file: Path) -> None:
    """Open a file of this machine in another tab of the browser."""
    ui.navigate.to(app.add_static_file(local_file=file, max_cache_age=0), new_tab=True)
