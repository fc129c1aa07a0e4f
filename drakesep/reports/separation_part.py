"""The separation as analysed: every value with its unit, and where it comes from."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from drakesep.reports.cells import EMPTY, Cell, Heading, Table, input_cell
from drakesep.reports.origins import CaseText, Origin
from drakesep.reports.pictures import Picture, stack_picture
from drakesep.reports.studies import Study
from drakesep.results.catalogue.names import STUDY
from drakesep.systems.equations.springs import law_name
from drakesep.systems.model.loads import Load
from drakesep.systems.model.orbit import Orbit
from drakesep.systems.model.parameters import owners, parameters
from drakesep.systems.model.parts import Box, Capsule, Cone, Mesh, Part, Shape, Sphere
from drakesep.systems.model.separation import (
    Attachment,
    Body,
    InitialMotion,
    Separation,
)
from drakesep.tables.columns import distribution_text, values_text
from drakesep.units import split_axis, unit_of, with_unit


_ACROSS = 8
"""Columns of numbers in a table: more are put below."""


@dataclass(frozen=True, slots=True)
class Source:
    """A line of the case file and its comment, as a report quotes them."""

    line: Cell
    note: Cell
    stands: bool


@dataclass(frozen=True, slots=True)
class SourcedTable:
    """A table whose rows say where their values come from.

    What tells of several rows stands below the first of them.
    """

    table: Table
    sources: Sequence[Sequence[Source]]
    zero: str = ""
    """Names of what is zero in all rows, and left out."""

    @property
    def shown(self) -> Sequence[tuple[Sequence[Any], Sequence[Source], Sequence[Cell]]]:
        """Of each row its cells, where these come from, and comments not yet told."""
        told: list[Any] = []
        rows = []
        for cells, sources in zip(self.table.rows, self.sources, strict=True):
            notes = {each.note.value: each.note for each in sources if each.note}
            rows.append(
                (cells, sources, [] if list(notes) == told else [*notes.values()])
            )
            told = list(notes)
        return rows


class SeparationPart:
    """What a report says of the separation and its tolerances."""

    def __init__(self, study: Study):
        """Read the case.

        Args:
            study: that has it.
        """
        self._study = study
        self._case = study.results.case
        text = study.record.case.get("text")
        self._text = None if text is None else CaseText(text)

    @property
    def separation(self) -> Separation:
        """The separation."""
        return self._case.separation

    @property
    def picture(self) -> Picture:
        """The mated stack."""
        return stack_picture(self.separation)

    @property
    def header(self) -> Cell:
        """What the case file says first."""
        said = "" if self._text is None else self._text.header
        return self._quoted(said)

    @property
    def lines(self) -> Sequence[str]:
        """Of the case file; none if it was made in Python."""
        return () if self._text is None else self._text.lines

    def _quoted(self, words: str) -> Cell:
        return Cell(words, f"{self._study.tag}/{STUDY}:case.text")

    def _source(self, origin: Origin | None) -> Source | None:
        if origin is None:
            return None
        place = f"{self._study.tag}/{STUDY}:case.text:{origin.line}"
        return Source(
            Cell(origin.line, place), self._quoted(origin.note), origin.stands
        )

    def _at(self, path: str, value: Any) -> Cell:
        return self._study.input("json", path, value=value)

    def _name(self, name: str) -> Cell:
        return self._study.input("name", name, value=name)

    @property
    def pairs(self) -> Table:
        """Which body leaves which, and where to."""
        rows = [
            [
                *(self._name(pair.B), self._name(pair.A)),
                *(
                    self._at(f"{path}direction.{i}", x)
                    for i, x in enumerate(pair.direction)
                ),
            ]
            for path, pair in zip(
                self._paths_of_pairs(), self.separation.pairs, strict=True
            )
        ]
        axes = [Heading(f"direction {axis}", "in A", True) for axis in "xyz"]
        return Table([Heading("leaves"), Heading("from"), *axes], rows)

    def _paths_of_pairs(self) -> Iterator[str]:
        yield "separation."
        for i in range(len(self.separation.others)):
            yield f"separation.others.{i}."

    @property
    def parameters(self) -> Sequence[tuple[str, Sequence[SourcedTable]]]:
        """Tables of parameters, by what has them."""
        titles: dict[str, list[tuple[str, Any]]] = {}
        for owner, record in owners(self.separation):
            titles.setdefault(_title(record), []).append((owner, record))
        return [(title, self._tables(mine)) for title, mine in titles.items()]

    def _tables(self, mine: Sequence[tuple[str, Any]]) -> list[SourcedTable]:
        values = parameters(self.separation)
        quantities: dict[str, None] = {}
        for owner, record in mine:
            for parameter in record.PARAMETERS:
                if f"{owner}.{parameter.quantity}" in values:
                    quantities[parameter.quantity] = None
        told = [
            q for q in quantities if any(values.get(f"{o}.{q}", 0.0) for o, _ in mine)
        ]
        zero = [q.replace("_", " ") for q in quantities if q not in told]
        groups = _split(told, _ACROSS) or [[]]
        tables = []
        for k, group in enumerate(groups):
            words = _WORDS.get(type(mine[0][1]), _of_pusher) if k == 0 else None
            tables.append(self._table(mine, group, values, words))
        last = tables[-1]
        tables[-1] = SourcedTable(last.table, last.sources, ", ".join(zero))
        return tables

    def _table(
        self,
        mine: Sequence[tuple[str, Any]],
        quantities: Sequence[str],
        values: Mapping[str, float],
        words: Callable[[Any, Separation], Mapping[str, str]] | None,
    ) -> SourcedTable:
        rows, sources = [], []
        said: Mapping[str, str] = {}
        for owner, record in mine:
            said = {} if words is None else words(record, self.separation)
            cells = [self._name(owner)]
            cells += [
                self._study.input("words", owner, k, value=text)
                for k, text in said.items()
            ]
            found: dict[str, Source] = {}
            for quantity in quantities:
                name = f"{owner}.{quantity}"
                cells.append(self._parameter(name, values.get(name)))
                origin = self._of(name) if name in values else None
                if origin is not None and values[name]:
                    found.setdefault(f"{origin.note.value} {origin.stands}", origin)
            rows.append(cells)
            sources.append(list(found.values()))
        headings = [Heading("name"), *map(Heading, said)]
        for quantity in quantities:
            stem, axis = split_axis(quantity)
            text = f"{stem} {axis}".replace("_", " ").strip()
            headings.append(
                Heading(text, unit_of(f"{mine[0][0]}.{quantity}").symbol, True)
            )
        return SourcedTable(Table(headings, rows), sources)

    def _parameter(self, name: str, value: float | None) -> Cell:
        if value is None:
            return EMPTY
        shown = unit_of(name).from_si(value)
        return self._study.input("parameter", with_unit(name), value=shown)

    def _of(self, name: str) -> Source | None:
        if self._text is None:
            return None
        return self._source(self._text.of_parameter(name, self.separation))

    @property
    def joints(self) -> Table:
        """The joints, with what holds: those alike in one row."""
        alike: dict[Any, list[int]] = {}
        for i, attachment in enumerate(self.separation.attachments):
            alike.setdefault(attachment.joint, []).append(i)
        rows = []
        for joint, places in alike.items():
            path = f"separation.attachments.{places[0]}.joint"
            names = ", ".join(self.separation.attachments[i].name for i in places)
            gains = [
                EMPTY if joint.rigid else self._gains(f"{path}.{k}", getattr(joint, k))
                for k in ("K_F", "D_F", "K_T", "D_T")
            ]
            kind = f"{joint.type}, {'rigid' if joint.rigid else 'by stiffness'}"
            rows.append([self._name(names), Cell(kind), *gains])
        headings = [
            *(Heading("attachments"), Heading("joint")),
            Heading("stiffness", "N/m", True),
            Heading("damping", "N s/m", True),
            Heading("angular stiffness", "N m/rad", True),
            Heading("angular damping", "N m s/rad", True),
        ]
        return Table(headings, rows)

    def _gains(self, path: str, gains: tuple[float, ...]) -> Cell:
        if len(set(gains)) == 1:
            return self._at(f"{path}.0", gains[0])
        text = ", ".join(input_cell(gain, "").text for gain in gains)
        return self._at(path, text)

    @property
    def surroundings(self) -> Sequence[tuple[str, Cell, str]]:
        """Of gravity, time and integration: what it is, its value and its unit."""
        separation, how = self.separation, self._case.integration
        duration = self._at("separation.duration", separation.duration)
        rows = [("run ends after", duration, "s")]
        if separation.orbit is not None:
            rows += self._orbit(separation.orbit)
        rows += [
            ("integrator", self._at("integration.scheme", how.scheme), ""),
            ("accuracy", self._at("integration.accuracy", how.accuracy), ""),
            ("largest step", self._at("integration.max_step", how.max_step), "s"),
            ("time limit", self._at("integration.time_limit", how.time_limit), "s"),
        ]
        return rows

    def _orbit(self, orbit: Orbit) -> list[tuple[str, Cell, str]]:
        def row(what: str, field: str, unit: str) -> tuple[str, Cell, str]:
            cell = self._at(f"separation.orbit.{field}", getattr(orbit, field))
            return what, cell, unit

        rows = [row("radius of the circular reference orbit", "radius", "m")]
        if orbit.horizontal_speed is not None:
            rows = [
                row("radius of the reference orbit at the start", "radius", "m"),
                row("speed across it", "horizontal_speed", "m/s"),
                row("climb rate", "climb_rate", "m/s"),
            ]
        if orbit.frame:
            rows += [
                row("inertial frame", "frame", ""),
                row("epoch of the start", "epoch", ""),
                row("time system", "time_system", ""),
            ]
        return rows

    @property
    def tolerances(self) -> SourcedTable:
        """How far each parameter may go, and how it is distributed in a campaign."""
        rows, sources = [], []
        for one in self._case.tolerance_set.box.dispersions:
            name, unit = with_unit(one.name), unit_of(one.name)
            sides = {
                side: self._study.input(
                    *("tolerance", name, side),
                    value=unit.from_si(getattr(one.sides, side)),
                )
                for side in ("minus", "plus")
            }
            distribution = self._study.input(
                *("tolerance", name, "distribution"), value=distribution_text(one)
            )
            values = self._study.input(
                *("tolerance", name, "values"), value=values_text(one)
            )
            nominal = self._parameter(one.name, one.nominal)
            rows.append(
                [
                    self._name(one.name),
                    *(nominal, sides["minus"], sides["plus"]),
                    *(
                        Cell(unit.symbol),
                        [distribution, values] if values else distribution,
                    ),
                ]
            )
            origin = None if self._text is None else self._text.of_dispersion(name)
            source = self._source(origin)
            sources.append([] if source is None else [source])
        headings = [
            Heading("parameter"),
            *(Heading(k, "", True) for k in ("nominal", "below by", "above by")),
            *(Heading("unit"), Heading("distribution")),
        ]
        return SourcedTable(Table(headings, rows), sources)

    @property
    def correlations(self) -> Sequence[str]:
        """What goes together, in words."""
        told = [
            f"{', '.join(map(with_unit, one.names))}: correlated by ranks in a "
            f"campaign, each two by {one.rank:g}"
            for one in self._case.correlations
        ]
        told += [
            f"{', '.join(map(with_unit, one.names))}: within an ellipsoid"
            for one in self._case.ellipsoids
        ]
        return told


def _split(names: Sequence[str], most: int) -> list[list[str]]:
    """Return names in groups of about the same length."""
    count = math.ceil(len(names) / most)
    size = math.ceil(len(names) / count) if count else 0
    return [list(names[k : k + size]) for k in range(0, len(names), size or 1)]


def _title(record: Any) -> str:
    for kind, title in _TITLES.items():
        if isinstance(record, kind):
            return title
    return "Springs and what else pushes"


_TITLES: Mapping[type[Any], str] = {
    Body: "Bodies",
    Attachment: "Attachments",
    Load: "Loads",
    Part: "Parts, of which clearances are measured",
    InitialMotion: "Motion of the mated stack before separation",
}


def _of_attachment(record: Attachment, _: Separation) -> Mapping[str, str]:
    spring = "" if record.spring is None else record.spring.name
    return {"A": record.A, "B": record.B, "spring": spring}


def _of_load(record: Load, _: Separation) -> Mapping[str, str]:
    return {"body": record.body, "axes": record.axes, "after": record.after or ""}


def _of_part(record: Part, separation: Separation) -> Mapping[str, str]:
    body = next(b.name for b in separation.bodies if record in b.parts)
    return {"body": body, "role": record.role, "shape": _shape_words(record.shape)}


def _shape_words(shape: Shape) -> str:
    mm = 1000.0

    def sizes(*lengths: float) -> str:
        return " \N{MULTIPLICATION SIGN} ".join(
            f"{mm * length:.10g}" for length in lengths
        )

    match shape:
        case Box(size=size):
            return f"box {sizes(*size)} mm"
        case Sphere(radius=radius):
            return f"sphere, radius {sizes(radius)} mm"
        case Capsule(radius=radius, length=length):
            return f"capsule, radius {sizes(radius)}, length {sizes(length)} mm"
        case Cone():
            ends = f"{sizes(shape.radius_aft)} aft, {sizes(shape.radius_fore)} fore"
            thickness = shape.thickness
            wall = "" if thickness is None else f", wall {sizes(thickness)}"
            if shape.radius_aft == shape.radius_fore:
                width = f"radius {sizes(shape.radius_aft)}"
                return f"cylinder, {width}, length {sizes(shape.length)}{wall} mm"
            return f"cone, radii {ends}, length {sizes(shape.length)}{wall} mm"
        case Mesh(file=file, scale=scale):
            return f"mesh {file.name}, scale {scale:.10g}"


def _of_pusher(record: Any, _: Separation) -> Mapping[str, str]:
    return {"law": law_name(record).replace("_", " ")}


def _nothing(_: Any, __: Separation) -> Mapping[str, str]:
    return {}


_WORDS: Mapping[type[Any], Callable[[Any, Separation], Mapping[str, str]]] = {
    Body: _nothing,
    Attachment: _of_attachment,
    Load: _of_load,
    Part: _of_part,
    InitialMotion: _nothing,
}
"""What is said of a record in words, by its kind; of what pushes, its law."""
