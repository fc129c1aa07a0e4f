"""The command that makes a report of results folders: report."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated

import typer

from drakesep.cli.answer import Answer
from drakesep.cli.options import JsonOption, QuietOption


if TYPE_CHECKING:
    from drakesep.reports.studies import Studies


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
    pdf: Annotated[
        bool,
        typer.Option("--pdf", help="Write it as PDF beside the page, too."),
    ] = False,
    check: Annotated[
        bool,
        typer.Option(
            "--check",
            help="Do each study again in a folder of its own, and compare: exits with "
            "1 if an answer differs.",
        ),
    ] = False,
    tolerance: Annotated[
        float | None,
        typer.Option(
            help="By how much a number may differ then, as a part of the larger "
            "magnitude; not by its last digit if not given.",
        ),
    ] = None,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Make one HTML page of results folders, to be read, printed and signed.

    Nothing is flown but with --check.
    """
    if tolerance is not None and not check:
        raise typer.BadParameter("needs --check", param_hint="--tolerance")
    with Answer("report", quiet=quiet, as_json=as_json) as answer:
        from drakesep.reports.html import write_report
        from drakesep.reports.studies import read_studies

        studies = read_studies(folders)
        answer.add(case=studies.case.name)
        with answer.aside.status("drawing"):
            written = write_report(studies, output, pdf=pdf)
        answer.add(
            file=str(written.file),
            pdf=None if written.pdf is None else str(written.pdf),
            folders=[str(study.results.folder) for study in studies.all],
            verdict=written.verdict,
            checked=[],
        )
        say_written(answer, written.file)
        if written.pdf is not None:
            answer.console.print(f"As PDF it is {written.pdf}", markup=False)
        if check:
            _check(answer, studies, tolerance)


def _check(answer: Answer, studies: "Studies", tolerance: float | None) -> None:
    """Do studies again, and say whether they come to the same."""
    from drakesep.reports.compare import compare
    from drakesep.studies.again import check_can_be_done_again, do_again

    for study in studies.all:  # before the first takes its time
        check_can_be_done_again(study.results)
    checked = []
    for study in studies.all:
        with TemporaryDirectory(prefix="drakesep-") as home:
            again = Path(home) / study.kind
            with answer.aside.status(f"doing {study.tag} again"):
                do_again(study.results, again)
                found = compare(study.results.folder, again, tolerance=tolerance)
        beyond = int(found.answers["beyond"].sum())
        folder = str(study.results.folder)
        checked.append({"folder": folder, "same": found.same, "differences": beyond})
        words = "comes to the same" if found.same else f"differs in {beyond} answers"
        answer.console.print(f"Done again, {study.tag} {words}", markup=False)
    answer.add(checked=checked)
    if not all(each["same"] for each in checked):
        answer.not_met("a study that is done again comes to something else")


def say_written(answer: Answer, file: Path) -> None:
    """Say where a report is."""
    answer.console.print(f"The report is {file}: open it in a browser", markup=False)
