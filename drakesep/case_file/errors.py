"""What is wrong with a case, in one line for each mistake."""

from typing import Any

from pydantic import ValidationError

from drakesep.systems.checks import InputError


UNNAMED = ""
"""Tag of a union's section, whose keys stand in no place of their own."""
_OF_KEY = "[key]"
"""By which pydantic says that it is the name of an entry itself."""


class CaseError(InputError):
    """A case cannot be read; the message names the key, what was wanted and got."""


def explained(error: ValidationError, source: str = "") -> CaseError:
    """Return what pydantic found, in our words; the source begins each line."""
    return CaseError("\n".join(source + _explain(dict(e)) for e in error.errors()))


def shown(value: Any) -> str:
    """Return a value as it stands in a message, cut short."""
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _explain(error: dict[str, Any]) -> str:
    place = "".join(
        f" (entry {part + 1})" if isinstance(part, int) else f".{part}"
        for part in error["loc"]
        if part not in (UNNAMED, _OF_KEY)
    ).lstrip(".")
    context = error.get("ctx", {})
    got = f", got {shown(error['input'])}"
    match error["type"]:
        case "missing":
            return f"{place}: missing"
        case "unexpected_keyword_argument":
            return f"{place}: unknown key"
        case "greater_than":
            message = f"must be > {context['gt']:g}{got}"
        case "greater_than_equal":
            message = f"must be >= {context['ge']:g}{got}"
        case "finite_number":
            message = f"must be finite{got}"
        case "float_type" | "int_type":
            message = f"must be a number{got}"
        case "string_type":
            message = f"must be text{got}"
        case "string_pattern_mismatch":
            message = f"must be made of letters, digits, _ and -{got}"
        case "model_type" | "dict_type":
            message = f"must be a mapping of keys{got}"
        case "value_error":
            message = str(context["error"])
        case _:
            wanted = error["msg"].replace("Input should be", "must be")
            message = f"{wanted[0].lower()}{wanted[1:]}{got}"
    return f"{place}: {message}" if place else message
