"""The tab Campaign: what share of launches meets the requirements, as draws come."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from nicegui import ui

from drakesep.page import elements
from drakesep.page.found_view import FoundView, hand_on
from drakesep.page.study import State, Study
from drakesep.page.study_bar import StudyBar
from drakesep.page.study_files import as_typed, case_argument, next_folder
from drakesep.page.workspace import Workspace


_STYLE = Path(__file__).with_name("studies.css")
_BEGIN = "Choose how many draws and start: histograms fill as draws come."
_WAITS = "Programs are made; histograms fill as soon as draws come."
_CHUNKS = 20
"""Into which draws are cut, so that histograms fill as one looks on."""


def build(workspace: Workspace) -> None:
    """Fill the tab."""
    ui.add_css(_STYLE)
    CampaignView(workspace)


class CampaignView:
    """The form at the left; shares, histograms and the verdict at the right."""

    def __init__(self, workspace: Workspace):
        from drakesep.page import study_charts

        self._charts_of = study_charts
        self._workspace = workspace
        self._shown: Mapping[str, Any] | None = None
        self._told: Study | None = None
        self._ended: Study | None = None
        self._shares: ui.echart | None = None
        self._histograms: list[ui.echart] = []
        with ui.element("div").classes("study"):
            with ui.element("div").classes("study-side"):
                self._form()
                StudyBar(workspace, "Campaign", self._begin, self._show)
                self._after = ui.element("div")
            with ui.element("div").classes("study-main"):
                self._nothing = elements.placeholder(_BEGIN)
                self._count = ui.label().classes("study-where")
                self._of_shares = ui.element("div")
                self._drawn = ui.element("div").classes("study-histograms")
                self._found = FoundView()
        self._show(None)

    def _form(self) -> None:
        with ui.element("div").classes("form"):
            self._runs = _number("draws", 10_000, step=1000, min=1)
            self._share = _number("share of launches", 0.99, step=0.001, min=0, max=1)
            self._confidence = _number("confidence", 0.9, step=0.01, min=0, max=1)
            self._seed = _number("seed", 0, min=0)
            ui.label(
                "The number of draws is fixed beforehand: to fly on until the verdict "
                "pleases would void its confidence."
            ).classes("study-words")

    def _begin(self) -> Study:
        runs = int(self._runs.value or 0)
        words = ["campaign", case_argument(self._workspace), "--runs", str(runs)]
        for name, field in (
            ("share", self._share),
            ("confidence", self._confidence),
            ("seed", self._seed),
        ):
            if field.value is not None:
                words += [f"--{name}", as_typed(field.value)]
        folder = next_folder(self._workspace, "campaign")
        words += ["--chunk", str(max(runs // _CHUNKS, 256)), "-o", str(folder)]
        assert self._workspace.case is not None  # which its argument has told
        return Study.begin(words, Path.cwd(), folder, self._workspace.case)

    def _show(self, study: Study | None) -> None:
        waits = study is not None and study.is_running and not study.draws
        self._nothing.set_visibility(study is None or waits)
        self._nothing.set_text(_WAITS if waits else _BEGIN)
        seen = study is not None and bool(study.draws)
        for element in (self._count, self._of_shares, self._drawn):
            element.set_visibility(seen)
        if study is None:
            return
        if study is not self._told:
            self._told, self._shown, self._histograms = study, None, []
            self._drawn.clear()
            self._found.clear()
            self._after.clear()
        last = study.draws[-1] if study.draws else None
        if last is not None and last is not self._shown:
            self._shown = last
            self._show_draws(study)
        if study.state is State.ENDED and study is not self._ended:
            self._ended = study
            with self._after:
                hand_on(study.folder, study.arguments[0])
            ui.timer(0.0, lambda: self._found.show(study.folder), once=True)

    def _show_draws(self, study: Study) -> None:
        last = study.draws[-1]
        before = (
            f", {last['before']} flown before beside them" if last["before"] else ""
        )
        self._count.set_text(f"{last['draws']} of {last['of']} draws{before}")
        shares = self._charts_of.shares_options(study.draws)
        if self._shares is None:  # a chart is as wide as there is room when it is made
            with self._of_shares:
                self._shares = ui.echart(shares).classes("study-chart")
            self._shares.props('role="img" aria-label="Share that is shown"')
        elements.redraw(self._shares, shares)
        told = last["requirements"]
        if len(self._histograms) != len(told):
            self._drawn.clear()
            with self._drawn:
                self._histograms = [
                    ui.echart({}).classes("study-chart").props('role="img"')
                    for _ in told
                ]
        for chart, each in zip(self._histograms, told, strict=True):
            chart.props(f'aria-label="{each["requirement"]} {each["axis"]}"')
            elements.redraw(chart, self._charts_of.histogram_options(each))


def _number(label: str, value: float, **limits: Any) -> ui.number:
    return ui.number(label, value=value, **limits).props("outlined dense")
