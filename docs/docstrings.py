"""What docstrings say of fields, arguments and ports."""

import ast
import inspect
import re
import textwrap
from collections.abc import Callable
from typing import Any


def field_docs(record: type[Any]) -> dict[str, str]:
    """Return the docstrings below the fields of a class and of its bases."""
    docs: dict[str, str] = {}
    for each in reversed(record.__mro__[:-1]):
        if each.__module__.startswith("drakesep"):
            docs |= _own_field_docs(each)
    return docs


def _own_field_docs(record: type[Any]) -> dict[str, str]:
    try:
        source = textwrap.dedent(inspect.getsource(record))
    except OSError:  # made at run time
        return {}
    [tree] = ast.parse(source).body
    assert isinstance(tree, ast.ClassDef)
    docs = {}
    for field, below in zip(tree.body, tree.body[1:], strict=False):
        match field, below:
            case (
                ast.AnnAssign(target=ast.Name(id=name)),
                ast.Expr(value=ast.Constant(value=str(text))),
            ):
                docs[name] = " ".join(text.split())
    return docs


def listed(what: type[Any] | Callable[..., Any], heading: str) -> dict[str, str]:
    """Return what a docstring lists below a heading: names and what it says of each.

    Args:
        what: whose docstring.
        heading: such as ``Args``; nothing is listed if it is missing.
    """
    lines = iter((inspect.getdoc(what) or "").splitlines())
    for line in lines:
        if re.fullmatch(rf"{heading}.*:", line):
            break
    entries: dict[str, str] = {}
    name = ""
    for line in lines:
        if line and not line.startswith(" "):
            break
        begun = re.fullmatch(r" {4}(\w+): (.*)", line)
        if begun:
            name = begun[1]
            entries[name] = begun[2]
        elif line.strip() and name:
            entries[name] += f" {line.strip()}"
    return entries
