"""The command: a line for each claim, verified or not.

Exit status: 0 if all claims are verified, 1 if one is not, 2 if the certificate cannot
be read.
"""

import argparse
import os
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from .certificate import Certificate, Claim, Unreadable
from .checking import longest_first, outcomes, read_certificate
from .tree import Outcome
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
        print(f"not readable: {options.certificate}: {error}")
        return 2
    print(_about(read))
    all_verified = True
    each = _all_checked(read, options.certificate, options.processes)
    for claim, outcome in zip(read.claims, each, strict=True):
        print(_line(claim, outcome, read), flush=True)
        all_verified &= outcome.failure is None
    return 0 if all_verified else 1


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


def _all_checked(read: Certificate, path: Path, processes: int) -> Iterator[Outcome]:
    """Yield what comes of each claim, as soon as it and those before have ended."""
    count = len(read.claims)
    if min(processes, count) <= 1:
        yield from outcomes(read, range(count))
        return
    with ProcessPoolExecutor(min(processes, count)) as pool:
        begun = {c: pool.submit(_outcome, str(path), c) for c in longest_first(read)}
        for c in range(count):
            yield begun[c].result()


def _outcome(path: str, c: int) -> Outcome:
    """Check one claim in a process of its own, which reads the file itself."""
    [outcome] = outcomes(read_certificate(Path(path)), [c])
    return outcome
