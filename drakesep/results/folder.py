"""The folder that a study writes: locked, and cleared of what the last one left."""

import contextlib
import fcntl
import os
import tempfile
import threading
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any, Self, TypeAlias, TypeVar

from drakesep.files import PREFIX, path_of
from drakesep.results.asked import Asked
from drakesep.results.catalogue.names import CASE, GEOMETRY, RUNS, STUDY
from drakesep.results.listing import files_in, names_of
from drakesep.results.parts import has_parts, keep_part, kept_part, remove_parts
from drakesep.results.recorded_case import read_case, recorded_text, staged_case
from drakesep.results.study_record import (
    Ended,
    StudyRecord,
    check_resumes,
    files_as_json,
    record_of,
)
from drakesep.systems.checks import InputError


_Kind = TypeVar("_Kind")
_LOCK = ".drakesep.lock"


def writable_folder(directory: str | Path) -> Path:
    """Return a folder, made if need be.

    Raises:
        ValueError: it cannot be made or written.
    """
    folder = path_of("output", directory)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except (OSError, ValueError) as error:  # of names that no file may have
        reason = error.strerror if isinstance(error, OSError) else error
        raise InputError(
            f"output: must be a folder that can be written, got {folder} ({reason})"
        ) from error
    return folder


class ResultsFolder:
    """The folder of a study while it is written; a context manager.

    It is locked from entering to leaving: a second study that wants it is refused, and
    the lock ends with its process. What is there stays until the study begins: one that
    is refused leaves the results of the last alone. Then goes what the last one left,
    as its `study.json` lists it; what no study has left stays. The list is kept up
    while a study goes on, so that one that is killed can be read, and cleared.

    Attributes:
        directory: as it was given.
        path: of the folder, wherever the process goes.
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
        self.directory = path_of("output", directory)
        self.path = self.directory.absolute()
        self._study = study
        self._command = command
        self._lock: int | None = None
        self._is_new = False
        self._resumes = False
        self._record: StudyRecord | None = None
        self._asked: Asked | None = None
        self._labels: dict[str, None] = {}
        self._others: dict[Path, tuple[int, int]] = {}
        self._writing = threading.RLock()

    def __enter__(self) -> Self:
        """Lock it.

        Raises:
            ValueError: it cannot be written, another study is writing it, or it holds
                the results of another kind of study.
        """
        self._is_new = not self.path.exists()
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
                "output: must be a folder without results of another study, got "
                f"{self.directory} with those of {last.study!r}; "
                f"give {self._study!r} a folder of its own"
            )

    @property
    def begun(self) -> bool:
        """Whether the study has begun, and what the last one left is gone."""
        return self._asked is not None

    def resume(self, asked: Asked) -> None:
        """Go on from what a study that ended early has finished, if there is any.

        Args:
            asked: the same study.

        Raises:
            ValueError: it did not end early, or it was another: the error says in what.
        """
        last = StudyRecord.read(self.path)
        if last is None:
            return
        if has_parts(self.path):
            if (self.path / CASE).read_text("utf-8") != recorded_text(asked.case):
                raise InputError(
                    f"resume: must be of the case that {self.directory} has, got one "
                    "that differs"
                )
            now = record_of(asked, self.path, self._command)
            check_resumes(last, now, self.directory)
            self._resumes = True
        elif last.ended in (Ended.COMPLETED, Ended.FAILED):
            raise InputError(
                f"resume: must be a study that ended early, got that of "
                f"{self.directory}, {last.ended.value}"
            )

    def part(self, name: str, kind: type[_Kind]) -> tuple[_Kind, ...] | None:
        """Return the records of a part, if an earlier study has finished it.

        Args:
            name: of the part.
            kind: of its records.
        """
        return kept_part(self.path, name, kind) if self._resumes else None

    def keep_part(self, name: str, records: Sequence[Any]) -> None:
        """Keep what the study has finished, until it ends."""
        assert self._record is not None
        keep_part(self.path, name, records)

    def begin(self, asked: Asked) -> None:
        """Write down what is asked, and take out what the last study left.

        Its parts stay, if this one goes on from them.
        """
        last = StudyRecord.read(self.path)
        record = record_of(asked, self.path, self._command)
        self._sweep()
        if not self._resumes:
            remove_parts(self.path)
        with staged_case(asked.case, self.path, asked.meshes):
            left = last.files if last else ()
            replace(record, files=left).write(self.path)
            self._asked, self._record = asked, record
            for file in left:
                self._remove(str(file["name"]))
            self._others = {file: _identity(file) for file in self._files()}
        self.keep()

    def go_on(self) -> StudyRecord:
        """Go on with the study that another process has begun, and handed over.

        Returns:
            What was asked then.

        Raises:
            ValueError: there is none, or it has ended.
        """
        record = StudyRecord.read(self.path)
        if record is None or not has_parts(self.path):
            got = "none" if record is None else "one that has ended"
            raise InputError(
                f"output: must be a folder with a study under way, got {got} in "
                f"{self.directory}"
            )
        case = read_case(self.path)
        self._asked = Asked(
            study=record.study,
            case=case,
            source=record.case["source"],
            text=record.case["text"],
            named_files=record.named_files,
            arguments=record.arguments,
            seed=record.seed,
        )
        self._record = replace(record, ended=Ended.UNDER_WAY, message="")
        mine = {self.path / str(file["name"]) for file in record.files}
        self._others = {f: _identity(f) for f in self._files() if f not in mine}
        return record

    @property
    def asked(self) -> Asked:
        """What is asked of the study that has begun."""
        assert self._asked is not None
        return self._asked

    def hand_over(self) -> None:
        """Leave the study under way, for other processes to go on with."""
        with self._writing:
            self.keep()
            self._record = None

    def plan(self, options: Mapping[str, Any]) -> None:
        """Write down what the study has planned, before it does."""
        with self._writing:
            assert self._record is not None
            self._record = replace(self._record, plan=dict(options))
            self.keep()

    def keep(self, labels: Sequence[str] = ()) -> None:
        """Write down which files the study has left until now, if it has not ended.

        Any thread may: what is drawn beside the study is written down when it is there.

        Args:
            labels: of runs that are written, or being written.
        """
        with self._writing:
            self._labels |= dict.fromkeys(labels)
            if self._record is None:
                return
            assert self._asked is not None
            bodies = [pair.B for pair in self._asked.case.separation.others]
            names = names_of(self._study, tuple(self._labels), bodies)
            files = files_in(self.path, names, self._is_ours)
            there = {one.name for one in files}
            self._record = replace(
                self._record,
                runs=[k for k in self._labels if f"{RUNS}/{k}.json" in there],
                files=files_as_json(files),
            )
            self._record.write(self.path)

    def end(self, *, failed: str = "", verdict: str | None = None) -> None:
        """Write down how the study ended, and what it has left.

        Args:
            failed: why, if it did.
            verdict: if it gives one.
        """
        ended = Ended.FAILED if failed else Ended.COMPLETED
        self._end(ended, message=failed, verdict=verdict)
        remove_parts(self.path)

    def leave(self, wait: float) -> None:
        """Leave it in the midst of the study, as its process ends; any thread may.

        Args:
            wait: for a thread that is writing, s.
        """
        self._interrupted(wait)
        if self._lock is not None:
            self._unlock()

    def _interrupted(self, wait: float = -1.0) -> None:
        if self._writing.acquire(timeout=wait):
            try:
                if self._record is not None:
                    self._end(Ended.INTERRUPTED)
            finally:
                self._writing.release()

    def _end(
        self, ended: Ended, *, message: str = "", verdict: str | None = None
    ) -> None:
        with self._writing:
            assert self._record is not None and self._asked is not None
            self._record = replace(
                self._record,
                ended=ended,
                message=message,
                verdict=verdict,
                seconds=round(self._asked.seconds, 3),
            )
            self.keep()
            self._record = None

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Write down how it ended, if that has not been done, and unlock it."""
        try:
            if isinstance(error, KeyboardInterrupt | SystemExit):
                self._interrupted()
            elif self._record is not None:
                name = "left before its end" if kind is None else kind.__name__
                self._end(Ended.FAILED, message=str(error or "") or name)
        finally:
            self._unlock()

    def _unlock(self) -> None:
        assert self._lock is not None
        (self.path / _LOCK).unlink(missing_ok=True)
        if self._is_new and not self.begun:  # refused: as if it had not been asked
            with contextlib.suppress(OSError):
                self.path.rmdir()
        os.close(self._lock)
        self._lock = None

    def _homes(self) -> list[Path]:
        within = (RUNS, GEOMETRY)
        return [self.path, *(self.path / name for name in within)]

    def _files(self) -> list[Path]:
        return [file for home in self._homes() for file in home.glob("*")]

    def _is_ours(self, file: Path) -> bool:
        """Return whether the study has written a file: one that was there is not."""
        if not file.is_file() or file.name.startswith(PREFIX):
            return False
        return file.name == STUDY or _identity(file) != self._others.get(file)

    def _sweep(self) -> None:
        """Take out what a killed study has left half."""
        for home in self._homes():
            for half in home.glob(f"{PREFIX}*"):
                half.unlink(missing_ok=True)

    def _remove(self, name: str) -> None:
        path = Path(name)
        if name == STUDY or path.is_absolute() or ".." in path.parts:
            return
        file = self.path / path
        if file.is_file() or file.is_symlink():
            file.unlink()
        if path.parent != Path("."):
            with contextlib.suppress(OSError):  # something else is in it
                file.parent.rmdir()


def _identity(file: Path) -> tuple[int, int]:
    """Return what tells a file from one that was renamed to its name."""
    status = file.lstat()
    return status.st_ino, status.st_mtime_ns


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
        except BlockingIOError as error:
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
def begun(output: Output | None, asked: Asked) -> Iterator[ResultsFolder | None]:
    """Give the folder of a study that begins at once; see `results_folder`.

    Args:
        output: the folder; None: none is written.
        asked: of the study.
    """
    with results_folder(output, asked.study) as folder:
        if folder is not None:
            folder.begin(asked)
        yield folder


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
