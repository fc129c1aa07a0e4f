"""The tab Play: values changed by sliders, and the motion that comes of them."""

import asyncio
import contextlib
import html
import math
import shlex
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from nicegui import ui

from drakesep.page import case_edit, charts, elements, playing
from drakesep.page.flights import Flights, FlightsEnded
from drakesep.page.sliders import Sliders
from drakesep.page.workspace import Workspace


if TYPE_CHECKING:  # imports Drake
    from drakesep.page.flown import Fares, Flown

_TRIES, _PAUSE = 40, 0.05
"""How often it is looked whether the browser has a chart, and how long between, s."""
_SIGNS = {"<=": "≤", ">=": "≥", "<": "<", ">": ">"}


def build(workspace: Workspace) -> None:
    """Fill the tab."""
    PlayView(workspace)


class PlayView:
    """Sliders at the left; charts, and what is required, at the right."""

    def __init__(self, workspace: Workspace):
        self._workspace = workspace
        self._playing = playing.Playing()
        self._body = ""
        self._nominal: Flown | None = None
        self._measured: Mapping[tuple[str, str, str, str], Fares] = {}
        self._fares: ui.html | None = None
        self._shown: list[tuple[charts.Chart, ui.echart]] = []
        self._flown: int | None = None
        with ui.element("div").classes("play"):
            with ui.element("div").classes("play-side"):
                self._build_side()
            with ui.element("div").classes("play-main"):
                self._note = ui.label().classes("play-note").props('role="status"')
                self._charts = ui.element("div").classes("play-charts")
                self._command = ui.label().classes("play-command")
        elements.follow(workspace.changes, self._case_changed)
        elements.follow(workspace.looks, self._case_changed)

    def _build_side(self) -> None:
        with ui.row().classes("play-tools"):
            ui.button("Reset", on_click=self._reset).props("flat no-caps dense")
            nominal = ui.button("Make nominal", on_click=self._make_nominal)
            nominal.props("flat no-caps dense")
            nominal.tooltip("Write these values into the case")
            self._follows = ui.switch("Clearance", on_change=self._measure)
            self._follows.props("dense").tooltip("Measure how near parts come")
        self._sliders = Sliders(self._move)
        self._more = elements.chosen_by_typing(
            [], "another parameter", on_change=self._add
        ).props("clearable")
        self._more.classes("play-more")

    # What changes.

    def _case_changed(self) -> None:
        """Fly what the case has become, once somebody looks."""
        workspace = self._workspace
        if workspace.tab != "Play" or self._flown == workspace.revision:
            return
        self._flown = workspace.revision
        case = workspace.case
        if case is None:
            self._say("The case is not right: see the tab Case.")
            return
        if self._playing.follow(case) or not self._sliders.props["sliders"]:
            self._sliders.show(self._playing)
            self._more.set_options(playing.others(case))
        self._nominal, self._measured = None, {}
        ui.timer(0.0, self._fly_nominal, once=True)

    async def _move(self, moved: Mapping[str, float]) -> None:
        for name, value in moved.items():
            if name in self._playing.played:
                self._playing.put(name, float(value))
        await self._fly()

    async def _reset(self) -> None:
        self._playing.reset()
        self._sliders.show(self._playing)
        await self._fly()

    def _add(self, event: Any) -> None:
        case = self._workspace.case
        if event.value and case is not None:
            self._playing.add(case, event.value)
            self._sliders.show(self._playing)
            self._more.set_value(None)

    def _make_nominal(self) -> None:
        """Write the values of the sliders into the case, as one change."""

        def write() -> None:
            text = self._workspace.text
            for name, value in self._playing.values.items():
                text = case_edit.with_parameter(text, name, value)
            self._workspace.change(text)

        if elements.attempt(write):
            self._sliders.show(self._playing)

    # What is flown.

    async def _fly_nominal(self) -> None:
        flown = await self._ask(self._workspace.flights, {}, "nominal")
        if flown is None:
            return
        self._nominal = flown
        await self._show_charts(flown)
        for chart, shown in self._shown:
            _set(shown, charts.nominal_data(chart, flown))
        await self._fly()

    async def _fly(self) -> None:
        self._measured = {}
        flown = await self._ask(self._workspace.flights, self._playing.values, "run")
        if flown is None:
            return
        self._say(flown.message and f"This run failed: {flown.message}")
        for chart, shown in self._shown if not flown.message else ():
            _set(shown, charts.run_data(chart, flown))
        self._show_fares(flown.fares)
        self._command.set_text(self._as_command())
        await self._measure()

    async def _measure(self) -> None:
        """Measure clearances, if that is wanted."""
        workspace = self._workspace
        if not self._follows.value or workspace.case is None:
            return
        asked = workspace.revision, dict(self._playing.values)
        flown = await self._ask(workspace.measuring, asked[1], "run", measure=True)
        now = workspace.revision, self._playing.values
        if flown is not None and asked == now:
            self._measured = {_key(each): each for each in flown.fares}
            self._show_fares(flown.fares)

    async def _ask(
        self,
        flights: Flights,
        values: Mapping[str, float],
        what: str,
        *,
        measure: bool = False,
    ) -> "Flown | None":
        """Return a run; None if something newer is flown, or it cannot be."""
        case = self._workspace.case
        if case is None:
            return None
        try:
            return await flights.newest(
                *(case.in_si(), values),
                asker=(id(self), what),
                restarts=elements.warn,
                measure=measure,
            )
        except (FlightsEnded, ValueError) as error:
            self._say(f"This cannot be flown: {error}")
            return None

    # What is shown.

    def _say(self, words: str) -> None:
        self._note.set_text(words)
        self._note.set_visibility(bool(words))
        if words:
            self._charts.classes(add="stale")
        else:
            self._charts.classes(remove="stale")

    async def _show_charts(self, flown: "Flown") -> None:
        """Have a chart for each quantity of the body that is looked at."""
        case = self._workspace.case
        if case is None or flown.message:
            return
        bodies = list(flown.times)
        if self._body not in bodies:
            self._body = bodies[0]
        wanted = charts.charts_of(flown, self._body)
        if [chart for chart, _ in self._shown] == wanted:
            return
        self._charts.clear()
        self._shown = []
        with self._charts:
            if len(bodies) > 1:
                ui.toggle(bodies, value=self._body, on_change=self._look_at).props(
                    "dense no-caps unelevated"
                ).classes("play-bodies")
            for chart in wanted:
                shown = ui.echart(charts.options(chart, flown)).classes("play-chart")
                shown.props(f'aria-label="{chart.title}" role="img"')
                self._shown.append((chart, shown))
            self._fares = ui.html(sanitize=False).classes("play-fares")
        await self._drawn()

    async def _drawn(self) -> None:
        """Wait until the browser has the charts: what it is told before is lost."""
        for _, shown in self._shown:
            for _ in range(_TRIES):
                with contextlib.suppress(TimeoutError):
                    if await shown.run_chart_method("getWidth", timeout=2.0):
                        break
                await asyncio.sleep(_PAUSE)

    async def _look_at(self, event: Any) -> None:
        self._body = event.value
        await self._fly_nominal()

    def _show_fares(self, fares: Sequence["Fares"]) -> None:
        """Show how the run fares by each requirement, beside the nominal."""
        shown = self._fares
        if shown is None:
            return
        of_nominal = self._nominal.fares if self._nominal else ()
        nominal = {_key(each): each for each in of_nominal}
        rows = [
            _row(self._measured.get(_key(each), each), nominal.get(_key(each)))
            for each in fares
        ]
        shown.set_content(f"<table>{_HEAD}<tbody>{''.join(rows)}</tbody></table>")
        shown.set_visibility(bool(rows))

    def _as_command(self) -> str:
        """Return the command that flies the same."""
        case = self._workspace.case
        if case is None or case.source is None:
            return "Save the case to fly the same on the command line."
        changes = " ".join(
            f"--set {name}={value!r}" for name, value in self._playing.values.items()
        )
        return f"drakesep simulate {shlex.quote(case.source)} {changes}".strip()


def _set(shown: ui.echart, series: list[dict[str, Any]]) -> None:
    shown.run_chart_method("setOption", {"series": series})


_RIGHT = ' class="number"'
_HEAD = (
    f"<thead><tr><th>requirement</th><th{_RIGHT}>limit</th><th{_RIGHT}>nominal</th>"
    f"<th{_RIGHT}>this run</th><th></th></tr></thead>"
)


def _key(fares: "Fares") -> tuple[str, str, str, str]:
    return fares.requirement, fares.axis, fares.pair, fares.sense


def _row(fares: "Fares", nominal: "Fares | None") -> str:
    unit = html.escape(fares.unit)
    what = ", ".join(filter(None, (fares.requirement, fares.axis)))
    limit = f"{_SIGNS[fares.sense]} {fares.limit:.4g} {unit}"
    cells = (
        f"<td>{html.escape(what)}</td>",
        f"<td{_RIGHT}>{limit}</td>",
        f"<td{_RIGHT}>{_number(nominal.value if nominal else math.nan)}</td>",
        f"<td{_RIGHT}>{_number(fares.value)}</td>",
        f'<td class="verdict-{fares.verdict.replace(" ", "-")}">{fares.verdict}</td>',
    )
    return f"<tr>{''.join(cells)}</tr>"


def _number(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.4g}"
