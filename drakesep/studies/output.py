"""The folder that results go into."""

from pathlib import Path

from drakesep.systems.checks import InputError


_RESULTS = (
    *("worst_cases.csv", "history.csv", "comparison.csv", "requirements.csv"),
    *("table_4.csv", "evidence.csv", "searches.csv", "candidates.csv"),
    *("worst_points.csv", "sensitivities.csv", "tolerances.csv"),
    *("translation.png", "rotation.png", "tornado.png", "worst_clearance.png"),
)
"""What a study writes, beside its `motion_*.csv`."""


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


def clear_results(folder: Path) -> None:
    """Take the results of an earlier study out of a folder.

    An interrupted study must not stand beside the verdict of an earlier one.
    """
    for path in (*(folder / name for name in _RESULTS), *folder.glob("motion_*.csv")):
        path.unlink(missing_ok=True)
