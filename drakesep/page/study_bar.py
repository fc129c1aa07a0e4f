"""What starts, stops and goes on with the study of a tab, and says how it stands."""

from collections.abc import Callable

from nicegui import ui

from drakesep.page import elements
from drakesep.page.study import SPARE, State, Study
from drakesep.page.study_files import from_here
from drakesep.page.workspace import Workspace


_LOOK = 0.1
"""How often it is looked what a study has told, s."""


class StudyBar:
    """Buttons, a bar of progress and words, for the study of one tab."""

    def __init__(
        self,
        workspace: Workspace,
        tab: str,
        begin: Callable[[], Study],
        show: Callable[[Study | None], None],
    ):
        """Build it where it is made.

        Args:
            workspace: whose study it is.
            tab: its name.
            begin: begins a study as it is asked for in the tab.
            show: called with the study when there is something new to be shown.
        """
        self._studies, self._tab = workspace.studies, tab
        self._begin, self._show = begin, show
        self._shown: tuple[Study | None, int] | None = None
        with ui.row().classes("study-bar"):
            self._start = ui.button("Start", icon="play_arrow", on_click=self._started)
            self._stop = ui.button("Stop", icon="stop", on_click=self._stopped)
            self._go_on = ui.button("Go on", icon="redo", on_click=self._gone_on)
            for button in (self._start, self._stop, self._go_on):
                button.props("no-caps unelevated dense").classes("study-button")
            self._stop.props("outline")
            self._go_on.props("outline")
        self._bar = ui.linear_progress(value=0.0, show_value=False, size="6px")
        self._bar.props('instant-feedback aria-label="How much of the study is done"')
        self._words = ui.label().classes("study-words").props('role="status"')
        SPARE.ready()
        ui.timer(_LOOK, self._look)

    @property
    def study(self) -> Study | None:
        """The study; None if there is none yet."""
        return self._studies.get(self._tab)

    def _started(self) -> None:
        if self.study is not None and self.study.is_running:
            return  # a second click, before the button has gone

        def begin() -> None:
            self._studies[self._tab] = self._begin()

        elements.attempt(begin)
        self._look()

    def _stopped(self) -> None:
        if self.study is not None:
            self._words.set_text("stopping")
            self.study.stop()

    def _gone_on(self) -> None:
        if self.study is not None and self.study.can_go_on:
            self.study.go_on()

    def _look(self) -> None:
        study = self.study
        if study is not None:
            study.hear()
        now = study, 0 if study is None else study.version
        if now == self._shown:
            return
        self._shown = now
        running = study is not None and study.is_running
        self._start.set_visibility(not running)
        self._stop.set_visibility(running)
        self._go_on.set_visibility(study is not None and study.can_go_on)
        self._bar.set_visibility(running)
        self._bar.set_value(0.0 if study is None else study.share)
        self._words.set_text("" if study is None else words_of(study))
        wrong = study is not None and study.state in (State.DIED, State.REFUSED)
        self._words.classes(add="wrong" * wrong, remove="wrong" * (not wrong))
        self._show(study)


def words_of(study: Study) -> str:
    """Return how a study stands, in a line."""
    if study.is_running:
        left = "" if study.seconds is None else f", {_in_time(study.seconds)} left"
        return f"{study.share:.0%}{left}: {study.step}"
    if study.state is State.STOPPED:
        return "Stopped. What was finished is kept: it goes on from there."
    if study.state is not State.ENDED:
        return study.message
    verdict = study.summary.get("verdict")
    words = f"Ended: {verdict}." if verdict else "Ended."
    told = f"{words} {study.message}".strip()
    return f"{told} Results are in {from_here(study.folder)}"


def _in_time(seconds: float) -> str:
    return f"{seconds / 60.0:.0f} min" if seconds >= 90.0 else f"{seconds:.0f} s"
