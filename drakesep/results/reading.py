"""Results folders, read: nothing is flown."""

import functools
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.results.catalogue.names import STUDY
from drakesep.results.recorded_case import read_case
from drakesep.results.recorded_runs import read_role, read_run
from drakesep.results.study_record import StudyRecord
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError, unknown
from drakesep.tables.columns import read_table
from drakesep.tables.labelled_run import LabelledRun
from drakesep.tables.roles import Role


@dataclass(frozen=True, kw_only=True)
class Results:
    """What a study has left in its folder."""

    folder: Path
    record: StudyRecord
    """What was asked, with what, and how it ended."""

    @functools.cached_property
    def case(self) -> AnalysisCase:
        """The case, in SI, with its geometry.

        Raises:
            ValueError: its file is not valid.
        """
        return read_case(self.folder)

    @property
    def labels(self) -> tuple[str, ...]:
        """Of the runs."""
        return tuple(self.record.runs)

    def run(self, label: str) -> LabelledRun:
        """Return a run, with its motion, loads and metrics.

        Args:
            label: of the run.

        Raises:
            ValueError: there is no such run, or its files are not valid.
        """
        if label not in self.labels:
            raise InputError(f"{self.folder}: {unknown('run', label, self.labels)}")
        return read_run(self.folder, label, self.case.separation)

    @functools.cached_property
    def roles(self) -> dict[str, Role]:
        """What each run is that has completed, by its label; no motion is read.

        Raises:
            ValueError: a file of a run is not valid.
        """
        read = {label: read_role(self.folder, label) for label in self.labels}
        return {label: role for label, (role, completed) in read.items() if completed}

    @functools.cached_property
    def runs(self) -> tuple[LabelledRun, ...]:
        """All runs, in the order of their labels."""
        return tuple(map(self.run, self.labels))

    def table(self, name: str) -> pd.DataFrame:
        """Return a table of the folder.

        Args:
            name: of its file, such as ``requirements.csv``.

        Raises:
            ValueError: there is none of this name.
        """
        tables = [str(file["name"]) for file in self.record.files if "row" in file]
        if name not in tables:
            raise InputError(f"{self.folder}: {unknown('table', name, tables)}")
        return read_table(self.folder / name)


@typed
def read_results(directory: str | Path) -> Results:
    """Return what a study has left in a folder.

    Args:
        directory: the folder.

    Raises:
        ValueError: it is none of a study.
    """
    folder = Path(directory).absolute()
    record = StudyRecord.read(folder)
    if record is None:
        raise InputError(f"{folder}: must be a folder of results, got no {STUDY} in it")
    return Results(folder=folder, record=record)
