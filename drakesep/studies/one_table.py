"""Studies that come to one table, of which Drake confirms a sample."""

from abc import abstractmethod
from dataclasses import dataclass, field
from typing import ClassVar

import pandas as pd

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.results.asked import Asked
from drakesep.results.folder import ResultsFolder
from drakesep.studies.saved import SavedStudy
from drakesep.tables.columns import write_csv


@dataclass(frozen=True, kw_only=True)
class OneTable(SavedStudy):
    """What such a study has found."""

    asked: Asked = field(repr=False)
    """With the case."""
    failure: str = ""
    """Which runs Drake does not confirm; empty if there are none."""

    FILE: ClassVar[str]
    """That has the table."""

    @property
    @abstractmethod
    def table(self) -> pd.DataFrame:
        """What was found."""

    @property
    def case(self) -> AnalysisCase:
        """The case."""
        return self.asked.case

    @property
    def completed(self) -> bool:
        """Whether Drake confirms a sample of what the batch engine says."""
        return not self.failure

    def write(self, results: ResultsFolder) -> None:
        """Write it into the folder of its study, which ends."""
        write_csv(self.table, results.path / self.FILE)
        results.end(failed=self.failure)
