"""The command that makes a report of results folders: report."""

from pathlib import Path
from typing import Annotated

import typer

from drakesep.cli.options import JsonOption, QuietOption
from drakesep.cli.report import Report


def report(
    folders: Annotated[
        list[Path],
        typer.Argument(
            metavar="FOLDER...",
            help="Folders of results, all of the same case: one report tells of all.",
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="The page; FOLDER_report.html beside the first folder if not given.",
        ),
    ] = None,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Make one HTML page of results folders, to be read, printed and signed.

    Nothing is flown.
    """
    with Report("report", quiet=quiet, as_json=as_json) as said:
        from drakesep.reports.html import write_report
        from drakesep.reports.studies import read_studies

        studies = read_studies(folders)
        said.add(case=studies.case.name)
        with said.aside.status("drawing"):
            written = write_report(studies, output)
        said.add(
            file=str(written.file),
            folders=[str(study.results.folder) for study in studies.all],
            verdict=written.verdict,
        )
        say_written(said, written.file)


def say_written(said: Report, file: Path) -> None:
    """Say where a report is."""
    said.console.print(f"The report is {file}: open it in a browser", markup=False)
