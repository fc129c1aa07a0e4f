"""What shows the runs of a study, apart from it: any process can draw it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.plots.approach import Approach
from drakesep.plots.campaign_curves import Curve
from drakesep.plots.campaign_points import Scatter
from drakesep.systems.model.run import Run
from drakesep.tables.columns import write_csv
from drakesep.tables.labelled_run import LabelledRun
from drakesep.tables.run_tables import motion_table


@dataclass(frozen=True)
class Tornado:
    """What each tolerance does to each objective."""

    sensitivities: pd.DataFrame
    """As `WorstCases.sensitivities` has them."""

    def save(self, folder: Path) -> None:
        """Draw it into a folder."""
        from drakesep.plots.tornado import save_tornado  # half a second, when drawn

        save_tornado(self.sensitivities, folder)


@dataclass(frozen=True)
class OfFailures:
    """What is required in failure cases, beside the design."""

    requirements: pd.DataFrame
    """As failure_requirements.csv has them."""

    def save(self, folder: Path) -> None:
        """Draw it into a folder."""
        from drakesep.plots.failure_cases import save_failure_cases

        save_failure_cases(self.requirements, folder)


@dataclass(frozen=True)
class OfProofs:
    """Bounds beside the worst found, and beside limits."""

    proofs: pd.DataFrame
    """As proofs.csv has them."""

    def save(self, folder: Path) -> None:
        """Draw it into a folder, if there is a bound."""
        if self.proofs["proven_bound"].notna().any():
            from drakesep.plots.proofs import save_proofs

            save_proofs(self.proofs, folder)


@dataclass(frozen=True, kw_only=True)
class OfCampaign:
    """What is required over the draws of a campaign."""

    name: str
    """Of the case."""
    runs: int
    """Draws."""
    curves: Sequence[Curve]
    """Of each requirement that was looked at."""
    scatters: Sequence[Scatter] = ()
    """Of each quantity that is required, where rows are kept."""

    def save(self, folder: Path) -> None:
        """Draw it into a folder, if there is anything."""
        if self.curves:
            from drakesep.plots.campaign import save_campaign

            save_campaign(self.name, self.runs, self.curves, folder)
        if self.scatters:
            from drakesep.plots.campaign_scatter import save_scatter

            save_scatter(self.name, self.scatters, folder)


@dataclass(frozen=True, kw_only=True)
class Pictures:
    """Plots of a study's runs, and their motions, as they are written down."""

    runs: Sequence[LabelledRun]
    """Of the study; plots of the motion choose among them."""
    case: AnalysisCase
    """With the requirements."""
    approaches: Sequence[Approach] = ()
    motions: Mapping[str, tuple[Run, str]] = field(default_factory=dict)
    """That are written, by the labels of the runs."""

    def save(self, folder: Path) -> None:
        """Write them into a folder."""
        from drakesep.plots.clearance_plots import save_approaches
        from drakesep.plots.motion import save_motion

        save_motion(self.runs, self.case, folder)
        if self.approaches:
            save_approaches(self.approaches, self.case.requirements, folder)
        for label, (run, body) in self.motions.items():
            write_csv(motion_table(run, body), folder / f"motion_{label}.csv")
