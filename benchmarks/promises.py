"""What a verification says beforehand that it takes, and what it took.

For each case a process of its own: what was said, each step's time, what it took from
then on, and the ratio of both. A promise is kept within a factor of two.

    python benchmarks/promises.py [CASE ...]
"""

import subprocess
import sys
import time

from drakesep import Case, Verification, builtin_cases, verify


def kept(case: Case | str) -> Verification:
    """Return the verification of a case; print what it says, and what it took."""
    began = time.perf_counter()
    begun: dict[str, float] = {}
    effort = None

    def tell(progress) -> None:
        nonlocal effort
        effort = progress.effort
        begun.setdefault(progress.search.search, time.perf_counter())

    study = verify(case, on_progress=tell)
    ended = time.perf_counter()
    print(f"{study.case.name}: {effort}")
    print(f"{'before':14} {begun['plan'] - began:7.1f} s")
    steps = [name for name in begun if name != "plan"]
    for name, end in zip(steps, [*(begun[s] for s in steps[1:]), ended], strict=True):
        said = effort.seconds.get(name, 0.0)
        print(f"{name:14} {end - begun[name]:7.1f} s, said {said:7.1f} s")
    took = ended - begun["plan"]
    print(
        f"{'all':14} {took:7.1f} s, said {effort.total:7.1f} s: "
        f"{took / effort.total:.2f} of what was said"
    )
    return study


if __name__ == "__main__":
    cases = sys.argv[1:] or sorted(builtin_cases())
    if len(cases) == 1:
        kept(cases[0])
    else:
        for case in cases:
            subprocess.run([sys.executable, __file__, case], check=True)
