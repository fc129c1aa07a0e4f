"""The page of parameters lists what the tables declare."""

import itertools
import re
from pathlib import Path

from drakesep.units import records, unit_of_kind


PAGE = Path(__file__).parents[2] / "docs" / "parameters.md"
OWNERS = {
    "Body": "a body",
    "Attachment": "an attachment",
    "Spring": "a spring, `law: time`",
    "DisplacementSpring": "a spring, `law: displacement` or `table`",
    "Load": "a load",
    "InitialMotion": "`before_separation`",
}


def rows():
    for record in records():
        for stem, group in itertools.groupby(record.PARAMETERS, lambda p: p.stem):
            first, *others = parameters = list(group)
            suffix = unit_of_kind(first.kind).suffix
            axes = ", ".join(p.axis for p in parameters if p.axis)
            name = "_".join(filter(None, [stem, "AXIS" if axes else "", suffix]))
            wanted = first.range.text(first.kind)
            assert all(p.range == first.range for p in others)
            owner = OWNERS[record.__name__]
            yield f"| {owner} | `{name}` | {axes} | {first.kind} | {wanted} |".replace(
                "angular_rate", "angular rate"
            )


def test_the_page_lists_every_parameter():
    text = PAGE.read_text(encoding="utf-8")
    assert re.findall(r"^\| (?:an? |`before).*$", text, re.M) == list(rows())
