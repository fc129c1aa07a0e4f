"""The examples run as they stand."""

import subprocess
import sys
from pathlib import Path

import pytest
from pictures import is_drawn


EXAMPLES = Path(__file__).parent.parent / "examples"


def run(example, picture):
    """Run an example and return the words of each line that it prints."""
    done = subprocess.run(
        [sys.executable, EXAMPLES / example, picture], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert is_drawn(picture)
    return [line.split() for line in done.stdout.splitlines()]


def test_spring_laws(tmp_path):
    rows = run("spring_laws.py", tmp_path / "laws.png")[2:]
    by_factor = {float(row[0]): [float(cell) for cell in row[1:]] for row in rows}
    v5, v, s5, s = by_factor[1.0]
    assert v5 == v == 1.160  # one law at the design
    assert s5 == s == 121
    v5, v, s5, s = by_factor[0.1]
    assert v5 > 1.8 * v  # a lighter payload, pushed too long by Eq. 5
    assert (s5 > 400, s) == (True, 121)


def test_end_to_end(tmp_path):
    rows = run("end_to_end.py", tmp_path / "end_to_end.png")[1:]
    by_event = {" ".join(row[:-5]): [float(x) for x in row[-5:]] for row in rows}
    shutdown, payload, carrier, end = by_event.values()
    assert shutdown[0] == 1.0
    assert payload[0] >= shutdown[0] + 0.5  # rates were quiet for half a second
    assert carrier[0] == pytest.approx(payload[0] + 2.0, abs=1e-3)
    assert max(map(abs, payload[1:4])) < 0.15  # deg/s, the limit
    # sqrt(2 E / mu) of 1000 kg against 1462 kg; joints give and take a hundredth
    energy = sum(0.5 * 600.0 * (1.0 + 0.01 * i) * 0.09 for i in (1, 2, 3, 4))
    speed = (2.0 * energy * (1 / 1000 + 1 / 1462)) ** 0.5
    assert carrier[4] == pytest.approx(speed, rel=2e-2)
    assert end[4] > carrier[4]  # the carrier pushes the stage back
