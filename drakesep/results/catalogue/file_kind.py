"""What is told of a file of a results folder, and of its columns."""

from dataclasses import dataclass
from typing import NamedTuple


class Column(NamedTuple):
    """A column of a table, or many by a name in braces."""

    name: str
    unit: str
    what: str


@dataclass(frozen=True, kw_only=True)
class FileKind:
    """A file, or many by a name in braces."""

    name: str
    studies: tuple[str, ...]
    """That write it."""
    what: str
    row: str = ""
    """What a row of the table is for; empty if it is no table."""
    columns: tuple[Column, ...] = ()
    key: tuple[str, ...] = ()
    """Columns that tell its rows apart; what has the same values there is told by its
    order."""
    is_long: bool = False
    """Whether its rows are so many that of each column only the greatest difference
    from another such table is worth telling."""

    def named(self, label: str, body: str) -> str:
        """Return its name for a run and a body, if it has one for each."""
        return self.name.replace("{label}", label).replace("{body}", body)

    @property
    def of_each_run(self) -> bool:
        """Whether there is one for each run."""
        return "{label}" in self.name

    @property
    def of_each_body(self) -> bool:
        """Whether there is one for each body that leaves, but the first."""
        return "{body}" in self.name
