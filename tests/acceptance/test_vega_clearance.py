"""Clearances of VEGA with its representative geometry."""

import numpy as np
import pandas as pd
import pytest

import drakesep
from drakesep.analysis.clearance_of_pair import ACCURACY
from drakesep.systems.proximity import FACET
from drakesep.systems.relative_path import RelativePath


@pytest.fixture(scope="module")
def study(vega):
    return drakesep.clearance(vega)


def test_nozzle_passes_the_ring(study):
    """The rim of the nozzle within the bore of the ring, as points on a circle."""
    path = RelativePath(study.run.completed_trajectory, "launch_vehicle", "payload")
    angles = np.linspace(0.0, 2.0 * np.pi, 2001)
    rim = np.stack(
        [np.full(2001, -0.45), 0.4 * np.cos(angles), 0.4 * np.sin(angles)], axis=1
    )
    smallest = np.inf
    for t in np.linspace(0.3, 0.6, 601):
        pose = path.at(t)
        x, y, z = (rim @ pose.R_AB.T + pose.p_AoBo_A).T
        beyond = np.maximum(np.maximum(x, -0.06 - x), 0.0)
        gaps = np.hypot(np.maximum(0.44 - np.hypot(y, z), 0.0), beyond)
        smallest = min(smallest, gaps.min())
    found = {(one.first, one.second): one for one in study.found}
    nozzle = found["adapter_ring", "nozzle"]
    assert smallest - 2.0 * FACET - 1e-6 <= nozzle.minimum <= smallest + ACCURACY
    assert study.clear


def test_every_pair_of_bodies_is_measured(study, tmp_path):
    study.save(tmp_path)
    summary = pd.read_csv(tmp_path / "clearance_summary.csv")
    assert len(summary) == 2 * 5
    assert summary["clearance_mm"].is_monotonic_increasing
    assert set(summary["status"]) == {"clear"}
    over_time = pd.read_csv(tmp_path / "clearance.csv")
    sampled = over_time["adapter_ring_to_nozzle_mm"].min()
    assert summary["clearance_mm"].min() <= sampled
    assert sampled == pytest.approx(summary["clearance_mm"].min(), abs=0.1)
    assert (tmp_path / "clearance.png").stat().st_size > 20_000
