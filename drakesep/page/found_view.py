"""What a study has found, shown: tables that answer, and what is handed on of it."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from nicegui import run, ui

from drakesep.page import elements, jobs
from drakesep.page.found import EVIDENCE, read_found
from drakesep.page.frames import show_frame
from drakesep.page.study_files import export


_ANIMATED = ("simulate", "clearance", "worst-case", "verify")
"""Studies that keep runs."""
OnWorst = Callable[[str, Mapping[str, float]], Any]
"""Called with a worst case's objective, and its parameters with units."""


class FoundView:
    """Tables of one folder; of another in their place, the newest that is asked for."""

    def __init__(self, on_worst: OnWorst | None = None):
        """Build it where it is made, with nothing in it.

        Args:
            on_worst: called for a worst case whose run is to be shown.
        """
        self._on_worst = on_worst
        self._folder: Path | None = None
        self._tables = ui.element("div").classes("study-tables")

    def clear(self) -> None:
        """Show nothing."""
        self._folder = None
        self._tables.clear()

    async def show(self, folder: Path) -> None:
        """Show what stands in a folder.

        Args:
            folder: with results.
        """
        self._folder = folder
        found = await run.io_bound(read_found, folder)
        if found is None or folder != self._folder:  # the page is gone, or is elsewhere
            return

        def show_run(row: Mapping[str, Any]) -> Any:
            assert self._on_worst is not None
            return self._on_worst(row["objective"], found.worst[row["objective"]])

        self._tables.clear()
        with self._tables:
            if found.wrong:
                ui.label(found.wrong).classes("wrong").props('role="alert"')
            for part in found.parts:
                ui.label(part.title).classes("study-title")
                of_worst = part.file == EVIDENCE and self._on_worst is not None
                show_frame(
                    *(part.table, part.columns),
                    on_row=show_run if of_worst else None,
                    button="Show run",
                )


def hand_on(folder: Path, study: str) -> None:
    """Build buttons for what can be handed on of a study: export, report, animation.

    Args:
        folder: with its results.
        study: its name.
    """
    with ui.row().classes("study-bar"):
        exported = _quiet("Export", "Its case, and the command that does it")
        report = _quiet("Report", "One page to be read")
        if study in _ANIMATED:
            film = _quiet("Animation", "The runs, animated")
    says = ui.label().classes("study-command")
    made = ui.row().classes("study-made")

    def say_export() -> None:
        target = folder.with_name(f"{folder.name}-export")

        def write() -> None:
            says.set_text(export(folder, target))

        elements.attempt(write)

    exported.on_click(say_export)
    report.on_click(lambda: jobs.open_page(report, "report", folder, made))
    if study in _ANIMATED:
        film.on_click(lambda: jobs.open_page(film, "animate", folder, made))


def _quiet(words: str, tip: str) -> ui.button:
    return ui.button(words).props("flat dense no-caps").tooltip(tip)
