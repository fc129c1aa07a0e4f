"""The workspaces of a server, by the addresses of their pages.

One that no page shows any more is dropped after a while, if all that it holds stands
elsewhere: its text in its file, its studies in their folders. Its address opens the
same file again.
"""

import itertools
import time
from collections.abc import Callable
from pathlib import Path

from drakesep.page.workspace import Workspace
from drakesep.systems.checks import InputError


_KEPT = 3600.0
"""For which one is kept that nobody looks at, s."""


class Place:
    """What stands at an address.

    Attributes:
        workspace: that its pages show; see `open`.
    """

    def __init__(self, source: str | None, results: Path, now: float):
        """Prepare.

        Args:
            source: case file or built-in case that is opened; None: a new case.
            results: folder with results.
            now: s.
        """
        self._source, self._results = source, results
        self._pages, self._left = 0, now
        self.workspace = Workspace(results)

    def open(self) -> str:
        """Open the case, if that is to be done; return what is wrong with its file."""
        if self.workspace.text:
            return ""
        if self._source is not None:
            try:
                self.workspace.open(self._source)
                return ""
            except InputError as error:
                self.workspace.begin()
                return str(error)
        self.workspace.begin()
        return ""

    def enter(self) -> None:
        """Count one page more that shows it."""
        self._pages += 1

    def leave(self, now: float) -> None:
        """Count one page less; after the last, what flies for them ends."""
        self._pages -= 1
        self._left = now
        if not self._pages:
            self.workspace.rest()

    def drop(self, now: float) -> None:
        """Drop the workspace, if nobody has looked for long and nothing is lost."""
        if self._pages or now < self._left + _KEPT or not self.workspace.is_elsewhere:
            return
        self._source = self.workspace.source
        self.workspace = Workspace(self._results)


class Workspaces:
    """All of a server."""

    def __init__(
        self,
        case: str | None,
        results: Path,
        clock: Callable[[], float] = time.monotonic,
    ):
        """Begin without any.

        Args:
            case: that a new one opens; a new case if None.
            results: folder with results.
            clock: tells the time, s.
        """
        self._case, self._results, self._clock = case, results, clock
        self._numbers = itertools.count(1)
        self._places: dict[str, Place] = {}

    def begin(self) -> str:
        """Return the address of a new one; others make room for it."""
        for place in self._places.values():
            place.drop(self._clock())
        key = str(next(self._numbers))
        self._places[key] = Place(self._case, self._results, self._clock())
        return key

    def get(self, key: str) -> Place | None:
        """Return what stands at an address; None: nothing does."""
        return self._places.get(key)

    def leave(self, key: str) -> None:
        """Tell that a page is gone."""
        self._places[key].leave(self._clock())

    def rest(self) -> None:
        """End all processes that fly for pages."""
        for place in self._places.values():
            place.workspace.rest()
