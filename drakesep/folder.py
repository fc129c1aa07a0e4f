"""The folder that results go into."""

from pathlib import Path

from drakesep.systems.checks import InputError


def writable_folder(directory: str | Path) -> Path:
    """Return a folder, made if need be.

    Raises:
        ValueError: it cannot be made or written.
    """
    folder = Path(directory)
    probe = folder / ".drakesep"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise InputError(
            f"output: must be a folder that can be written, got {folder} "
            f"({error.strerror})"
        ) from error
    return folder
