"""How a run is integrated. No Drake here: the command line reads it."""

from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError, check_positive, unknown
from drakesep.systems.model.magnitudes import check_size


Scheme: TypeAlias = Literal[
    "runge_kutta5", "runge_kutta3", "bogacki_shampine3", "radau3"
]
SCHEMES: tuple[str, ...] = get_args(Scheme)
"""Integration schemes of Drake that control their error and suit separations.

The last, implicit, is for stiff joints with much damping.
"""

FINEST, COARSEST = 1e-12, 1e-3
"""Of the accuracies: beyond them round-off, or the error, would rule the result."""


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Integration:
    """How a run is integrated.

    Raises:
        ValueError: the scheme is unknown, the accuracy is out of bounds, or the
            largest step or the time limit is not positive.
    """

    scheme: Scheme = "runge_kutta5"
    """One of `SCHEMES`."""
    accuracy: float = 1e-6
    """Of Drake's error control, in m, rad, m/s and rad/s a step; of a tenth of it with
    runge_kutta5, whose errors then are no larger than those of runge_kutta3."""
    max_step: float = 1.0
    """Largest step, s."""
    time_limit: float = 600.0
    """After so much time of a processor a run fails, s.

    The last resort, which depends on the machine: how many steps a run may take, and
    how often its forces may be evaluated, does not.
    """

    def __post_init__(self) -> None:
        """Check the values."""
        if self.scheme not in SCHEMES:
            raise InputError(unknown("integration scheme", self.scheme, SCHEMES))
        check_positive("accuracy", self.accuracy)
        if not FINEST <= self.accuracy <= COARSEST:
            raise InputError(
                f"accuracy must be from {FINEST:g} to {COARSEST:g}, "
                f"got {self.accuracy:g}"
            )
        check_size("time", "max_step", self.max_step)
        check_size("time", "time_limit", self.time_limit)
