"""The worst cases of a case: what was flown and found, and why to believe it."""

import functools
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.clearance.objective import LowestClearance
from drakesep.analysis.metrics.functions import FunctionRequirement
from drakesep.analysis.metrics.objectives import OBJECTIVES, Objective
from drakesep.analysis.search.judge import WorstCase
from drakesep.analysis.search.problem import FROM_NOMINAL, Candidate, Searched
from drakesep.plots.approach import Approach
from drakesep.plots.pictures import Pictures, Tornado
from drakesep.results.asked import Asked
from drakesep.results.folder import ResultsFolder
from drakesep.results.recorded_runs import save_runs
from drakesep.studies.remarks import Remark, remarks, save_remarks
from drakesep.studies.saved import SavedStudy
from drakesep.studies.worst_case.effort import StudyEffort
from drakesep.systems.arrays import Array
from drakesep.tables.columns import write_csv
from drakesep.tables.comparison import comparison_table
from drakesep.tables.evidence_tables import (
    Flown,
    candidates_table,
    evidence_table,
    searches_table,
    sensitivities_table,
    worst_points_table,
)
from drakesep.tables.iterates_table import iterates_of, iterates_table
from drakesep.tables.labelled_run import LabelledRun
from drakesep.tables.roles import Published
from drakesep.tables.run_tables import motion_table, runs_table
from drakesep.tables.table_4 import table_4


@dataclass(frozen=True, kw_only=True)
class WorstCases(SavedStudy):
    """The nominal run, the published worst cases, and the worst found."""

    asked: Asked = field(repr=False)
    """With the case."""
    objectives: tuple[Objective, ...] = ()
    runs: tuple[LabelledRun, ...] = ()
    effort: StudyEffort | None = field(default=None, repr=False)
    """What was planned by the speed of runs, and the options that plan it again."""
    searched: tuple[Searched, ...] = ()
    """What each search found, in their order."""
    worst: tuple[WorstCase, ...] = ()
    """The worst case of each objective, with its evidence."""
    nominal_slopes: Array | None = field(default=None, repr=False)
    """(m, n) of the objectives at the nominal, with the scaled parameters."""
    functions: tuple[FunctionRequirement, ...] = ()
    """Of a run, that are required beside the case's requirements."""
    flown: Mapping[str, Flown] = field(default_factory=dict, repr=False)
    """How searches were told each objective, by its name."""
    clearances: Mapping[str, LowestClearance] = field(default_factory=dict, repr=False)
    """That tell how near the nominal and published runs come, by their metrics."""

    @property
    def case(self) -> AnalysisCase:
        """The case."""
        return self.asked.case

    @property
    def share_unphysical(self) -> float:
        """The share of the tolerances whose inertias no body can have."""
        return self.case.share_unphysical

    @property
    def table(self) -> pd.DataFrame:
        """A row for each run: parameters, metrics, and how it was found."""
        return runs_table(self.runs, self.case.box.names, self.functions)

    @property
    def iterates(self) -> pd.DataFrame:
        """A row for each iterate of each search by SQP."""
        iterates = iterates_of(self.searched)
        return iterates_table(iterates, self.objectives, self.case.box)

    @property
    def from_nominal(self) -> list[Candidate]:
        """What the search from the nominal ended at."""
        return [
            c for s in self.searched if s.search == FROM_NOMINAL for c in s.candidates
        ]

    @property
    def looks_at_paper(self) -> bool:
        """Whether objectives of the paper are looked at: by the case, or on request."""
        asked = any(objective.name in OBJECTIVES for objective in self.objectives)
        return asked or self.case.objectives == "paper"

    @property
    def comparison(self) -> pd.DataFrame:
        """For each of the paper's objectives: nominal, published, SQP and worst."""
        return comparison_table(self.runs)

    @property
    def table_4(self) -> pd.DataFrame:
        """The worst cases in the form of the paper's Table 4."""
        shown = [o for o in self.runs if o.objective is None or _of_paper(o)]
        return table_4(shown, self.case.box)

    @property
    def worst_points(self) -> pd.DataFrame:
        """A row for each parameter: M, m or its value, at each worst case."""
        return worst_points_table(self.worst, self.case.box)

    @property
    def evidence(self) -> pd.DataFrame:
        """A row for each worst case, with why it may be believed."""
        return evidence_table(self.worst, self.objectives, self.runs, self.flown)

    @property
    def searches(self) -> pd.DataFrame:
        """A row for each search: what it looked at."""
        return searches_table(self.searched, self.share_unphysical)

    @property
    def candidates(self) -> pd.DataFrame:
        """A row for the best point of each search, for each objective."""
        return candidates_table(self.searched, self.objectives, self.case.box)

    @property
    def sensitivities(self) -> pd.DataFrame:
        """What each tolerance does to each objective, at the nominal and the worst."""
        slopes = self.nominal_slopes
        assert slopes is not None or not self.worst
        return sensitivities_table(self.worst, self.objectives, slopes, self.case.box)

    @property
    def nearest_sensitivities(self) -> pd.DataFrame:
        """Sensitivities of all but the better direction of each requirement."""
        frame = self.sensitivities
        return frame[~frame["objective"].isin(self._better_directions)]

    @property
    def deciding(self) -> list[WorstCase]:
        """The worst cases but for the better direction of each requirement."""
        better = self._better_directions
        return [case for case in self.worst if case.name not in better]

    @property
    def _better_directions(self) -> set[str]:
        values = {case.name: case.value for case in self.worst}
        return better_directions(self.case, values)

    @property
    def motions(self) -> dict[str, pd.DataFrame]:
        """The motion of each run that did not fail, by its label."""
        return {
            one.label: motion_table(one.run, one.run.separation.B)
            for one in self.runs
            if one.run.motion is not None
        }

    @property
    def remarks(self) -> list[Remark]:
        """What should be told of the runs, each of a body or a spring once."""
        return remarks({one.label: one.run for one in self.runs})

    @property
    def completed(self) -> bool:
        """Whether no run failed, of searches either, and Drake confirmed the worst.

        A run within the tolerances that cannot be flown is not known to be harmless.
        """
        return not self.failure

    @property
    def failure(self) -> str:
        """What of the study failed; empty if it is completed."""
        failed = [f"{o.label}: {o.status}" for o in self.runs if o.outcome.failed]
        failed += self.failed_searches
        return "; ".join(failed)

    @property
    def failed_searches(self) -> list[str]:
        """Of each search in which runs failed, how many, and why the first did."""
        return [
            f"{search.search}: {sum(search.failures.values())} of {search.points} runs "
            f"within the tolerances failed: {next(iter(search.failures))}"
            for search in self.searched
            if search.failures
        ]

    @property
    def verdict(self) -> str | None:
        """Of the study, as `study.json` has it; a search for worst cases gives none."""
        return None

    def write_tables(self, results: ResultsFolder) -> None:
        """Write the tables, as far as there are any, into a folder that is locked."""
        folder = results.path
        write_csv(self.table, folder / "worst_cases.csv")
        save_remarks(self.remarks, folder)
        if self.searched:
            write_csv(self.searches, folder / "searches.csv")
            write_csv(self.candidates, folder / "candidates.csv")
            if len(iterates := self.iterates):
                write_csv(iterates, folder / "iterates.csv")
        if self.worst:
            write_csv(self.evidence, folder / "evidence.csv")
            write_csv(self.worst_points, folder / "worst_points.csv")
            write_csv(self.sensitivities, folder / "sensitivities.csv")
        if any(map(_of_paper, self.runs)):
            write_csv(self.comparison, folder / "comparison.csv")

    def write(self, results: ResultsFolder) -> None:
        """Write it into the folder of its study, which ends."""
        folder = results.path
        self.write_tables(results)
        save_runs(self.runs, self.case.separation, folder)
        results.keep([one.label for one in self.runs])
        self.draw(folder)
        results.end(failed=self.failure, verdict=self.verdict)

    def draw(self, folder: Path) -> None:
        """Draw what shows it into a folder."""
        if self.worst:
            Tornado(self.nearest_sensitivities).save(folder)
        self.pictures.save(folder)

    @property
    def pictures(self) -> Pictures:
        """What shows the runs."""
        return Pictures(
            runs=self.runs,
            case=self.case,
            approaches=self._approaches,
        )

    @functools.cached_property
    def _approaches(self) -> list[Approach]:
        """Of the nominal run and of the worst of each clearance that was looked for."""
        approaches = []
        for metric, clearance in self.clearances.items():
            for one in self.runs:
                found = one.nearest.get(metric)
                if found is None or isinstance(one.role, Published):
                    continue
                x, distances = clearance.approach(one.run, found)
                pair = found.pair.replace("_", " ")
                approaches.append(Approach(metric, one.label, pair, x, distances))
        return approaches


def better_directions(
    case: AnalysisCase, values: Mapping[str, float], by: float = 0.0
) -> set[str]:
    """Return objectives of requirements that have another, whose worst is worse.

    Args:
        case: with the requirements.
        values: of the worst by the objectives' names.
        by: as a share of the worse, at least so much.
    """
    better = set()
    for requirement in case.requirements:
        known = [name for name in case.names_towards(requirement) if name in values]
        worst = max(known, key=values.__getitem__, default="")
        better |= {
            name
            for name in known
            if name != worst and values[worst] - values[name] >= by * abs(values[worst])
        }
    return better


def _of_paper(one: LabelledRun) -> bool:
    return one.objective in OBJECTIVES
