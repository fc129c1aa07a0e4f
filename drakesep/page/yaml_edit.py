"""YAML text changed in one place, and left as it stands in all others.

Comments, order, anchors and the way numbers are written stay: what is replaced is the
stretch of text where a value stands. A path leads to a value by keys of mappings and
indices of lists, ``("bodies", "payload", "mass_kg")``.
"""

import io
import re
from collections.abc import Iterator
from typing import Any, TypeAlias

from ruamel.yaml import YAML
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from drakesep.case_file.yaml_text import read_nodes, read_yaml
from drakesep.systems.checks import InputError


Path: TypeAlias = tuple[str | int, ...]

_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
_ANY = "k"
"""A key."""
_INDENT = 2
"""Of a mapping within another, where there is none to follow."""


def value_at(data: Any, path: Path) -> Any:
    """Return a value of nested mappings and lists; None if there is none.

    Args:
        data: the outermost.
        path: keys and numbers that lead to it.
    """
    for key in path:
        try:
            data = data[key]
        except (KeyError, IndexError, TypeError):
            return None
    return data


class YamlText:
    """A YAML text, and where in it values stand."""

    def __init__(self, text: str):
        """Read it.

        Raises:
            ValueError: it is not YAML.
        """
        self.text = text
        self.data = read_yaml(text)
        self._root = read_nodes(text)

    def has(self, path: Path) -> bool:
        """Return whether there is a value."""
        return self._node(path) is not None

    def in_line(self, path: Path) -> bool:
        """Return whether a value is a mapping or list within brackets."""
        node = self._node(path)
        return node is not None and _is_in_line(node)

    def shown(self, path: Path) -> str:
        """Return a value as it stands, in one line; empty if there is none."""
        node = self._node(path)
        if isinstance(node, ScalarNode):
            return str(node.value)
        value = value_at(self.data, path)  # of a mapping, it may be merged from another
        return "" if value is None else in_one_line(value)

    def with_value(self, path: Path, value: str) -> str:
        """Return the text with another value, or with one where there is none.

        Args:
            path: to the value. Mappings on its way that are missing are made; a list
                gets a new last entry by the index after its last.
            value: YAML in one line, as from `in_one_line`.
        """
        node = self._node(path)
        if node is not None:
            return self._replaced(path, node, value)
        known = len(path) - 1
        while self._node(path[:known]) is None:
            known -= 1
        return self._inserted(path[:known], path[known:], value)

    def without(self, path: Path) -> str:
        """Return the text without an entry, nor the mapping that had nothing else.

        Raises:
            ValueError: it does not stand there itself.
        """
        if not self.has(path):  # a second click would take out what is beside it
            if value_at(self.data, path) is None:
                raise InputError(f"{path[-1]} is not there any more")
            raise InputError(f"{path[-1]} is merged from elsewhere: change the YAML")
        parent = self._node(path[:-1])
        entries = [] if parent is None else _entries(parent)
        if len(entries) == 1 and len(path) > 1:
            return self.without(path[:-1])
        [i] = [i for i, (key, _, _) in enumerate(entries) if key == path[-1]]
        _, begin, value = entries[i]
        if parent is not None and _is_in_line(parent):
            return self._without_in_flow(entries, i)
        start = self.text.rfind("\n", 0, begin) + 1
        if isinstance(parent, MappingNode) and self.text[start:begin].strip():
            # The first key after the dash of a list's entry.
            return self._cut(begin, entries[i + 1][1])
        return self._cut(start, self._end_of_line(_end(value)))

    # Where things stand.

    def _node(self, path: Path) -> Node | None:
        node: Node | None = self._root
        for key in path:
            if node is None:
                return None
            node = next((v for k, _, v in _entries(node) if k == key), None)
        return node

    def _end_of_line(self, index: int) -> int:
        """Return where the line after that of a place begins."""
        end = self.text.find("\n", index)
        return len(self.text) if end < 0 else end + 1

    def _cut(self, start: int, end: int, instead: str = "") -> str:
        return self.text[:start] + instead + self.text[end:]

    # How they are changed.

    def _replaced(self, path: Path, node: Node, value: str) -> str:
        start, end = node.start_mark.index, _end(node)
        if node.anchor is not None:
            raise InputError("has an anchor that others refer to: change the YAML")
        if self.text[start:end] == "" and isinstance(path[-1], str):
            value = f" {value}"  # right after the colon
        parent = self._node(path[:-1])
        if isinstance(parent, MappingNode):
            key = next(k for k, _ in parent.value if k.value == path[-1])
            if "\n" in self.text[key.end_mark.index : start]:  # a block, below its key
                return self._cut(key.end_mark.index, end, f": {value}")
        return self._cut(start, end, value)

    def _inserted(self, known: Path, missing: Path, value: str) -> str:
        parent = self._node(known)
        if isinstance(parent, ScalarNode) or (parent is None and known):
            raise InputError("stands in the way: change the YAML")
        if len(missing) > 1 and value_at(self.data, (*known, missing[0])) is not None:
            raise InputError("is merged from elsewhere (<<): change the YAML")
        entries = [] if parent is None else _entries(parent)
        if parent is not None and (_is_in_line(parent) or not entries):
            end = _end(parent) - 1
            comma = ", " if entries else ""
            return self._cut(end, end, comma + _nested_in_line(missing, value))
        if not entries:
            return self.text + "".join(_nested(missing, value, 0))
        assert parent is not None
        first = entries[0][1]
        indent = first - (self.text.rfind("\n", 0, first) + 1)
        end = self._end_of_line(_end(parent))
        lines = "".join(_nested(missing, value, indent))
        if not known:
            end, lines = len(self.text.rstrip()) + 1, f"\n{lines}"
        before = self.text[:end]
        if not before.endswith("\n"):
            before += "\n"
        return before + lines + self.text[end:]

    def _without_in_flow(
        self, entries: list[tuple[str | int, int, Node]], i: int
    ) -> str:
        _, start, value = entries[i]
        if i:
            return self._cut(_end(entries[i - 1][2]), _end(value))
        return self._cut(start, entries[1][1] if len(entries) > 1 else _end(value))


def _is_in_line(node: Node) -> bool:
    """Return whether a mapping or list stands within brackets."""
    return bool(getattr(node, "flow_style", False))


def _entries(node: Node) -> list[tuple[str | int, int, Node]]:
    """Return the entries of a mapping or list: key, where it begins, value."""
    if isinstance(node, MappingNode):
        return [(str(k.value), k.start_mark.index, v) for k, v in node.value]
    if isinstance(node, SequenceNode):
        starts = [_start_of_entry(node, v) for v in node.value]
        return [*zip(range(len(starts)), starts, node.value, strict=True)]
    return []


def _start_of_entry(node: SequenceNode, entry: Node) -> int:
    """Return where an entry of a list begins: of a block, at its dash."""
    start: int = entry.start_mark.index
    if _is_in_line(node):
        return start
    buffer: str = entry.start_mark.buffer
    return buffer.rfind("-", 0, start) if buffer else start


def _end(node: Node) -> int:
    """Return where the text of a value ends: of a block, with its last value."""
    if isinstance(node, ScalarNode) or _is_in_line(node) or not node.value:
        end: int = node.end_mark.index
        if isinstance(node, ScalarNode) and node.style in ("|", ">"):
            return end - 1
        return end
    return max(_end(value) for _, _, value in _entries(node))


def _nested(path: Path, value: str, indent: int) -> Iterator[str]:
    """Yield the lines of a value below its keys."""
    space = " " * indent
    match path:
        case (int(),):
            first, *others = value.splitlines()
            yield f"{space}- {first}\n"
            yield from (f"{space}  {line}\n" for line in others)
        case (key,):
            yield f"{space}{_key(key)}: {value}\n"
        case (int(), *rest):
            first, *others = _nested(tuple(rest), value, indent + _INDENT)
            yield f"{space}- {first.lstrip()}"
            yield from others
        case (key, *rest):
            yield f"{space}{_key(key)}:\n"
            yield from _nested(tuple(rest), value, indent + _INDENT)


def _nested_in_line(path: Path, value: str) -> str:
    *_, last = path
    text = value if isinstance(last, int) else f"{_key(last)}: {value}"
    for key in reversed(path[:-1]):
        inner = f"{{{text}}}"
        text = inner if isinstance(key, int) else f"{_key(key)}: {inner}"
    return text


def _key(key: str | int) -> str:
    return in_one_line(str(key))


def in_one_line(value: Any) -> str:
    """Return a value as YAML in one line, wherever it is to stand."""
    if isinstance(value, str) and value == "":
        return "''"
    stream = io.StringIO()
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = True
    yaml.width = 1_000_000
    yaml.representer.sort_base_mapping_type_on_output = False
    # In a list, a mapping of one key would be without its brackets.
    yaml.dump({_ANY: value}, stream)
    return stream.getvalue().strip().removeprefix(f"{{{_ANY}: ")[:-1]


def typed_in(text: str) -> str:
    """Return what was typed as YAML that can stand anywhere in one line.

    A number stays as it was typed.

    Raises:
        ValueError: it is not YAML.
    """
    text = text.strip()
    if _NUMBER.fullmatch(text):
        return text
    value = read_yaml(text)
    if value is None and text not in ("null", "~"):
        raise InputError("must have a value, got none")
    return in_one_line(value)
