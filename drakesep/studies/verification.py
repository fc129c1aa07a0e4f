"""The worst cases against the requirements, and the room that tolerances leave."""

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Unpack

import pandas as pd

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.metrics.functions import FunctionRequirement
from drakesep.analysis.metrics.requirements import (
    Finding,
    Requirement,
    Verdict,
    assess,
    verdict_on_all,
)
from drakesep.analysis.search.effort import Effort, SearchSettings
from drakesep.case_file.case import Case
from drakesep.case_file.objectives import (
    Wanted,
    case_objectives,
    choose_objectives,
    clearances_of,
    listed,
)
from drakesep.plots.pictures import Pictures
from drakesep.plots.shown_runs import bodies_shown_by
from drakesep.results.asked import Asked
from drakesep.results.catalogue import VERIFY
from drakesep.results.folder import Output, ResultsFolder, results_folder
from drakesep.studies.background_process import BackgroundProcess
from drakesep.studies.tolerance_growth import (
    Growths,
    find_growths,
    ways_out,
)
from drakesep.studies.worst_case.plan import OnProgress, StudyPlan
from drakesep.studies.worst_case.procedure import carried_out, ended
from drakesep.studies.worst_case.result import WorstCases
from drakesep.studies.worst_case.searches import WantedSearches
from drakesep.studies.worst_case.session import session
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError
from drakesep.tables.columns import write_csv
from drakesep.tables.labelled_run import nominal_of
from drakesep.tables.requirement_tables import requirements_table, tolerances_table
from drakesep.tables.run_tables import is_column_of_runs


@dataclass(frozen=True, kw_only=True)
class Verification(WorstCases):
    """The worst cases held against the requirements."""

    growths: Growths = field(default=())
    """Of all tolerances together: the smallest of each requirement's directions."""
    single_growths: Growths = field(default=())
    """Of one tolerance, the others as they are: the smallest of the directions."""

    @property
    def findings(self) -> list[Finding]:
        """How each requirement fares over all runs."""
        runs = {
            one.label: {**one.metrics, **one.of_functions}
            for one in self.runs
            if one.metrics
        }
        of_functions = (limit for f in self.functions for limit in f.limits)
        required = [*self.case.requirements, *of_functions]
        at_most = {one.label: one.at_most for one in self.runs}
        findings = assess(required, runs, nominal_of(self.runs).label, at_most)
        unsettled = self._unsettled
        return [replace(f, settled=f.requirement not in unsettled) for f in findings]

    @property
    def _unsettled(self) -> set[Requirement]:
        """What may be broken by a run that was not flown, or not as it was found.

        A run that cannot be flown may break any; of a worst case that is not confirmed,
        what it was searched for.
        """
        ways = ways_out(self.case, self.functions)
        if self.failed_searches or any(one.run.motion is None for one in self.runs):
            return {*self.case.requirements, *(requirement for requirement, _ in ways)}
        unconfirmed = {one.objective for one in self.runs if one.outcome.failed}
        return {requirement for requirement, name in ways if name in unconfirmed}

    @property
    def requirements(self) -> pd.DataFrame:
        """A row for each requirement and axis, with its margins and verdict."""
        return requirements_table(
            self.findings,
            self.growths,
            self.single_growths,
            self.case.box,
            self._bodies,
            self.functions,
        )

    @property
    def tolerances(self) -> pd.DataFrame:
        """For each requirement and parameter, the tolerance that would violate it."""
        return tolerances_table(
            self.single_growths, self.case.box, self._bodies, self.functions
        )

    @property
    def _bodies(self) -> list[str]:
        """Names of those that leave, the first first."""
        return [pair.B for pair in self.case.separation.pairs]

    def write_tables(self, results: ResultsFolder) -> None:
        """Write the tables, as far as there are any, into a folder that is locked."""
        super().write_tables(results)
        folder = results.path
        # No verdict before the worst cases are known.
        if self.worst or (self.runs and not self.objectives):
            write_csv(self.requirements, folder / "requirements.csv")
            if self.looks_at_paper:
                write_csv(self.table_4, folder / "table_4.csv")
        if self.single_growths:
            write_csv(self.tolerances, folder / "tolerances.csv")

    @property
    def passed(self) -> bool:
        """Whether every requirement is met, with no run and no search failed."""
        return self.verdict == Verdict.MET.value

    @property
    def verdict(self) -> str | None:
        """``met``, ``not met`` or ``not looked at``.

        What a run is beyond stays so, whatever else failed; without it, a study that is
        not completed has no verdict: None.
        """
        found = verdict_on_all(self.findings)
        if found is Verdict.NOT_MET or self.completed:
            return found.value
        return None

    @property
    def pictures(self) -> Pictures:
        """What shows the runs, and their motions."""
        motions = {}
        for one in self.runs:
            if one.run.motion is not None:
                for body in bodies_shown_by(one):
                    first = body == one.run.separation.B
                    name = one.label if first else f"{one.label}_{body}"
                    motions[name] = one.run.motion_of(body)
        return replace(super().pictures, motions=motions)


@typed
def verify(
    case: Case | AnalysisCase | str | Path,
    *,
    requirements: Sequence[FunctionRequirement] = (),
    objectives: Wanted = (),
    searches: Sequence[str] | None = None,
    growth: bool | None = None,
    output: Output | None = None,
    workers: int | None = None,
    on_progress: OnProgress | None = None,
    background: BackgroundProcess | None = None,
    minutes: float | None = None,
    resume: bool = False,
    **effort: Unpack[Effort],
) -> Verification:
    """Find the worst cases of a case and hold them against its requirements.

    What leads out of each requirement is searched, and the paper's objectives if the
    case says so.

    Args:
        case: a case, in SI or as a file holds it, a case file, or the name of a
            built-in case.
        requirements: on functions of a run, beside the case's.
        objectives: that are searched beside these, as `worst_case` takes them.
        searches: as `worst_case` takes them.
        growth: whether to find how far tolerances may grow; None: unless Drake flies
            alone, or a study with it takes longer than it may.
        output: folder that receives tables and plots, tables as the study goes on.
        workers: number of processes that fly Drake; one per core if None; with 1, the
            caller's does all.
        on_progress: called as the study goes on.
        background: a process that is under way, to measure and draw in; one of its own
            if None.
        minutes: as `worst_case` takes them.
        resume: as `worst_case` takes it.
        effort: `starts`, `samples`, `vertices`, `flips`, `generations`, `corners` and
            `seed` of `SearchSettings`; the speed of runs, as it is measured, decides
            what is left out: see `Verification.effort`.

    Raises:
        ValueError: the case is wrong or nothing is required, a search is wrong, a
            function gives no finite number, it takes longer than it may, the folder
            cannot be written, or has another study to resume.
        RuntimeError: the nominal run fails.
    """
    asked = Asked.of(
        VERIFY,
        case,
        {
            "requirements": requirements,
            "objectives": objectives,
            "searches": searches,
            "growth": growth,
            "minutes": minutes,
            **effort,
        },
        seed=SearchSettings(**effort).seed,
    )
    plan = planned(asked, objectives, searches, requirements)
    with contextlib.ExitStack() as stack:
        folder = stack.enter_context(results_folder(output, VERIFY))
        plan = replace(
            plan,
            effort=effort,
            growth=growth,
            minutes=minutes,
            workers=workers,
            resume=resume,
            folder=folder,
        )
        study = Verification(
            asked=asked,
            objectives=plan.objectives,
            functions=tuple(requirements),
            clearances=plan.clearances,
        )
        if background is None:
            own = BackgroundProcess(workers if plan.on_batch_engine else 1)
            background = stack.enter_context(own)
        with session(plan, background, on_progress) as under_way:
            study = carried_out(study, under_way)
            if study.effort is not None and study.effort.growth:
                growths, single_growths = find_growths(
                    study.worst, under_way, study.functions
                )
                study = replace(study, growths=growths, single_growths=single_growths)
            study = under_way.write_down(study)
        return ended(study, folder)


def planned(
    asked: Asked,
    objectives: Wanted = (),
    searches: Sequence[str] | None = None,
    requirements: Sequence[FunctionRequirement] = (),
) -> StudyPlan:
    """Return what is asked of a study that verifies a case.

    Args:
        asked: the study.
        objectives: as `verify` takes them.
        searches: as `verify` takes them.
        requirements: on functions of a run, as `verify` takes them.

    Raises:
        ValueError: nothing is required, or an objective, a search or a function is
            wrong.
    """
    case = asked.case
    _check_functions(requirements)
    if not case.requirements and not requirements:
        raise InputError("requirements: a case to verify must have some, got none")
    of_functions = [o for function in requirements for o in function.objectives]
    also = [*listed(objectives), *of_functions]
    # Nothing leads out of requirements of which no run tells.
    leads = bool(also or case_objectives(case))
    chosen = choose_objectives(case, None, also) if leads else ()
    return StudyPlan(
        asked=asked,
        # Without dispersions, or objectives, there are the nominal and published runs.
        objectives=chosen if case.tolerances else (),
        searches=WantedSearches.named(searches),
        clearances=clearances_of(chosen),
    )


def _check_functions(requirements: Sequence[FunctionRequirement]) -> None:
    """Raise InputError unless each has a name and a column of its own."""
    for required in requirements:
        if is_column_of_runs(required.column):
            raise InputError(
                f"requirements: {required.name!r} would be the column "
                f"{required.column!r} of tables, which is another's: give it another "
                "name"
            )
    names = [required.name for required in requirements]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"requirements: {name!r} must stand once")
