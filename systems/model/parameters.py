"""Every number of a separation that can be varied, by name.

A name is ``owner.quantity``: a body's ``payload.mass``, a spring's
``spring_1.stroke``, an attachment's ``attachment_1.release_time``, a load's
``thruster_1.factor``, the mated stack's ``before_separation.rate_x``. Values are in SI
and radians.
"""

import dataclasses
import math
from collections.abc import Iterator, Mapping
from typing import Any

from drakesep.systems.checks import InputError, check_finite, unknown
from drakesep.systems.model.inertia import ENTRIES
from drakesep.systems.model.separation import STACK, Separation
from drakesep.systems.model.springs import Spring


_Field = tuple[str, int | None]


def _vector(stem: str, field: str, axes: tuple[str, ...]) -> dict[str, _Field]:
    return {f"{stem}_{axis}": (field, i) for i, axis in enumerate(axes)}


_XYZ = ("x", "y", "z")
_RPY = ("roll", "pitch", "yaw")
_BODY: dict[str, _Field] = {
    "mass": ("mass", None),
    **_vector("cg", "p_BoBcm_B", _XYZ),
    **_vector("inertia", "I_BBcm_B", ENTRIES),
}
_ATTACHMENT: dict[str, _Field] = {
    **_vector("position", "p_AoPad_A", _XYZ),
    "release_time": ("release_time", None),
    "release_angle": ("release_angle", None),
}
_ANY_SPRING: dict[str, _Field] = {
    name: (name, None) for name in ("force_max", "stroke", "tilt_y", "tilt_z")
}
_SPRING: dict[str, _Field] = {**_ANY_SPRING, "design_mass": ("design_mass", None)}
_DISPLACEMENT_SPRING: dict[str, _Field] = {**_ANY_SPRING, "damping": ("damping", None)}
_LOAD: dict[str, _Field] = {
    **_vector("position", "p_BoQ_B", _XYZ),
    "start": ("start", None),
    "factor": ("factor", None),
}
_INITIAL: dict[str, _Field] = {
    **_vector("attitude", "rpy_WA", _RPY),
    **_vector("rate", "w_WA_A", _XYZ),
}


def _owners(
    separation: Separation,
) -> Iterator[tuple[str, Any, dict[str, _Field]]]:
    for body in separation.bodies:
        yield body.name, body, _BODY
    for attachment in separation.attachments:
        yield attachment.name, attachment, _ATTACHMENT
    for spring in separation.springs:
        timed = isinstance(spring, Spring)
        yield spring.name, spring, _SPRING if timed else _DISPLACEMENT_SPRING
    for load in separation.loads:
        yield load.name, load, _LOAD
    yield STACK, separation.initial, _INITIAL


def parameters(separation: Separation) -> dict[str, float]:
    """Return every parameter of the separation with its value, in SI.

    A release by time has no angle, and one by angle no time.
    """
    values = {}
    for name, owner, fields in _owners(separation):
        for quantity, (field, index) in fields.items():
            value = getattr(owner, field)
            value = value if index is None else value[index]
            if math.isfinite(value):
                values[f"{name}.{quantity}"] = value
    return values


def with_values(separation: Separation, values: Mapping[str, float]) -> Separation:
    """Return the separation with some of its parameters changed.

    Args:
        separation: the separation to vary.
        values: new values by parameter name, in SI.

    Raises:
        ValueError: a name is unknown, or a value is not finite or not physical.
    """
    known = parameters(separation)
    changes: dict[str, dict[str, float]] = {}
    for name, value in values.items():
        if name not in known:
            raise InputError(unknown("parameter", name, known))
        check_finite(name, value)
        owner, _, quantity = name.rpartition(".")
        changes.setdefault(owner, {})[quantity] = float(value)

    new = {
        name: _replace(owner, fields, changes.get(name, {}))
        for name, owner, fields in _owners(separation)
    }
    return dataclasses.replace(
        separation,
        bodies=tuple(new[body.name] for body in separation.bodies),
        attachments=tuple(
            dataclasses.replace(
                new[attachment.name],
                spring=attachment.spring and new[attachment.spring.name],
            )
            for attachment in separation.attachments
        ),
        loads=tuple(new[load.name] for load in separation.loads),
        initial=new[STACK],
    )


def _replace(
    owner: Any, fields: dict[str, _Field], changes: Mapping[str, float]
) -> Any:
    new: dict[str, Any] = {}
    for quantity, value in changes.items():
        field, index = fields[quantity]
        if index is None:
            new[field] = value
        else:
            entries = list(new.get(field, getattr(owner, field)))
            entries[index] = value
            new[field] = tuple(entries)
    return dataclasses.replace(owner, **new) if new else owner
