"""Case files: YAML, built-in or a user's own."""

import errno
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.case_file.case import Case, Origin
from drakesep.case_file.errors import CaseError, explained, shown
from drakesep.case_file.yaml_text import read_yaml
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError
from drakesep.tables.roles import check_labels


_CASES = Path(__file__).parents[1] / "cases"


@typed
def builtin_cases() -> dict[str, Path]:
    """Return the built-in cases: name and file."""
    return {path.stem: path for path in sorted(_CASES.glob("*.yaml"))}


@typed
def load_case(source: str | Path) -> Case:
    """Read a case.

    A key without a value is an error: a case is written with
    ``model_dump(mode="json", exclude_none=True)``.

    Args:
        source: a file, or the name of a built-in case.

    Raises:
        CaseError: the file is missing, is not YAML, or does not describe a case.
    """
    return read_case(
        read_text(source),
        folder=_path_of(source).parent,
        source=_named(source),
        said=f"{source}: ",
    )


def read_text(source: str | Path) -> str:
    """Return what a case file, or the file of a built-in case, has in it.

    Raises:
        CaseError: the file is missing, or is no text.
    """
    try:
        return _text_of(_path_of(source))
    except (OSError, ValueError) as error:  # the latter of names that no file has, too
        reason = error.strerror if isinstance(error, OSError) else error
        if isinstance(error, UnicodeDecodeError):
            reason = "not a text file"
        raise CaseError(
            f"{source}: must be a readable case file or a built-in case "
            f"({', '.join(builtin_cases())}), got: {reason}"
        ) from error


def read_case(
    text: str, *, folder: Path, source: str | None = None, said: str = ""
) -> Case:
    """Return the case that a text describes.

    Args:
        text: YAML.
        folder: from which the files are named that it refers to.
        source: the file, or the name if it is built in; None: none.
        said: with which each line of an error begins.

    Raises:
        CaseError: the text is not YAML, or does not describe a case.
    """
    try:
        data = read_yaml(text)
    except InputError as error:
        raise CaseError(f"{said}{error}") from error
    if not isinstance(data, dict):
        raise CaseError(f"{said}must be a mapping of keys, got {shown(data)}")
    empty = list(_empty(data))
    if empty:
        wanted = "must have a value, got none"
        raise CaseError("\n".join(f"{said}{key}: {wanted}" for key in empty))
    try:
        context = {"folder": folder, "origin": Origin(source, text)}
        return Case.model_validate(data, context=context)
    except ValidationError as error:
        raise explained(error, said) from error


def _path_of(source: str | Path) -> Path:
    return builtin_cases().get(str(source), Path(source))


def _named(source: str | Path) -> str:
    """Return by what a case is read again, from any directory."""
    builtin = str(source) in builtin_cases()
    return str(source) if builtin else str(Path(source).absolute())


def analysis_case_of(case: Case | AnalysisCase | str | Path) -> AnalysisCase:
    """Return what a study works on.

    Args:
        case: a case, in SI or as a file holds it, a case file, or the name of a
            built-in case.

    Raises:
        CaseError: a file cannot be read.
        ValueError: a published case has the label of a run of a study.
    """
    if isinstance(case, AnalysisCase):
        check_labels(case, case.objective_names)
        return case
    return (case if isinstance(case, Case) else load_case(case)).in_si()


_LONGEST = 10_000_000
"""Bytes of a case file."""


def _text_of(path: Path) -> str:
    with path.open("rb") as file:
        data = file.read(_LONGEST + 1)
    if len(data) > _LONGEST:
        raise OSError(errno.E2BIG, f"more than {_LONGEST // 1_000_000} MB", str(path))
    return data.decode("utf-8")


_LIMITS = ("at_most", "at_least")


def _empty(data: Any, place: str = "") -> Iterator[str]:
    """Name the keys without a value: a section that was begun is not left out.

    An axis may be without a limit.
    """
    if isinstance(data, dict):
        for key, value in data.items():
            yield from _empty(value, f"{place}.{key}".lstrip("."))
    elif isinstance(data, list) and not place.endswith(_LIMITS):
        for number, value in enumerate(data, 1):
            yield from _empty(value, f"{place} (entry {number})")
    elif data is None:
        yield place
