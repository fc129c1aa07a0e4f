"""What is searched and how: the form of the tab Search, and the command it makes."""

import contextlib

from nicegui import run, ui

from drakesep.page import elements
from drakesep.page.study import SPARE
from drakesep.page.study_files import as_typed, case_argument, next_folder
from drakesep.page.workspace import Workspace
from drakesep.systems.checks import InputError


_KINDS = {
    "worst-case": "Worst cases",
    "verify": "Requirements",
}
_SEARCHES = ["sqp", "multistart", "best", "samples", "vertices", "corners", "evolution"]
_NUMBERS = ("starts", "samples", "seed", "minutes")
_CHEAP = "highest_final_rate_x"
"""What it takes, most objectives take that may be chosen then."""
_PAUSE = 0.6
"""After the last change of a choice, before programs are made for it, s."""


class SearchForm:
    """The form; what it says is a command line."""

    def __init__(self, workspace: Workspace):
        self._workspace = workspace
        self._revision = -1
        with ui.element("div").classes("form"):
            self._kind = ui.toggle(
                _KINDS, value="worst-case", on_change=self._kind_changed
            ).props("no-caps dense unelevated spread")
            self._objectives = elements.chosen_by_typing(
                {}, "objectives", multiple=True
            ).props("use-chips")
            self._objectives.on_value_change(self.warm_soon)
            self._metric()
            with ui.element("div").classes("form-beside") as self._beside:
                self._failures = ui.switch("Failure cases, too").props("dense")
                self._proofs = ui.switch("Proven bounds, too").props("dense")
                self._proofs.tooltip("What nothing within the tolerances is beyond")
                self._draws = ui.number("launches drawn, too", min=1, step=1000)
                self._draws.props("outlined dense clearable")
            self._searches = ui.select(
                _SEARCHES,
                label="searches; what suits if empty",
                multiple=True,
                value=["sqp", "multistart"],
            ).props("outlined dense use-chips")
            with ui.element("div").classes("form-numbers"):
                self._numbers = {
                    name: ui.number(name, min=0).props("outlined dense")
                    for name in _NUMBERS
                }
        self._beside.set_visibility(False)
        self._pause = ui.timer(_PAUSE, self._warm, active=False, once=False)
        elements.follow(workspace.changes, self._case_changed)
        elements.follow(workspace.looks, self._case_changed)

    def _metric(self) -> None:
        """Build what names an objective on any metric and window."""
        from drakesep.page import objective_choice as choice

        with (
            ui.expansion("Objective on any metric", icon="add")
            .classes("form-metric")
            .props("duration=0")
        ):
            with ui.element("div").classes("form-pair"):
                self._sense = _select("sense", list(choice.SENSES), "highest")
                self._axis = _select("axis", {a: a or "none" for a in choice.AXES}, "x")
            self._quantity = elements.chosen_by_typing(
                choice.quantities(), "quantity", value="rate"
            )
            with ui.element("div").classes("form-pair"):
                self._window = _select("when", dict(choice.WINDOWS), "after_separation")
                self._extreme = _select("of it", dict(choice.EXTREMES), "")
            with ui.element("div").classes("form-pair") as times:
                self._from = ui.number("from (s)", min=0.0).props("outlined dense")
                self._to = ui.number("to (s)", min=0.0).props("outlined dense")
            times.bind_visibility_from(self._window, "value", value="from")
            self._wrong = ui.label().classes("wrong").props('role="alert"')
            add = ui.button("Add objective", on_click=self._add)
            add.props("no-caps dense outline")

    async def _add(self) -> None:
        """Add the objective that is named, or say there what is wrong with it."""
        from drakesep.page.objective_choice import objective_name

        case = self._workspace.case
        if case is None:
            self._wrong.set_text("the case is not right: see the tab Case")
            return

        def named() -> str:
            return objective_name(
                case.in_si(),
                sense=self._sense.value,
                quantity=self._quantity.value,
                extreme=self._extreme.value,
                window=self._window.value,
                start=self._from.value,
                end=self._to.value,
                axis=self._axis.value,
            )

        try:
            name = await run.io_bound(named)
        except InputError as error:
            self._wrong.set_text(str(error))
            return
        if name is None:  # the page is gone
            return
        self._wrong.set_text("")
        self._objectives.set_options({**dict(self._objectives.options), name: name})
        self._objectives.set_value([*self._chosen(), name])

    # What is chosen.

    def _chosen(self) -> list[str]:
        return [*(self._objectives.value or ())]

    @property
    def kind(self) -> str:
        """The study that is asked for."""
        return str(self._kind.value)

    def command(self) -> tuple[str, ...]:
        """Return the command line, with where it writes last.

        Raises:
            ValueError: the case is not right, or must be saved first.
        """
        words = [self.kind, case_argument(self._workspace)]
        for name in self._chosen():
            words += ["--objective", name]
        for name in self._searches.value or ():
            words += ["--search", name]
        for name, number in self._numbers.items():
            if number.value is not None:
                words += [f"--{name}", as_typed(number.value)]
        if self.kind == "verify":
            words += self._asked_beside()
        return (*words, "-o", str(next_folder(self._workspace, self.kind)))

    def _asked_beside(self) -> list[str]:
        """Return the options of what is verified beside the worst cases."""
        words = []
        if self._failures.value and self._failures.enabled:
            words.append("--failures")
        if self._proofs.value:
            words.append("--prove")
        if self._draws.value is not None:
            words += ["--campaign", as_typed(self._draws.value)]
        return words

    # What follows the case.

    def _kind_changed(self) -> None:
        verifies = self.kind == "verify"
        self._beside.set_visibility(verifies)
        self._searches.set_value([] if verifies else ["sqp", "multistart"])
        label = "objectives beside these" if verifies else "objectives"
        self._objectives.props(f'label="{label}"')
        self.warm_soon()

    def _case_changed(self) -> None:
        workspace = self._workspace
        if workspace.tab != "Search" or self._revision == workspace.revision:
            return
        self._revision = workspace.revision
        if workspace.case is not None:
            ui.timer(0.0, self._list_objectives, once=True)

    async def _list_objectives(self) -> None:
        from drakesep.page.objective_choice import own_objectives

        case = self._workspace.case
        if case is None:
            return
        try:
            own = await run.io_bound(lambda: own_objectives(case.in_si()))
        except InputError as error:
            elements.say_wrong(str(error))
            return
        kept = {name: name for name in self._chosen()}
        self._objectives.set_options({**{name: name for name in own or ()}, **kept})
        self._failures.set_enabled(bool(case.failure_cases))
        self.warm_soon()

    def warm_soon(self) -> None:
        """Get a process ready for what is chosen, once that stays as it is."""
        self._pause.deactivate()
        self._pause.activate()

    def _warm(self) -> None:
        """Let programs be made for what is chosen, before it is asked for."""
        self._pause.deactivate()
        workspace = self._workspace
        if workspace.case is None or workspace.tab != "Search":
            return
        study = workspace.studies.get("Search")
        if study is not None and study.is_running:  # it has the machine for itself
            return
        with contextlib.suppress(OSError):
            verifies = self.kind == "verify"
            wanted = self._chosen() or [_CHEAP] * (not verifies)
            SPARE.ready().warm(
                workspace.text, workspace.folder, wanted, verifies=verifies
            )


def _select(label: str, options: "dict[str, str] | list[str]", value: str) -> ui.select:
    return ui.select(options, label=label, value=value).props("outlined dense")
