"""Forces between bodies that touch again after they have parted. No Drake here."""

from dataclasses import dataclass

from drakesep.systems.argument_types import typed
from drakesep.systems.checks import check_not_negative
from drakesep.systems.model.magnitudes import check_size, check_within


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Recontact:
    """Contact between parts of different bodies.

    Where a ball or a capsule touches, two convex pieces that overlap by x push each
    other apart at a point with the force of Hunt and Crossley, k x (1 + d x'), never
    below 0. Pieces with faces press over all of where they overlap, with a pressure of
    the same form, x the depth at each place, and a stiffness for each area in the place
    of k: exactly of boxes and solid cylinders; what is cut into other pieces is up to
    twice as stiff to these. Both slide with Coulomb friction.

    Raises:
        ValueError: a stiffness is not positive, or another number negative.
    """

    stiffness: float
    """k, of one pair of pieces, N/m."""
    face_stiffness: float | None = None
    """Pressure of faces for each depth, N/m^3; None: the stiffness over the area of the
    smallest piece, a quarter of its surface."""
    dissipation: float = 0.0
    """d, s/m; 0: no energy is lost."""
    friction: float = 0.0
    """Coefficient, sticking and sliding."""
    without: tuple[tuple[str, str], ...] = ()
    """Pairs of parts that do not push, such as those that touch while mated."""

    def __post_init__(self) -> None:
        """Check the values."""
        check_size("stiffness", "recontact: stiffness", self.stiffness)
        if self.face_stiffness is not None:
            check_size(
                "face_stiffness", "recontact: face_stiffness", self.face_stiffness
            )
        for name in ("dissipation", "friction"):
            check_not_negative(f"recontact: {name}", getattr(self, name))
            check_within("factor", f"recontact: {name}", getattr(self, name))
