"""Arguments and options that several commands have."""

import math
from pathlib import Path
from typing import Annotated

import typer

from drakesep.files import path_of
from drakesep.systems.checks import InputError


CaseArgument = Annotated[
    str, typer.Argument(help="A case file, or the name of a built-in case.")
]


def path_argument(text: str) -> Path:
    """Return a path; an empty one would be the working directory."""
    try:
        return path_of("output", text)
    except InputError as error:
        raise typer.BadParameter(str(error)) from error


OutputOption = Annotated[
    Path | None,
    typer.Option(
        "--output",
        "-o",
        parser=path_argument,
        metavar="PATH",
        help="Folder for the results; results/CASE/COMMAND if not given.",
    ),
]
ChangesOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        help="Change a parameter; can be repeated. `show` lists the names.",
    ),
]
WorkersOption = Annotated[
    int | None,
    typer.Option(
        min=1, help="Processes; one per core if not given; 1: this one alone."
    ),
]
ShareOption = Annotated[
    float | None,
    typer.Option(
        help="Of launches that must meet each requirement that names none, such as "
        "0.99865, which a campaign shows; if not given, every run must, which none "
        "does."
    ),
]
ConfidenceOption = Annotated[
    float | None,
    typer.Option(help="At which that share is to be shown; 0.9 if not given."),
]
ProofSecondsOption = Annotated[
    float | None,
    typer.Option(
        help="For each bound, about; what is known then is its bound. 60 if not given."
    ),
]
ResumeOption = Annotated[
    bool,
    typer.Option(
        "--resume",
        help="Go on from what the same study has finished in its folder, if it was "
        "interrupted or killed.",
    ),
]
QuietOption = Annotated[
    bool,
    typer.Option(
        "--quiet",
        help="Say nothing but errors and what was asked; the exit code says the rest.",
    ),
]
JsonOption = Annotated[
    bool,
    typer.Option("--json", help="Print a summary as one JSON object, and no tables."),
]


def parse_changes(texts: list[str]) -> dict[str, float]:
    """Return the values of `--set` by parameter name.

    Raises:
        ValueError: one is not NAME=VALUE, or a name stands twice.
    """
    values: dict[str, float] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals:
            raise InputError(f"--set: must be NAME=VALUE, got {text!r}")
        if name in values:
            raise InputError(f"--set {name}: must stand once, got it twice")
        values[name] = number(f"--set {name}", value)
    return values


def number(what: str, text: str) -> float:
    """Return the number that a text says; ``never`` is an infinite time.

    Raises:
        ValueError: it says none.
    """
    if text == "never":
        return math.inf
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{what}: must be a number, got {text!r}") from None
