"""Parameters that are correlated: by ranks, through a Gaussian copula.

Each keeps its own distribution. Standard normal values that are correlated are drawn,
and each is turned into the value of its parameter at the same share. For continuous
distributions Spearman's rank correlation r comes of the correlation 2 sin(pi r / 6) of
the normal values (K. Pearson, "On further methods of determining correlation", 1907).
"""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError, check_finite


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class RankCorrelation:
    """Parameters any two of which have the same rank correlation.

    Raises:
        ValueError: fewer than two parameters, or the correlation is not between -1 and
            1.
    """

    names: tuple[str, ...]
    """Of the parameters."""
    rank: float
    """Spearman's rank correlation of any two."""

    def __post_init__(self) -> None:
        """Check the values."""
        if len(set(self.names)) < max(2, len(self.names)):
            raise InputError(
                "correlation: must have two different parameters or more, got "
                + (", ".join(self.names) or "none")
            )
        check_finite(f"{self.label}: rank", self.rank)
        if not -1.0 < self.rank < 1.0:
            raise InputError(
                f"{self.label}: rank must be between -1 and 1, got {self.rank:g}"
            )

    @property
    def label(self) -> str:
        """Of it, in errors."""
        return f"correlation of {', '.join(self.names)}"

    def without(self, names: Collection[str]) -> "RankCorrelation | None":
        """Return that of the other parameters; None if no two are left."""
        kept = tuple(name for name in self.names if name not in names)
        return RankCorrelation(names=kept, rank=self.rank) if len(kept) > 1 else None


@dataclass(frozen=True, slots=True)
class CorrelatedNormals:
    """Standard normal values of parameters that are correlated with each other."""

    names: tuple[str, ...]
    """Of the m parameters."""
    matrix: Array
    """Their correlations, (m, m)."""


def correlated_normals(
    correlations: Sequence[RankCorrelation],
) -> tuple[CorrelatedNormals, ...]:
    """Return the normal values behind rank correlations, those that go together in one.

    Raises:
        ValueError: two correlations are of the same two parameters, or nothing can be
            correlated so.
    """
    ranks: dict[frozenset[str], float] = {}
    for correlation in correlations:
        for pair in map(frozenset, combinations(correlation.names, 2)):
            if pair in ranks:
                raise InputError(
                    f"{correlation.label}: {' and '.join(sorted(pair))} must stand in "
                    "one correlation, got two"
                )
            ranks[pair] = correlation.rank
    return tuple(_normals(names, ranks) for names in _together(correlations))


def _together(correlations: Sequence[RankCorrelation]) -> list[tuple[str, ...]]:
    """Return the names of parameters that are correlated, through others too."""
    groups: list[tuple[str, ...]] = []
    for correlation in correlations:
        names = correlation.names
        for group in [g for g in groups if set(g) & set(names)]:
            groups.remove(group)
            names = tuple(dict.fromkeys([*group, *names]))
        groups.append(names)
    return groups


def _normals(
    names: tuple[str, ...], ranks: dict[frozenset[str], float]
) -> CorrelatedNormals:
    matrix = np.eye(len(names))
    for i, j in combinations(range(len(names)), 2):
        rank = ranks.get(frozenset((names[i], names[j])), 0.0)
        matrix[i, j] = matrix[j, i] = 2.0 * math.sin(math.pi * rank / 6.0)
    least = float(np.linalg.eigvalsh(matrix)[0])
    if least < _LEAST:
        raise InputError(
            f"correlation of {', '.join(names)}: must be one that values can have, "
            "whose matrix is positive definite, got one with the eigenvalue "
            f"{least:.3g}"
        )
    return CorrelatedNormals(names, matrix)


_LEAST = 1e-9
"""Smallest eigenvalue of a correlation matrix."""
