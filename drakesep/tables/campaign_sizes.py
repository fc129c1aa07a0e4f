"""Tables of how many runs a campaign needs, before it flies."""

from collections.abc import Sequence

import pandas as pd

from drakesep.analysis.campaigns.order_statistics import CampaignSize


def sizes_table(sizes: Sequence[CampaignSize]) -> pd.DataFrame:
    """Return a row for each size: what it allows, and both parties' risks.

    The producer's is told by the share of launches that a design must have within the
    limit to pass with a chance that equals the confidence.

    Args:
        sizes: of campaigns.
    """
    return pd.DataFrame(
        {
            "runs": one.runs,
            "failures_allowed": one.allowed,
            "consumers_risk": one.consumers_risk,
            "share_that_passes": one.share_that_passes(one.confidence),
        }
        for one in sizes
    )
