"""What all sections of a case file are made of."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    Strict,
    ValidationInfo,
    model_validator,
)

from drakesep.systems.checks import Vector3, unknown
from drakesep.units import unit_of


Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]*$")]


def _check_vector(value: Any) -> Any:
    if not isinstance(value, list | tuple) or len(value) != 3:
        raise ValueError(f"must be 3 numbers, got {value!r}")
    return value


def _as_three(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    if not value >= 0:
        raise ValueError(f"must be >= 0, got {value}")
    return (value,) * 3


def _in_folder_of_case(path: str, info: ValidationInfo) -> str:
    folder = (info.context or {}).get("folder")
    return path if folder is None else str(Path(folder, path))


Vector = Annotated[
    tuple[float, float, float], Strict(False), BeforeValidator(_check_vector)
]
Gains = Annotated[
    tuple[NotNegative, NotNegative, NotNegative],
    Strict(False),
    BeforeValidator(_check_vector),
    BeforeValidator(_as_three),  # the last is the first to run
]
"""Along x, y and z; one number stands for all three."""
Column = Annotated[tuple[float, ...], Strict(False)]
Rows = Annotated[tuple[Vector, ...], Strict(False)]
File = Annotated[str, AfterValidator(_in_folder_of_case)]
"""Its path, from the folder of the case file."""


class Section(BaseModel):
    """A mapping of keys, each of which is known."""

    model_config = ConfigDict(
        strict=True,
        frozen=True,
        extra="forbid",
        allow_inf_nan=False,
        # A key that is a word of Python has an underscore at its end there.
        alias_generator=lambda name: name.removesuffix("_"),
        serialize_by_alias=True,
    )

    @model_validator(mode="before")
    @classmethod
    def _check_keys(cls, data: Any) -> Any:
        if isinstance(data, dict):
            known = [name.removesuffix("_") for name in cls.model_fields]
            for key in data:
                if key not in known:
                    raise ValueError(unknown("key", key, known))
        return data


def files_of(value: Any) -> Iterator[str]:
    """Yield the paths of the files that a section names, and sections within it."""
    if isinstance(value, Section):
        for name in type(value).model_fields:
            entry = getattr(value, name)
            if name == "file":
                yield entry
            elif name == "from_":
                yield from entry or ()
            else:
                yield from files_of(entry)
    elif isinstance(value, dict | list):
        for entry in value.values() if isinstance(value, dict) else value:
            yield from files_of(entry)


def check_one(section: Section, keys: tuple[str, ...]) -> None:
    """Raise ValueError unless one of the keys is given."""
    got = [key for key in keys if getattr(section, key) is not None]
    if len(got) != 1:
        raise ValueError(
            f"must have one of {', '.join(keys)}, got {' and '.join(got) or 'none'}"
        )


def to_si(quantity: str, vector: Vector3) -> Vector3:
    """Return a vector in SI, from the unit that its quantity has at the edges."""
    unit = unit_of(quantity)
    x, y, z = vector
    return unit.to_si(x), unit.to_si(y), unit.to_si(z)
