"""The tab Search: what is searched, every iterate as it comes, the worst cases."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd
from nicegui import run, ui

from drakesep.files import written
from drakesep.page import elements, jobs
from drakesep.page.found import show_found
from drakesep.page.response import Response
from drakesep.page.search_form import SearchForm
from drakesep.page.study import State, Study
from drakesep.page.study_bar import StudyBar
from drakesep.page.study_files import export_beside
from drakesep.page.workspace import Workspace


_STYLE = Path(__file__).with_name("studies.css")


def build(workspace: Workspace) -> None:
    """Fill the tab."""
    ui.add_css(_STYLE)
    SearchView(workspace)


class SearchView:
    """The form at the left; iterates, parameters, motion and tables at the right."""

    def __init__(self, workspace: Workspace):
        from drakesep.page import study_charts

        self._charts_of = study_charts
        self._workspace = workspace
        self._bounds: study_charts.Bounds | None = None
        self._objective = ""
        self._chosen: Mapping[str, Any] | None = None
        self._follows = True
        self._told: Study | None = None
        self._ended: Study | None = None
        with ui.element("div").classes("study"):
            with ui.element("div").classes("study-side"):
                self._form = SearchForm(workspace)
                StudyBar(workspace, "Search", self._begin, self._show)
                self._finish_buttons()
            with ui.element("div").classes("study-main"):
                self._nothing = elements.placeholder(
                    "Choose objectives and start: every iterate is shown as it comes."
                )
                self._seen = ui.element("div").classes("study-seen")
                with self._seen:
                    self._looks()
                self._tables = ui.element("div").classes("study-tables")
        self._show(None)

    def _finish_buttons(self) -> None:
        with ui.row().classes("study-bar") as self._after:
            _quiet("Export", "Its case, and the command that does it", self._export)
            self._report = _quiet("Report", "One page to be read", self._open_report)
            self._film = _quiet("Animation", "The runs, animated", self._animate)
        self._exported = ui.label().classes("study-command")

    def _looks(self) -> None:
        """Build what shows iterates."""
        with ui.row().classes("study-pick"):
            self._of = ui.select([], label="objective", on_change=self._other)
            self._of.props("outlined dense").classes("study-of")
            self._best = ui.label().classes("study-best")
            ui.space()
            self._where = ui.label().classes("study-where").props('aria-live="polite"')
            for icon, words, step in (
                ("chevron_left", "Iterate before", -1),
                ("chevron_right", "Next iterate", 1),
            ):
                button = ui.button(icon=icon, on_click=lambda step=step: self._go(step))
                button.props(f'flat dense round aria-label="{words}"').tooltip(words)
            self._film_one = ui.button(icon="movie", on_click=self._animate_chosen)
            self._film_one.props('flat dense round aria-label="Animate this iterate"')
            self._film_one.tooltip("Animate this iterate")
        with ui.element("div").classes("study-pair"):
            self._iterates = ui.echart(
                self._charts_of.iterates_options([], None), on_point_click=self._clicked
            ).classes("study-chart")
            self._iterates.props('role="img" aria-label="Iterates"')
            self._in_bounds = ui.echart({}).classes("study-chart")
            self._in_bounds.props('role="img" aria-label="Parameters in their bounds"')
        self._response = Response(self._workspace)

    # What is asked.

    def _begin(self) -> Study:
        command = self._form.command()
        self._follows, self._chosen = True, None
        case = self._workspace.case
        assert case is not None  # which the command has told
        return Study.begin(command, Path.cwd(), Path(command[-1]), case)

    # What is told.

    def _show(self, study: Study | None) -> None:
        """Show what the study has told so far."""
        self._after.set_visibility(study is not None and study.state is State.ENDED)
        self._nothing.set_visibility(study is None or not study.iterates)
        self._seen.set_visibility(study is not None and bool(study.iterates))
        if study is None:
            return
        if study is not self._told:
            self._told, self._objective, self._bounds = study, "", None
            self._tables.clear()
            self._exported.set_text("")
        if study.iterates:
            self._show_iterates(study)
        if not study.is_running:
            self._form.warm_soon()  # for the next one, or for going on
        if study.state is State.ENDED and study is not self._ended:
            self._ended = study
            ui.timer(0.0, lambda: self._show_found(study), once=True)

    def _show_iterates(self, study: Study) -> None:
        names = [*dict.fromkeys(str(key[0]) for key in study.iterates)]
        if [*self._of.options] != names:
            self._of.set_options(names)
        if self._objective not in names:
            self._objective = names[0]
            self._of.set_value(names[0])
        rows = self._rows(study)
        ascended = {row["search"] for row in rows}
        swept = {
            search: best
            for search, best in study.best.get(self._objective, {}).items()
            if search not in ascended and best["value"] is not None
        }
        self._best.set_text(
            ", ".join(f"{s}: {b['value']:.6g} {b['unit']}" for s, b in swept.items())
        )
        if self._follows and rows:
            self._choose(self._worst_of(study, rows))
        self._draw(study)

    def _rows(self, study: Study) -> list[Mapping[str, Any]]:
        return [r for k, r in study.iterates.items() if k[0] == self._objective]

    @staticmethod
    def _worst_of(study: Study, rows: list[Mapping[str, Any]]) -> Mapping[str, Any]:
        """Return the iterate that is worst so far: the objective goes up or down."""
        first = rows[0]
        mine = [r["value"] for r in rows if _ascent(r) == _ascent(first)]
        down = mine[-1] < mine[0]
        return (min if down else max)(rows, key=lambda r: r["value"])

    def _choose(self, row: Mapping[str, Any]) -> None:
        if row is self._chosen:
            return
        self._chosen = row
        self._where.set_text(
            f"{row['search']} {row['start']}, iterate {row['iteration']}: "
            f"{row['value']:.6g} {row['unit']}"
        )
        ui.timer(0.0, self._fly_chosen, once=True)

    async def _fly_chosen(self) -> None:
        row, study = self._chosen, self._told
        bounds = await self._known_bounds()
        if row is None or bounds is None or study is None:
            return
        elements.redraw(self._in_bounds, self._charts_of.bounds_options(bounds, row))
        await self._response.show(study.case, {n: row[n] for n in bounds.nominal})

    async def _known_bounds(self) -> Any:
        if self._bounds is None and self._told is not None:
            make, case = self._charts_of.Bounds.of, self._told.case
            self._bounds = await run.io_bound(lambda: make(case.in_si()))
        return self._bounds

    def _draw(self, study: Study) -> None:
        options = self._charts_of.iterates_options(self._rows(study), self._chosen)
        elements.redraw(self._iterates, options)

    # What is looked at.

    def _other(self, event: Any) -> None:
        study = self._told
        if study is not None and event.value and event.value != self._objective:
            self._objective, self._follows = event.value, True
            self._chosen = None
            self._show_iterates(study)

    def _clicked(self, event: Any) -> None:
        study, value = self._told, event.value
        if study is None or not isinstance(value, list):
            return
        for row in self._rows(study):
            named = f"{row['search']} {row['start']}" == event.series_name
            if named and [row["evaluations"], row["value"]] == value[:2]:
                self._pick(row)

    def _go(self, step: int) -> None:
        """Show the iterate before or after the one that is shown."""
        study = self._told
        if study is None or self._chosen is None:
            return
        rows = sorted(self._rows(study), key=lambda r: (_ascent(r), r["iteration"]))
        place = next((i for i, r in enumerate(rows) if r == self._chosen), 0)
        self._pick(rows[(place + step) % len(rows)])

    def _pick(self, row: Mapping[str, Any]) -> None:
        self._follows = False
        self._choose(row)
        if self._told is not None:
            self._draw(self._told)

    # What is found.

    async def _show_found(self, study: Study) -> None:
        self._tables.clear()
        with self._tables:
            await show_found(study.folder, self._show_worst)

    async def _show_worst(self, objective: str, values: Mapping[str, float]) -> None:
        self._follows = False
        self._where.set_text(f"worst case of {objective}, in Drake")
        self._chosen = {**values, "name": f"worst_{objective}"}
        bounds = await self._known_bounds()
        if bounds is not None:
            options = self._charts_of.bounds_options(bounds, self._chosen)
            elements.redraw(self._in_bounds, options)
        self._seen.run_method("scrollIntoView")
        if self._told is not None:
            await self._response.show(self._told.case, values)

    async def _animate_chosen(self) -> None:
        """Animate the run that is shown, beside the nominal."""
        bounds, study = await self._known_bounds(), self._told
        if study is None or self._chosen is None or bounds is None:
            return
        folder = study.folder.with_name(f"{study.folder.name}-iterate")
        row = {"label": "shown", **{n: self._chosen[n] for n in bounds.nominal}}
        with written(folder.with_suffix(".csv")) as beside:
            pd.DataFrame([row]).to_csv(beside, index=False)
        table, file = folder.with_suffix(".csv"), folder.with_suffix(".html")
        case = study.arguments[1]
        words = ("animate", case, "--runs", str(table), "--run", "shown")
        await jobs.open_page(self._film_one, (*words, "-o", str(file)), file)

    async def _animate(self) -> None:
        await _page_of(self._told, "animate", self._film)

    async def _open_report(self) -> None:
        await _page_of(self._told, "report", self._report)

    def _export(self) -> None:
        study = self._told
        if study is None:
            return
        elements.attempt(lambda: self._exported.set_text(export_beside(study.folder)))


async def _page_of(study: Study | None, command: str, button: ui.button) -> None:
    if study is not None:
        file = study.folder.with_name(f"{study.folder.name}-{command}.html")
        words = (command, str(study.folder), "-o", str(file))
        await jobs.open_page(button, words, file)


def _ascent(row: Mapping[str, Any]) -> tuple[str, int]:
    return row["search"], row["start"]


def _quiet(words: str, tip: str, action: Any) -> ui.button:
    button = ui.button(words, on_click=action)
    button.props("flat dense no-caps").tooltip(tip)
    return button
