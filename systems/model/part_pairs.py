"""Pairs of parts that are measured to each other. No Drake here."""

import itertools
from collections.abc import Mapping, Sequence

from drakesep.systems.checks import InputError, unknown
from drakesep.systems.model.separation import Separation


Names = tuple[str, str]


def owners_of(separation: Separation) -> dict[str, str]:
    """Return the body of each part, by their names."""
    return {e.name: body.name for body in separation.bodies for e in body.parts}


def part_pairs(
    separation: Separation, wanted: Sequence[Sequence[str]] | None = None
) -> list[Names]:
    """Return pairs of parts of different bodies.

    Args:
        separation: whose bodies have parts.
        wanted: names of two parts each; all there are if None.

    Raises:
        ValueError: one does not name two parts of different bodies.
    """
    owners = owners_of(separation)
    if wanted is None:
        return [
            (a, b)
            for a, b in itertools.combinations(owners, 2)
            if owners[a] != owners[b]
        ]
    checked = [_checked(names, owners) for names in wanted]
    # The same pair the other way round is the same pair.
    return list({frozenset(pair): pair for pair in reversed(checked)}.values())[::-1]


def pairs_apart(
    separation: Separation,
    wanted: Sequence[Sequence[str]] | None,
    touching: Sequence[Sequence[str]],
) -> list[Names]:
    """Return the pairs that are wanted; if None, all that do not touch while mated.

    Args:
        separation: whose bodies have parts.
        wanted: names of two parts each.
        touching: names of two parts each.

    Raises:
        ValueError: one does not name two parts of different bodies.
    """
    if wanted is not None:
        return part_pairs(separation, wanted)
    together = set(map(frozenset, part_pairs(separation, touching)))
    return [p for p in part_pairs(separation) if frozenset(p) not in together]


def _checked(names: Sequence[str], owners: Mapping[str, str]) -> Names:
    if isinstance(names, str) or len(names) != 2:
        raise InputError(f"pair: must name two parts, got {names!r}")
    for name in names:
        if name not in owners:
            known = owners or ["none, since no body has geometry"]
            raise InputError(f"pair: {unknown('part', name, known)}")
    a, b = names
    if owners[a] == owners[b]:
        raise InputError(
            f"pair: must name parts of two bodies, got {a} and {b} of {owners[a]}"
        )
    return a, b
