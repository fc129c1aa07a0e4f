"""One run of a case: tables, plots."""

import functools
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import pandas as pd

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.metrics.requirements import assess
from drakesep.case_file.case import Case
from drakesep.case_file.values import values_in_si
from drakesep.results.asked import Asked
from drakesep.results.catalogue.names import SIMULATE
from drakesep.results.folder import Output, ResultsFolder, begun
from drakesep.results.recorded_runs import save_runs
from drakesep.studies.remarks import Remark, remarks, save_remarks
from drakesep.studies.saved import SavedStudy
from drakesep.systems.argument_types import typed
from drakesep.systems.model.parameters import with_values
from drakesep.systems.model.run import Run
from drakesep.systems.simulation.shared_simulation import shared_simulation
from drakesep.tables.columns import write_csv
from drakesep.tables.contact_tables import contact_forces_table, contacts_table
from drakesep.tables.labelled_run import LabelledRun, measured
from drakesep.tables.requirement_tables import requirements_of_run_table
from drakesep.tables.roles import COMPLETED, Changed, Nominal
from drakesep.tables.run_tables import motion_table, runs_table


@dataclass(frozen=True, kw_only=True)
class Simulated(SavedStudy):
    """One run of a case."""

    asked: Asked = field(repr=False)
    """With the case."""
    labelled: LabelledRun
    """The run with its metrics, and how it ended."""
    values: Mapping[str, float]
    """What was changed, by parameter name with unit."""

    @property
    def case(self) -> AnalysisCase:
        """The case."""
        return self.asked.case

    @property
    def run(self) -> Run:
        """The run itself."""
        return self.labelled.run

    @functools.cached_property
    def summary(self) -> pd.DataFrame:
        """One row, as in `WorstCases.table`, with what was changed."""
        changed = values_in_si(self.case.separation, self.values)
        names = list(dict.fromkeys([*self.case.box.names, *changed]))
        return runs_table([self.labelled], names)

    @functools.cached_property
    def motion(self) -> pd.DataFrame:
        """The motion over time; empty if the run failed."""
        if not self.completed:
            return pd.DataFrame()
        return motion_table(self.run, self.run.separation.B)

    @property
    def contacts(self) -> pd.DataFrame:
        """A row for each contact after separation, if the case has recontact."""
        return contacts_table(self.run)

    @functools.cached_property
    def requirements(self) -> pd.DataFrame:
        """A row for each requirement and axis, with whether this run alone meets it.

        That is no verdict, which is over the tolerances. How near parts come is looked
        at only if it was measured. Empty if the run failed.
        """
        if not self.completed:
            return pd.DataFrame()
        one = self.labelled
        found = assess(self.case.requirements, {one.label: one.metrics}, one.label)
        bodies = [pair.B for pair in self.case.separation.pairs]
        return requirements_of_run_table(found, bodies)

    @property
    def remarks(self) -> list[Remark]:
        """What should be told of the run."""
        return remarks({self.labelled.label: self.run})

    @property
    def completed(self) -> bool:
        """Whether the run did not fail."""
        return not self.labelled.outcome.failed

    def write(self, results: ResultsFolder) -> None:
        """Write it into the folder of its study, which ends."""
        folder = results.path
        write_csv(self.summary, folder / "summary.csv")
        save_remarks(self.remarks, folder)
        save_runs([self.labelled], self.case.separation, folder)
        results.keep([self.labelled.label])
        if self.completed:
            self._write_motion(folder)
        results.end(failed=self.labelled.outcome.message)

    def _write_motion(self, folder: Path) -> None:
        write_csv(self.motion, folder / "motion.csv")
        if self.case.requirements:
            write_csv(self.requirements, folder / "requirements_of_run.csv")
        for body in self.run.others:
            write_csv(motion_table(self.run, body), folder / f"motion_{body}.csv")
        if self.run.separation.recontact is not None:
            write_csv(self.contacts, folder / "contacts.csv")
            write_csv(contact_forces_table(self.run), folder / "contact_forces.csv")
        # Half a second to import, where something is drawn.
        from drakesep.plots.motion import save_motion

        save_motion([self.labelled], self.case, folder)


@typed
def simulate(
    case: Case | AnalysisCase | str | Path,
    values: Mapping[str, float] | None = None,
    *,
    measure: bool = False,
    output: Output | None = None,
) -> Simulated:
    """Fly a case once.

    Args:
        case: a case, in SI or as a file holds it, a case file, or the name of a
            built-in case.
        values: new values by parameter name with unit, ``payload.mass_kg``.
        measure: whether to measure how near parts come, where that is required.
        output: folder that receives tables and plots.

    Raises:
        ValueError: the case or a value is wrong, or the folder cannot be written.
    """
    asked = Asked.of(SIMULATE, case, {"values": values, "measure": measure or None})
    case, values = asked.case, values or {}
    required = {r.metric: None for r in case.requirements if r.measured_apart}
    clearances = [case.lowest_clearance(name) for name in required if measure]
    changed = values_in_si(case.separation, values)
    with_values(case.separation, changed)  # what is refused leaves the folder alone
    with begun(output, asked) as folder:
        run = shared_simulation(case.separation, case.integration).run(changed)
        role = Changed() if values else Nominal()
        labelled = measured(role, run, case, clearances)
        if run.motion is not None:
            # What does not separate is told by its motion: one run is no verdict.
            labelled = replace(labelled, outcome=COMPLETED)
        result = Simulated(asked=asked.over(), labelled=labelled, values=values)
        if folder is not None:
            result.write(folder)
    return result
