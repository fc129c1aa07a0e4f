"""Where a user's caches cannot be written, a command goes on with ones of its own."""

import contextlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path


_FOLDER = "MPLCONFIGDIR"


@contextlib.contextmanager
def fonts_kept() -> Iterator[None]:
    """Give matplotlib a folder, and that of processes which are started meanwhile."""
    if _is_writable("XDG_CONFIG_HOME", ".config") and _is_writable(
        "XDG_CACHE_HOME", ".cache"
    ):
        yield
        return
    before = os.environ.get(_FOLDER)
    with tempfile.TemporaryDirectory(prefix="drakesep-fonts-") as own:
        os.environ[_FOLDER] = own
        try:
            yield
        finally:
            del os.environ[_FOLDER]
            if before is not None:
                os.environ[_FOLDER] = before


def _is_writable(variable: str, default: str) -> bool:
    """Return whether matplotlib can write one of its folders, as it looks for them."""
    folder = Path(os.environ.get(variable) or Path.home() / default) / "matplotlib"
    folder = Path(os.environ.get(_FOLDER) or folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK)
