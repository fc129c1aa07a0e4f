"""The page of equations names what codes each of them, and what proves it.

It is read as a list of entries: a heading, what it says, `Code:` and `Tests:`. Names of
code are imported; tests are looked up in their files, which are not.
"""

import ast
import functools
import importlib
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest


ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "equations.md"
FOLDERS = ("systems", "analysis", "drakesep")
EQUATIONS = range(1, 15)
"""Those that the paper numbers."""
_PACKAGES = {"systems": "drakesep.systems", "analysis": "drakesep.analysis"}
_NAMED = re.compile(r"`([\w/]+\.py): ([\w.]+)`")
_CITED = re.compile(r"Eq\. (\d+)((?:(?: and |, |-)\d+)*)")
"""Eq. 5; Eq. 3 and 4; Eq. 1-4."""


class Entry(NamedTuple):
    """What the page says of an equation, or of a law."""

    title: str
    number: int | None
    """In the paper; None of what stands beside it."""
    code: tuple[tuple[str, str], ...]
    """Files and names in them."""
    tests: tuple[tuple[str, str], ...]


def entries(text: str) -> list[Entry]:
    found = []
    for section in re.split(r"^### ", text, flags=re.M)[1:]:
        section = re.split(r"^## ", section, flags=re.M)[0]
        title, _, body = section.partition("\n")
        before, _, tests = body.partition("\nTests:")
        _, _, code = before.partition("\nCode:")
        number = re.match(r"Eq\. (\d+): ", title)
        found.append(
            Entry(
                title,
                int(number[1]) if number else None,
                tuple(_NAMED.findall(code)),
                tuple(_NAMED.findall(tests)),
            )
        )
    return found


ENTRIES = entries(PAGE.read_text(encoding="utf-8"))


def code_exists(file: str, name: str) -> bool:
    folder, *rest = Path(file).with_suffix("").parts
    try:
        found = importlib.import_module(
            ".".join([_PACKAGES.get(folder, folder), *rest])
        )
        functools.reduce(getattr, name.split("."), found)
    except (ImportError, AttributeError):
        return False
    return True


@functools.cache
def functions_of(file: str) -> frozenset[str]:
    if not (ROOT / file).exists():
        return frozenset()
    tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
    return frozenset(n.name for n in tree.body if isinstance(n, ast.FunctionDef))


def numbers(comment: str) -> Iterator[int]:
    """The equations that a comment cites."""
    for first, others in _CITED.findall(comment):
        last = int(first)
        yield last
        for joint, number in re.findall(r"( and |, |-)(\d+)", others):
            start = last + 1 if joint == "-" else int(number)
            last = int(number)
            yield from range(start, last + 1)


def enclosing(tree: ast.Module, line: int) -> str:
    """The function, the class or the constant in which a line stands."""
    names: list[str] = []
    body = tree.body
    while True:
        inside = [n for n in body if n.lineno <= line <= (n.end_lineno or n.lineno)]
        match inside:
            case [ast.FunctionDef() | ast.ClassDef() as node]:
                names.append(node.name)
                body = node.body
            case [ast.Assign(targets=[ast.Name(id=name)])] if not names:
                return name
            case [ast.AnnAssign(target=ast.Name(id=name))] if not names:
                return name
            case _:
                return ".".join(names)


def citations() -> Iterator[tuple[int, str, str]]:
    """Equations that comments cite: number, file, and in what they stand."""
    for path in (
        p for folder in FOLDERS for p in sorted((ROOT / folder).rglob("*.py"))
    ):
        with tokenize.open(path) as source:
            text = source.read()
        if "Eq." not in text:
            continue
        tree = ast.parse(text)
        lines = iter(text.splitlines(keepends=True))
        for token in tokenize.generate_tokens(lambda it=lines: next(it, "")):
            if token.type == tokenize.COMMENT:
                for number in numbers(token.string):
                    file = path.relative_to(ROOT).as_posix()
                    yield number, file, enclosing(tree, token.start[0])


CITATIONS = list(citations())


def is_named(number: int, file: str, name: str, of: list[Entry]) -> bool:
    """Whether the page names, for an equation, what cites it, or what holds that."""
    return any(
        (file, named) == (file, name) or name.startswith(f"{named}.")
        for entry in of
        if entry.number == number
        for in_file, named in entry.code
        if in_file == file
    )


@pytest.mark.parametrize("entry", ENTRIES, ids=[entry.title for entry in ENTRIES])
def test_what_codes_and_proves_an_equation_exists(entry):
    assert entry.code, "Code: names nothing"
    assert entry.tests, "Tests: names nothing"
    assert [x for x in entry.code if not code_exists(*x)] == []
    assert [x for x in entry.tests if x[1] not in functions_of(x[0])] == []


def test_every_equation_of_the_paper_stands_once():
    numbered = [entry.number for entry in ENTRIES if entry.number is not None]
    assert numbered == list(EQUATIONS)


def test_every_equation_is_cited_where_it_is_coded():
    assert {number for number, *_ in CITATIONS} == set(EQUATIONS)


@pytest.mark.parametrize("citation", CITATIONS, ids=map(str, CITATIONS))
def test_what_cites_an_equation_is_named_by_the_page(citation):
    assert is_named(*citation, ENTRIES)


def test_faults_of_the_page_and_of_the_code_are_seen():
    """What each of the tests above would see, on an entry made for it."""
    text = (
        "### Eq. 5: a spring\n\nCode: `systems/model/springs.py: push_frequency`.\n"
        "Tests: `tests/test_equations_page.py: test_no_such_thing`.\n"
    )
    [entry] = entries(text)
    [(file, name)] = entry.code
    assert entry.number == 5
    assert code_exists(file, name)
    assert not code_exists(file, "push_frequenzy")
    assert not code_exists("systems/model/sprungs.py", name)
    [(file_of_test, test)] = entry.tests
    assert test not in functions_of(file_of_test)
    assert is_named(5, file, name, [entry])
    assert not is_named(4, file, name, [entry])
    assert not is_named(5, file, "push_duration", [entry])
    assert list(numbers("# Eq. 3 and 4; integrand of Eq. 6; Eq. 9-11")) == [
        *(3, 4, 6, 9, 10, 11)
    ]
