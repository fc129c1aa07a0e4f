"""The examples run as they stand."""

import subprocess
import sys
from pathlib import Path


EXAMPLES = Path(__file__).parent.parent / "examples"


def test_spring_laws(tmp_path):
    picture = tmp_path / "laws.png"
    done = subprocess.run(
        [sys.executable, EXAMPLES / "spring_laws.py", picture],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert picture.stat().st_size > 10_000
    rows = [line.split() for line in done.stdout.splitlines()[2:]]
    by_factor = {float(row[0]): [float(cell) for cell in row[1:]] for row in rows}
    v5, v, s5, s = by_factor[1.0]
    assert v5 == v == 1.160  # one law at the design
    assert s5 == s == 121
    v5, v, s5, s = by_factor[0.1]
    assert v5 > 1.8 * v  # a lighter payload, pushed too long by Eq. 5
    assert (s5 > 400, s) == (True, 121)
