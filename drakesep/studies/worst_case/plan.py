"""What is asked of a study of worst cases, and how far it has come."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.bounds.proving import ProofSettings
from drakesep.analysis.clearance.objective import LowestClearance
from drakesep.analysis.failure_cases import FailureCase
from drakesep.analysis.metrics.objectives import Objective
from drakesep.analysis.search.effort import Effort, SearchSettings
from drakesep.analysis.search.expensive_objectives import check_expensive
from drakesep.analysis.search.problem import SearchProgress
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.results.asked import Asked
from drakesep.results.folder import ResultsFolder
from drakesep.studies.worst_case.effort import StudyEffort, check_minutes
from drakesep.studies.worst_case.pace import Remaining
from drakesep.studies.worst_case.searches import WantedSearches
from drakesep.systems.checks import InputError
from drakesep.tables.roles import check_labels


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyPlan:
    """What is asked of a study.

    Raises:
        ValueError: how hard to search is out of range, the searches do not suit the
            objectives, or a published run bears the label of one that will be found.
    """

    asked: Asked
    """With the case."""
    objectives: tuple[Objective, ...] = ()
    """To be maximised; without any, the nominal and the published runs are all."""
    searches: WantedSearches = field(default_factory=WantedSearches)
    effort: Effort = field(default_factory=Effort)
    """How hard to search; what is left out, the speed of runs decides."""
    growth: bool | None = False
    """Whether to find how far tolerances may grow; None: if there is time."""
    minutes: float | None = None
    """That it may take; None: ten, or as long as searches take that are asked for."""
    workers: int | None = None
    """Processes that fly Drake; one per core if None; with 1, the caller's does all."""
    failures: Mapping[FailureCase, AnalysisCase] = field(default_factory=dict)
    """That are searched beside the design, with the case in which each has failed."""
    draws: int = 0
    """Of the campaign that is flown beside the worst cases."""
    draws_in_drake: int = 0
    """Of them, those that Drake flies, at most."""
    proofs: int = 0
    """Bounds that are proven beside the worst cases."""
    proof_settings: ProofSettings | None = None
    """How hard they are tried; None: there are none."""
    clearances: Mapping[str, LowestClearance] = field(default_factory=dict)
    """That tell how near nominal and published runs come, by their metrics."""
    resume: bool = False
    """Whether it goes on from what an earlier one has finished in the folder."""
    folder: ResultsFolder | None = None
    """That receives tables and plots as the study goes on."""

    def __post_init__(self) -> None:
        """Check the values."""
        SearchSettings(**self.effort)
        if self.resume and self.folder is None:
            raise InputError(
                "output: must be the folder of the study to resume, got None"
            )
        check_minutes(self.minutes)
        if self.searches.names and not self.searches.drake_alone:
            check_expensive(self.objectives, self.searches.names)
        check_labels(self.case, [objective.name for objective in self.objectives])

    @property
    def case(self) -> AnalysisCase:
        """The case."""
        return self.asked.case

    @property
    def proof_seconds(self) -> float:
        """That all bounds take, at most."""
        return self.proofs * self.proof_settings.seconds if self.proof_settings else 0.0

    @property
    def on_batch_engine(self) -> bool:
        """Whether the batch engine flies what is searched, not Drake."""
        return bool(self.objectives) and not self.searches.drake_alone


@dataclass(frozen=True, kw_only=True)
class Progress:
    """Where a study stands."""

    objectives: tuple[Objective, ...]
    """That are searched."""
    box: ToleranceBox = field(repr=False)
    """The tolerances over which they are."""
    search: SearchProgress
    """The search under way; after them the confirmation in Drake, and growth. Before
    them `PLAN`, with nothing done."""
    effort: StudyEffort
    """What the study does, and how long it takes."""
    remaining: Remaining
    """What is left of it."""


PLAN = "plan"
"""What is told before the searches begin."""
OnProgress: TypeAlias = Callable[[Progress], None]
