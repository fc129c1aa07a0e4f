"""Metrics of a run from its samples, by their definitions, for tests.

Shares nothing with drakesep but the run's samples: cubic splines between kinks,
evaluated at very many moments.
"""

import itertools
import math

import numpy as np
from scipy.integrate import simpson
from scipy.interpolate import CubicSpline


DEG, MM = math.degrees(1.0), 1e3
XYZ, ANGLES = ("x", "y", "z"), ("roll", "pitch", "yaw")


def dense(run, quantity, start, end):
    """(n,) times and (n, 3) values of a quantity of the motion, from start to end."""
    motion = run.motion
    times, values = [], []
    for a, b in itertools.pairwise(run.breaks):
        if min(b, end) - max(a, start) < 1e-9:
            continue
        mine = (motion.time >= a - 1e-10) & (motion.time <= b + 1e-10)
        spline = CubicSpline(motion.time[mine], getattr(motion, quantity)[mine])
        t = np.linspace(max(a, start), min(b, end), 1001)
        times.append(t)
        values.append(spline(t))
    return times, values


def metrics(run, limits=(math.inf,) * 3):
    """Every metric by its name with unit, in that unit: of the paper's and others."""
    B = run.separation.B
    mine = [a for a in run.separation.attachments if B in (a.A, a.B)]
    release = min(run.releases[a.name] for a in mine)
    parted = max(
        run.stroke_ends[a.spring.name] if a.spring else run.releases[a.name]
        for a in mine
    )
    end = run.separation.duration
    told = {}

    times, rates = dense(run, "relative_rate", release, end)
    integral = sum(
        simpson(np.abs(r), x=t, axis=0) for t, r in zip(times, rates, strict=True)
    )
    square = sum(simpson(r**2, x=t, axis=0) for t, r in zip(times, rates, strict=True))
    told["G_L1_deg"] = DEG * integral.sum()  # Eq. 11
    told["G_L2_deg_per_sqrt_s"] = DEG * math.sqrt(square.sum())  # Eq. 12
    largest = np.max([np.abs(r).max(axis=0) for r in rates], axis=0)
    told["G_Linf_deg_s"] = DEG * largest.sum()  # Eq. 13
    _, speeds = dense(run, "relative_velocity", release, end)
    told["G_PM_m_s"] = -max(v[:, 0].max() for v in speeds)  # Eq. 14

    _, rates = dense(run, "rate", parted, end)
    rate = DEG * np.concatenate(rates)
    for i, axis in enumerate(XYZ):
        told[f"final_rate_{axis}_deg_s"] = rate[-1, i]
        told[f"rate_after_separation_{axis}_deg_s"] = np.abs(rate[:, i]).max()
        told[f"rate_min_after_separation_{axis}_deg_s"] = rate[:, i].min()
        told[f"rate_max_after_separation_{axis}_deg_s"] = rate[:, i].max()
        changes = rate[:, i].min() <= 0.0 <= rate[:, i].max()
        least = 0.0 if changes else np.abs(rate[:, i]).min()
        told[f"rate_magnitude_min_after_separation_{axis}_deg_s"] = least

    _, angles = dense(run, "angle", parted, end)
    for i, axis in enumerate(ANGLES):
        told[f"angle_at_separation_{axis}_deg"] = DEG * angles[0][0, i]
        told[f"deviation_at_separation_{axis}_deg"] = DEG * abs(angles[0][0, i])
    times, angles = (np.concatenate(x) for x in dense(run, "angle", 0.0, end))
    beyond = (np.abs(angles) > np.array(limits)).any(axis=1)
    told["deviation_within_limits_until_s"] = times[beyond][0] if beyond.any() else end

    for name, start in (("max", 0.0), ("max_after_separation", parted)):
        _, speeds = dense(run, "relative_velocity", start, end)
        told[f"longitudinal_speed_{name}_m_s"] = max(v[:, 0].max() for v in speeds)
    told["longitudinal_speed_after_separation_m_s"] = min(v[:, 0].min() for v in speeds)
    told["separation_end_s"] = parted
    return told
