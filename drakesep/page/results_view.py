"""The tab Results: studies of the past, opened, reported, animated and compared."""

from pathlib import Path
from typing import Any

from nicegui import run, ui

from drakesep.page import elements
from drakesep.page.found_view import FoundView, hand_on
from drakesep.page.frames import facts, show_frame
from drakesep.page.past_results import Past, past_results
from drakesep.page.study_files import from_here
from drakesep.page.workspace import Workspace
from drakesep.systems.checks import InputError


_STYLE = Path(__file__).with_name("studies.css")
_COLUMNS = [
    {"name": key, "label": label, "field": key, "align": "left", "sortable": True}
    for key, label in (
        ("name", "folder"),
        ("case", "case"),
        ("study", "study"),
        ("begun", "begun"),
        ("ended", "ended"),
        ("verdict", "verdict"),
    )
]
_CHANGES = {
    "kind": "",
    "where": "where",
    "row": "row",
    "column": "column",
    "first": "first",
    "second": "second",
    "relative_difference": "relative difference",
}
_MOST = 200
"""Changes that are listed."""


def build(workspace: Workspace) -> None:
    """Fill the tab."""
    ui.add_css(_STYLE)
    ResultsView(workspace)


class ResultsView:
    """The list above; what is chosen of it below."""

    def __init__(self, workspace: Workspace):
        self._workspace = workspace
        self._all: dict[str, Past] = {}
        with ui.element("div").classes("study-main"):
            with ui.row().classes("study-pick"):
                ui.label(f"Results in {from_here(workspace.results)}")
                ui.space()
                self._compare = ui.button("Compare two", on_click=self._compared)
                self._compare.props("no-caps dense outline")
                refresh = ui.button(icon="refresh", on_click=self._list)
                refresh.props('flat dense round aria-label="Look again"')
            self._table = ui.table(
                rows=[],
                columns=_COLUMNS,
                row_key="name",
                selection="multiple",
                pagination=10,
                on_select=lambda _: self._chosen(),
            ).props("dense flat bordered")
            self._table.classes("results-table")
            self._table.props('no-data-label="No results yet"')
            self._table.on("row-click", self._row_clicked, [None, ["name"], None])
            self._below = ui.element("div").classes("study-tables")
            self._found = FoundView()
        elements.follow(workspace.looks, self._looked)

    def _looked(self) -> None:
        if self._workspace.tab == "Results":
            ui.timer(0.0, self._list, once=True)

    async def _list(self) -> None:
        found = await run.io_bound(past_results, self._workspace.results)
        self._all = {one.name: one for one in found or ()}
        kept = {row["name"] for row in self._table.selected}
        rows = [
            {**one._asdict(), "folder": str(one.folder), "ended": one.ended or "?"}
            for one in self._all.values()
        ]
        self._table.rows = rows
        self._table.selected = [row for row in rows if row["name"] in kept]
        self._compare.set_enabled(len(self._table.selected) == 2)

    async def _row_clicked(self, event: Any) -> None:
        """Open one: what was chosen before is so no more."""
        name = event.args[1]["name"]
        self._table.selected = [r for r in self._table.rows if r["name"] == name]
        await self._chosen()

    async def _chosen(self) -> None:
        await self._list()  # one that was under way has gone on
        chosen = [self._all[row["name"]] for row in self._table.selected]
        if len(chosen) == 1:
            self._found.clear()
            self._below.clear()
            with self._below:
                self._say(chosen[0])
            if not chosen[0].unreadable:
                await self._found.show(chosen[0].folder)

    def _say(self, one: Past) -> None:
        """Say what a study is, and what can be handed on of it."""
        if one.unreadable:
            ui.label(one.unreadable).classes("wrong")
            return
        ui.label(one.name).classes("study-title")
        hand_on(one.folder, one.study)
        facts(
            [
                ("case", one.case),
                ("begun", f"{one.begun}, took {one.seconds:.0f} s"),
                ("ended", " ".join(filter(None, (one.ended, one.verdict)))),
            ]
        )

    async def _compared(self) -> None:
        """Say what changed between the two that are chosen, the older first."""
        second, first = (
            self._all[row["name"]].folder for row in _newest_first(self._table.selected)
        )

        def compared() -> Any:
            from drakesep.reports.compare import compare

            return compare(first, second)

        self._compare.props("loading")
        try:
            changes = await run.io_bound(compared)
        except InputError as error:
            elements.say_wrong(str(error))
            return
        finally:
            self._compare.props(remove="loading")
        if changes is None:  # the page is gone
            return
        self._found.clear()
        self._below.clear()
        with self._below:
            ui.label(f"From {first.name} to {second.name}").classes("study-title")
            same = "No answer differs" if changes.same else "Answers differ"
            rest = len(changes.table) - _MOST
            more = f"; {rest} more are not listed" if rest > 0 else ""
            ui.label(f"{same}: {len(changes.table)} changes{more}")
            show_frame(changes.table.head(_MOST), _CHANGES)


def _newest_first(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return sorted(rows, key=lambda row: row["begun"], reverse=True)
