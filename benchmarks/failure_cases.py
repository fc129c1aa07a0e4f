"""What a failure case costs, as a part of the verification of the design.

In CPU time of one process, tables and pictures written: of the whole verification of
the design, and of the usual failure cases by their number.

    python benchmarks/failure_cases.py [CASE ...]
"""

import subprocess
import sys
import tempfile
import time

from drakesep import builtin_cases, load_case, verify


def measured(name: str) -> None:
    """Print what the failure cases of a built-in case cost."""
    case = load_case(builtin_cases()[name])
    begun: list[float] = []

    def tell(progress) -> None:
        if progress.search.search == "failure cases":
            begun.append(time.process_time())

    before = time.process_time()
    usual = case.replaced(failure_cases="standard")
    with tempfile.TemporaryDirectory() as folder:
        study = verify(usual, failures=True, output=folder, workers=1, on_progress=tell)
    count = len(study.failed_cases)
    design, each = begun[0] - before, (begun[-1] - begun[0]) / count
    print(
        f"{name}: design {design:.1f} s, {count} failure cases {each:.2f} s each: "
        f"{each / design:.3f} of the design"
    )


if __name__ == "__main__":
    names = sys.argv[1:] or ["vega", "smallsat", "fairing"]
    if len(names) == 1:
        measured(names[0])
    else:
        for name in names:
            subprocess.run([sys.executable, __file__, name], check=True)
