"""Every metric that looks at a window, over parts of a run, against brute force.

The paper's begin at the first release at the earliest, whatever window is asked for;
the others look wherever they are told.
"""

import numpy as np
import pytest
from runs import made_up_run
from separations import generic_pair

from drakesep.analysis.metrics.objectives import highest, lowest
from drakesep.analysis.metrics.of_run import metric_within
from drakesep.analysis.metrics.registry import registered_metrics


RELEASE, DURATION = 0.5, 3.0
WINDOWS = ((0.0, 3.0), (0.2, 0.9), (0.9, 2.0), (1.7, 9.0))
"""From before the release, around it, after it, and beyond the end."""


def turning(w, phase):
    return lambda t: tuple(
        np.sin(w * t + phase + i) * (1.0 + 0.2 * i) for i in range(3)
    )


SIGNALS = {
    "rate": turning(2.0, 0.3),
    "relative_rate": turning(1.5, 1.2),
    "relative_velocity": turning(1.0, 2.1),
}
RUN = made_up_run(
    generic_pair(release_times=(RELEASE, 0.8, 0.6, 0.7), duration=DURATION), **SIGNALS
)
OVER_TIME = {
    "G_L1": lambda t, x: np.trapezoid(np.abs(x), t).sum(),
    "G_L2": lambda t, x: np.sqrt(np.trapezoid(x**2, t).sum()),
    "G_Linf": lambda t, x: np.abs(x).max(axis=1).sum(),
    "G_PM": lambda t, x: -x[0].max(),
    "longitudinal_speed_max": lambda t, x: x[0].max(),
    "longitudinal_speed_after_separation": lambda t, x: x[0].min(),
    "longitudinal_speed_max_after_separation": lambda t, x: x[0].max(),
}
OF_RATES = {
    "rate_after_separation": lambda x: np.abs(x).max(),
    "rate_min_after_separation": lambda x: x.min(),
    "rate_max_after_separation": lambda x: x.max(),
    "rate_magnitude_min_after_separation": lambda x: (
        0.0 if x.min() <= 0.0 <= x.max() else np.abs(x).min()
    ),
}


def expected(name, window):
    of_paper = name.startswith("G_")
    start = max(window[0], RELEASE) if of_paper else window[0]
    t = np.linspace(start, min(window[1], DURATION), 200_001)
    if name in OVER_TIME:
        relative = "relative_velocity" if "speed" in name or name == "G_PM" else None
        return OVER_TIME[name](t, np.array(SIGNALS[relative or "relative_rate"](t)))
    stem, _, axis = name.rpartition("_")
    return OF_RATES[stem](SIGNALS["rate"](t)["xyz".index(axis)])


NAMES = [name for m in registered_metrics() if m.windowed for name in m.names]


@pytest.mark.parametrize("window", WINDOWS)
@pytest.mark.parametrize("name", NAMES)
def test_metric_within(name, window):
    # Splines through samples 10 ms apart are within 1e-8 of such sines.
    wanted = pytest.approx(expected(name, window), abs=1e-7)
    assert metric_within(RUN, name, window) == wanted
    assert highest(name, window=window)(RUN) == wanted
    assert -lowest(name, window=window)(RUN) == wanted
