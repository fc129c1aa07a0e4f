"""Studies that can be written into a folder once they have ended."""

from abc import ABC, abstractmethod
from pathlib import Path

from drakesep.results.asked import Asked
from drakesep.results.folder import ResultsFolder


class SavedStudy(ABC):
    """A study with what it was asked."""

    asked: Asked
    """With the case."""

    def save(self, directory: str | Path) -> None:
        """Write tables, plots and `study.json` into a folder.

        Raises:
            ValueError: it cannot be written, another study is writing it, or it holds
                the results of another kind of study.
        """
        with ResultsFolder(directory, self.asked.study) as results:
            results.begin(self.asked)
            self.write(results)

    @abstractmethod
    def write(self, results: ResultsFolder) -> None:
        """Write it into the folder of its study, which ends."""
