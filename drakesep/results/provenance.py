"""Where results come from: versions, the commit, hashes of files."""

import hashlib
import importlib.metadata
import os
import platform
import subprocess
from collections.abc import Iterable
from pathlib import Path

from drakesep.version import __version__


DIRTY = "-dirty"
"""At the end of a commit beside which there were changes, as git says it."""
_LIBRARIES = ("drake", "jax", "jaxlib", "numpy", "scipy", "pandas")
_CHECKOUT = Path(__file__).parents[2]
"""Of drakesep, if it is not installed apart from it."""


def versions() -> dict[str, str]:
    """Return versions by name: of drakesep, Python and the libraries that compute."""
    libraries = {name: importlib.metadata.version(name) for name in _LIBRARIES}
    return {"drakesep": __version__, "python": platform.python_version(), **libraries}


def commit() -> str | None:
    """Return the commit of drakesep's own checkout, ``-dirty`` if it was changed.

    None if drakesep is not in one, or git is not there.
    """
    if not (_CHECKOUT / ".git").exists():  # else git would look in folders above
        return None
    command = ["git", "-C", str(_CHECKOUT), "describe", "--always", "--dirty"]
    # A hook of the user's own repository points git at that one.
    clean = {k: v for k, v in os.environ.items() if not k.startswith("GIT_")}
    try:
        told = subprocess.run(
            [*command, "--abbrev=40", "--exclude=*"],
            capture_output=True,
            text=True,
            timeout=10.0,
            env=clean,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return told.stdout.strip()


def hashed(files: Iterable[Path]) -> dict[str, str | None]:
    """Return the SHA-256 of each file by its path; None of one that is not there."""
    return {str(file.resolve()): sha256_of(file) for file in files}


def sha256(text: str) -> str:
    """Return the SHA-256 of a text in UTF-8."""
    return hashlib.sha256(text.encode()).hexdigest()


def sha256_of(file: Path) -> str | None:
    """Return the SHA-256 of a file; None if it cannot be read."""
    try:
        with file.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError:
        return None
