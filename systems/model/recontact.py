"""Forces between bodies that touch again after they have parted. No Drake here."""

from dataclasses import dataclass

from drakesep.systems.argument_types import typed
from drakesep.systems.checks import check_not_negative
from drakesep.systems.model.magnitudes import check_size, check_within


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Recontact:
    """Contact between parts of different bodies.

    Each two convex pieces that overlap by x push each other apart with the force of
    Hunt and Crossley, k x (1 + d x'), never below 0, and slide with Coulomb friction.

    Raises:
        ValueError: the stiffness is not positive, or another number negative.
    """

    stiffness: float
    """k, of one pair of pieces, N/m."""
    dissipation: float = 0.0
    """d, s/m; 0: no energy is lost."""
    friction: float = 0.0
    """Coefficient, sticking and sliding."""
    without: tuple[tuple[str, str], ...] = ()
    """Pairs of parts that do not push, such as those that touch while mated."""

    def __post_init__(self) -> None:
        """Check the values."""
        check_size("stiffness", "recontact: stiffness", self.stiffness)
        for name in ("dissipation", "friction"):
            check_not_negative(f"recontact: {name}", getattr(self, name))
            check_within("factor", f"recontact: {name}", getattr(self, name))
