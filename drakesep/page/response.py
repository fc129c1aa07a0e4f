"""The motion at a point of the tolerances, over the nominal and the limits."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from nicegui import ui

from drakesep.page import charts, elements
from drakesep.page.flights import FlightsEnded
from drakesep.page.workspace import Workspace


if TYPE_CHECKING:  # imports Drake
    from drakesep.case_file.case import Case
    from drakesep.page.flown import Flown

_SHOWN = 3
"""Charts, of the body that leaves first."""


class Response:
    """Charts of one run; the newest that is asked for is shown."""

    def __init__(self, workspace: Workspace):
        self._workspace = workspace
        self._nominal: tuple[Case, Flown] | None = None
        self._note = ui.label().classes("study-words wrong").props('role="alert"')
        self._charts = ui.element("div").classes("response")
        self._built: list[tuple[charts.Chart, ui.echart]] = []

    async def show(self, case: "Case", values: Mapping[str, float]) -> None:
        """Fly a point and show its motion.

        Args:
            case: that is flown.
            values: of parameters, by their names with units.
        """
        nominal = await self._of_nominal(case)
        if nominal is None:
            return
        flown = await self._fly(case, values, "run")
        if flown is None:
            return
        self._say(flown.message and f"This run failed: {flown.message}")
        for chart, shown in self._built if not flown.message else ():
            options = charts.options(chart, nominal)
            changed = {each["id"]: each for each in charts.run_data(chart, flown)}
            for series in options["series"]:
                series.update(changed.get(series["id"], {}))
            elements.redraw(shown, options)

    def _say(self, wrong: str) -> None:
        """Say what is wrong: what was shown before is not what is asked for then."""
        self._note.set_text(wrong)
        self._charts.classes(add="stale" * bool(wrong), remove="stale" * (not wrong))

    async def _of_nominal(self, case: "Case") -> "Flown | None":
        if self._nominal is not None and self._nominal[0] is case:
            return self._nominal[1]
        flown = await self._fly(case, {}, "nominal")
        if flown is None:
            return None
        if flown.message:
            self._say(f"The nominal run failed: {flown.message}")
            return None
        self._nominal = case, flown
        self._charts.clear()
        with self._charts:
            wanted = charts.charts_of(flown, next(iter(flown.times)))[:_SHOWN]
            self._built = [(chart, self._chart(chart, flown)) for chart in wanted]
        return flown

    def _chart(self, chart: charts.Chart, flown: "Flown") -> ui.echart:
        shown = ui.echart(charts.options(chart, flown)).classes("study-chart")
        shown.props(f'role="img" aria-label="{chart.title}"')
        return shown

    async def _fly(
        self, case: "Case", values: Mapping[str, float], what: str
    ) -> "Flown | None":
        flights = self._workspace.flights
        try:
            return await flights.newest(
                *(case.in_si(), values), asker=(id(self), what), restarts=elements.warn
            )
        except (FlightsEnded, ValueError) as error:
            self._say(f"This cannot be flown: {error}")
            return None
