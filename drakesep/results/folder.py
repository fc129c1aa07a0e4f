"""The folder that a study writes: locked, and cleared of what the last one left."""

import contextlib
import fcntl
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any, Self, TypeAlias

from drakesep.files import PREFIX
from drakesep.results import catalogue, recorded_runs
from drakesep.results.asked import Asked
from drakesep.results.recorded_case import CASE, other_bodies, save_case
from drakesep.results.study_record import (
    STUDY,
    Ended,
    StudyRecord,
    files_as_json,
    record_of,
)
from drakesep.systems.checks import InputError


_LOCK = ".drakesep.lock"


def writable_folder(directory: str | Path) -> Path:
    """Return a folder, made if need be.

    Raises:
        ValueError: it cannot be made or written.
    """
    folder = Path(directory)
    probe = folder / f"{PREFIX}{os.getpid()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise InputError(
            f"output: must be a folder that can be written, got {folder} "
            f"({error.strerror})"
        ) from error
    return folder


class ResultsFolder:
    """The folder of a study while it is written; a context manager.

    It is locked from entering to leaving: a second study that wants it is refused, and
    the lock ends with its process. What is there stays until the study begins: one that
    is refused leaves the results of the last alone. Then goes what the last one left,
    by its `study.json` or, if it was killed, by its names; what is not a study's stays.

    Attributes:
        path: of the folder.
    """

    def __init__(
        self,
        directory: str | Path,
        study: str,
        *,
        command: Sequence[str] | None = None,
    ):
        """Prepare.

        Args:
            directory: of the folder; made if need be.
            study: that will write it, one of `catalogue.STUDIES`.
            command: arguments of the command line that asks for it; None: Python does.
        """
        self.path = Path(directory)
        self._study = study
        self._command = command
        self._record: StudyRecord | None = None
        self._asked: Asked | None = None
        self._lock: int | None = None

    def __enter__(self) -> Self:
        """Lock it.

        Raises:
            ValueError: it cannot be written, another study is writing it, or it holds
                the results of another kind of study.
        """
        writable_folder(self.path)
        self._lock = _locked(self.path)
        try:
            self._check_study()
        except BaseException:
            self._unlock()
            raise
        return self

    def _check_study(self) -> None:
        last = StudyRecord.read(self.path)
        if last is not None and last.study != self._study:
            raise InputError(
                f"output: must be a folder without results of another study, got "
                f"{self.path} with those of {last.study!r}; give {self._study!r} a "
                "folder of its own"
            )

    def begin(self, asked: Asked) -> None:
        """Take out what the last study left, and write down what is asked now."""
        self._clear()
        self._asked = asked
        self._record = record_of(asked, self.path, self._command)
        save_case(asked.case, self.path)
        self._record.write(self.path)

    def plan(self, options: Mapping[str, Any]) -> None:
        """Write down what the study has planned, before it does."""
        assert self._record is not None
        self._record = replace(self._record, plan=dict(options))
        self._record.write(self.path)

    def end(
        self, *, failed: str = "", verdict: str | None = None, interrupted: bool = False
    ) -> None:
        """Write down how the study ended, and what it has left.

        Args:
            failed: why, if it did.
            verdict: if it gives one.
            interrupted: whether it was.
        """
        assert self._record is not None and self._asked is not None
        ended = Ended.FAILED if failed else Ended.COMPLETED
        record = replace(
            self._record,
            ended=Ended.INTERRUPTED if interrupted else ended,
            message=failed,
            verdict=verdict,
            seconds=round(self._asked.seconds, 3),
            runs=recorded_runs.labels_in(self.path),
        )
        record.write(self.path)
        files = catalogue.files_in(self.path, self._study, other_bodies(self.path))
        replace(record, files=files_as_json(files)).write(self.path)
        self._record = None

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Write down how it ended, if that has not been done, and unlock it."""
        try:
            if self._record is not None:
                interrupted = isinstance(error, KeyboardInterrupt | SystemExit)
                self.end(failed=str(error or ""), interrupted=interrupted)
        finally:
            self._unlock()

    def _unlock(self) -> None:
        assert self._lock is not None
        (self.path / _LOCK).unlink(missing_ok=True)
        os.close(self._lock)
        self._lock = None

    def _clear(self) -> None:
        """Take out what the last study left; its record last, which says what it is."""
        last = StudyRecord.read(self.path)
        labels = recorded_runs.labels_in(self.path)
        bodies = other_bodies(self.path)
        left = [name for name, _ in catalogue.names_of(self._study, labels, bodies)]
        left += [str(file["name"]) for file in last.files] if last else []
        left += [f"{catalogue.GEOMETRY}/{p.name}" for p in self._meshes(last)]
        for name in dict.fromkeys(left):
            if name != STUDY:
                self._remove(self.path / name)
        for folder in (recorded_runs.FOLDER, catalogue.GEOMETRY):
            with contextlib.suppress(OSError):  # something else is in it
                (self.path / folder).rmdir()
        for half in self.path.rglob(f"{PREFIX}*"):
            half.unlink(missing_ok=True)
        self._remove(self.path / STUDY)

    def _meshes(self, last: StudyRecord | None) -> list[Path]:
        """Return meshes that a study left; without a record none is known to be its."""
        known = last is not None and (self.path / CASE).exists()
        return list((self.path / catalogue.GEOMETRY).glob("*")) if known else []

    def _remove(self, file: Path) -> None:
        if self.path.resolve() in file.resolve().parents:  # whatever a record says
            file.unlink(missing_ok=True)


def _locked(folder: Path) -> int:
    """Return the lock of a folder, which ends with the process.

    Raises:
        ValueError: another has it.
    """
    file = folder / _LOCK
    while True:
        lock = os.open(file, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            process = os.read(lock, 32).decode(errors="replace").strip()
            os.close(lock)
            raise InputError(
                "output: must be a folder that no other study is writing, got "
                f"{folder} (process {process or 'unknown'} is)"
            ) from error
        # Whoever had it may have removed the file between the two calls.
        if _is_still(lock, file):
            os.ftruncate(lock, 0)
            os.write(lock, str(os.getpid()).encode())
            return lock
        os.close(lock)


def _is_still(lock: int, file: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(lock), file.stat())
    except FileNotFoundError:
        return False


Output: TypeAlias = str | Path | ResultsFolder
"""Where results go: a folder, or one that is open."""


@contextlib.contextmanager
def results_folder(output: Output | None, study: str) -> Iterator[ResultsFolder | None]:
    """Give the folder of a study until it is left; one that is open stays open.

    Args:
        output: the folder; None: none is written.
        study: its name.
    """
    if output is None or isinstance(output, ResultsFolder):
        yield output
    else:
        with ResultsFolder(output, study) as folder:
            yield folder
