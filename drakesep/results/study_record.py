"""``study.json``: what was asked of a study, with what, and how it ended."""

import enum
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from drakesep.files import write_text
from drakesep.results import provenance
from drakesep.results.asked import Asked
from drakesep.results.catalogue import FileInFolder
from drakesep.systems.checks import InputError


STUDY = "study.json"
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

    format: int = _FORMAT
    study: str
    """Its name, that of the function and of the command."""
    ended: Ended
    message: str = ""
    """Why it failed."""
    verdict: str | None = None
    """Of a study that gives one: ``met``, ``not met``, ``clear`` or ``contact``."""
    again: str
    """What does the study again, in a shell."""
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
    """Its ``name``, its ``source``: the file, or the name if it is built in, its
    ``text`` as a case file, and the ``sha256`` of that text; made in Python, it has
    none of the three, and stands in ``case.json``."""
    named_files: Sequence[Mapping[str, Any]] = ()
    """Meshes and models that the case names, each with its ``sha256``."""
    runs: Sequence[str] = ()
    """Labels of the runs that the folder keeps."""
    files: Sequence[Mapping[str, Any]] = ()
    """Files of the study: ``name``, ``what`` it holds, and of a table what a row is
    for, and of each column its ``name``, ``unit`` and ``what`` it holds."""

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
        except (OSError, ValueError) as error:
            raise InputError(f"{file}: must be that of a study, got: {error}") from None
        try:
            return cls(**{**data, "ended": Ended(data["ended"])})
        except (TypeError, KeyError, ValueError) as error:
            raise InputError(f"{file}: must be that of a study, got: {error}") from None


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
        named_files=provenance.hashed(asked.named_files),
    )


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
