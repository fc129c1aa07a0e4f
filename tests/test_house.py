"""The house as CONTRIBUTING draws it: floors, quarters, and what may be imported where.

Imports are read from the source, so that those inside functions and those for the type
checker count too.
"""

import ast
import re
import sys
from collections.abc import Iterator, Mapping
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import NamedTuple

import pytest


ROOT = Path(__file__).parents[1]
FLOORS = {"systems": 0, "analysis": 1, "drakesep": 2}
"""Folders at the top of the repository, from the ground up."""
NO_DRAKE = (
    "drakesep.systems.checks",
    "drakesep.systems.vectors",
    "drakesep.systems.arrays",
    "drakesep.systems.sampling",
    "drakesep.systems.model",
    "drakesep.systems.equations",
    "drakesep.systems.batch",
)
"""Of the ground floor, on which alone Drake is known."""
JAX = ("drakesep.systems.batch", "drakesep.analysis.engines.jax")
"""Where JAX is known."""


class Import(NamedTuple):
    importer: str
    imported: str
    within_function: bool


def modules() -> dict[str, Path]:
    """The modules by their dotted names."""
    found = {}
    for folder in FLOORS:
        for path in sorted((ROOT / folder).rglob("*.py")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            parts = parts if folder == "drakesep" else ("drakesep", *parts)
            found[".".join(parts).removesuffix(".__init__")] = path
    return found


MODULES = modules()

STANDS_ALONE = ("drakesep.check_proof",)
"""What may be copied elsewhere by itself: imports within it are relative."""


def imports_of(module: str, path: Path) -> Iterator[Import]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    inner = {
        node
        for function in ast.walk(tree)
        if isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef)
        for node in ast.walk(function)
    }
    for node in ast.walk(tree):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            if module.startswith(STANDS_ALONE):
                continue
            assert node.level == 0, f"{module}: imports must be absolute"
            for alias in node.names:
                full = f"{node.module}.{alias.name}"
                names.append(full if full in MODULES else str(node.module))
        for name in names:
            yield Import(module, name, node in inner)


IMPORTS = [
    found for module, path in MODULES.items() for found in imports_of(module, path)
]


def floor_of(module: str) -> int:
    _, *parts = module.split(".")
    return FLOORS.get(parts[0] if parts else "", FLOORS["drakesep"])


def within(module: str, packages: tuple[str, ...]) -> bool:
    return any(module == p or module.startswith(f"{p}.") for p in packages)


def quarter_of(module: str) -> str:
    """The sub-package of a module; the module itself if it stands in the hall."""
    depth = 2 if floor_of(module) == FLOORS["drakesep"] else 3
    return ".".join(module.split(".")[:depth])


def test_floors_are_imported_downwards_only():
    wrong = [
        found
        for found in IMPORTS
        if found.imported in MODULES
        and floor_of(found.imported) > floor_of(found.importer)
    ]
    assert not wrong


def test_no_circle():
    graph: dict[str, set[str]] = {module: set() for module in MODULES}
    for found in IMPORTS:
        if found.imported in MODULES:
            graph[found.importer].add(found.imported)
    check_no_circle(graph)


def check_no_circle(graph: Mapping[str, set[str]]) -> None:
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))


def test_no_circle_of_quarters():
    graph: dict[str, set[str]] = {}
    for found in IMPORTS:
        if found.imported in MODULES:
            ends = quarter_of(found.importer), quarter_of(found.imported)
            if ends[0] != ends[1]:
                graph.setdefault(ends[0], set()).add(ends[1])
    check_no_circle(graph)


def test_drake_is_known_on_the_ground_floor_alone():
    wrong = [
        found
        for found in IMPORTS
        if found.imported.split(".")[0] == "pydrake"
        and (floor_of(found.importer) > 0 or within(found.importer, NO_DRAKE))
    ]
    assert not wrong


def test_jax_is_known_to_the_batch_engine_alone():
    wrong = [
        found
        for found in IMPORTS
        if found.imported.split(".")[0] in ("jax", "jaxlib")
        and not within(found.importer, JAX)
    ]
    assert not wrong


def reached_from(module: str) -> set[str]:
    """The modules that are imported with one, when it is imported."""
    direct: dict[str, set[str]] = {}
    for found in IMPORTS:
        if found.imported in MODULES and not found.within_function:
            direct.setdefault(found.importer, set()).add(found.imported)
    reached, waiting = set(), [module]
    while waiting:
        one = waiting.pop()
        if one not in reached:
            reached.add(one)
            waiting += direct.get(one, ())
    return reached


@pytest.mark.parametrize(
    "module",
    [
        "drakesep.analysis.engines.evaluator",
        "drakesep.analysis.search.problem",
        "drakesep.analysis.search.registry",
        "drakesep.analysis.search.judge",
        "drakesep.analysis.margins.tolerance_margins",
        "drakesep.case_file.reader",
    ],
)
def test_what_describes_engines_does_not_import_them(module):
    engines = [found for found in reached_from(module) if within(found, JAX)]
    assert not engines


def tree() -> str:
    """The house, a line a room: each by the first line of its docstring."""
    lines = []
    for folder in FLOORS:
        for path in sorted((ROOT / folder).rglob("*.py"), key=_place):
            place = path.relative_to(ROOT)
            is_quarter = path.stem == "__init__"
            place = place.parent if is_quarter else place
            name = f"{place.name}/" if is_quarter else place.stem
            indent = "  " * (len(place.parts) - 1)
            doc = str(ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))))
            lines.append(f"{indent + name:<28}{doc.splitlines()[0]}")
    return "\n".join(lines)


def _place(path: Path) -> tuple[tuple[bool, str], ...]:
    """Rooms of a quarter before the quarters in it; a quarter before its rooms."""
    *folders, name = path.relative_to(ROOT).with_suffix("").parts
    return (*((True, folder) for folder in folders), (False, f" {name}"))


def test_tree_of_the_house():
    """CONTRIBUTING draws every room, and no other: on failure, copy what is printed."""
    drawn = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    print(tree())
    assert tree() in drawn


def test_packages_are_listed():
    """setuptools takes only what pyproject.toml lists."""
    listed = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    packages = {m for m, path in MODULES.items() if path.stem == "__init__"}
    assert packages == set(re.findall(r'^    "(drakesep[\w.]*)",$', listed, re.M))


def test_what_stands_alone_knows_nothing_of_the_house():
    """Its own rooms, the standard library and python-flint: no code of the prover's."""
    for module, path in MODULES.items():
        if not module.startswith(STANDS_ALONE):
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                assert node.level <= 1, module
                names = [str(node.module)] if node.level == 0 else []
            for name in names:
                root = name.partition(".")[0]
                assert root in {"flint", *sys.stdlib_module_names}, (module, name)
