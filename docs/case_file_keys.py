"""The keys of case files, as the page on them lists them: read from their sections."""

import inspect
import re
import types
from collections.abc import Iterable, Iterator
from typing import (
    Annotated,
    Any,
    Literal,
    NamedTuple,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

import annotated_types
from docstrings import field_docs, listed
from pydantic.fields import FieldInfo

from drakesep.case_file import (
    before_separation,
    dispersions,
    extents,
    geometry,
    others,
    section,
)
from drakesep.case_file.attachments import SpringSection, key_of
from drakesep.case_file.case import Case
from drakesep.case_file.section import Section
from drakesep.systems.equations.springs import PUSHERS


NAME = "NAME"
"""Stands in paths for a name that a case gives."""
ENTRY = "ENTRY"
"""Stands for each entry of a list."""
WORDS = {
    section.Vector: "3 numbers",
    section.Gains: "number >= 0, or 3 along x, y and z",
    section.Rows: "3 numbers for each row",
    section.Column: "list of numbers",
    section.Name: "name of letters, digits, _ and -",
    section.File: "path",
    before_separation.Files: "path, or list of paths",
    geometry.PartNames: "pairs of names of parts `[a, b]`",
    others.Limits: "number, or one for each axis (`null`: none)",
    others.Mark: "`M`, `m` or number",
    others.Quantities: "name of a [quantity or metric](metrics.md), with its unit",
    others.WhenOf: "name of a [time](metrics.md#requirements), or section",
    dispersions.Tolerance: "number > 0, a share such as `5 %`, or section",
    extents.Extent: "number > 0, a share such as `5 %`, or section",
    extents.Width: "number > 0, or a share such as `5 %`",
    extents.Side: "number >= 0, or a share such as `5 %`",
    float: "number",
    bool: "`true` or `false`",
    int: "whole number",
    list[str]: "list of names",
    list[list[float]]: "rows of numbers",
    str: "text",
}
"""What a value is, by its type."""
UNITS = {
    "_kg": "kg",
    "_kg_m3": "kg/m³",
    "_kg_m2": "kg m²",
    "_mm": "mm",
    "_km": "km",
    "_km_s": "km/s",
    "_deg": "deg",
    "_deg_s": "deg/s",
    "_s": "s",
    "_m_s": "m/s",
    "_s_m": "s/m",
    "_N": "N",
    "_N_m": "N/m",
    "_N_s_m": "N s/m",
    "_N_m_rad": "N m/rad",
    "_N_m_s_rad": "N m s/rad",
    "torques_N_m": "N m",
}
"""By how keys end."""
_NEEDED = "needed"
_HEAD = "| key | value | unit | if left out | what it is |\n|---|---|---|---|---|"


class Key(NamedTuple):
    """A key of a section."""

    name: str
    value: str
    """What its value is."""
    left_out: str
    """What holds if it is left out; or that it cannot be."""
    meaning: str
    unit: str
    """Empty if it has none."""

    @property
    def row(self) -> str:
        """Its row in the page."""
        cells = (f"`{self.name}`", self.value, self.unit, self.left_out, self.meaning)
        return f"| {' | '.join(cells)} |"


def unit_of(path: str) -> str:
    """Return the unit that the last key of a path carries; empty if it has none."""
    ends = [end for end in UNITS if path.endswith(end)]
    return UNITS[max(ends, key=len)] if ends else ""


def keys_of_case_files() -> str:
    """Return the sections with their keys, as Markdown."""
    paths: dict[type[Section], list[str]] = {}
    for path, found in sections(Case):
        paths.setdefault(found, []).append(path)
    return "\n\n".join(_text(found, where) for found, where in paths.items())


def sections(of: type[Section], path: str = "") -> Iterator[tuple[str, type[Section]]]:
    """Yield a section, and those within it, each with the path to it."""
    yield path, of
    for name, hint in get_type_hints(of, include_extras=True).items():
        if name in of.model_fields:
            for inner, found in _within(hint):
                yield from sections(found, ".".join(filter(None, [path, name, inner])))


def _within(hint: Any) -> Iterator[tuple[str, type[Section]]]:
    """Yield the sections in a type, each with what stands for a name or an entry."""
    if isinstance(hint, type) and issubclass(hint, Section):
        yield "", hint
    place = {dict: NAME, list: ENTRY}.get(get_origin(hint), "")
    arguments = get_args(hint)
    for argument in arguments[:1] if get_origin(hint) is Annotated else arguments:
        yield from (
            (".".join(filter(None, [place, p])), s) for p, s in _within(argument)
        )


def _text(of: type[Section], paths: list[str]) -> str:
    title = ", ".join(f"`{path}`" for path in paths if path) or "At the top"
    doc = " ".join((of.__doc__ or "").split())
    if of is Case:
        doc = "A case file is a mapping with these keys."
    rows = [key.row for key in keys(of, paths[0])]
    parts = [f"## {title}\n\n{doc}\n\n{_HEAD}\n" + "\n".join(rows)]
    if of is SpringSection:
        parts += [_text_of_law(law) for law in PUSHERS]
    return "\n\n".join(parts)


def _text_of_law(law: str) -> str:
    rows = "\n".join(key.row for key in keys_of_law(law))
    return f"With `law: {law}` also:\n\n{_HEAD}\n{rows}"


def keys(of: type[Section], path: str) -> list[Key]:
    """Return the keys of a section; of a spring, those of every law.

    Args:
        of: the section.
        path: to it; it may carry the unit of what it holds.
    """
    hints, docs = get_type_hints(of, include_extras=True), field_docs(of)
    found = []
    for name, field in of.model_fields.items():
        value = words(hints[name], *field.metadata)
        if (of, name) == (SpringSection, "law"):
            value = _any_of(PUSHERS)
        unit = unit_of(name) or unit_of(path)
        key = name.removesuffix("_")
        found.append(Key(key, value, _left_out(field), docs[name], unit))
    return found


def keys_of_law(law: str) -> list[Key]:
    """Return the keys that springs have with a law alone."""
    kind = PUSHERS[law]
    docs = listed(kind.make, "Args") if kind.make else field_docs(kind.record)
    parameters = inspect.signature(kind.maker).parameters
    found = []
    for argument, needed in kind.arguments.items():
        name, unit = key_of(kind, argument)
        if argument in kind.columns:
            value = WORDS[section.Column]
        else:
            parameter = kind.parameter(argument)
            value = f"number {parameter.range.text(parameter.kind)}"
        default = parameters[argument].default
        left_out = _NEEDED if needed else _shown(unit.from_si(default))
        meaning = _without_unit(docs[argument])
        found.append(Key(name, value, left_out, meaning, unit_of(name)))
    return found


def _without_unit(doc: str) -> str:
    """Return what a docstring in SI says, without shape and unit: the key has one."""
    doc = re.sub(r", (?:N s/m|kg|rad|m|N)(?=[:.])", "", doc.removeprefix("(n,) "))
    return re.sub("^[a-z](?=[a-z])", lambda first: first[0].upper(), doc)


def words(hint: Any, *metadata: Any) -> str:
    """Return what a value of a type is.

    Args:
        hint: the type.
        metadata: what a field has to say of it beside its type.
    """
    if hint in WORDS:
        return _limited(WORDS[hint], metadata)
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return words(arguments[0], *hint.__metadata__, *metadata)
    if origin in (Union, types.UnionType):
        given = [each for each in arguments if each is not type(None)]
        return " or ".join(words(each, *metadata) for each in given)
    if origin is Literal:
        return _any_of(arguments)
    if origin is dict:
        of = arguments[1]
        return _limited(f"{words(of)} for each name", metadata)
    if origin is list:
        of = arguments[0]
        kind = "of sections" if _is_section(of) else f"of {words(of)}"
        return f"list {kind}"
    assert _is_section(hint), hint
    return "section"


def _is_section(hint: Any) -> bool:
    return any(True for _ in _within(hint))


def _limited(what: str, metadata: Iterable[Any]) -> str:
    """Return what a value is, with the bounds that pydantic checks."""
    return "".join(dict.fromkeys([what, *_bounds(metadata)]))


def _bounds(metadata: Iterable[Any]) -> Iterator[str]:
    for each in metadata:
        match each:
            case annotated_types.Gt(gt=bound):
                yield f" > {bound:g}"
            case annotated_types.Ge(ge=bound):
                yield f" >= {bound:g}"
            case annotated_types.MinLen(min_length=count):
                yield f", {count} or more"
            case FieldInfo(metadata=inner):
                yield from _bounds(inner)


def _any_of(names: Iterable[str]) -> str:
    *others_, last = (f"`{name}`" for name in names)
    return f"{', '.join(others_)} or {last}" if others_ else last


def _left_out(field: FieldInfo) -> str:
    if field.is_required():
        return _NEEDED
    return _shown(field.get_default(call_default_factory=True))


def _shown(value: Any) -> str:
    """Return a default as a case file would have it."""
    match value:
        case None | "":
            return "none"
        case Section():
            return "its own defaults"
        case tuple():
            return f"[{', '.join(map(_shown, value))}]"
        case dict() | list():
            assert not value
            return "none"
        case float():
            return f"{value:g}"
    return str(value)
