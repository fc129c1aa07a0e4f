"""The parameters of records, from their declarations, as the page lists them."""

import itertools
from collections.abc import Iterator

from drakesep.systems.equations.springs import PUSHERS
from drakesep.systems.model.magnitudes import MAGNITUDES
from drakesep.units import records, unit_of_kind


OWNERS = {
    "Body": "a body",
    "Attachment": "an attachment",
    "Load": "a load",
    "Part": "a part of a body's geometry",
    "InitialMotion": "`before_separation`",
}
"""What those that are no pushers are called."""


def table_of_parameters() -> str:
    """Return the parameters of all kinds of records, as Markdown."""
    head = "| of | name | AXIS | what it is | value |\n|---|---|---|---|---|"
    return "\n".join([head, *_rows()])


def _rows() -> Iterator[str]:
    for record in records():
        for stem, group in itertools.groupby(record.PARAMETERS, lambda p: p.stem):
            first, *others = parameters = list(group)
            assert all(p.range == first.range for p in others)
            axes = ", ".join(p.axis for p in parameters if p.axis)
            suffix = unit_of_kind(first.kind).suffix
            name = "_".join(filter(None, [stem, "AXIS" if axes else "", suffix]))
            kind, wanted = first.kind.replace("_", " "), first.range.text(first.kind)
            yield f"| {_owner(record)} | `{name}` | {axes} | {kind} | {wanted} |"


def _owner(record: type) -> str:
    laws = [f"`{law}`" for law, kind in PUSHERS.items() if kind.record is record]
    if not laws:
        return OWNERS[record.__name__]
    return f"a spring, `law: {' or '.join(laws).removeprefix('`')}"


def table_of_magnitudes() -> str:
    """Return a row for each kind of number: how small and how large it may be."""
    rows = [
        "| what it measures | above zero, no less than | no more than |",
        "|---|---|---|",
    ]
    rows += [
        f"| {kind.replace('_', ' ')} | {m.least:g} {m.unit} | {m.most:g} {m.unit} |"
        for kind, m in MAGNITUDES.items()
    ]
    return "\n".join(row.replace("  |", " |") for row in rows)
