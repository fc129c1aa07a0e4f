"""Where the numbers of a report stand: its places, looked up in the folders anew."""

import csv
import functools
import json
import math
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any, NamedTuple

import pytest

import drakesep
from drakesep.systems.model.parameters import parameters
from drakesep.tables.columns import in_units


REPORTS = Path(drakesep.__file__).parent / "reports"
TEMPLATES = REPORTS / "templates"
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
_VOID = {"meta", "img", "br", "wbr", "hr"}
_POWERS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


class Told(NamedTuple):
    """A stretch of text in a page."""

    text: str
    place: str
    """Of the element around it; empty if none has any."""
    title: str
    tags: tuple[str, ...]
    """Of all elements around it."""


class _Page(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self._open: list[list[Any]] = []
        self.told: list[Told] = []

    def handle_starttag(self, tag, attrs):
        if tag not in _VOID:
            self._open.append([tag, dict(attrs), ""])

    def handle_data(self, data):
        for element in reversed(self._open):
            if "data-source" in element[1]:
                element[2] += data
                return
        self._add(data, {})

    def handle_endtag(self, tag):
        name, attributes, text = self._open[-1]
        assert name == tag, f"</{tag}> closes <{name}>"
        if "data-source" in attributes:
            self._add(text, attributes)
        self._open.pop()

    def _add(self, text, attributes):
        words = " ".join(text.split())
        place = attributes.get("data-source", "")
        tags = tuple(element[0] for element in self._open)
        self.told.append(Told(words, place, attributes.get("title", ""), tags))


def told_in(page: str) -> list[Told]:
    """Return the texts of a page; its elements close in their order."""
    reader = _Page()
    reader.feed(page)
    assert not reader._open
    return [told for told in reader.told if told.text]


def words_of_reports() -> str:
    """What stands in their templates and modules, without blanks: of every report."""
    files = [*sorted(TEMPLATES.glob("*.html")), *sorted(REPORTS.glob("*.py"))]
    marks = re.compile(r"<[^>]*>|\{[{%].*?[%}]\}")
    return without_blanks(" ".join(marks.sub("", f.read_text("utf-8")) for f in files))


def without_blanks(text: str) -> str:
    return "".join(text.split())


def shown(text: str) -> float:
    """Return the number that a report shows."""
    plain = text.replace("\N{MINUS SIGN}", "-")
    plain = plain.replace("\N{INFINITY}", "inf").replace("·10", "e")
    return float(plain.translate(_POWERS))


class Folders:
    """The folders of a report by their names in it."""

    def __init__(self, by_tag: dict[str, Path]):
        self._by_tag = by_tag

    def check(self, told: Told) -> None:
        """Hold what a page shows against what stands in its place."""
        tag = next(tag for tag in self._by_tag if told.place.startswith(f"{tag}/"))
        folder = self._by_tag[tag]
        file, _, key = told.place.removeprefix(f"{tag}/").partition(":")
        if file == "study.json":
            _check_study(told, folder, key)
        elif file == "case.json":
            _check_case(told, folder, key)
        else:
            row, _, column = key.partition(":")
            _check_value(told, _rows(folder / file)[int(row) - 1][column])


@functools.cache
def _rows(file: Path) -> list[dict[str, str]]:
    with file.open(newline="", encoding="utf-8") as table:
        return list(csv.DictReader(table))


@functools.cache
def _json(file: Path) -> Any:
    return json.loads(file.read_text(encoding="utf-8"))


@functools.cache
def _case(folder: Path) -> drakesep.AnalysisCase:
    return drakesep.read_results(folder).case


def _check_value(told: Told, value: Any) -> None:
    if value is None or value == "":
        assert told.text == "\N{EN DASH}", told
        return
    if isinstance(value, list | bool):
        words = {True: "yes", False: "no"}
        is_list = isinstance(value, list)
        assert told.text == (", ".join(value) if is_list else words[value]), told
        return
    try:
        number = float(value)
    except (TypeError, ValueError):
        plain = " ".join(str(value).split())
        signs = plain.replace("<=", "≤").replace(">=", "≥")
        assert told.text in (plain, signs), told
        return
    if told.title:
        assert float(told.title) == number, told
        # Rounded to four digits or more.
        assert math.isclose(shown(told.text), number, rel_tol=5.001e-4), told
    else:
        assert shown(told.text) == number, told


def _within(data: Any, path: str) -> Any:
    for key in path.split("."):
        if isinstance(data, list):
            data = data[int(key)]
        elif path in data:  # a name with dots
            return data[path]
        else:
            data = data[key]
            path = path.partition(".")[2]
    return data


def _check_study(told: Told, folder: Path, key: str) -> None:
    study = _json(folder / "study.json")
    if key == "case.text":
        plain = " ".join(study["case"]["text"].replace("#", " ").split())
        assert " ".join(told.text.replace("#", " ").split()) in plain, told
    elif key.startswith("case.text:"):
        line = study["case"]["text"].splitlines()[int(told.text) - 1]
        assert key == f"case.text:{told.text}" and ":" in line, told
    else:
        _check_value(told, _within(study, key))


def _check_case(told: Told, folder: Path, key: str) -> None:
    kind, _, name = key.partition(":")
    case = _case(folder)
    if kind == "json":
        value = _within(_json(folder / "case.json"), name)
        if isinstance(value, list):
            assert [*map(shown, told.text.split(", "))] == value, told
        else:
            _check_value(told, value)
    elif kind == "parameter":
        value = in_units(parameters(case.separation))[name]
        assert math.isclose(shown(told.text), value, rel_tol=1e-9), told
    elif kind == "tolerance":
        _check_tolerance(told, case, *name.split(":"))
    else:
        _check_words(told, folder)


def _check_tolerance(told: Told, case: Any, name: str, what: str) -> None:
    from drakesep.units import unit_of, with_unit

    box = case.tolerance_set.box
    [one] = [d for d in box.dispersions if with_unit(d.name) == name]
    if what == "distribution":
        sides = [abs(unit_of(one.name).from_si(x)) for x in (one.sides.plus,)]
        assert not NUMBER.findall(told.text) or sides, told
        return
    if what == "values":
        values = [unit_of(one.name).from_si(x) for x in one.tolerance.values]
        listed = [float(x.split(" (")[0]) for x in told.text.split(", ")]
        assert listed == pytest.approx(values, rel=1e-9), told
        return
    value = unit_of(one.name).from_si(getattr(one.sides, what))
    assert math.isclose(shown(told.text), value, rel_tol=1e-9), told


def _check_words(told: Told, folder: Path) -> None:
    """Hold names and shapes against the case: each number is one of its, in mm."""
    text = (folder / "case.json").read_text(encoding="utf-8")
    numbers = {float(x) for x in NUMBER.findall(text)}
    plain = told.text
    for name in re.findall(r'"([^"]+)"', text):
        plain = plain.replace(name, " ") if re.search(r"\d", name) else plain
    for found in NUMBER.findall(plain):
        x = float(found)
        assert any(math.isclose(x, k * y) for y in numbers for k in (1, 1e3)), told
