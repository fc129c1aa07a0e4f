"""How a run is integrated. No Drake here: the command line reads it."""

from dataclasses import dataclass

from drakesep.systems.checks import check_positive, unknown


SCHEMES = ("runge_kutta3", "runge_kutta5", "bogacki_shampine3", "radau3")
"""Integration schemes of Drake that control their error and suit separations."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Integration:
    """How a run is integrated.

    Raises:
        ValueError: the scheme is unknown, or the accuracy or the largest step is
            not positive.
    """

    scheme: str = "runge_kutta3"
    """One of `SCHEMES`."""
    accuracy: float = 1e-6
    """Of Drake's error control, in m, rad, m/s and rad/s a step."""
    max_step: float = 1.0
    """Largest step, s."""

    def __post_init__(self) -> None:
        """Check the values."""
        if self.scheme not in SCHEMES:
            raise ValueError(unknown("integration scheme", self.scheme, SCHEMES))
        check_positive("accuracy", self.accuracy)
        check_positive("max_step", self.max_step)
