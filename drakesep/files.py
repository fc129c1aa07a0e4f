"""Files that are never half: written under another name, then renamed."""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path


PREFIX = ".writing-"
"""Of the name of a file until it is whole; its suffix is kept."""


@contextlib.contextmanager
def written(path: Path) -> Iterator[Path]:
    """Give the path to write a file to, which takes its place when it is whole.

    Args:
        path: of the file; one that is there stays until the new one is whole.
    """
    beside = path.with_name(f"{PREFIX}{os.getpid()}-{path.name}")
    try:
        yield beside
        os.replace(beside, path)
    finally:
        beside.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text, in UTF-8."""
    with written(path) as beside:
        beside.write_text(text, encoding="utf-8")
