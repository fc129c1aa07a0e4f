"""The parameters of a separation by name: all that records declare, in one walk.

A name is ``owner.quantity``: a body's ``payload.mass``, a spring's
``spring_1.stroke``, an attachment's ``attachment_1.release_time``, a load's
``thruster_1.factor``, a part's ``antenna.position_x``, the mated stack's
``before_separation.rate_x``. Values are in SI and radians. What a record's parameters
are stands in its table; see `drakesep.systems.model.parameter_table`.
"""

import dataclasses
import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError, check_finite, unknown
from drakesep.systems.model.parameter_table import Parameter, split_axis
from drakesep.systems.model.parts import Part
from drakesep.systems.model.separation import STACK, Attachment, Body, Separation


class ParameterName(NamedTuple):
    """A parameter's name, taken apart."""

    owner: str
    """Name of the body, attachment, spring, load or part, or the mated stack's."""
    stem: str
    axis: str
    """Empty if it has none."""

    @classmethod
    def of(cls, name: str) -> "ParameterName":
        """Return the parts of a name such as ``payload.cg_x``."""
        owner, _, quantity = name.rpartition(".")
        return cls(owner, *split_axis(quantity))


def owners(separation: Separation) -> Iterator[tuple[str, Any]]:
    """Yield the name of each record that has parameters, and the record."""
    for record in _records(separation):
        yield _owner_of(record), record


def _records(separation: Separation) -> tuple[Any, ...]:
    return (
        *separation.bodies,
        *separation.attachments,
        *separation.springs,
        *separation.loads,
        *parts_of(separation),
        separation.initial,
    )


def parts_of(separation: Separation) -> tuple[Part, ...]:
    """Return the parts of all bodies."""
    return tuple(part for body in separation.bodies for part in body.parts)


def places_of_parts(separation: Separation) -> tuple[str, ...]:
    """Return the names of the parameters that say where parts are in their bodies.

    No motion depends on them: they go with a run to where it is measured.
    """
    return names_of(parts_of(separation), Part.PARAMETERS.by_field)


def _owner_of(record: Any) -> str:
    return getattr(record, "name", STACK)


def names_of(records: Iterable[Any], fields: Collection[str]) -> tuple[str, ...]:
    """Return the names of the parameters in some fields of records, in their order.

    Args:
        records: of a separation.
        fields: of the records; one that holds no parameter adds no name.
    """
    return tuple(
        name for name, parameter, _ in _declared(records) if parameter.field in fields
    )


def _declared(records: Iterable[Any]) -> Iterator[tuple[str, Parameter, Any]]:
    """Yield the name of each parameter of records, its declaration and its record."""
    for record in records:
        owner = _owner_of(record)
        for parameter in record.PARAMETERS:
            yield f"{owner}.{parameter.quantity}", parameter, record


def declarations(separation: Separation) -> dict[str, Parameter]:
    """Return what is declared of each parameter of the separation, by name.

    A release by time has no angle, and one by angle no time; A, in whose frame the
    stack is placed, sits where it does; and a body whose joints do not let it has no
    spin.
    """
    return {name: parameter for name, parameter, _ in _of(separation)}


def _of(separation: Separation) -> Iterator[tuple[str, Parameter, float]]:
    """Yield the name of each parameter, its declaration and its value."""
    for name, parameter, record in _declared(_records(separation)):
        if _has(separation, record, parameter):
            yield name, parameter, parameter.of(record)


def _has(separation: Separation, record: Any, parameter: Parameter) -> bool:
    """Return whether a record has a parameter, see `declarations`."""
    if parameter.field in MATED:
        return record is not separation.body(separation.A)
    if parameter.field == SPIN:
        return separation.spins_on(record) is not None
    return not (parameter.optional and math.isinf(parameter.of(record)))


SPIN = "spin"
"""Field of bodies that says how they spin while mated."""
MATED = ("mated_offset", "mated_misalignment")
"""Fields of bodies that say how they are displaced while mated."""


@typed
def parameters(separation: Separation) -> dict[str, float]:
    """Return every parameter of the separation with its value, in SI.

    Those that `declarations` returns.
    """
    return {name: value for name, _, value in _of(separation)}


def check_read(names: Iterable[str], read: Collection[str], reader: str) -> None:
    """Raise InputError if a parameter is named that an engine does not read.

    Args:
        names: of parameters that vary.
        read: names of those that the engine reads.
        reader: the engine, in words.
    """
    for name in names:
        if name not in read:
            raise InputError(
                f"{name} must be a parameter that {reader} reads, got one that it does "
                "not: to vary it would have no effect"
            )


@typed
def with_values(separation: Separation, values: Mapping[str, float]) -> Separation:
    """Return the separation with some of its parameters changed.

    Args:
        separation: the separation to vary.
        values: new values by parameter name, in SI.

    Raises:
        ValueError: a name is unknown, a value is not finite or not physical, or a part
            would move that pushes others where it touches them. A time of release may
            be infinite: never.
    """
    records = dict(owners(separation))
    changes: dict[str, dict[str, float]] = {}
    for name, value in values.items():
        owner, _, quantity = name.rpartition(".")
        parameter = None  # looked up one by one: of all, most do not change
        if owner in records:
            parameter = records[owner].PARAMETERS.by_quantity.get(quantity)
        if parameter is None or not _has(separation, records[owner], parameter):
            raise InputError(unknown("parameter", name, declarations(separation)))
        never = parameter.optional and parameter.kind == "time"
        if not (never and value == math.inf):
            check_finite(name, value)
        changes.setdefault(owner, {})[quantity] = float(value)
    _check_pushing_parts(separation, values)

    new = {
        owner: _replace(record, changes.get(owner, {}))
        for owner, record in records.items()
    }
    return dataclasses.replace(
        separation,
        bodies=tuple(_with_parts(new[body.name], new) for body in separation.bodies),
        attachments=tuple(
            _with_spring(new[attachment.name], new)
            for attachment in separation.attachments
        ),
        loads=tuple(new[load.name] for load in separation.loads),
        initial=new[STACK],
    )


def _with_spring(attachment: Attachment, new: Mapping[str, Any]) -> Attachment:
    spring = attachment.spring and new[attachment.spring.name]
    if spring is attachment.spring:
        return attachment
    return dataclasses.replace(attachment, spring=spring)


def _with_parts(body: Body, new: Mapping[str, Any]) -> Body:
    parts = tuple(new[part.name] for part in body.parts)
    return body if parts == body.parts else dataclasses.replace(body, parts=parts)


def _check_pushing_parts(separation: Separation, names: Iterable[str]) -> None:
    if separation.recontact is None:
        return
    places = places_of_parts(separation)
    for name in names:
        if name in places:
            raise InputError(
                f"{name}: must stay as it is where parts push each other, got a "
                "recontact; leave one of both out"
            )


def _replace(record: Any, changes: Mapping[str, float]) -> Any:
    new: dict[str, Any] = {}
    for quantity, value in changes.items():
        parameter = record.PARAMETERS.by_quantity[quantity]
        if parameter.entry is None:
            new[parameter.field] = value
        else:
            entries = list(new.get(parameter.field, getattr(record, parameter.field)))
            entries[parameter.entry] = value
            new[parameter.field] = tuple(entries)
    return dataclasses.replace(record, **new) if new else record
