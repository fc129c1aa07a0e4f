"""A certificate read from a file, and its claims checked."""

import json
import math
from collections.abc import Iterable, Iterator
from pathlib import Path

from .certificate import Certificate, Unreadable, certificate
from .intervals import NotVerified
from .tree import Motions, Outcome, checked


def read_certificate(path: Path) -> Certificate:
    """Read a file; raise Unreadable if it is not a certificate."""
    try:
        record = json.loads(path.read_text(encoding="utf-8"), object_pairs_hook=_once)
    except (OSError, ValueError, RecursionError) as error:
        words = error.strerror if isinstance(error, OSError) else error
        raise Unreadable(f"{words}") from error
    return certificate(record)


def _once(pairs: list[tuple[str, object]]) -> dict[str, object]:
    record = dict(pairs)
    if len(record) < len(pairs):
        raise Unreadable(f"a key stands twice in {', '.join(key for key, _ in pairs)}")
    return record


def longest_first(read: Certificate) -> list[int]:
    """Return the numbers of the claims: none of long proof is left to one process."""
    return sorted(range(len(read.claims)), key=lambda c: -len(read.claims[c].tree))


def outcomes(read: Certificate, claims: Iterable[int]) -> Iterator[Outcome]:
    """Yield what comes of claims, by their numbers from 0, one after the other."""
    try:
        motions = Motions(read.problem)
    except NotVerified as error:
        for _ in claims:
            yield Outcome(str(error), 0, -math.inf)
        return
    for c in claims:
        yield checked(read.claims[c], motions)
