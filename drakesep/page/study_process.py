"""A command that runs in a process of its own, watched from here.

The process is started before it is asked, so that it has imported and compiled what
takes long; it runs one command, and ends with it. It is the command line itself (see
`drakesep.cli.watched`): results are a folder like any other, and the command in its
`study.json` does it again. Its group is its own, so that an interrupt of the terminal
does not reach it; when this process ends, however that is, its input ends, and it
leaves its results in order and ends too.
"""

import json
import os
import queue
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any


STOPPED = 130
"""Exit code of a command that was stopped."""
_AT_ONCE = 5.0
"""That a process may take to end when it is closed, s."""
_LAST_WORDS = 2000
"""Characters of what a process said before it died."""


class StudyProcess:
    """A process that is warm, then runs a command, then is gone.

    Attributes:
        folder: that the command writes; None before it runs.
    """

    def __init__(self) -> None:
        """Start it; it tells `ready` when it has imported what it needs."""
        self.folder: Path | None = None
        self._said = tempfile.TemporaryFile()
        self._process = subprocess.Popen(
            [sys.executable, "-m", "drakesep.cli.watched"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._said,
            start_new_session=True,
        )
        self._events: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        self._ended = threading.Event()
        threading.Thread(target=self._read, daemon=True).start()

    @property
    def id(self) -> int:
        """Number of the process."""
        return self._process.pid

    @property
    def is_alive(self) -> bool:
        """Whether it runs, or all that it has told is not yet heard."""
        return not self._ended.is_set()

    def warm(
        self,
        case: str,
        folder: Path,
        objectives: Sequence[str] = (),
        *,
        verifies: bool = False,
    ) -> None:
        """Let it do what takes long in a study, before that is asked; it tells `warm`.

        Args:
            case: as a case file has it.
            folder: from which the case names files.
            objectives: that will be searched.
            verifies: whether requirements will be verified.
        """
        asked = {"case": case, "folder": str(folder), "objectives": [*objectives]}
        self._ask({"warm": {**asked, "verifies": verifies}})

    def run(
        self, arguments: Sequence[str], *, where: Path, folder: Path | None = None
    ) -> None:
        """Let it run a command, and tell what comes of it until it has `ended`.

        Args:
            arguments: of the command line.
            where: folder in which it is run.
            folder: that it writes.
        """
        self.folder = folder
        self._ask({"run": [*arguments], "folder": str(where)})

    def events(self) -> list[dict[str, Any]]:
        """Return what it has told since this was asked last.

        The last of all is `ended`, or `died` of one that has not ended by itself, with
        the ``reason``; of one that was stopped, `stopped`.
        """
        told = []
        while not self._events.empty():
            told.append(self._events.get())
        return told

    def wait_for(self, *kinds: str, timeout: float) -> list[dict[str, Any]]:
        """Return what it tells up to the first event of some kinds.

        Args:
            kinds: of the event.
            timeout: s.

        Raises:
            TimeoutError: none comes.
        """
        told = []
        end = time.monotonic() + timeout
        while True:
            try:
                left = max(end - time.monotonic(), 0.0)
                told.append(self._events.get(timeout=left))
            except queue.Empty:
                raise TimeoutError(f"no {' or '.join(kinds)} in {timeout} s") from None
            if told[-1]["event"] in kinds:
                return told

    def stop(self) -> None:
        """Let it leave its results in order and end at once, whatever it is at."""
        self._ask({"stop": True})

    def close(self) -> None:
        """End it, and wait until it has; one that does not end in order is killed."""
        self.stop()
        if not self._ended.wait(_AT_ONCE):
            os.killpg(self._process.pid, signal.SIGKILL)
            self._ended.wait(_AT_ONCE)

    def _ask(self, request: Mapping[str, Any]) -> None:
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(request).encode() + b"\n")
            self._process.stdin.flush()
        except (OSError, ValueError):  # it has ended, which it tells
            pass

    def _read(self) -> None:
        """Take in what it tells, and tell how it ended."""
        assert self._process.stdout is not None and self._process.stdin is not None
        ended = False
        for line in self._process.stdout:
            if line.endswith(b"\n"):  # else it died as it told
                event = json.loads(line)
                ended = ended or event["event"] == "ended"
                self._events.put(event)
        code = self._process.wait()
        self._process.stdout.close()
        try:
            self._process.stdin.close()
        except OSError:  # what it was asked last has nowhere to go
            pass
        if not ended and code == STOPPED:
            self._events.put({"event": "stopped"})
        elif not ended:
            self._events.put({"event": "died", "reason": self._reason(code)})
        self._said.close()
        self._ended.set()

    def _reason(self, code: int) -> str:
        """Return how the process ended, with the last that it said."""
        self._said.seek(0, os.SEEK_END)
        self._said.seek(max(self._said.tell() - _LAST_WORDS, 0))
        lines = self._said.read().decode(errors="replace").strip().splitlines()
        last = f": {lines[-1]}" if lines else ""
        if code < 0:
            return f"The process was ended by {signal.Signals(-code).name}{last}"
        return f"The process ended with {code}{last}"
