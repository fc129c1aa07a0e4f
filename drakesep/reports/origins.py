"""Where the values of a case come from: lines of its file, and what it says there.

A comment tells of what stands on its line; one on lines of its own, of what follows it
until a blank line. What has none is told by that of the section which it stands in.
"""

import fnmatch
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from drakesep.systems.model.separation import STACK, Separation
from drakesep.units import split_axis, unit_of, with_unit


_COMMENT = re.compile(r"""^(?:[^'"#]|'[^']*'|"[^"]*"|(?<!\s)\#)*?(?:^|\s)\#\s?(.*)$""")


@dataclass(frozen=True, slots=True)
class Origin:
    """Where a value comes from.

    Attributes:
        line: of the case file, from 1.
        note: the comment that tells of it; empty if none does.
        stands: whether the value stands there; else it is computed of what does, or a
            default.
    """

    line: int
    note: str
    stands: bool


class CaseText:
    """The text of a case file, in which values are found again."""

    def __init__(self, text: str):
        """Read a text; one that is no YAML has no values.

        Args:
            text: of the file.
        """
        self.lines = text.splitlines()
        try:
            self._data: Any = YAML(typ="rt").load(text)
        except YAMLError:
            self._data = None

    @property
    def header(self) -> str:
        """The comment that the file begins with; empty if there is none."""
        end = 0
        while end < len(self.lines) and _is_comment(self.lines[end]):
            end += 1
        return self._words(0, end)

    def of_parameter(self, name: str, separation: Separation) -> Origin | None:
        """Return where a parameter's value comes from; None if nothing tells.

        Args:
            name: without unit, as `parameters` has it.
            separation: that has it.
        """
        owner, _, quantity = name.rpartition(".")
        unit = unit_of(name).suffix
        stem, axis = split_axis(quantity)
        whole = with_unit(name).rpartition(".")[2]
        of_all = f"{stem}_{unit}" if unit else stem
        # A vector is a list, or a mapping by its axes.
        leaves = ((whole,), (of_all, axis), (of_all,))
        in_solid = tuple(("solid", *leaf) for leaf in leaves)
        return self._found(_home(owner, separation), (*leaves, *in_solid))

    def of_dispersion(self, name: str) -> Origin | None:
        """Return where a tolerance comes from; None if nothing tells.

        Args:
            name: of the parameter, with its unit.
        """
        section = self._data.get("dispersions") if self._is_map(self._data) else None
        keys = [str(key) for key in section or ()]
        fits = [key for key in keys if fnmatch.fnmatchcase(name, key)]
        key = name if name in keys else next(iter(fits), None)
        return None if key is None else self._found(("dispersions",), ((key,),))

    def of_section(self, *path: str) -> Origin | None:
        """Return where a section stands; None if nothing tells."""
        return self._found(path, ())

    def _found(
        self, home: Sequence[str], leaves: Sequence[Sequence[str]]
    ) -> Origin | None:
        """Return the origin of the first of some leaves that is there, else of home."""
        at_home = self._lines_to(home)
        if len(at_home) < len(home):
            return None
        for leaf in leaves:
            lines = self._lines_to([*home, *leaf])
            if len(lines) == len(home) + len(leaf):
                return Origin(lines[-1] + 1, self._note(lines), True)
        return Origin(at_home[-1] + 1, self._note(at_home), not leaves)

    def _lines_to(self, path: Sequence[str]) -> list[int]:
        """Return the lines of the keys on the way to a value, as far as they are."""
        lines: list[int] = []
        place = self._data
        for key in path:
            if not self._is_map(place) or key not in place:
                break
            merged = key not in place.lc.data  # by <<, into the section above
            lines.append(lines[-1] if merged else place.lc.key(key)[0])
            place = place[key]
        return lines

    @staticmethod
    def _is_map(value: Any) -> bool:
        return hasattr(value, "lc") and hasattr(value, "keys")

    def _note(self, lines: Sequence[int]) -> str:
        """Return the nearest comment that tells of what stands on the last line."""
        for line in reversed(lines):
            beside = _beside(self.lines[line])
            if note := beside or self._above(line):
                return note
        return ""

    def _above(self, line: int) -> str:
        """Return the comment above a line, no blank line between."""
        indent = _indent(self.lines[line])
        end = line
        while end > 0 and not _is_comment(self.lines[end - 1]):
            above = self.lines[end - 1]
            if not above.strip() or _indent(above) < indent:
                return ""
            end -= 1
        start = end
        while start > 0 and _is_comment(self.lines[start - 1]):
            start -= 1
        if start == end or start == 0 or _indent(self.lines[start]) != indent:
            return ""  # none, that of the file, or of what stands deeper
        return self._words(start, end)

    def _words(self, start: int, end: int) -> str:
        return " ".join(_beside(line) for line in self.lines[start:end]).strip()


def _is_comment(line: str) -> bool:
    return line.lstrip().startswith("#")


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())


def _beside(line: str) -> str:
    """Return the comment on a line; empty if there is none."""
    found = _COMMENT.match(line)
    return found[1].strip() if found else ""


def _home(owner: str, separation: Separation) -> list[str]:
    """Return the keys to the section of what has a parameter."""
    return next(_homes(owner, separation), [])


def _homes(owner: str, separation: Separation) -> Iterator[list[str]]:
    if owner == STACK:
        yield [STACK]
    for body in separation.bodies:
        if body.name == owner:
            yield ["bodies", owner]
        if any(part.name == owner for part in body.parts):
            yield ["bodies", body.name, "geometry", owner]
    for attachment in separation.attachments:
        if attachment.name == owner:
            yield ["attachments", owner]
        if attachment.spring is not None and attachment.spring.name == owner:
            yield ["attachments", attachment.name, "spring"]
    if any(load.name == owner for load in separation.loads):
        yield ["loads", owner]
