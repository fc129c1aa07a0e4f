"""Table of Sobol' indices."""

from collections.abc import Sequence

import pandas as pd

from drakesep.analysis.campaigns.sensitivity import SobolIndices
from drakesep.units import with_unit


def sobol_table(
    indices: SobolIndices, parameters: Sequence[str], metrics: Sequence[str]
) -> pd.DataFrame:
    """Return a row for each metric and parameter, those of the largest shares first.

    Args:
        indices: (n, m).
        parameters: n names.
        metrics: m names.
    """
    frames = []
    for k, metric in enumerate(metrics):
        frame = pd.DataFrame(
            {
                "metric": with_unit(metric),
                "parameter": [with_unit(name) for name in parameters],
                "first": indices.first[:, k],
                "first_error": indices.first_error[:, k],
                "total": indices.total[:, k],
                "total_error": indices.total_error[:, k],
            }
        )
        frames.append(frame.sort_values("total", ascending=False, kind="stable"))
    return pd.concat(frames, ignore_index=True)
