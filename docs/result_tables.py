"""The tables of `results.md`: every file of a results folder, and every column."""

from collections.abc import Iterator

from drakesep.results.catalogue import FILES, FileKind


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
