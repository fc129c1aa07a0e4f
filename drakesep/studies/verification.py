"""The worst cases against the requirements, and the room that tolerances leave."""

import math
from dataclasses import dataclass, field, replace
from pathlib import Path

import pandas as pd

from drakesep.analysis.margins.tolerance_margins import Growth, Limit, grow
from drakesep.analysis.metrics.requirements import Finding, Requirement, assess
from drakesep.analysis.search.effort import SearchSettings
from drakesep.analysis.search.judge import WorstCase
from drakesep.analysis.search.problem import OnProgress, Problem, SearchProgress
from drakesep.plots.pictures import Pictures
from drakesep.studies.worst_case.result import WorstCases
from drakesep.tables.columns import write_csv
from drakesep.tables.evidence_tables import tolerances_table
from drakesep.tables.labelled_run import NOMINAL
from drakesep.tables.requirement_tables import requirements_table


@dataclass(kw_only=True)
class Verification(WorstCases):
    """The worst cases held against the requirements."""

    growths: list[tuple[Requirement, Growth]] = field(default_factory=list)
    """Of all tolerances together: the smallest of each requirement's directions."""
    single_growths: list[tuple[Requirement, Growth]] = field(default_factory=list)
    """Of one tolerance, the others as they are: the smallest of the directions."""

    @property
    def findings(self) -> list[Finding]:
        """How each requirement fares over all runs."""
        runs = {f.label: f.metrics for f in self.runs if f.metrics}
        return assess(self.case.requirements, runs, NOMINAL)

    @property
    def requirements(self) -> pd.DataFrame:
        """A row for each requirement and axis, with its margins and verdict."""
        return requirements_table(
            self.findings, self.growths, self.single_growths, self.case.box
        )

    @property
    def tolerances(self) -> pd.DataFrame:
        """For each requirement and parameter, the tolerance that would violate it."""
        return tolerances_table(self.single_growths, self.case.box)

    def save_tables(self, directory: str | Path) -> None:
        """Write the tables, as far as there are any, into a folder."""
        super().save_tables(directory)
        folder = Path(directory)
        # No verdict before the worst cases are known.
        if self.worst or (self.runs and not self.case.tolerances):
            write_csv(self.requirements, folder / "requirements.csv")
            write_csv(self.table_4, folder / "table_4.csv")
        if self.single_growths:
            write_csv(self.tolerances, folder / "tolerances.csv")

    @property
    def passed(self) -> bool:
        """Whether every requirement is met, with no run and no search failed."""
        return self.completed and all(finding.met for finding in self.findings)

    def find_growths(
        self, problem: Problem, settings: SearchSettings, on_progress: OnProgress
    ) -> None:
        """Find how far tolerances may grow before each requirement is violated."""
        worst = {case.name: case for case in self.worst}
        limits = [
            (requirement, limit)
            for requirement in self.case.requirements
            for objective in self.case.towards(requirement)
            if objective.name in worst and not objective.expensive
            for limit in _limits(
                worst[objective.name], _bound(requirement), len(problem.tolerances)
            )
        ]
        found = grow(
            problem,
            [limit for _, limit in limits],
            corners=settings.corners,
            seed=settings.seed,
            on_progress=lambda done, total: on_progress(
                SearchProgress(search="growth", done=done, total=total)
            ),
        )
        least: dict[tuple[Requirement, int | None], Growth] = {}
        for (requirement, limit), growth in zip(limits, found, strict=True):
            key = requirement, limit.parameter
            if key not in least or _sooner(growth, least[key]):
                least[key] = growth
        self.growths = [(r, g) for (r, i), g in least.items() if i is None]
        self.single_growths = [(r, g) for (r, i), g in least.items() if i is not None]

    @property
    def pictures(self) -> Pictures:
        """What shows the runs, and their motions."""
        flown = {f.label: f.run.motion for f in self.runs}
        motions = {k: motion for k, motion in flown.items() if motion is not None}
        return replace(super().pictures, motions=motions)


def _limits(case: WorstCase, value: float, n: int) -> list[Limit]:
    """Return the limits on one worst case, of all tolerances and of each."""
    return [
        Limit(objective=case.objective, value=value, u=case.u, parameter=parameter)
        for parameter in (None, *range(n))
    ]


def _bound(requirement: Requirement) -> float:
    """Return what the objectives that lead out of a requirement must not exceed."""
    return requirement.limit if requirement.sense == "<=" else -requirement.limit


def _sooner(growth: Growth, other: Growth) -> bool:
    """Return whether one growth ends before another; one that failed after all."""
    return math.isnan(other.factor) or growth.factor < other.factor
