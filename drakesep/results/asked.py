"""What was asked of a study: enough to ask again."""

import json
import shlex
import time
from collections.abc import Mapping, Sequence, Sized
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Self

import numpy as np

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.case_file.case import Case
from drakesep.case_file.reader import analysis_case_of, load_case
from drakesep.results import provenance
from drakesep.systems.checks import InputError
from drakesep.systems.geometry.meshes import mesh_bytes
from drakesep.systems.model.parts import Mesh


@dataclass(frozen=True, kw_only=True)
class Asked:
    """A study, its case and its arguments, and when it began."""

    study: str
    """Its name, that of the function and of the command."""
    case: AnalysisCase
    source: str | None
    """The case file, or the name of the built-in case; None of what was made in
    Python."""
    text: str | None
    """The case as a case file has it; None of a case in SI, made in Python."""
    named_files: Mapping[str, str | None] = field(default_factory=dict)
    """Meshes and models that it names: their SHA-256 then, by their paths."""
    meshes: Mapping[Path, bytes] = field(default_factory=dict, repr=False)
    """What the meshes of its parts held then, by their files."""
    arguments: Mapping[str, Any] = field(default_factory=dict)
    """Of the function, beside the case and the folder, that were given."""
    seed: int | None = None
    """Of what is drawn at random; None: nothing is."""
    begun: datetime = field(default_factory=lambda: datetime.now(UTC))
    took: float | None = None
    """How long it took, s; None: it is under way."""
    _clock: float = field(default_factory=time.monotonic)

    @classmethod
    def of(
        cls,
        study: str,
        case: Case | AnalysisCase | str | Path,
        arguments: Mapping[str, Any] | None = None,
        *,
        seed: int | None = None,
    ) -> Self:
        """Return what is asked, with the case read if it is a file.

        Args:
            study: its name.
            case: as studies take it.
            arguments: of the function; one that is None or empty was not given.
            seed: of what is drawn at random.

        Raises:
            CaseError: a file cannot be read.
            ValueError: a published case has the label of a run of a study.
        """
        read = load_case(case) if isinstance(case, str | Path) else case
        in_file = read if isinstance(read, Case) else None
        record = analysis_case_of(read)
        meshes = _meshes(record)
        files = in_file.files if in_file else meshes
        return cls(
            study=study,
            case=record,
            source=None if in_file is None else in_file.source,
            text=in_file.text if in_file else None,
            named_files=provenance.hashed(files),
            meshes={file: mesh_bytes(file) for file in meshes if file.is_file()},
            arguments={k: v for k, v in (arguments or {}).items() if is_given(v)},
            seed=None if seed is None else int(seed),
        )

    @property
    def seconds(self) -> float:
        """How long it took, or takes until now."""
        return time.monotonic() - self._clock if self.took is None else self.took

    def over(self) -> Self:
        """Return it for a study that has ended now.

        Raises:
            ValueError: a mesh is no longer what it was when the study began. Parts are
                measured at several times and by several processes: nobody can say
                which of its contents was.
        """
        for file, content in self.meshes.items():
            if not file.is_file() or mesh_bytes(file) != content:
                raise InputError(
                    f"{file}: must stay as it is while it is measured, got a file that "
                    "has changed since"
                )
        return replace(self, took=self.seconds)

    def again(self, folder: Path, command: Sequence[str] | None) -> str | None:
        """Return what does the study again, for a shell, from any directory.

        None if an argument is a function or an object, which no text holds.

        Args:
            folder: of its results, which has the case if nothing else does.
            command: arguments of the command line that asked; None if Python did.
        """
        if command is not None:
            where = shlex.quote(str(Path.cwd()))
            return f"cd {where} && {shlex.join(['drakesep', *command])}"
        try:
            given = json.loads(json.dumps(dict(self.arguments), default=_data))
        except TypeError:
            return None
        case = (
            f"drakesep.read_results({str(folder)!r}).case"
            if self.source is None
            else repr(self.source)
        )
        call = ", ".join([case, *(f"{k}={value!r}" for k, value in given.items())])
        function = f"drakesep.{self.study.replace('-', '_')}({call})"
        again = f"import drakesep; {function}.save({str(folder)!r})"
        return shlex.join(["python", "-c", again])

    @property
    def plain_arguments(self) -> dict[str, Any]:
        """The arguments as JSON has them; of functions and objects their names."""
        text = json.dumps(dict(self.arguments), default=_data_or_name)
        plain: dict[str, Any] = json.loads(text)
        return plain


def _meshes(case: AnalysisCase) -> tuple[Path, ...]:
    parts = (part for body in case.separation.bodies for part in body.parts)
    return tuple(p.shape.file for p in parts if isinstance(p.shape, Mesh))


def is_given(value: Any) -> bool:
    """Return whether an argument was given: one that is None or empty was not."""
    return value is not None and not (isinstance(value, Sized) and not len(value))


def _data(value: Any) -> Any:
    """Return what JSON has for data that it does not know.

    Raises:
        TypeError: it is no data.
    """
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"must be data, got {value!r}")


def _data_or_name(value: Any) -> Any:
    try:
        return _data(value)
    except TypeError:
        name = getattr(value, "name", None) or getattr(value, "__name__", None)
        return str(name or type(value).__name__)
