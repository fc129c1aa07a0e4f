"""Arguments are what their annotations say, or are refused by name.

Types alone are looked at here, before anything else: how large a number may be, how
many entries there are and which names are known, is checked where it matters.
"""

import functools
import inspect
import numbers
import types
import typing
from collections import abc
from collections.abc import Callable
from typing import Any, Literal, TypeVar, Union

import numpy as np

from drakesep.systems.checks import InputError


_Target = TypeVar("_Target", bound=Callable[..., Any])
_LARGEST = 2**63
"""Of whole numbers: beyond it numpy has none."""
_LONGEST = 60
"""Of what is shown of a value, in characters."""


def typed(target: _Target) -> _Target:
    """Let a function, or the constructor of a class, refuse arguments of another type.

    Raises:
        ValueError: as it is called, with the argument's name.
    """
    if isinstance(target, type):
        target.__init__ = _typed(target.__init__)  # type: ignore[misc]
        return target
    return _typed(target)  # type: ignore[return-value]


def _typed(function: Callable[..., Any]) -> Callable[..., Any]:
    by_place = [
        name
        for name, parameter in inspect.signature(function).parameters.items()
        if parameter.kind in _BY_PLACE
    ]
    of_record = function.__name__ == "__init__"

    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        checks = _checks(function)
        # Arguments that do not fit at all the function itself refuses.
        given = {**dict(zip(by_place, args, strict=False)), **kwargs}
        for name, value in given.items():
            if name in checks and not checks[name](value):
                owner = given.get("name") if of_record and name != "name" else None
                whose = f"{owner}: " if isinstance(owner, str) else ""
                raise InputError(whose + _fault(name, value, _wanted(function)[name]))
        return function(*args, **kwargs)

    return call


_BY_PLACE = (
    inspect.Parameter.POSITIONAL_ONLY,
    inspect.Parameter.POSITIONAL_OR_KEYWORD,
)


@functools.cache
def _checks(function: Callable[..., Any]) -> dict[str, Callable[[Any], bool]]:
    """Return what tells of each of a function's arguments whether its type is right."""
    return {name: _check(wanted) for name, wanted in _wanted(function).items()}


@functools.cache
def _wanted(function: Callable[..., Any]) -> dict[str, Any]:
    """Return the types of a function's arguments, but of ``*args`` and ``**kwargs``."""
    hints = typing.get_type_hints(function)
    single = (*_BY_PLACE, inspect.Parameter.KEYWORD_ONLY)
    return {
        name: hints[name]
        for name, parameter in inspect.signature(function).parameters.items()
        if name in hints and parameter.kind in single
    }


def _is(value: Any, wanted: Any) -> bool:
    """Return whether a value is of a type, and so are its entries."""
    return _check(wanted)(value)


@functools.cache
def _check(wanted: Any) -> Callable[[Any], bool]:
    """Return what tells whether a value is of a type, and so are its entries.

    Made once for each type: records are made by the thousand.
    """
    if wanted is Any:
        return lambda _: True
    check = _check_of(wanted)
    return lambda value: not isinstance(value, np.ma.MaskedArray) and check(value)


def _check_of(wanted: Any) -> Callable[[Any], bool]:
    origin, inner = typing.get_origin(wanted), typing.get_args(wanted)
    if wanted in _PLAIN:
        return _PLAIN[wanted]
    if origin in (Union, types.UnionType):
        some = [_check(one) for one in inner]
        return lambda value: any(check(value) for check in some)
    if origin is Literal:
        kinds = tuple(type(one) for one in inner)
        return lambda value: isinstance(value, kinds)
    if origin is np.ndarray:
        return _is_array
    if origin is tuple:
        return _check_of_tuple(inner)
    if origin in (abc.Sequence, abc.Iterable, abc.Collection):
        return _check_of_entries(origin, _check(inner[0]))
    if origin is abc.Mapping:
        of_key, of_value = map(_check, inner)
        return lambda value: (
            isinstance(value, abc.Mapping)
            and all(of_key(key) and of_value(one) for key, one in value.items())
        )
    if origin is abc.Callable:
        return callable
    if isinstance(wanted, type):
        return lambda value: _is_one(value, wanted)
    return lambda _: True


def _check_of_tuple(inner: tuple[Any, ...]) -> Callable[[Any], bool]:
    alike = _check(inner[0]) if inner[-1:] == (...,) else None
    each = [] if alike else [_check(one) for one in inner]

    def check(value: Any) -> bool:
        if not isinstance(value, tuple | list | np.ndarray):
            return False
        if alike:
            return all(map(alike, value))
        # How many there are is checked elsewhere.
        return all(one(entry) for one, entry in zip(each, value, strict=False))

    return check


def _check_of_entries(
    origin: Any, entry: Callable[[Any], bool]
) -> Callable[[Any], bool]:
    def check(value: Any) -> bool:
        if isinstance(value, str | bytes):
            return False
        if origin is abc.Sequence and isinstance(value, np.ndarray):
            return bool(np.ndim(value)) and all(map(entry, value))
        if not isinstance(value, origin):
            return False
        again = isinstance(value, abc.Collection)  # an iterator is not used up
        return not again or all(map(entry, value))

    return check


def _fault(name: str, value: Any, wanted: Any) -> str:
    """Return what is wrong with a value, or with the first entry that is."""
    origin, inner = typing.get_origin(wanted), typing.get_args(wanted)
    if origin in (Union, types.UnionType):
        kind = _kind_of(value)
        alike = [one for one in inner if kind and typing.get_origin(one) in kind]
        if len(alike) == 1:
            return _fault(name, value, alike[0])
    elif origin is abc.Mapping and isinstance(value, abc.Mapping):
        for key, entry in value.items():
            if not _is(key, inner[0]):
                return _fault(f"{name}: key", key, inner[0])
            if not _is(entry, inner[1]):
                return _fault(f"{name}: {key}", entry, inner[1])
    elif inner and origin in _SEQUENCES and _kind_of(value) == _SEQUENCES:
        kinds = inner if origin is tuple and inner[-1] is not ... else ()
        for i, entry in enumerate(value):
            kind = inner[0] if not kinds else kinds[min(i, len(kinds) - 1)]
            if not _is(entry, kind):
                return _fault(f"{name} (entry {i + 1})", entry, kind)
    fault = f"{name} must be {in_words(wanted)}, got {_shown(value)}"
    if isinstance(wanted, type):
        part = wanted.__name__.lower()
        if _is_one(getattr(value, part, None), wanted):
            fault += f"; it has one: .{part}"
    return fault


_SEQUENCES = (tuple, abc.Sequence, abc.Collection, abc.Iterable)


def _kind_of(value: Any) -> tuple[Any, ...]:
    """Return the types whose entries a value has; empty if it has none."""
    if isinstance(value, abc.Mapping):
        return (abc.Mapping,)
    if isinstance(value, list | tuple):
        return _SEQUENCES
    return ()


def _is_one(value: Any, kind: type) -> bool:
    if getattr(kind, "_is_protocol", False):  # half of one may do
        return not isinstance(value, _DATA)
    return isinstance(value, kind)


_DATA = (type(None), str, bytes, numbers.Number, list, tuple, abc.Mapping, np.ndarray)


def _is_number(value: Any) -> bool:
    if type(value) is float:
        return True
    if isinstance(value, bool | np.bool_) or not isinstance(value, numbers.Real):
        return False
    try:
        float(value)
    except OverflowError:
        return False
    return True


def _is_whole(value: Any) -> bool:
    whole = isinstance(value, numbers.Integral) and not isinstance(value, bool)
    return whole and -_LARGEST <= value < _LARGEST


def _is_array(value: Any) -> bool:
    """Return whether it is an array of numbers, or may be taken for one."""
    try:
        return np.asarray(value).dtype.kind in "iuf"
    except (TypeError, ValueError):
        return False


_PLAIN: dict[Any, Callable[[Any], bool]] = {
    float: _is_number,
    int: _is_whole,
    bool: lambda value: isinstance(value, bool | np.bool_),
    str: lambda value: isinstance(value, str),
    type(None): lambda value: value is None,
    None: lambda value: value is None,
}
_WORDS: dict[Any, str] = {
    float: "a number",
    int: "a whole number",
    bool: "True or False",
    str: "text",
    type(None): "None",
}


def in_words(wanted: Any) -> str:
    """Return a type as an error names it."""
    origin, inner = typing.get_origin(wanted), typing.get_args(wanted)
    if wanted in _WORDS:
        return _WORDS[wanted]
    if origin in (Union, types.UnionType):
        return " or ".join(dict.fromkeys(map(in_words, inner)))
    if origin is Literal:
        return f"one of {', '.join(map(str, inner))}"
    if origin is np.ndarray:
        return "an array of numbers"
    if origin is abc.Mapping:
        return f"a mapping of {in_words(inner[0])} to {in_words(inner[1])}"
    if origin is abc.Callable:
        return "a function"
    if inner and inner[-1] is not ... and origin is tuple:
        return f"({', '.join(map(in_words, inner))})"
    if inner and isinstance(origin, type):
        return f"a sequence, each {in_words(inner[0])}"
    name = getattr(wanted, "__name__", str(wanted))
    return f"{'an' if name[0] in 'AEIOU' else 'a'} {name}"


def _shown(value: Any) -> str:
    try:
        text = " ".join(repr(value).split())
    except ValueError:  # of a number with too many digits
        text = f"{type(value).__name__} of many digits"
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."
