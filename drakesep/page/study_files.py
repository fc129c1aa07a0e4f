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


def as_typed(number: float) -> str:
    """Return a number of a field as a command line has it, to its last digit."""
    return str(int(number)) if number == int(number) else repr(number)


def next_folder(workspace: Workspace, study: str) -> Path:
    """Make the folder of a new study, the first of its kind that is not there.

    It is there from now on, so that no other page takes it.

    Raises:
        OSError: it cannot be made.
    """
    home = _home(workspace)
    home.mkdir(parents=True, exist_ok=True)
    while True:
        with contextlib.suppress(FileExistsError):
            folder = _first_free(home, study, "")
            folder.mkdir()
            return folder


def _home(workspace: Workspace) -> Path:
    return (workspace.results / workspace.name).absolute()


def _kept(home: Path, name: str, text: str) -> Path:
    """Return the file of a case beside its results; one that has this text, or new."""
    home.mkdir(parents=True, exist_ok=True)
    for file in sorted(home.glob(f"{name}-*.yaml")):
        if file.read_bytes() == text.encode():
            return file
    file = _first_free(home, name, ".yaml")
    write_text(file, text)
    return file


def _first_free(home: Path, name: str, ending: str) -> Path:
    number = 1
    while (path := home / f"{name}-{number}{ending}").exists():
        number += 1
    return path


def from_here(folder: Path) -> Path:
    """Return a folder as seen from the working directory, if it is below that."""
    here = Path.cwd()
    return folder.relative_to(here) if folder.is_relative_to(here) else folder


def export(folder: Path, target: Path) -> str:
    """Write what reproduces a study to the bit: its case, and the command.

    The command pins what was planned by the speed of this machine, so that another
    does the same. Files that the case names are copied beside it.

    Args:
        folder: with results.
        target: new folder.

    Returns:
        What runs it in a shell, from any folder; of what has been exported before, too.

    Raises:
        ValueError: the study was asked from Python or has just begun, files lie outside
            of the case's folder, or something else is where the target would be.
        OSError: it cannot be written.
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
    if not _holds(target, {name: text, _SCRIPT: script}):
        if target.exists():
            raise InputError(f"{target}: is there already, and holds something else")
        copies = [_copy_of(Path(f), source.absolute()) for f in record.named_files]
        target.mkdir(parents=True)
        for file, place in copies:
            (target / place).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, target / place)
        write_text(target / name, text)
        write_text(target / _SCRIPT, script)
        (target / _SCRIPT).chmod(0o755)
    return f"cd {shlex.quote(str(target))} && {command}"


def _holds(folder: Path, texts: Mapping[str, str]) -> bool:
    """Return whether a folder has files with these texts."""
    try:
        return all((folder / k).read_bytes() == t.encode() for k, t in texts.items())
    except OSError:
        return False


_SCRIPT = "command.sh"
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


def _copy_of(file: Path, source: Path) -> tuple[Path, Path]:
    """Return a file that a case names, and where it stands below the case's folder."""
    absolute = file if file.is_absolute() else source / file
    if not absolute.is_relative_to(source):
        raise InputError(f"{file}: must lie within {source}, to be exported")
    return absolute, absolute.relative_to(source)
