"""Commands that a page asks for by a click: a report, an animation."""

import asyncio
import functools
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from nicegui import app, context, ui

from drakesep.page import elements
from drakesep.page.study_process import StudyProcess


_LOOK = 0.05
_LONGEST = 600.0
"""That is waited, s."""


async def done(arguments: Sequence[str], where: Path) -> dict[str, Any] | None:
    """Return what `--json` says of a command; None of one that failed, which is said.

    Args:
        arguments: of the command line.
        where: folder in which it is run.
    """
    process = StudyProcess()  # the spare one is warm for a study
    process.run((*arguments, "--json", "--quiet"), where=where)
    end = time.monotonic() + _LONGEST
    while time.monotonic() < end:
        for event in process.events():
            if event["event"] == "ended":
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


async def open_page(
    button: ui.button, command: str, folder: Path, links: ui.element
) -> None:
    """Let a command write a page of a folder beside it, and open it.

    Args:
        button: that asks for it, and shows that it is under way.
        command: that writes one page of a folder of results.
        folder: of the results.
        links: gets a link to the page.
    """
    file = folder.with_name(f"{folder.name}-{command}.html")
    await open_file(button, (command, str(folder), "-o", str(file)), file, links)


async def open_file(
    button: ui.button, arguments: Sequence[str], file: Path, links: ui.element
) -> None:
    """Let a command write a page, and open it.

    A browser lets a page open another only soon after a click: what takes longer is
    opened by its link.

    Args:
        button: that asks for it, and shows that it is under way.
        arguments: of the command line.
        file: that it writes.
        links: gets a link to the page.
    """
    button.props("loading")
    client = context.client  # is there, too, where something else is shown meanwhile
    try:
        with client:
            if await done(arguments, Path.cwd()) is None:
                return
    finally:
        button.props(remove="loading")
    address = _address_of(file)
    if not links.is_deleted:
        links.clear()
        with links:
            ui.link(file.name, address, new_tab=True)
    with client:
        ui.navigate.to(address, new_tab=True)


@functools.cache
def _address_of(file: Path) -> str:
    """Return the address of a file of this machine, as it is whenever it is asked."""
    address: str = app.add_static_file(local_file=file, max_cache_age=0)
    return address
