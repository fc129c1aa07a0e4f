"""A certificate of proven bounds, checked anew by the program that shares no code.

That program, `drakesep.check_proof`, stands alone; here its claims go to processes that
end with the caller, and the user is told how far they are.
"""

import functools
import os
from collections.abc import Callable, Iterator
from concurrent.futures import as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import pandas as pd

from drakesep.analysis.engines.processes import end_processes, start_processes
from drakesep.studies.worst_case.effort import in_time
from drakesep.studies.worst_case.pace import Pace, Remaining
from drakesep.systems.checks import InputError


if TYPE_CHECKING:
    from drakesep.check_proof.certificate import Certificate
    from drakesep.check_proof.tree import Outcome

_STEP = "check"
_NODE = 1.0
"""Seconds that a node takes, about, until the pace of this machine is known."""


@dataclass(frozen=True, kw_only=True)
class CheckProgress:
    """How far a certificate is checked."""

    claim: str
    """That was checked last; empty: none yet."""
    done: int
    """Claims."""
    total: int
    """Claims."""
    nodes: int
    """Of the trees of all claims."""
    remaining: Remaining
    """What is left."""

    def __str__(self) -> str:
        """Return what it will do, in a line."""
        several = "a claim" if self.total == 1 else f"{self.total} claims"
        return (
            f"check of {several} in Arb, {self.nodes} nodes: about "
            f"{in_time(self.remaining.seconds)}"
        )


OnCheck: TypeAlias = Callable[[CheckProgress], None]


@dataclass(frozen=True, kw_only=True)
class CheckedClaim:
    """What came of a claim."""

    claim: str
    """Its name."""
    says: str
    """What it says, in words, with bound and unit."""
    bound: float
    """In SI."""
    reaches: float
    """What the quantity surely reaches at a point of the certificate, in SI."""
    nodes: int
    """Of its tree, that were looked at."""
    failure: str
    """The node that does not hold, and why; empty: the claim is verified."""

    @property
    def verified(self) -> bool:
        """Whether all of its tree holds."""
        return not self.failure


@dataclass(frozen=True, kw_only=True)
class ProofCheck:
    """What came of a certificate."""

    certificate: Path
    """The file."""
    claims: tuple[CheckedClaim, ...]
    """In the order of the certificate."""
    parameters: pd.DataFrame
    """`parameter`, `from` and `to` of each, in SI: for all values together the claims
    are made."""

    @property
    def verified(self) -> bool:
        """Whether every claim is."""
        return all(claim.verified for claim in self.claims)


def check_certificate(
    certificate: str | Path,
    *,
    workers: int | None = None,
    on_progress: OnCheck | None = None,
) -> ProofCheck:
    """Check each claim of a certificate, in Arb.

    Args:
        certificate: the file, in the form of docs/proof.md.
        workers: processes, each with a claim at a time; one per core if None; with 1,
            the caller's does all.
        on_progress: called as it goes on.

    Raises:
        ValueError: python-flint is missing, or the file is no such certificate.
    """
    _check_flint()
    from drakesep.check_proof.words import in_words

    path = Path(certificate)
    read = _read(path)
    found: dict[int, Outcome] = {}
    telling = _Telling(on_progress, read)
    for c, outcome in _outcomes(path, read, workers or os.cpu_count() or 1):
        found[c] = outcome
        telling(c)
    claims = tuple(
        CheckedClaim(
            claim=claim.name,
            says=in_words(claim, read.problem),
            bound=claim.bound,
            reaches=found[c].least,
            nodes=found[c].nodes,
            failure=found[c].failure or "",
        )
        for c, claim in enumerate(read.claims)
    )
    return ProofCheck(certificate=path, claims=claims, parameters=_parameters(read))


def _check_flint() -> None:
    try:
        import flint  # noqa: F401
    except ImportError as error:
        raise InputError(
            "check-proof needs python-flint: pip install 'drakesep[proof]'"
        ) from error


def _parameters(read: "Certificate") -> pd.DataFrame:
    rows = []
    for p in read.problem.parameters:
        low, high = (p.nominal + p.scale * s for s in (p.lower, p.upper))
        rows.append((p.name, low, high))
    return pd.DataFrame(rows, columns=["parameter", "from", "to"])


class _Telling:
    """Tells the user how many claims are checked."""

    def __init__(self, on_progress: OnCheck | None, read: "Certificate"):
        self._on_progress = on_progress
        self._names = [claim.name for claim in read.claims]
        self._nodes = [len(claim.tree) for claim in read.claims]
        self._pace = Pace({_STEP: _NODE * sum(self._nodes)})
        self._done: list[int] = []
        self._tell("")

    def __call__(self, c: int) -> None:
        """Tell that another has been checked."""
        self._done.append(c)
        self._tell(self._names[c])

    def _tell(self, claim: str) -> None:
        if self._on_progress is None:
            return
        done, total = sum(self._nodes[c] for c in self._done), sum(self._nodes)
        self._on_progress(
            CheckProgress(
                claim=claim,
                done=len(self._done),
                total=len(self._names),
                nodes=total,
                remaining=self._pace.at(_STEP, done, total),
            )
        )


def _outcomes(
    path: Path, read: "Certificate", workers: int
) -> Iterator[tuple[int, "Outcome"]]:
    """Yield what comes of claims, by their numbers, in whichever order they end."""
    from drakesep.check_proof.checking import longest_first, outcomes

    order = longest_first(read)
    if min(workers, len(order)) <= 1:
        yield from zip(order, outcomes(read, order), strict=True)
        return
    pool = start_processes(min(workers, len(order)), _check_flint)
    try:
        asked = {pool.submit(_outcome, path, c): c for c in order}
        for done in as_completed(asked):
            yield asked[done], done.result()
    finally:
        end_processes(pool)


def _outcome(path: Path, c: int) -> "Outcome":
    """Return what comes of a claim, in a process that reads the file itself."""
    from drakesep.check_proof.checking import outcomes

    [outcome] = outcomes(_kept(path), [c])
    return outcome


def _read(path: Path) -> "Certificate":
    from drakesep.check_proof.certificate import Unreadable
    from drakesep.check_proof.checking import read_certificate

    try:
        return read_certificate(path)
    except Unreadable as error:
        raise InputError(
            f"{path}: must be a certificate of proven bounds, got: {error}"
        ) from error.__cause__


_kept = functools.lru_cache(maxsize=1)(_read)
"""Of a process that checks several claims of the file."""
