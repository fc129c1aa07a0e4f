"""A case as tables: rows of its text's entries, cells that lead back into the text.

Tables are made of the text alone, whatever is wrong with it, and have columns for what
stands there: a new key of case files needs nothing here. What is wrong is told by the
reader of case files; its lines are placed at the cells that they are about.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, get_args

from drakesep.case_file.others import MomentName, limitable
from drakesep.page.yaml_edit import Path, YamlText, in_one_line, typed_in, value_at
from drakesep.systems.checks import InputError
from drakesep.systems.model.parameters import parameters
from drakesep.units import split_unit, unit_of, with_unit


if TYPE_CHECKING:
    from drakesep.case_file.case import Case

_AXES = "xyz"
_UNITS = {
    "angular_stiffness_N_m_rad": "N m/rad",
    "angular_damping_N_m_s_rad": "N m s/rad",
    **{"stiffness_N_m": "N/m", "face_stiffness_N_m3": "N/m³", "dissipation_s_m": "s/m"},
    **{"density_kg_m3": "kg/m³", "altitude_km": "km"},
}
"""Of keys of case files whose units no parameter has."""
_SETTINGS = (
    *("name", "description", "pair", "orbit", "before_separation", "run"),
    *("recontact", "clearance", "objectives", "failure_cases", "failures"),
)
"""Sections whose leaves are rows of one table."""
_LIKE_ANOTHER = {
    "bodies": "a body",
    "attachments": "an attachment",
    "loads": "a load",
    "parts": "a part",
}
"""To what tables a row may be added that is like one of theirs."""
_FIRST = {
    "attachments": ("A", "B", "position_mm", "release_time_s"),
    "requirements": ("quantity", "when", "at_least", "at_most"),
    "bodies": ("mass_kg", "cg_mm", "inertia_kg_m2"),
    "springs": ("name", "law", "force_max_N", "stroke_mm"),
}
"""Keys whose columns come first."""


@dataclass(frozen=True, slots=True)
class Column:
    """A column: what its cells are."""

    title: str
    unit: str = ""
    numeric: bool = True
    """Whether its cells are numbers, which stand at the right."""


@dataclass(frozen=True, slots=True)
class Cell:
    """A value of the text."""

    path: Path | None
    """None: it cannot be changed."""
    text: str
    problem: str = ""
    """What is wrong with it."""


@dataclass(frozen=True, slots=True)
class Row:
    """An entry of a section."""

    name: str
    path: Path
    """For what removes it."""
    cells: tuple[Cell, ...]
    problem: str = ""
    """What is wrong with it, not with one of its cells."""
    removable: bool = False


@dataclass(frozen=True, slots=True)
class Table:
    """A section as a table, whose first column are names of rows."""

    key: str
    title: str
    first: str
    columns: tuple[Column, ...]
    rows: tuple[Row, ...]
    addable: str = ""
    """What may be added to it, in words."""


@dataclass(frozen=True)
class Problem:
    """A line of what is wrong with a case: the places that it names, and the words."""

    line: str

    @property
    def place(self) -> str:
        """As `place_of` names it; empty if it names none."""
        return self.line.partition(": ")[0] if ": " in self.line else ""

    def is_about(self, path: Path) -> bool:
        """Return whether it is about the value at a path itself."""
        place, _, said = self.line.partition(": ")
        above, last = place_of(path[:-1]), str(path[-1])
        if place == place_of(path):
            return True
        # ``attachments.one.spring: force_max_N: missing``
        return place == above != "" and said.replace(":", " ").split()[:1] == [last]

    def is_about_row(self, path: Path, names: Collection[str]) -> bool:
        """Return whether it is about a row, and of none of its cells.

        Args:
            path: to the row.
            names: by which it is known, too.
        """
        return self.place in (place_of(path), *names)


def place_of(path: Path) -> str:
    """Return a path as messages of the reader of case files name it."""
    return "".join(
        f" (entry {key + 1})" if isinstance(key, int) else f".{key}" for key in path
    ).lstrip(".")


def tables(
    text: YamlText, case: "Case | None" = None, problems: Sequence[str] = ()
) -> list[Table]:
    """Return the tables of a case.

    Args:
        text: of the case.
        case: what it says, if it says one: it tells nominal values and bounds.
        problems: what is wrong with it.
    """
    told = [Problem(line) for line in problems]
    maker = _Maker(text, told)
    return [table for table in maker.tables(case) if table.rows or table.addable]


class _Maker:
    """Makes tables of a text."""

    def __init__(self, text: YamlText, problems: Sequence[Problem]):
        self._text, self._problems = text, problems
        self._data: Mapping[str, Any] = (
            text.data if isinstance(text.data, Mapping) else {}
        )

    def tables(self, case: "Case | None") -> Iterator[Table]:
        bodies = self._named("bodies")
        attachments = self._named("attachments")
        parts = [
            (*path, "geometry", name)
            for path in bodies
            for name in _keys(self._at((*path, "geometry")))
        ]
        springs = [
            (*path, "spring")
            for path in attachments
            if isinstance(self._at((*path, "spring")), Mapping)
        ]
        yield self._of_mappings("bodies", "Bodies", "body", bodies, ("geometry",))
        yield self._of_mappings(
            *("attachments", "Attachments and releases", "attachment", attachments),
            ("spring",),
        )
        yield self._of_mappings("springs", "Springs", "attachment", springs)
        yield self._of_mappings("loads", "Loads", "load", self._named("loads"))
        yield self._dispersions(case)
        yield self._requirements()
        yield self._of_mappings("parts", "Geometry", "part", parts)
        yield self._settings()

    def _at(self, path: Path) -> Any:
        return value_at(self._data, path)

    def _named(self, section: str) -> list[Path]:
        return [(section, key) for key in _keys(self._data.get(section))]

    def _of_mappings(
        self,
        key: str,
        title: str,
        first: str,
        paths: Sequence[Path],
        without: tuple[str, ...] = (),
    ) -> Table:
        """Return a table with a row for each mapping, a column for each of its leaves.

        Args:
            key: of the table.
            title: of the table.
            first: what the names of its rows are.
            paths: to the mappings.
            without: keys of theirs that are left out.
        """
        leaves: dict[Path, None] = dict.fromkeys(
            leaf
            for name in _FIRST.get(key, ())
            for path in paths
            for leaf in _leaves(self._at(path))
            if leaf[0] == name
        )
        for path in paths:
            leaves |= dict.fromkeys(
                leaf for leaf in _leaves(self._at(path)) if leaf[0] not in without
            )
        leaves = dict.fromkeys(leaf for leaf in leaves if not _covered(leaf, leaves))
        columns = tuple(self._column(leaf, paths) for leaf in leaves)
        rows = tuple(self._row(path, leaves, removable=True) for path in paths)
        addable = _LIKE_ANOTHER.get(key, "") if rows else ""
        return Table(key, title, first, columns, rows, addable)

    def _row(self, path: Path, leaves: Iterable[Path], removable: bool = False) -> Row:
        name = _name_of(path)
        cells = tuple(self._cell((*path, *leaf)) for leaf in leaves)
        names = {name, self._text.shown((*path, "name"))} - {""}
        lines = [p.line for p in self._problems if p.is_about_row(path, names)]
        of_cells = {line for cell in cells for line in cell.problem.splitlines()}
        problem = "\n".join(line for line in lines if line not in of_cells)
        return Row(name, path, cells, problem, removable)

    def _column(self, leaf: Path, paths: Sequence[Path]) -> Column:
        values = [self._at((*path, *leaf)) for path in paths]
        numeric = not any(isinstance(v, str | list | Mapping) for v in values)
        *above, last = leaf
        if isinstance(last, int):
            *above, key = above
            quantity, unit = words_and_unit(str(key))
            return Column(_title((*above, quantity, _AXES[last])), unit)
        quantity, unit = words_and_unit(str(last))
        if not unit and above and (upper := words_and_unit(str(above[-1])))[1]:
            # An entry of an inertia, whose unit is in the key above.
            return Column(_title((*above[:-1], upper[0], last)), upper[1])
        return Column(_title((*above, quantity)), unit, numeric)

    def _cell(self, path: Path) -> Cell:
        return Cell(path, self._text.shown(path), self._problem(path))

    def _problem(self, path: Path) -> str:
        return "\n".join(p.line for p in self._problems if p.is_about(path))

    def _dispersions(self, case: "Case | None") -> Table:
        bounds = {} if case is None else _bounds(case)
        rows = []
        for path in self._named("dispersions"):
            name = str(path[-1])
            nominal, low, high = bounds.get(name, ("", "", ""))
            told = (Cell(None, nominal), Cell(None, low), Cell(None, high))
            cells = (self._cell(path), Cell(None, split_unit(name)[1].symbol), *told)
            rows.append(Row(name, path, cells, "", removable=True))
        columns = (
            *(Column("tolerance"), Column("unit", numeric=False)),
            *(Column("nominal"), Column("least"), Column("most")),
        )
        return Table(
            *("dispersions", "Tolerances", "parameter", columns, tuple(rows)),
            addable="a parameter",
        )

    def _requirements(self) -> Table:
        entries = self._data.get("requirements")
        count = len(entries) if isinstance(entries, list) else 0
        paths: list[Path] = [("requirements", i) for i in range(count)]
        keys = dict.fromkeys(("quantity", "when", "at_least", "at_most"))
        for path in paths:
            keys |= dict.fromkeys(_keys(self._at(path)))
        columns = [Column(_title((key,)), "", key.startswith("at_")) for key in keys]
        leaves = [(key,) for key in keys]
        rows = tuple(self._row(path, leaves, removable=True) for path in paths)
        return Table(
            *("requirements", "Requirements", "", tuple(columns), rows),
            addable="a requirement",
        )

    def _settings(self) -> Table:
        rows = []
        for section in _SETTINGS:
            value = self._data.get(section)
            leaves = (
                [(key,) for key in _keys(value)] if isinstance(value, Mapping) else [()]
            )
            for leaf in leaves if value is not None else ():
                path = (section, *leaf)
                quantity, unit = words_and_unit(str(path[-1]))
                cells = (self._cell(path), Cell(None, unit))
                rows.append(Row(_title((*path[:-1], quantity)), path, cells))
        columns = (Column("value", numeric=False), Column("unit", numeric=False))
        return Table("settings", "The rest", "what", columns, tuple(rows))


def _keys(value: Any) -> list[str]:
    """Return the keys of a mapping; those that are no text are left to the YAML."""
    mapping = value if isinstance(value, Mapping) else {}
    return [key for key in mapping if isinstance(key, str)]


def _name_of(path: Path) -> str:
    """Return the name of a row: of a spring, its attachment's; of others, their own."""
    if isinstance(path[-1], int):
        return str(path[-1] + 1)
    return str(path[-2] if path[-1] == "spring" else path[-1])


def _leaves(value: Any) -> Iterator[Path]:
    """Yield the paths to what stands in cells: values, components of vectors."""
    for key in _keys(value):
        entry = value[key]
        if isinstance(entry, Mapping) and entry:
            yield from ((key, *leaf) for leaf in _leaves(entry))
        elif _is_vector(entry):
            yield from ((key, i) for i in range(3))
        else:
            yield (key,)


def _is_vector(value: Any) -> bool:
    return (
        isinstance(value, list)
        and len(value) == 3
        and all(isinstance(x, int | float) for x in value)
    )


def _covered(leaf: Path, leaves: Iterable[Path]) -> bool:
    """Return whether a leaf of some rows is a mapping or vector in others."""
    return any(len(o) > len(leaf) and o[: len(leaf)] == leaf for o in leaves)


def _title(path: Path) -> str:
    return " ".join(str(key) for key in path).replace("_", " ")


def words_and_unit(key: str) -> tuple[str, str]:
    """Return a key of case files without its unit, and the symbol of that."""
    if key in _UNITS:
        return key.rpartition("_N_" if "_N_" in key else "_")[0], _UNITS[key]
    quantity, unit = split_unit(key)
    return quantity, unit.symbol


def _bounds(case: "Case") -> dict[str, tuple[str, str, str]]:
    """Return nominal, least and most of the dispersed parameters, by name with unit."""
    return {
        with_unit(each.name): (
            shown(unit_of(each.name).from_si(each.nominal)),
            shown(unit_of(each.name).from_si(each.bounds[0])),
            shown(unit_of(each.name).from_si(each.bounds[1])),
        )
        for each in case.box.dispersions
    }


def shown(value: float) -> str:
    """Return a number as it is read: six digits, no more than it has."""
    return f"{value:.6g}"


# What changes the text.


def changed(text: str, path: Path, typed: str) -> str:
    """Return the text with what was typed into a cell; nothing: without its entry.

    Raises:
        ValueError: what was typed is not YAML, or cannot stand there.
    """
    yaml = YamlText(text)
    if typed.strip():
        return yaml.with_value(path, typed_in(typed))
    if not yaml.has(path):
        return text
    if isinstance(path[-1], int) and path[0] != "requirements":
        raise InputError("must be a number, got nothing")
    return yaml.without(path)


def with_parameter(text: str, name: str, value: float) -> str:
    """Return the text with the nominal value of a parameter that stands in a file.

    Args:
        text: of a case.
        name: of the parameter, with its unit.
        value: in that unit.

    Raises:
        ValueError: the case file has no place for it.
    """
    yaml = YamlText(text)
    return yaml.with_value(_path_of(yaml, name), in_one_line(value))


def _path_of(yaml: YamlText, name: str) -> Path:
    """Return where a parameter stands."""
    owner, _, quantity = name.rpartition(".")
    places: list[Path] = [
        *(("bodies", owner), ("attachments", owner), ("loads", owner)),
        *(("bodies", body, "geometry", owner) for body in _at(yaml, "bodies")),
    ]
    if owner == "before_separation":
        places.append(("before_separation",))
    for attachment, section in _at(yaml, "attachments").items():
        spring = section.get("spring") if isinstance(section, Mapping) else None
        if isinstance(spring, Mapping) and spring.get("name") == owner:
            places.append(("attachments", attachment, "spring"))
    stem, _ = split_unit(quantity)
    suffix = quantity.removeprefix(stem)
    head, _, axis = stem.rpartition("_")
    for place in places:
        if yaml.has((*place, quantity)):
            return (*place, quantity)
        if axis in (*_AXES,) and yaml.has((*place, head + suffix)):
            return (*place, head + suffix, _AXES.index(axis))
        if head == "inertia" and yaml.has((*place, "inertia" + suffix)):
            return (*place, "inertia" + suffix, axis)
    raise InputError(f"{name}: stands nowhere in the case file")


def _at(yaml: YamlText, section: str) -> Mapping[str, Any]:
    value = yaml.data.get(section) if isinstance(yaml.data, Mapping) else None
    return value if isinstance(value, Mapping) else {}


def with_tolerance(text: str, name: str, tolerance: str) -> str:
    """Return the text with a tolerance of a parameter, another or a new one.

    Args:
        text: of a case.
        name: of the parameter, with its unit.
        tolerance: a number in that unit, a share such as ``5 %``, bounds.
    """
    return YamlText(text).with_value(("dispersions", name), typed_in(tolerance))


def with_requirement(text: str, **typed: str) -> str:
    """Return the text with one more requirement.

    Args:
        text: of a case.
        typed: what was typed for its keys; nothing: without the key.

    Raises:
        ValueError: something is not YAML.
    """
    yaml = YamlText(text)
    found = yaml.data.get("requirements") if isinstance(yaml.data, Mapping) else None
    count = len(found) if isinstance(found, list) else 0
    entries = {k: typed_in(value) for k, value in typed.items() if value.strip()}
    lines = [f"{key}: {value}" for key, value in entries.items()]
    in_line = count and yaml.in_line(("requirements",))
    value = f"{{{', '.join(lines)}}}" if in_line else "\n".join(lines)
    return yaml.with_value(("requirements", count), value)


def with_another(text: str, like: Path, name: str) -> str:
    """Return the text with one more entry of a section.

    Names of parts and springs must all differ: a body is added without its parts, and
    the spring of an attachment is named after it.

    Args:
        text: of a case.
        like: path to the entry that it is like.
        name: of the new one.

    Raises:
        ValueError: there is no name, or there is one of that name.
    """
    yaml = YamlText(text)
    path = (*like[:-1], name.strip())
    if not name.strip():
        raise InputError("name: must be given, got nothing")
    if yaml.has(path):
        raise InputError(f"name: {place_of(path)} is there already")
    entry = {k: v for k, v in value_at(yaml.data, like).items() if k != "geometry"}
    if isinstance(spring := entry.get("spring"), Mapping):
        entry["spring"] = {**spring, "name": f"{name.strip()}_spring"}
    return yaml.with_value(path, in_one_line(entry))


def rows_of(text: str, table: str) -> dict[str, Path]:
    """Return the paths to the rows of a table, by their names.

    Args:
        text: of a case.
        table: its key.
    """
    [found] = [each for each in tables(YamlText(text)) if each.key == table]
    return {row.name: row.path for row in found.rows}


def parameters_left(case: "Case | None") -> list[str]:
    """Return the parameters that have no tolerance yet, by names with units."""
    if case is None:
        return []
    held = set(case.box.names)
    return [with_unit(n) for n in parameters(case.separation) if n not in held]


def quantities() -> list[str]:
    """Return what requirements may be on."""
    return [*limitable()]


def moments() -> tuple[str, ...]:
    """Return when requirements may hold, by the names of case files."""
    return get_args(MomentName)


def without(text: str, path: Path) -> str:
    """Return the text without an entry."""
    return YamlText(text).without(path)
