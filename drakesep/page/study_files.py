"""Files around the studies of a page: the case that they read, and where they write.

A study is asked for by a case file or the name of a built-in case. A case that was
changed and not saved is written beside its results first: that is what was studied.
"""

import contextlib
import shlex
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from drakesep.files import write_text
from drakesep.page.workspace import Workspace
from drakesep.systems.checks import InputError


def case_argument(workspace: Workspace) -> str:
    """Return the case as the command line names it.

    Raises:
        ValueError: something is wrong with the case, or it is not saved and names
            files, which it would not find from elsewhere.
    """
    case = workspace.case
    if case is None:
        raise InputError("the case is not right: see the tab Case")
    if case.source is not None and workspace.is_on_disk:
        return str(case.source)
    if case.files:
        raise InputError(
            "the case names files: save it where they are found, then study it"
        )
    file = _kept(_home(workspace), workspace.name, workspace.text)
    return str(file)


def next_folder(workspace: Workspace, study: str) -> Path:
    """Return the folder of a new study: the first of its kind that is not there.

    It is made, so that no other page takes it before the study begins.

    Raises:
        ValueError: it cannot be made.
    """
    home = _home(workspace)
    while True:
        folder = _first_free(home, study, "")
        with contextlib.suppress(FileExistsError):  # another has been faster
            folder.mkdir()
            return folder


def _home(workspace: Workspace) -> Path:
    from drakesep.results.folder import writable_folder

    return writable_folder((workspace.results / workspace.name).absolute())


def number_option(name: str, value: float | None) -> list[str]:
    """Return an option of the command line that is a number, to its last digit.

    Args:
        name: of the option, without dashes.
        value: as a field gives it; None: it is empty, and the option left out.
    """
    if value is None:
        return []
    return [f"--{name}", f"{value:.0f}" if value == round(value) else repr(value)]


def _kept(home: Path, name: str, text: str) -> Path:
    """Return the file of a case beside its results; one that has this text, or new."""
    for file in sorted(home.glob(f"{name}-*.yaml")):
        if file.read_text(encoding="utf-8") == text:
            return file
    file = _first_free(home, name, ".yaml")
    write_text(file, text)
    return file


def _first_free(home: Path, name: str, ending: str) -> Path:
    number = 1
    while (path := home / f"{name}-{number}{ending}").exists():
        number += 1
    return path


def export(folder: Path, target: Path) -> str:
    """Write what reproduces a study to the bit: its case, and the command.

    The command pins what was planned by the speed of this machine, so that another
    does the same. Files that the case names are copied beside it.

    Args:
        folder: with results.
        target: new folder.

    Returns:
        The command, to be run in the target.

    Raises:
        ValueError: the study was asked from Python or under way, files lie outside of
            the case's folder, the target holds something else, or cannot be written.
    """
    from drakesep.results.reading import read_results

    record = read_results(folder).record
    text = record.case["text"]
    if text is None:
        raise InputError(f"{folder}: must be of a case file, got a case made in Python")
    name = f"{record.case['name']}.yaml"
    source = Path(record.case["source"] or "").parent
    words = [
        *("drakesep", *_COMMANDS.get(record.study, (record.study,)), name),
        *_options({**record.arguments, **record.plan}, record.seed, record.study),
        *("-o", "again"),
    ]
    command = shlex.join(words)
    script = f'#!/bin/sh\ncd "$(dirname "$0")"\n{command}\n'
    written = {name: text, "command.sh": script}
    if target.exists():
        if any(_text_of(target / file) != what for file, what in written.items()):
            raise InputError(f"{target}: is there already, with something else in it")
        return command  # it has been exported before
    try:
        target.mkdir(parents=True)
        for file in record.named_files:
            _copy(Path(file), source.absolute(), target)
        for file, what in written.items():
            write_text(target / file, what)
        (target / "command.sh").chmod(0o755)
    except OSError as error:
        raise InputError(f"{target}: cannot be written: {error.strerror}") from error
    return command


def export_beside(folder: Path) -> str:
    """Export a study into a folder beside its results.

    Returns:
        The command, which goes there first.

    Raises:
        ValueError: as `export`.
    """
    target = folder.absolute().with_name(f"{folder.name}-export")
    return f"cd {shlex.quote(str(target))} && {export(folder, target)}"


def _text_of(file: Path) -> str | None:
    try:
        return file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return None


_COMMANDS: Mapping[str, tuple[str, ...]] = {
    "sensitivity": ("campaign", "sensitivity"),
    "rare-events": ("campaign", "rare-events"),
}
_SINGULAR = {"objectives": "objective", "searches": "search", "metrics": "metric"}


def _options(arguments: Mapping[str, Any], seed: int | None, study: str) -> list[str]:
    """Return the options of the command line that say the same as arguments."""
    seeded = {} if seed is None else {"seed": seed}
    words: list[str] = []
    for name, value in {**arguments, **seeded}.items():
        if study == "worst-case" and name in ("growth", "corners"):
            continue  # of its plan, which it shares with `verify`
        option = "--" + _SINGULAR.get(name, name).replace("_", "-")
        if value is True:
            words.append(option)
        elif value is False:
            words.append(option.replace("--", "--no-", 1))
        elif value is not None:
            each = value if isinstance(value, list | tuple) else [value]
            for one in each:
                words += [option, one if isinstance(one, str) else repr(one)]
    return words


def _copy(file: Path, source: Path, target: Path) -> None:
    absolute = file if file.is_absolute() else source / file
    if not absolute.is_relative_to(source):
        raise InputError(f"{file}: must lie within {source}, to be exported")
    copy = target / absolute.relative_to(source)
    copy.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(absolute, copy)
