"""The command: a line for each claim, verified or not.

Exit status: 0 if all claims are verified, 1 if one is not, 2 if the certificate cannot
be read.
"""

import argparse
import json
import math
import os
import sys
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from .certificate import Certificate, Claim, Unreadable, certificate
from .intervals import NotVerified
from .tree import Motions, Outcome, checked
from .words import in_words


def main(arguments: list[str] | None = None) -> int:
    """Check a certificate; print what came of each claim."""
    parser = argparse.ArgumentParser(prog="check_proof", description=__doc__)
    parser.add_argument("certificate", type=Path, help="JSON")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    options = parser.parse_args(arguments)
    try:
        read = read_certificate(options.certificate)
    except Unreadable as error:
        print(f"not readable: {error}")
        return 2
    print(_about(read))
    outcomes = _all_checked(read, options.certificate, options.processes)
    for claim, outcome in zip(read.claims, outcomes, strict=True):
        print(_line(claim, outcome, read), flush=True)
    return int(any(outcome.failure for outcome in outcomes))


def read_certificate(path: Path) -> Certificate:
    """Read a file; raise Unreadable if it is not a certificate."""
    try:
        record = json.loads(path.read_text(encoding="utf-8"), object_pairs_hook=_once)
    except (OSError, ValueError, RecursionError) as error:
        raise Unreadable(f"{path}: {error}") from None
    return certificate(record)


def _once(pairs: list[tuple[str, object]]) -> dict[str, object]:
    record = dict(pairs)
    if len(record) < len(pairs):
        raise Unreadable(f"a key stands twice in {', '.join(key for key, _ in pairs)}")
    return record


def _about(read: Certificate) -> str:
    problem = read.problem
    lines = [
        f"{len(read.claims)} claims, for all values of {len(problem.parameters)}"
        " parameters at once, inertias that no body can have among them:"
    ]
    for p in problem.parameters:
        low, high = (p.nominal + p.scale * s for s in (p.lower, p.upper))
        lines.append(f"  {p.name} from {low:.9g} to {high:.9g}")
    return "\n".join(lines)


def _line(claim: Claim, outcome: Outcome, read: Certificate) -> str:
    words = in_words(claim, read.problem)
    if outcome.failure:
        return f"NOT VERIFIED  {claim.name}: {outcome.failure} ({words})"
    return (
        f"verified  {claim.name}: {words} ({outcome.nodes} nodes; it reaches"
        f" {outcome.least:.9g})"
    )


def _all_checked(read: Certificate, path: Path, processes: int) -> list[Outcome]:
    count = len(read.claims)
    if min(processes, count) <= 1:
        return _checked(read, range(count))
    # The longest first, so that none is left to one process at the end.
    order = sorted(range(count), key=lambda c: -len(read.claims[c].tree))
    with ProcessPoolExecutor(min(processes, count)) as pool:
        outcomes = pool.map(_outcome, [str(path)] * count, order)
        by_claim = dict(zip(order, outcomes, strict=True))
    return [by_claim[c] for c in range(count)]


def _checked(read: Certificate, claims: Iterable[int]) -> list[Outcome]:
    try:
        motions = Motions(read.problem)
    except NotVerified as error:
        return [Outcome(str(error), 0, -math.inf) for _ in claims]
    return [checked(read.claims[c], motions) for c in claims]


def _outcome(path: str, c: int) -> Outcome:
    """Check one claim in a process of its own, which reads the file itself."""
    return _checked(read_certificate(Path(path)), [c])[0]


if __name__ == "__main__":
    sys.exit(main())
