"""Failure cases: what may go wrong in a separation, apart from its tolerances."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError, check_positive, named, unknown
from drakesep.systems.frozen_mapping import FrozenMapping
from drakesep.systems.model.parameters import parameters, with_values
from drakesep.systems.model.separation import Separation


DESIGN = "design"
"""By which tables name what has not failed."""


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class FailureCase:
    """What has failed: parameters that have other values than they were designed with.

    They keep these whatever their tolerances; all others vary as they do in the design.

    Raises:
        ValueError: the name cannot stand in tables and names of files, or nothing is
            changed.
    """

    name: str
    """In tables and plots; of letters, digits, _ and -."""
    values: Mapping[str, float]
    """Of parameters by name, in SI; an infinite time of release: never."""

    def __post_init__(self) -> None:
        """Check the values."""
        object.__setattr__(self, "values", FrozenMapping(self.values))
        if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]*", self.name):
            raise InputError(
                "name of a failure case must be made of letters, digits, _ and -, got "
                f"{self.name!r}"
            )
        if self.name == DESIGN:
            raise InputError(
                f"name of a failure case must not be {DESIGN!r}: so tables name what "
                "has not failed"
            )
        if not self.values:
            raise InputError(f"{self.name}: must change a parameter, got none")


def check_failure_cases(
    separation: Separation, failures: tuple[FailureCase, ...]
) -> None:
    """Raise InputError unless each stands once and differs from what is designed."""
    nominal = parameters(separation)
    names = [failure.name for failure in failures]
    for failure in failures:
        if names.count(failure.name) > 1:
            raise InputError(f"failure_cases: {failure.name!r} must stand once")
        with named(f"failure_cases: {failure.name}"):
            with_values(separation, failure.values)
            if all(nominal[name] == x for name, x in failure.values.items()):
                raise InputError(
                    "must differ from the nominal values, got what they are: "
                    + ", ".join(failure.values)
                )


def check_probabilities(
    failures: tuple[FailureCase, ...], probabilities: Mapping[str, float]
) -> None:
    """Raise InputError unless each is one of a failure case, and they leave a rest."""
    names = [failure.name for failure in failures]
    for name, probability in probabilities.items():
        if name not in names:
            raise InputError(f"failures: {unknown('failure case', name, names)}")
        check_positive(f"failures: {name}", probability)
    total = math.fsum(probabilities.values())
    if total >= 1.0:
        raise InputError(
            f"failures: probabilities must add up to less than 1, got {total:g}"
        )
