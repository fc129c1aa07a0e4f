"""Files: read where they end, and never half written."""

import contextlib
import itertools
import os
import stat
from collections.abc import Iterator
from pathlib import Path

from drakesep.systems.checks import InputError


PREFIX = ".writing-"
"""Of the name of a file until it is whole; its suffix is kept."""


_numbers = itertools.count()
"""Of the files that this process has written."""


def path_of(what: str, path: str | Path) -> Path:
    """Return the path of what is to be written.

    Args:
        what: the argument that names it.
        path: as it was given.

    Raises:
        ValueError: it is empty, which elsewhere is the working directory.
    """
    if path == "":
        raise InputError(f"{what}: must be a path, got ''; '.' is this folder")
    return Path(path)


@contextlib.contextmanager
def written(path: Path, *, synced: bool = False) -> Iterator[Path]:
    """Give the path to write a file to, which takes its place when it is whole.

    Args:
        path: of the file; one that is there stays until the new one is whole.
        synced: whether it is to be on the disk, too, before it takes its place.

    Raises:
        OSError: it cannot be written; the error names it.
    """
    beside = path.with_name(f"{PREFIX}{os.getpid()}-{next(_numbers)}-{path.name}")
    try:
        yield beside
        if synced:
            with beside.open("rb") as stream:
                os.fsync(stream.fileno())
        os.replace(beside, path)
    except OSError as error:
        if error.filename not in (None, str(beside)):
            raise
        raise OSError(error.errno, error.strerror, str(path)) from error
    finally:
        beside.unlink(missing_ok=True)


def check_readable(path: Path, most: int) -> None:
    """Raise an error unless a path is that of a file of so many bytes, which ends.

    Args:
        path: of what is to be read.
        most: bytes.

    Raises:
        OSError: it is not there.
        ValueError: it is a folder, a pipe or a device, or larger.
    """
    found = path.stat()
    if not stat.S_ISREG(found.st_mode):
        raise InputError(f"{path}: must be a file, got a folder, a pipe or a device")
    if found.st_size > most:
        raise InputError(f"{path}: must be at most {most // 1_000_000} MB")


def write_text(path: Path, text: str) -> None:
    """Write a text, in UTF-8, down to the disk."""
    with written(path, synced=True) as beside:
        beside.write_text(text, encoding="utf-8")
