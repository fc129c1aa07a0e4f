"""The page of parameters has those of the built-in cases, and no other."""

import re
from pathlib import Path

from drakesep.case_file.reader import builtin_cases, load_case
from drakesep.systems.model.parameters import parameters
from drakesep.units import with_unit


PAGE = Path(__file__).parents[2] / "docs" / "parameters.md"


def listed() -> set[str]:
    """The names of the page, with their axes."""
    rows = re.findall(
        r"^\| .* \| `(\w+)` \| (.*?) \| .* \| .* \|$", PAGE.read_text("utf-8"), re.M
    )
    return {
        name.replace("AXIS", axis)
        for name, axes in rows
        for axis in (axes.split(", ") if axes else [""])
    }


def test_the_page_has_the_parameters_of_the_built_in_cases():
    names = {
        with_unit(name).rpartition(".")[2]
        for case in builtin_cases()
        for name in parameters(load_case(case).separation)
    }
    # What no built-in case has: rails, connectors, and bodies that spin.
    assert listed() == names | {"release_travel_mm", "travel_mm", "spin_deg_s"}
