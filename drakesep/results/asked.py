"""What was asked of a study: enough to ask again."""

import shlex
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Self

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.case_file.case import Case
from drakesep.case_file.reader import analysis_case_of, load_case
from drakesep.systems.model.parts import Mesh


@dataclass(frozen=True, kw_only=True)
class Asked:
    """A study, its case and its arguments, and when it began."""

    study: str
    """Its name, that of the function and of the command."""
    case: AnalysisCase
    source: str | None
    """The case file, or the name of the built-in case; None if it came as an object."""
    text: str | None
    """The case as a case file has it; None of a case in SI, made in Python."""
    named_files: tuple[Path, ...] = ()
    """Meshes and models that it names."""
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
        *,
        seed: int | None = None,
        **arguments: Any,
    ) -> Self:
        """Return what is asked, with the case read if it is a file.

        Args:
            study: its name.
            case: as studies take it.
            seed: of what is drawn at random.
            arguments: of the function; one that is None or empty was not given.

        Raises:
            CaseError: a file cannot be read.
            ValueError: a published case has the label of a run of a study.
        """
        source = str(case) if isinstance(case, str | Path) else None
        read = load_case(case) if isinstance(case, str | Path) else case
        in_file = read if isinstance(read, Case) else None
        record = analysis_case_of(read)
        return cls(
            study=study,
            case=record,
            source=source or (in_file.source if in_file else None),
            text=in_file.text if in_file else None,
            named_files=in_file.files if in_file else _meshes(record),
            arguments={k: v for k, v in arguments.items() if v not in (None, (), {})},
            seed=seed,
        )

    @property
    def seconds(self) -> float:
        """How long it took, or takes until now."""
        return time.monotonic() - self._clock if self.took is None else self.took

    def over(self) -> Self:
        """Return it for a study that has ended now."""
        return replace(self, took=self.seconds)

    def again(self, folder: Path, command: Sequence[str] | None) -> str:
        """Return what does the study again, for a shell.

        Args:
            folder: of its results, which has the case if nothing else does.
            command: arguments of the command line that asked; None if Python did.
        """
        if command is not None:
            return shlex.join(["drakesep", *command])
        case = (
            f"drakesep.read_results({str(folder)!r}).case"
            if self.source is None
            else repr(self.source)
        )
        given = {**self.arguments, "seed": self.seed} if self.seed else self.arguments
        call = ", ".join([case, *(f"{k}={_written(v)}" for k, v in given.items())])
        function = f"drakesep.{self.study.replace('-', '_')}({call})"
        again = f"import drakesep; {function}.save({str(folder)!r})"
        return shlex.join(["python", "-c", again])

    @property
    def plain_arguments(self) -> dict[str, Any]:
        """The arguments as JSON has them; of functions and objects their names."""
        return {name: _plain(value) for name, value in self.arguments.items()}


def _meshes(case: AnalysisCase) -> tuple[Path, ...]:
    parts = (part for body in case.separation.bodies for part in body.parts)
    return tuple(p.shape.file for p in parts if isinstance(p.shape, Mesh))


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    if value is None or isinstance(value, bool | int | float | str):
        return value
    return _name(value)


def _name(value: Callable[..., Any] | object) -> str:
    name = getattr(value, "name", None) or getattr(value, "__name__", None)
    return str(name or type(value).__name__)


def _written(value: Any) -> str:
    """Return a value as Python has it; what has no such text, by its name."""
    plain = _plain(value)
    return repr(plain)
