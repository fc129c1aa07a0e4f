"""What the page of one browser tab works on: a case as text, and what it says.

The text is the case: tables and the YAML beside them change it, undo brings back an
earlier one, and what is read of it is either a `Case` or what is wrong with it. Those
who show it are told of each change.
"""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from drakesep.files import write_text
from drakesep.page.flights import Flights
from drakesep.systems.checks import InputError


if TYPE_CHECKING:
    from drakesep.case_file.case import Case
    from drakesep.page.study import Study


_MOST_UNDONE = 200
"""Texts that are kept to go back to."""


class ChangedMeanwhile(InputError):
    """The file is no more what was opened: another page or program has written it."""


@dataclass(frozen=True)
class _Opened:
    """The file that a case came from, as it was."""

    path: Path
    digest: str


class Listeners:
    """Who is told of something."""

    def __init__(self) -> None:
        self._all: list[Callable[[], None]] = []

    def add(self, listener: Callable[[], None]) -> Callable[[], None]:
        """Let something be called each time; return what ends that."""
        self._all.append(listener)

        def end() -> None:
            if listener in self._all:
                self._all.remove(listener)

        return end

    def tell(self) -> None:
        """Call all of them."""
        for listener in [*self._all]:
            listener()


class Workspace:
    """A case that is edited, and where results of it go.

    Attributes:
        text: the case as YAML.
        case: what it says; None while something is wrong with it.
        problems: what is wrong, a line for each mistake.
        revision: a number that grows with each change.
        name: of the case, for titles and folders; the last that could be read.
        path: its file; None if it has none yet, as a built-in or a new case.
        results: folder that holds results, one folder for each case.
        tab: that is shown.
        dark: whether the page is; None until the browser has told how its user has it.
        changes: told of each change of the case.
        looks: told when another tab is shown, and of light and dark.
        flights: flies what is played with.
        measuring: flies what is measured, which takes longer.
        studies: the last of each tab, by its name: a page loaded again shows it.
    """

    def __init__(self, results: Path = Path("results")):
        """Begin without a case; see `open` and `begin`."""
        self.results = results.absolute()
        self.text = ""
        self.case: Case | None = None
        self.problems: tuple[str, ...] = ()
        self.revision = 0
        self.name = "case"
        self.tab = "Case"
        self.dark: bool | None = None
        self._builtin: str | None = None
        self._opened: _Opened | None = None
        self._saved = ""
        self._undone: list[str] = []
        self._before: list[str] = []
        self.flights = Flights()
        self.measuring = Flights()
        self.studies: dict[str, Study] = {}
        self.changes = Listeners()
        self.looks = Listeners()

    def rest(self) -> None:
        """End processes that nobody looks at what they do."""
        self.flights.end()
        self.measuring.end()

    # What others see.

    @property
    def path(self) -> Path | None:
        """The file of the case."""
        return None if self._opened is None else self._opened.path

    @property
    def is_builtin(self) -> bool:
        """Whether it is of drakesep."""
        return self._builtin is not None

    @property
    def is_saved(self) -> bool:
        """Whether the text is what was opened or saved last."""
        return self.text == self._saved

    @property
    def is_on_disk(self) -> bool:
        """Whether its file holds the text: nobody else has changed or removed it."""
        if self.is_builtin:
            return self.is_saved
        return (
            self._opened is not None
            and self.is_saved
            and _digest_of(self._opened.path) == self._opened.digest
        )

    @property
    def source(self) -> str | None:
        """What opens the case again: its file or built-in name; None of a new one."""
        return self._builtin if self.path is None else str(self.path)

    @property
    def is_elsewhere(self) -> bool:
        """Whether nothing is lost without it: no text, and no study that is running."""
        if any(study.is_running for study in self.studies.values()):
            return False
        return self.is_saved if self.path is None else self.is_on_disk

    @property
    def folder(self) -> Path:
        """From which the files are named that the case refers to."""
        from drakesep.case_file.reader import builtin_cases

        if self.path is not None:
            return self.path.parent
        if self._builtin is not None:
            return builtin_cases()[self._builtin].parent
        return Path.cwd()

    # Files.

    def open(self, source: str) -> None:
        """Open a case file or a built-in case, whatever is wrong with it.

        Raises:
            CaseError: it cannot be read as text.
        """
        from drakesep.case_file.reader import builtin_cases, read_text

        text = read_text(source)
        builtin = source in builtin_cases()
        self._builtin = source if builtin else None
        path = Path(source).absolute()
        self._opened = None if builtin else _Opened(path, _digest(text))
        self.name = path.stem  # until it says another
        self._start(text)

    def begin(self, name: str = "new") -> None:
        """Begin a new case, with comments that explain each section."""
        from drakesep.case_file.new_case import new_case_text

        self._builtin, self._opened = None, None
        self._start(new_case_text(name))

    def save(self, path: Path | None = None, *, replaces: bool = False) -> None:
        """Write the case into a file, at once and whole.

        Args:
            path: another than that which was opened.
            replaces: whether to write over what somebody else has written.

        Raises:
            ChangedMeanwhile: the file is not what was opened, or another is there.
            ValueError: there is no path, or it cannot be written.
        """
        target = path.absolute() if path is not None else self.path
        if target is None:
            raise InputError("a new or built-in case needs a file to be saved in")
        if not replaces:
            self._check_unchanged(target)
        try:
            write_text(target, self.text)
        except OSError as error:
            raise InputError(f"{target}: {error.strerror}") from error
        self._builtin, self._opened = None, _Opened(target, _digest(self.text))
        self._saved = self.text
        self._read()
        self._tell()

    def _check_unchanged(self, target: Path) -> None:
        found = _digest_of(target)
        if found is None:
            return
        if self._opened is None or target != self._opened.path:
            raise ChangedMeanwhile(f"{target}: is there already")
        if found != self._opened.digest:
            raise ChangedMeanwhile(
                f"{target}: has been changed by somebody else since it was opened here"
            )

    # Changes.

    def change(self, text: str) -> None:
        """Take another text; undo brings the present one back."""
        if text == self.text:
            return
        self._before = [*self._before[1 - _MOST_UNDONE :], self.text]
        self._undone.clear()
        self._take(text)

    @property
    def can_undo(self) -> bool:
        """Whether there is something to undo."""
        return bool(self._before)

    @property
    def can_redo(self) -> bool:
        """Whether something was undone that can be done again."""
        return bool(self._undone)

    def undo(self) -> None:
        """Go back to the text before the last change."""
        if self._before:
            self._undone.append(self.text)
            self._take(self._before.pop())

    def redo(self) -> None:
        """Do again what was undone last."""
        if self._undone:
            self._before.append(self.text)
            self._take(self._undone.pop())

    def _start(self, text: str) -> None:
        self._before, self._undone = [], []
        self._saved = text
        self._take(text)

    def _take(self, text: str) -> None:
        self.text = text
        self._read()
        self._tell()

    def _read(self) -> None:
        from drakesep.case_file.errors import CaseError
        from drakesep.case_file.reader import read_case

        # What was changed here stands nowhere yet.
        source = self.source if self.is_saved else None
        try:
            self.case = read_case(self.text, folder=self.folder, source=source)
            self.problems = ()
            self.name = self.case.name
        except CaseError as error:
            self.case = None
            self.problems = tuple(str(error).splitlines())

    def _tell(self) -> None:
        self.revision += 1
        self.changes.tell()


def _digest_of(file: Path) -> str | None:
    """Return that of a file; None if it is not there.

    Raises:
        ValueError: it cannot be read.
    """
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise InputError(f"{file}: {error.strerror}") from error


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
