"""Finished parts of a study that is under way, from which one that ended early goes on.

They are records as JSON has them, exact: reading them runs nothing. What takes less to
do again than to keep is no part, a run in Drake for one.
"""

import json
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeVar

from drakesep.files import write_text
from drakesep.results.case_json import NO_RECORD, from_json, to_json
from drakesep.systems.checks import InputError


_Kind = TypeVar("_Kind")
_PARTS = ".parts"
"""Name of the folder that has them."""


def keep_part(folder: Path, name: str, records: Sequence[Any]) -> None:
    """Keep a part, down to the disk.

    Args:
        folder: of the results.
        name: of the part.
        records: that it is.
    """
    parts_folder(folder).mkdir(exist_ok=True)
    write_text(_file(folder, name), json.dumps(to_json(records)) + "\n")


def kept_part(folder: Path, name: str, kind: type[_Kind]) -> tuple[_Kind, ...] | None:
    """Return the records of a part as they were kept; None if it was not.

    Args:
        folder: of the results.
        name: of the part.
        kind: of its records.

    Raises:
        ValueError: what stands there is no such part.
    """
    file = _file(folder, name)
    try:
        records = from_json(json.loads(file.read_text(encoding="utf-8")))
    except FileNotFoundError:
        return None
    except NO_RECORD as error:
        raise _no_part(file, str(error)) from error
    if not isinstance(records, tuple) or not all(isinstance(r, kind) for r in records):
        raise _no_part(file, type(records).__name__)
    return records


def _no_part(file: Path, got: str) -> InputError:
    return InputError(
        f"{file}: must be a part of a study, got: {got}; without resume, the study "
        "begins anew"
    )


def parts_folder(folder: Path) -> Path:
    """Return the folder of the parts, within that of the results."""
    return folder / _PARTS


def has_parts(folder: Path) -> bool:
    """Return whether a study has left parts."""
    return parts_folder(folder).is_dir()


def remove_parts(folder: Path) -> None:
    """Remove all parts."""
    if has_parts(folder):
        shutil.rmtree(parts_folder(folder))


def _file(folder: Path, name: str) -> Path:
    return parts_folder(folder) / f"{name}.json"
