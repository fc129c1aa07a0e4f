"""The tables of `command_line.md`: what `--json` says of each command."""

import dataclasses
from collections.abc import Iterator

from docstrings import field_docs

from drakesep.cli.summaries import SUMMARIES, Row


_VALUES = {
    bool: "true or false",
    str: "text",
    int: "whole number",
    str | None: "text or null",
    list[str]: "list of texts",
    list[Row]: "list of objects",
    dict[str, float | None]: "object of numbers",
}


def tables_of_summaries() -> str:
    """Return a section for each command, made of the declared keys."""
    return "\n\n".join("\n".join(_lines(command)) for command in SUMMARIES)


def _lines(command: str) -> Iterator[str]:
    record = SUMMARIES[command]
    docs = field_docs(record)
    yield f"### `{command}`"
    yield ""
    yield "| key | value | what it says |"
    yield "|---|---|---|"
    for field in dataclasses.fields(record):
        text = docs[field.name].replace("|", "\\|")
        yield f"| `{field.name}` | {_VALUES[field.type]} | {text} |"
