"""Public names that have changed: the former ones still work, with a warning."""

import warnings
from collections.abc import Callable, Mapping
from typing import Any

from drakesep.systems.checks import DrakesepWarning


class FormerName(DrakesepWarning, DeprecationWarning):
    """A name that has changed is asked for."""


def or_former(
    package: str, get: Callable[[str], Any], renamed: Mapping[str, str]
) -> Callable[[str], Any]:
    """Return a package's ``__getattr__`` that knows former names too.

    Args:
        package: its name.
        get: its ``__getattr__``.
        renamed: new names by former ones.
    """

    def get_or_former(name: str) -> Any:
        new = renamed.get(name)
        if new is None:
            return get(name)
        message = f"{package}.{name} is called {new} now; the former name will go"
        warnings.warn(message, FormerName, stacklevel=2)
        return get(new)

    return get_or_former
