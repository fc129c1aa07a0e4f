"""The command that hands a run over to other programs: export."""

from pathlib import Path
from typing import Annotated

import typer

from drakesep.cli.answer import Answer
from drakesep.cli.options import JsonOption, QuietOption, number, path_argument
from drakesep.systems.checks import InputError


def export(
    folder: Annotated[Path, typer.Argument(help="A folder of results.")],
    format_: Annotated[
        str,
        typer.Option(
            "--format",
            help="oem, aem: CCSDS messages; mat, parquet, json: arrays; csv: tables of "
            "the handover alone.",
        ),
    ],
    run: Annotated[
        str | None,
        typer.Option(
            help="Label of the run; the nominal or the changed one if not given."
        ),
    ] = None,
    epoch: Annotated[
        str | None,
        typer.Option(help="Of t = 0, in ISO 8601, if the case has none."),
    ] = None,
    frame: Annotated[
        str | None,
        typer.Option(help="Inertial, such as EME2000, if the case has none."),
    ] = None,
    plane: Annotated[
        str | None,
        typer.Option(
            metavar="I,NODE,U",
            help="How the orbit lies, if the case does not say it: inclination, right "
            "ascension of the ascending node, argument of latitude at the start, deg.",
        ),
    ] = None,
    time_system: Annotated[
        str | None,
        typer.Option(help="Of the epoch; that of the case, or UTC, if not given."),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            parser=path_argument,
            metavar="PATH",
            help="Folder for the files; FOLDER_handover if not given.",
        ),
    ] = None,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Hand states and attitudes of every body over: to OEM, AEM, MAT, parquet, JSON.

    Beside them stands handover.csv, the states after separation. Nothing is flown.
    """
    with Answer("export", quiet=quiet, as_json=as_json) as answer:
        from drakesep.reports.export import export

        name = folder.resolve().name
        files = export(
            folder,
            format_,  # type: ignore[arg-type]  # it says which there are
            run=run,
            epoch=epoch,
            frame=frame,
            plane=None if plane is None else _angles(plane),
            time_system=time_system,
            output=output or folder.parent / f"{name}_handover",
        )
        answer.add(files=[str(file.absolute()) for file in files])
        for file in files:
            answer.console.print(f"{file}", markup=False)


def _angles(text: str) -> list[float]:
    parts = text.split(",")
    if len(parts) != 3:
        raise InputError(f"--plane: must be three angles I,NODE,U, deg, got {text!r}")
    return [number("--plane", part) for part in parts]
