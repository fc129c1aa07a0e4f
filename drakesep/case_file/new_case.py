"""New case files: a small one with comments to start from, or a built-in one."""

import re
from pathlib import Path

from drakesep.case_file.reader import builtin_cases
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError, unknown


_TEMPLATE = Path(__file__).with_name("new_case.yaml")
"""Its name of a case stands wherever the new one does; in quotes as the case's name, as
YAML would read 123, null or a date as no text."""


@typed
def new_case(name: str, *, like: str | None = None, file: Path | None = None) -> Path:
    """Write a case file to start from; what is there is never overwritten.

    Args:
        name: of the case, of letters, digits, _ and -.
        like: name of the built-in case that it begins as; a small one with comments if
            None.
        file: to be written; NAME.yaml if None.

    Returns:
        The file.

    Raises:
        ValueError: the name is not made of these, or that of a built-in case; there is
            no such built-in case; or the file is there.
    """
    text = new_case_text(name, like=like)
    file = Path(f"{name}.yaml") if file is None else file
    try:
        with file.open("x", encoding="utf-8") as stream:
            stream.write(text)
    except FileExistsError:
        raise InputError(
            f"output: must be a file that is not there yet, got {file}"
        ) from None
    return file


def new_case_text(name: str, *, like: str | None = None) -> str:
    """Return the text of a case file to start from.

    Args:
        name: of the case, of letters, digits, _ and -.
        like: name of the built-in case that it begins as; a small one with comments if
            None.

    Raises:
        ValueError: the name is not made of these, or that of a built-in case; or there
            is no such built-in case.
    """
    builtin = builtin_cases()
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]*", name):
        raise InputError(
            f"name: must be made of letters, digits, _ and -, got {name!r}"
        )
    if name in builtin:
        raise InputError(f"name: must not be that of a built-in case, got {name!r}")
    if like is not None and like not in builtin:
        raise InputError(unknown("built-in case", like, builtin))
    if like is None:
        return _TEMPLATE.read_text(encoding="utf-8").replace("new_case", name)
    text = builtin[like].read_text(encoding="utf-8")
    return re.sub(r"^name: .*$", f'name: "{name}"', text, count=1, flags=re.M)
