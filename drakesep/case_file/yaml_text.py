"""YAML text to data; what would never end, or fill the memory, is refused first.

A few hundred bytes can stand for more data than any memory holds, by aliases of
aliases, for data that contain themselves, or for deeper nesting than a stack bears. All
that is seen in the stream of the text's events, before anything is made of them.
"""

from collections.abc import Iterable
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.constructor import SafeConstructor
from ruamel.yaml.error import YAMLError
from ruamel.yaml.events import (
    AliasEvent,
    CollectionEndEvent,
    CollectionStartEvent,
    Event,
    ScalarEvent,
)
from ruamel.yaml.nodes import Node

from drakesep.systems.checks import InputError


_DEEPEST = 50
"""Levels of mappings and lists; a case has eight."""
_REPEATED = 100_000
"""Entries for which aliases may stand, all together; those of a case for hundreds."""


class _Constructor(SafeConstructor):
    """Leaves times as text: a Python time has no more than six decimals of a second."""


_Constructor.add_constructor(
    "tag:yaml.org,2002:timestamp", SafeConstructor.construct_yaml_str
)


def read_yaml(text: str) -> Any:
    """Return the data of YAML text.

    Raises:
        ValueError: it is none, or stands for too much.
    """
    try:
        _check(YAML(typ="safe", pure=True).parse(text))
        yaml = YAML(typ="safe", pure=True)
        yaml.Constructor = _Constructor
        return yaml.load(text)
    except InputError:
        raise
    except YAMLError as error:
        raise InputError(f"must be YAML, got: {_in_one_line(error)}") from error
    # Of what says what it is and is something else, such as a month 13.
    except (ValueError, LookupError, TypeError, AttributeError) as error:
        raise InputError(f"must be YAML, got: {error}") from error


def read_nodes(text: str) -> Node | None:
    """Return the nodes of YAML text, which know where they stand; None of none.

    Args:
        text: that `read_yaml` has read.
    """
    root: Node | None = YAML(typ="safe", pure=True).compose(text)
    return root


def _check(events: Iterable[Event]) -> None:
    """Raise InputError if the events stand for too much.

    Of merge keys (``<<``) each alias counts with all entries of its mapping.
    """
    known: dict[str, int] = {}
    """Entries of what has a name that is complete."""
    named: dict[str, int] = {}
    """In which line names are given."""
    open_: list[tuple[str | None, int]] = []
    """Names of what is begun, and how many entries came before it."""
    entries = repeated = 0
    for event in events:
        line = event.start_mark.line + 1
        entries += 1
        anchor = getattr(event, "anchor", None)
        if anchor is not None and not isinstance(event, AliasEvent):
            if anchor in named:
                raise InputError(
                    f"&{anchor} must name one thing, got it in lines "
                    f"{named[anchor]} and {line}"
                )
            named[anchor] = line
        if isinstance(event, CollectionStartEvent):
            open_.append((event.anchor, entries))
            if len(open_) > _DEEPEST:
                raise InputError(
                    f"must be nested at most {_DEEPEST} levels deep, got more in line "
                    f"{line}"
                )
        elif isinstance(event, CollectionEndEvent):
            name, before = open_.pop()
            if name is not None:
                known[name] = entries - before
        elif isinstance(event, AliasEvent):
            name = event.anchor
            if name in (begun for begun, _ in open_):
                raise InputError(
                    f"*{name} in line {line} must not stand within what it stands for"
                )
            stands_for = known.get(name, 0)  # an unknown name is told of later
            entries += stands_for
            repeated += stands_for
            if repeated > _REPEATED:
                raise InputError(
                    f"aliases must stand for at most {_REPEATED} entries, got more in "
                    f"line {line} (*{name})"
                )
        elif isinstance(event, ScalarEvent) and event.anchor is not None:
            known[event.anchor] = 1


def _in_one_line(error: YAMLError) -> str:
    problem = getattr(error, "problem", None) or str(error)
    mark = getattr(error, "problem_mark", None)
    place = f" in line {mark.line + 1}, column {mark.column + 1}" if mark else ""
    return " ".join(problem.split()) + place
