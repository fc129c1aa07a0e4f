"""The tab Search: what is searched, every iterate as it comes, the worst cases."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd
from nicegui import run, ui

from drakesep.files import written
from drakesep.page import elements, jobs
from drakesep.page.found_view import FoundView, hand_on
from drakesep.page.response import Response
from drakesep.page.search_form import SearchForm
from drakesep.page.study import State, Study
from drakesep.page.study_bar import StudyBar
from drakesep.page.workspace import Workspace


if TYPE_CHECKING:
    from drakesep.case_file.case import Case
    from drakesep.page import study_charts

_BEGIN = "Choose objectives and start: every iterate is shown as it comes."
_WAITS = "Programs are made; iterates are shown as soon as they come."
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
        self._bounds: tuple[Case, study_charts.Bounds] | None = None
        self._objective = ""
        self._chosen: Mapping[str, Any] | None = None
        self._follows = True
        self._told: Study | None = None
        self._ended: Study | None = None
        with ui.element("div").classes("study"):
            with ui.element("div").classes("study-side"):
                self._form = SearchForm(workspace)
                StudyBar(workspace, "Search", self._begin, self._show)
                self._after = ui.element("div")
            with ui.element("div").classes("study-main"):
                self._nothing = elements.placeholder(_BEGIN)
                self._seen = ui.element("div").classes("study-seen")
                with self._seen:
                    self._looks()
                self._found = FoundView(self._show_worst)
        self._show(None)

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
            self._film_link = ui.element("span").classes("study-made")
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
        waits = study is not None and study.is_running and not study.iterates
        self._nothing.set_visibility(study is None or waits)
        self._nothing.set_text(_WAITS if waits else _BEGIN)
        self._seen.set_visibility(study is not None and bool(study.iterates))
        if study is None:
            return
        if study is not self._told:
            self._told, self._objective = study, ""
            self._found.clear()
            self._after.clear()
        if study.iterates:
            self._show_iterates(study)
        if not study.is_running:
            self._form.warm_soon()  # for the next one, or for going on
        if study.state is State.ENDED and study is not self._ended:
            self._ended = study
            with self._after:
                hand_on(study.folder, study.arguments[0])
            ui.timer(0.0, lambda: self._found.show(study.folder), once=True)

    def _show_iterates(self, study: Study) -> None:
        names = [*dict.fromkeys(str(key[0]) for key in study.iterates)]
        if [*self._of.options] != names:
            self._of.set_options(names)
        if self._objective not in names:
            self._objective = names[0]
            self._of.set_value(names[0])
        rows = study.rows_of(self._objective)
        ascended = {row["search"] for row in rows}
        swept = {
            search: best
            for search, best in study.best.get(self._objective, {}).items()
            if search not in ascended and best["value"] is not None
        }
        self._best.set_text(
            ", ".join(f"{s}: {b['value']:.6g} {b['unit']}" for s, b in swept.items())
        )
        if self._follows:
            self._choose(study.worst_of(self._objective))
        self._draw(study)

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
        if row is None or study is None:
            return
        bounds = await self._bounds_of(study)
        if bounds is None or row is not self._chosen:  # another is, meanwhile
            return
        elements.redraw(self._in_bounds, self._charts_of.bounds_options(bounds, row))
        await self._response.show(study.case, {n: row[n] for n in bounds.nominal})

    async def _bounds_of(self, study: Study) -> "study_charts.Bounds | None":
        """Return the bounds of a study's parameters; None: the page is gone."""
        case = study.case
        if self._bounds is None or self._bounds[0] is not case:
            make = self._charts_of.Bounds.of
            made = await run.io_bound(lambda: make(case.in_si()))
            if made is None:
                return None
            self._bounds = case, made
        return self._bounds[1]

    def _draw(self, study: Study) -> None:
        options = self._charts_of.iterates_options(
            study.rows_of(self._objective), self._chosen
        )
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
        for row in study.rows_of(self._objective):
            named = f"{row['search']} {row['start']}" == event.series_name
            if named and [row["evaluations"], row["value"]] == value[:2]:
                self._pick(row)

    def _go(self, step: int) -> None:
        """Show the iterate before or after the one that is shown."""
        study = self._told
        if study is None or self._chosen is None:
            return
        rows = sorted(
            study.rows_of(self._objective), key=lambda r: (_ascent(r), r["iteration"])
        )
        place = next((i for i, r in enumerate(rows) if r == self._chosen), 0)
        self._pick(rows[(place + step) % len(rows)])

    def _pick(self, row: Mapping[str, Any]) -> None:
        self._follows = False
        self._choose(row)
        if self._told is not None:
            self._draw(self._told)

    # What is found.

    def _show_worst(self, objective: str, values: Mapping[str, float]) -> None:
        """Show a worst case as an iterate is, ringed by none."""
        self._follows = False
        self._where.set_text(f"worst case of {objective}, in Drake")
        self._chosen = {**values}
        ui.timer(0.0, self._fly_chosen, once=True)
        self._seen.run_method("scrollIntoView")
        if self._told is not None:
            self._draw(self._told)

    async def _animate_chosen(self) -> None:
        """Animate the run that is shown, beside the nominal."""
        study, chosen = self._told, self._chosen
        if study is None or chosen is None:
            return
        bounds = await self._bounds_of(study)
        if bounds is None:
            return
        folder = study.folder.with_name(f"{study.folder.name}-iterate")
        row = {"label": "shown", **{n: chosen[n] for n in bounds.nominal}}
        with written(folder.with_suffix(".csv")) as beside:
            pd.DataFrame([row]).to_csv(beside, index=False)
        table, file = folder.with_suffix(".csv"), folder.with_suffix(".html")
        case = study.arguments[1]
        words = ("animate", case, "--runs", str(table), "--run", "shown")
        made = (*words, "-o", str(file))
        await jobs.open_file(self._film_one, made, file, self._film_link)


def _ascent(row: Mapping[str, Any]) -> tuple[str, int]:
    return row["search"], row["start"]
