"""A draw of a campaign, flown in Drake as a run by itself."""

from pathlib import Path

import numpy as np

from drakesep.analysis.campaigns.flights import CampaignFlights
from drakesep.results.campaign_files import RecordedPlan
from drakesep.results.folder import Output
from drakesep.studies.simulate import Simulated, simulate
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError
from drakesep.tables.columns import in_units


@typed
def replay(
    directory: str | Path, run: int, *, output: Output | None = None
) -> Simulated:
    """Fly a draw of a campaign in Drake, with its motion, as `simulate` flies a run.

    How near parts come is measured, where that is required.

    What was drawn comes again from its number: the campaign may keep no runs, and may
    not have flown yet.

    Args:
        directory: of the campaign.
        run: number of the draw, from 0.
        output: folder that receives tables and plots.

    Raises:
        ValueError: there is no such campaign or draw, it was planned with other
            versions, or the folder cannot be written.
    """
    plan = RecordedPlan.read(Path(directory).absolute()).plan
    if not 0 <= run < plan.runs:
        raise InputError(f"run: must be from 0 to {plan.runs - 1}, got {run}")
    [values] = CampaignFlights(plan).values(np.array([run]))
    return simulate(plan.case, in_units(values), measure=True, output=output)
