"""The paper's objectives on motions whose norms are known."""

import dataclasses
import math

import numpy as np
import pytest
from runs import made_up_run
from separations import generic_pair

from drakesep.analysis.metrics import metrics
from drakesep.analysis.objectives import OBJECTIVES
from drakesep.systems.run import Run, RunStatus


RUN = made_up_run(
    relative_rate=lambda t: (np.sin(math.pi * t), -2.0 * t, 3.0 + 0.0 * t),
    relative_velocity=lambda t: (1.0 - (t - 1.1) ** 2, 9.0 + 0.0 * t, t),
    rate=lambda t: (0.1 * t, -0.2 * t, 0.3 - 0.2 * t),
    angle=lambda t: (0.1 * t, -0.2 * t, 0.05 * t),
)

# Splines over steps of 0.01 s: 5/384 (pi h)^4 = 1e-8
CLOSE = 5e-8


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("L1", 6.0 / math.pi + 9.0 + 9.0),
        ("L2", math.sqrt(1.5 + 36.0 + 27.0)),
        ("Linf", 1.0 + 6.0 + 3.0),
        ("PM", -1.0),
    ],
)
def test_objective(name, expected):
    assert OBJECTIVES[name](RUN) == pytest.approx(expected, abs=CLOSE)


def test_objectives_begin_at_the_release():
    late = generic_pair(release_times=(1.0, 1.5, 2.0, 2.0), duration=3.0)
    run = made_up_run(late, relative_rate=lambda t: (3.0 - t, 0.0 * t, 0.0 * t))
    assert OBJECTIVES["L1"](run) == pytest.approx(2.0, abs=CLOSE)
    assert OBJECTIVES["Linf"](run) == pytest.approx(2.0, abs=CLOSE)


def test_metrics():
    limits = (1.0, 0.3, math.inf)
    figures = metrics(RUN, limits)
    end = RUN.separation_end
    assert figures["separation_end"] == end
    assert figures["final_rate_y"] == pytest.approx(-0.6, abs=1e-12)
    assert figures["rate_after_separation_y"] == pytest.approx(0.6, abs=1e-12)
    # falls through zero after the separation: the larger side counts
    assert figures["rate_after_separation_z"] == pytest.approx(0.3, abs=1e-12)
    assert figures["deviation_at_separation_pitch"] == pytest.approx(0.2 * end)
    assert figures["deviation_within_limits_until"] == pytest.approx(1.5, abs=1e-9)
    assert figures["longitudinal_speed_max"] == pytest.approx(1.0)
    slowest = 1.0 - 1.9**2
    assert figures["longitudinal_speed_after_separation"] == pytest.approx(slowest)
    assert figures["G_PM"] == OBJECTIVES["PM"](RUN)


def test_failed_run_has_no_value():
    failed = dataclasses.replace(RUN, status=RunStatus.FAILED, motion=None, message="x")
    assert isinstance(failed, Run)
    for objective in OBJECTIVES.values():
        with pytest.raises(RuntimeError, match="the run failed: x"):
            objective(failed)
