"""``study.json``: what was asked of a study, with what, and how it ended."""

import enum
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import ConfigDict, TypeAdapter, ValidationError

from drakesep.case_file.errors import explained, shown
from drakesep.files import write_text
from drakesep.results import provenance
from drakesep.results.asked import Asked
from drakesep.results.catalogue.names import STUDY
from drakesep.results.listing import FileInFolder
from drakesep.systems.checks import InputError


_FORMAT = 1
"""Of the file: another number means other keys."""


class Ended(enum.Enum):
    """How a study ended."""

    UNDER_WAY = "under way"
    """It has not; or its process was killed."""
    COMPLETED = "completed"
    FAILED = "failed"
    INTERRUPTED = "interrupted"


@dataclass(frozen=True, kw_only=True)
class StudyRecord:
    """What `study.json` says; its fields are the keys of the file."""

    __pydantic_config__ = ConfigDict(extra="forbid")

    format: int = _FORMAT
    """Of the file."""
    study: str
    """Its name, that of the function and of the command."""
    ended: Ended
    """``completed``, ``failed`` or ``interrupted``; ``under way`` of a study that still
    is, or was killed."""
    message: str = ""
    """Why it failed."""
    verdict: str | None = None
    """Of a study that gives one: ``met``, ``not met`` or ``not looked at``; of
    `clearance`, ``clear`` or ``contact``; of `prove`, ``proven met`` or ``not
    proven``."""
    again: str | None
    """What does the study again, in a shell; null if it was asked with functions."""
    arguments: Mapping[str, Any] = field(default_factory=dict)
    """That were given, beside the case and the folder."""
    plan: Mapping[str, Any] = field(default_factory=dict)
    """What was searched and how hard: options that plan the same again where runs are
    faster or slower; none if nothing was searched."""
    seed: int | None = None
    """Of what is drawn at random; none if nothing is."""
    begun: str
    """When, in UTC, ISO 8601."""
    seconds: float
    """For how long, s."""
    process: int
    """Number of the process that wrote the folder."""
    versions: Mapping[str, str]
    """Of drakesep, Python, and the libraries that compute."""
    commit: str | None = None
    """Of drakesep, if it was run from a checkout; ``-dirty`` if that was changed."""
    case: Mapping[str, Any]
    """Its ``name``; its ``source``: the file, or the name if it is built in, null if
    it was made or changed in Python; its ``text`` as a case file, and the ``sha256`` of
    that. A case in SI has no text: it stands in ``case.json``, as all do."""
    named_files: Mapping[str, str | None] = field(default_factory=dict)
    """SHA-256 of the meshes and models that the case names, by their paths."""
    runs: Sequence[str] = ()
    """Labels of the runs that the folder keeps."""
    files: Sequence[Mapping[str, Any]] = ()
    """Files of the study, those of the last one while they are cleared: ``name``,
    ``what`` it holds, and of a table what a ``row`` is for, and of each of its
    ``columns`` the ``name``, the ``unit`` and ``what`` it holds."""

    def __post_init__(self) -> None:
        """Check what others are found by."""
        for i, file in enumerate(self.files):
            if not isinstance(name := file.get("name"), str):
                raise InputError(
                    f"files (entry {i + 1}).name: must be text, got {shown(name)}"
                )

    def write(self, folder: Path) -> None:
        """Write it into a folder."""
        data = {**self.__dict__, "ended": self.ended.value}
        text = json.dumps(data, indent=1, ensure_ascii=False)
        write_text(folder / STUDY, text + "\n")

    @classmethod
    def read(cls, folder: Path) -> "StudyRecord | None":
        """Return that of a folder; None if it has none.

        Raises:
            ValueError: what stands there is none.
        """
        file = folder / STUDY
        try:
            data = json.loads(file.read_text(encoding="utf-8"))
        except FileNotFoundError:
            return None
        except (OSError, ValueError, RecursionError) as error:
            raise InputError(f"{file}: must be that of a study, got: {error}") from None
        if not isinstance(data, dict) or data.get("format") != _FORMAT:
            got = data.get("format") if isinstance(data, dict) else None
            raise InputError(f"{file}: format must be {_FORMAT}, got {got}")
        try:
            return TypeAdapter(cls).validate_python(data)
        except ValidationError as error:
            raise explained(error, f"{file}: ") from None


def record_of(asked: Asked, folder: Path, command: Sequence[str] | None) -> StudyRecord:
    """Return what is known of a study that begins."""
    text = asked.text
    return StudyRecord(
        study=asked.study,
        ended=Ended.UNDER_WAY,
        again=asked.again(folder, command),
        arguments=asked.plain_arguments,
        seed=asked.seed,
        begun=asked.begun.isoformat(timespec="seconds"),
        seconds=asked.seconds,
        process=os.getpid(),
        versions=provenance.versions(),
        commit=provenance.commit(),
        case={
            "name": asked.case.name,
            "source": asked.source,
            "text": text,
            "sha256": None if text is None else provenance.sha256(text),
        },
        named_files=dict(asked.named_files),
    )


def check_resumes(last: StudyRecord, now: StudyRecord, folder: Path) -> None:
    """Raise InputError unless a study is what another was, and would find the same.

    Args:
        last: that ended early.
        now: that is to go on with it.
        folder: that has the other.
    """
    if now.again is None:
        raise InputError(
            "resume: what is asked must be names and numbers, which can be compared, "
            "got functions or objects"
        )
    for name in ("arguments", "seed", "versions", "commit", "named_files"):
        was, got = (_by_name(name, getattr(each, name)) for each in (last, now))
        for key in {**was, **got}:
            if was.get(key) != got.get(key):
                raise InputError(
                    f"resume: must be the study that {folder} has, with {key} = "
                    f"{was.get(key)}, got {got.get(key)}"
                )


def _by_name(name: str, value: Any) -> dict[str, Any]:
    if isinstance(value, Mapping):
        return {f"{name}.{key}": entry for key, entry in value.items()}
    return {name: value}


def files_as_json(files: Sequence[FileInFolder]) -> list[dict[str, Any]]:
    """Return what `StudyRecord.files` says of files."""
    return [
        {
            "name": one.name,
            "what": one.what,
            **({"row": one.row} if one.row else {}),
            **({"columns": [c._asdict() for c in one.columns]} if one.columns else {}),
        }
        for one in files
    ]
