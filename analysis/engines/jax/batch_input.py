"""What a batch refuses when it is made."""

from collections.abc import Mapping, Sequence

import numpy as np

from drakesep.analysis.metrics.requirements import Limits
from drakesep.systems.checks import InputError, unknown
from drakesep.systems.model.separation import Pair, Separation


def check_names(names: Sequence[str], known: Mapping[str, float]) -> None:
    """Raise InputError unless the names are different parameters that are known."""
    if isinstance(names, str) or not len(names):
        raise InputError(f"names must be a list of parameters, got {names!r}")
    for name in names:
        if name not in known:
            raise InputError(unknown("parameter", name, known))
    if len(set(names)) < len(names):
        raise InputError(f"parameters must differ, got {', '.join(names)}")


def check_limits(limits: Limits, pairs: Sequence[Pair]) -> None:
    """Raise InputError unless there are three limits of zero or more, rad.

    Args:
        limits: of the first pair, or of several by their B's name.
        pairs: that there are.
    """
    if isinstance(limits, Mapping):
        known = ["", *(pair.B for pair in pairs[1:])]
        for name, mine in limits.items():
            if name not in known:
                raise InputError(unknown("body with deviation limits", name, known))
            check_limits(mine, pairs)
    elif not np.shape(limits) == (3,) or not all(limit >= 0.0 for limit in limits):
        raise InputError(f"deviation limits must be three, >= 0, in rad, got {limits}")


def check_free(separation: Separation) -> None:
    """Raise InputError if parts push each other where they touch again."""
    if separation.recontact is not None:
        raise InputError(
            "recontact: the batch engine knows no contact forces; leave recontact out, "
            "or let Drake fly run by run: --search drake"
        )
