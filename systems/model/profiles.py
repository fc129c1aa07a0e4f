"""Profiles of force over a stroke, and tables of measured ones."""

from typing import NamedTuple, TypeAlias

from drakesep.systems.checks import InputError, check_finite
from drakesep.systems.model.magnitudes import check_within


Profile: TypeAlias = tuple[tuple[float, float], ...]
"""Rows of displacement over the stroke and of force over the largest force. Straight
lines join them."""

LINEAR: Profile = ((0.0, 1.0), (1.0, 0.0))
"""The force falls from its maximum to zero at the stroke."""
CONSTANT: Profile = ((0.0, 1.0), (1.0, 1.0))
"""The force is the same over the stroke."""


class Table(NamedTuple):
    """What a table of force over displacement says."""

    stroke: float
    """m."""
    force_max: float
    """The largest force, whichever way, N."""
    profile: Profile


def read_table(
    name: str,
    displacements: tuple[float, ...],
    forces: tuple[float, ...],
    *,
    signed: bool = False,
) -> Table:
    """Return what a table says.

    Args:
        name: whose it is, for errors.
        displacements: (n,) of the rows, from 0, increasing, m.
        forces: (n,) at these displacements, N.
        signed: whether some may be negative.

    Raises:
        ValueError: the columns differ in length, or do not make a profile.
    """
    if len(displacements) != len(forces) or len(forces) < 2:
        raise InputError(
            f"{name}: force-stroke table must have two rows or more with a force "
            f"to each displacement, got {len(displacements)} displacements and "
            f"{len(forces)} forces"
        )
    check_within("length", f"{name}: displacement", *displacements)
    check_within("force", f"{name}: force", *forces)
    if displacements[0] != 0.0 or list(displacements) != sorted(set(displacements)):
        raise InputError(
            f"{name}: displacements must increase from 0, got "
            f"{', '.join(f'{s:g}' for s in displacements)} m"
        )
    stroke, force_max = displacements[-1], max(map(abs, forces))
    if force_max == 0.0 or (min(forces) < 0.0 and not signed):
        wanted = "not be 0 all" if signed else "be >= 0, with one above it"
        raise InputError(
            f"{name}: forces must {wanted}, got {', '.join(f'{f:g}' for f in forces)} N"
        )
    profile = tuple(
        (s / stroke, f / force_max) for s, f in zip(displacements, forces, strict=True)
    )
    return Table(stroke, force_max, profile)


def check_profile(name: str, profile: Profile, *, signed: bool = False) -> None:
    """Raise InputError unless it goes from 0 to 1, with forces up to 1.

    Args:
        name: of the profile, for errors.
        profile: in question.
        signed: whether forces may be negative.
    """
    if len(profile) < 2 or any(len(row) != 2 for row in profile):
        raise InputError(f"{name} must have two rows of two or more, got {profile}")
    check_finite(name, *(entry for row in profile for entry in row))
    fractions = [s for s, _ in profile]
    if (
        fractions[0] != 0.0
        or fractions[-1] != 1.0
        or fractions != sorted(set(fractions))
    ):
        raise InputError(
            f"{name} must have displacements that increase from 0 to the stroke, "
            f"got {', '.join(f'{s:g}' for s in fractions)} of the stroke"
        )
    forces = [f for _, f in profile]
    if max(map(abs, forces)) != 1.0 or (min(forces) < 0.0 and not signed):
        raise InputError(
            f"{name} must have forces from 0 to the largest, got "
            f"{', '.join(f'{f:g}' for f in forces)} of it"
        )
