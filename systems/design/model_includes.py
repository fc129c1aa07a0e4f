"""What model files include: looked for beside the file that names it, and checked.

Drake's parser looks beside the first file alone, and finds no include of an include in
another folder, or takes another file of that name; what is no model it leaves out
without a word, and of a file that includes itself it makes no end.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.dom import expatbuilder
from xml.parsers.expat import ExpatError

from drakesep.systems.checks import InputError


_ROOTS = ("sdf", "robot", "mujoco", "mujocoinclude")
"""Of model files."""


def text_with_includes(file: Path, copies: Path) -> str | None:
    """Return the text of a model file by which Drake's parser finds all it includes.

    An include is looked for beside the file that names it; MJCF's, as MuJoCo does,
    first beside the file that is not included by another MJCF.

    Args:
        file: where the model is.
        copies: a folder for copies of included files by which the parser finds theirs.

    Returns:
        None if the parser finds everything as it stands.

    Raises:
        ValueError: an include is not there, no model, or includes what includes it.
    """
    return _text(file, copies, above=(), beside=None)


def _text(
    file: Path, copies: Path, above: tuple[Path, ...], beside: Path | None
) -> str | None:
    """Return the text of a file.

    Args:
        file: where it is.
        copies: folder for copies.
        above: the files that include each other, and it.
        beside: the folder of the first MJCF, if it is included by one.
    """
    above = (*above, file)
    name, included = above[0].name, len(above) > 1
    try:
        # Prefixes such as drake: stay as they are.
        document: Any = expatbuilder.parse(str(file), namespaces=False)
    except (OSError, ExpatError) as error:
        if not included:
            return None  # the parser has more to say of it
        raise _NoModel(name, file.name, f": {error}") from error
    root = document.documentElement.tagName
    if included and root not in _ROOTS:
        raise _NoModel(name, file.name, f" <{root}>")
    if root.startswith("mujoco"):
        beside = beside or file.parent
        folders = [beside, file.parent]
    else:
        folders = [file.parent]
    looked_in = beside or above[0].parent  # by the parser
    changed = False
    for place in _places(document):
        uri = place.nodeValue.strip().removeprefix("file://")
        if "://" in uri:
            continue  # refused by the parser, which knows no packages
        there = [path for folder in folders if (path := folder / uri).exists()]
        if not there:
            raise _NoModel(name, uri, " no file")
        model = there[0] / "model.sdf" if there[0].is_dir() else there[0]
        if model.resolve() in [each.resolve() for each in above]:
            raise InputError(f"{name}: must not include itself, got {model.name}")
        text = _text(model, copies, above, beside)
        if text is not None:
            model = copies / str(len(list(copies.iterdir()))) / model.name
            model.parent.mkdir()
            model.write_text(text, encoding="utf-8")
        elif there[0] == looked_in / uri:
            continue
        place.nodeValue = str(model)
        changed = True
    return document.toxml() if changed else None


def _places(document: Any) -> Iterator[Any]:
    """Yield the nodes of a document whose values say what is included."""
    for include in document.getElementsByTagName("include"):
        yield from filter(None, [include.getAttributeNode("file")])
        for uri in include.getElementsByTagName("uri")[:1]:
            yield from [x for x in uri.childNodes if x.nodeType == x.TEXT_NODE][:1]


class _NoModel(InputError):
    """What is included is no model."""

    def __init__(self, name: str, include: str, got: str):
        super().__init__(f"{name}: include {include} must be a model, got{got}")
