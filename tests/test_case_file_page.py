"""The page of case files has every key, as other walks find them.

Those are pydantic's JSON schema, the kinds of springs, and the built-in cases.
"""

import re
from collections.abc import Iterator
from typing import Any

import generate
import pytest
from ruamel.yaml import YAML

from drakesep.case_file.case import Case
from drakesep.case_file.reader import builtin_cases
from drakesep.systems.equations.springs import PUSHERS


Rows = dict[str, list[str]]
"""Cells of a key: value, unit, what holds if it is left out, what it is."""


def sections_of_the_page() -> dict[str, Rows]:
    """The rows of each section by the paths to it; of springs, those of all laws."""
    text = (generate.DOCS / "case_file.md").read_text(encoding="utf-8")
    found = {}
    for section in re.split("^## ", text, flags=re.M)[1:]:
        title, _, body = section.partition("\n")
        rows = {}
        for line in re.findall(r"^\| `.*$", body, re.M):
            key, *cells = (cell.strip() for cell in line.strip("|").split(" | "))
            rows[key.strip("`")] = cells
        for path in re.findall("`(.*?)`", title) or [""]:
            found[path] = rows
    return found


SECTIONS = sections_of_the_page()
SCHEMA = Case.model_json_schema()
SPRING = "attachments.NAME.spring"


def sections_of_the_schema(node: dict[str, Any], path: str = "") -> Iterator[Any]:
    """Sections by the paths to them, as pydantic tells them to others."""
    if "$ref" in node:
        node = SCHEMA["$defs"][node["$ref"].rpartition("/")[2]]
    for name, inner in node.get("properties", {}).items():
        yield from sections_of_the_schema(inner, f"{path}.{name}".lstrip("."))
    for one in (*node.get("anyOf", []), *node.get("oneOf", [])):
        yield from sections_of_the_schema(one, path)
    if isinstance(node.get("additionalProperties"), dict):
        yield from sections_of_the_schema(node["additionalProperties"], f"{path}.NAME")
    for named in node.get("patternProperties", {}).values():
        yield from sections_of_the_schema(named, f"{path}.NAME")
    if "items" in node:
        yield from sections_of_the_schema(node["items"], f"{path}.ENTRY")
    if "properties" in node:
        yield path, node


IN_SCHEMA = dict(sections_of_the_schema(SCHEMA))


def test_every_key_of_case_files_stands_and_no_other():
    """Springs are read by their law: their keys are held to the cases below."""
    assert {path: set(rows) for path, rows in SECTIONS.items() if path != SPRING} == {
        path: set(node["properties"]) for path, node in IN_SCHEMA.items()
    }


def test_keys_of_springs_are_those_of_every_law():
    names = {"name", "law", "axis"}
    for kind in PUSHERS.values():
        for argument in kind.arguments:
            [key] = [k for k in SECTIONS[SPRING] if f"{k}_".startswith(f"{argument}_")]
            names.add(key)
    assert set(SECTIONS[SPRING]) == names


def defaults() -> Iterator[tuple[str, str]]:
    for path, node in IN_SCHEMA.items():
        yield from ((path, key) for key in node["properties"])


@pytest.mark.parametrize(("path", "key"), list(defaults()))
def test_what_holds_if_a_key_is_left_out(path, key):
    node = IN_SCHEMA[path]
    _, _, left_out, meaning = SECTIONS[path][key]
    assert len(meaning) > 3
    assert (left_out == "needed") == (key in node.get("required", ()))
    default = node["properties"][key].get("default")
    if isinstance(default, dict):
        assert left_out == "its own defaults"
    elif left_out not in ("needed", "none"):
        got = YAML(typ="safe").load(left_out)
        assert got == (list(default) if isinstance(default, tuple) else default)
    else:
        assert not default


SUFFIXES = {
    r"_mm": "mm",
    r"_km": "km",
    r"_deg": "deg",
    r"_deg_s": "deg/s",
    r"(?<!deg)(?<!N)(?<!_m)(?<!_km)_s": "s",
    r"(?<!angular_damping_N)_m_s": "m/s",
    r"_kg": "kg",
    r"_kg_m2": "kg m²",
    r"_kg_m3": "kg/m³",
    r"_km_s": "km/s",
    r"_N": "N",
    r"stiffness_N_m": "N/m",
    r"torques_N_m": "N m",
    r"damping_N_s_m": "N s/m",
    r"dissipation_s_m": "s/m",
    r"stiffness_N_m_rad": "N m/rad",
    r"damping_N_m_s_rad": "N m s/rad",
    r"[xyz]{2}": "kg m²",
}


def test_units_are_those_that_keys_carry():
    for rows in SECTIONS.values():
        for key, (_, unit, *_) in rows.items():
            ends = [u for end, u in SUFFIXES.items() if re.search(f"{end}$", key)]
            assert [unit] == (ends or [""]), key


def keys_given(data: Any, path: str = "") -> Iterator[tuple[str, str]]:
    """The keys of a case file, with the sections in which they stand."""
    if not isinstance(data, dict):
        return  # what may be a section is a number
    for key, value in data.items():
        yield path, key
        inside = f"{path}.{key}".lstrip(".")
        if f"{inside}.NAME" in SECTIONS:
            for named in value.values():
                yield from keys_given(named, f"{inside}.NAME")
        elif f"{inside}.ENTRY" in SECTIONS:
            for entry in value:
                yield from keys_given(entry, f"{inside}.ENTRY")
        elif inside in SECTIONS and isinstance(value, dict):  # else in short
            yield from keys_given(value, inside)


@pytest.mark.parametrize("case", builtin_cases())
def test_keys_of_the_built_in_cases_stand(case):
    data = YAML(typ="safe").load(builtin_cases()[case])
    assert [k for k in keys_given(data) if k[1] not in SECTIONS[k[0]]] == []
