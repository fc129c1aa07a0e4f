"""The tables of `results.md`: every file of a results folder, and every column."""

from collections.abc import Iterator

from docstrings import field_docs

from drakesep.results.catalogue.file_kind import FileKind
from drakesep.results.catalogue.files import FILES
from drakesep.results.study_record import StudyRecord


def tables_of_results() -> str:
    """Return a section for each file, made of the catalogue."""
    return "\n\n".join("\n".join(_lines(kind)) for kind in FILES)


def _lines(kind: FileKind) -> Iterator[str]:
    row = f" A row for each {kind.row}." if kind.row else ""
    yield f"### `{kind.name}`"
    yield ""
    yield f"{kind.what}{row} Of {', '.join(f'`{study}`' for study in kind.studies)}."
    if kind.columns:
        yield ""
        yield "| column | unit | what it is |"
        yield "|---|---|---|"
        for column in kind.columns:
            yield f"| `{column.name}` | {column.unit} | {column.what} |"


def table_of_study() -> str:
    """Return the keys of `study.json`, made of the record's fields."""
    rows = [
        f"| `{name}` | {text.replace('``', '`')} |"
        for name, text in field_docs(StudyRecord).items()
    ]
    return "\n".join(["| key | what it says |\n|---|---|", *rows])
