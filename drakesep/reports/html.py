"""Reports of results folders as one HTML page that needs nothing beside it."""

import math
import re
from collections.abc import Iterable, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
from markupsafe import Markup, escape

from drakesep.files import path_of, write_text
from drakesep.reports import (
    campaign_part,
    clearance_part,
    computation_part,
    credibility_part,
    failures_part,
    motion_part,
    not_covered_part,
    proof_part,
    provenance_part,
    sensitivities_part,
    worst_cases_part,
)
from drakesep.reports.compliance import Matrix, matrix_of
from drakesep.reports.pdf import write_pdf
from drakesep.reports.separation_part import SeparationPart
from drakesep.reports.studies import Studies, read_studies
from drakesep.reports.summary import summary_of
from drakesep.results.folder import writable_folder
from drakesep.systems.argument_types import typed


_HOME = files("drakesep.reports") / "templates"


class Part(NamedTuple):
    """A part of a report, whose template is ``NAME.html``."""

    name: str
    title: str
    data: Any
    """What its template tells of; without, the part is left out."""


@typed
def report(
    folders: Sequence[str | Path] | str | Path,
    *,
    output: str | Path | None = None,
    pdf: bool = False,
) -> Path:
    """Write a report of results folders as one HTML page; nothing is flown.

    Args:
        folders: of results, all of the same case; or one. Together they become one
            report: of the design with its failure cases, a campaign, clearances.
        output: the page; if None, ``FOLDER_report.html`` beside the first folder.
        pdf: whether to write it as PDF beside the page, too.

    Returns:
        The page.

    Raises:
        ValueError: a folder holds no results, two are not of the same case, or a PDF
            is wanted and WeasyPrint is not there.
    """
    several = [folders] if isinstance(folders, str | Path) else folders
    return write_report(read_studies(several), output, pdf=pdf).file


class Written(NamedTuple):
    """A report that has been written."""

    file: Path
    pdf: Path | None
    """None: it was not asked for."""
    verdict: str
    """On everything that it tells of."""


def write_report(
    studies: Studies, output: str | Path | None = None, *, pdf: bool = False
) -> Written:
    """Write the page of some studies; how and where, `report` says."""
    beside = page_beside(studies.first.results.folder)
    file = (beside if output is None else path_of("output", output)).absolute()
    page, verdict = page_of(studies, file)
    writable_folder(file.parent)
    write_text(file, page)
    as_pdf = file.with_suffix(".pdf") if pdf else None
    if as_pdf is not None:
        write_pdf(page, as_pdf)
    return Written(file, as_pdf, verdict)


def page_beside(folder: Path) -> Path:
    """Return where the report of a folder stands unless it is said."""
    whole = folder.absolute()
    return whole.with_name(f"{whole.name}_report.html")


def page_of(studies: Studies, file: Path) -> tuple[str, str]:
    """Return the page of a report, and its verdict.

    For the same folders the page is the same, to the last byte.

    Args:
        studies: that are reported.
        file: that it will be written into: links lead from there.
    """
    matrix = matrix_of(studies)
    summary = summary_of(studies, matrix)
    template = _environment().get_template("page.html")
    page = template.render(
        studies=studies,
        case=studies.case,
        summary=summary,
        parts=[part for part in _parts(studies, matrix, file) if part.data],
        infinity=math.inf,
        style=_template("report.css"),
    )
    return page, summary.verdict


def _parts(studies: Studies, matrix: Matrix, page: Path) -> Iterable[Part]:
    separation = SeparationPart(studies.first)
    yield Part("compliance", "Compliance matrix", matrix)
    yield Part("separation", "The separation as analysed", separation)
    if separation.tolerances.table:
        yield Part("tolerances", "Tolerances and distributions", separation)
    worst_cases = worst_cases_part.of(studies)
    yield Part("worst_cases", "Worst cases, with their evidence", worst_cases)
    yield Part("proofs", "What is proven", proof_part.of(studies))
    yield Part("motion", "Motion over time", motion_part.of(studies))
    yield Part("failures", "Failure cases", failures_part.of(studies))
    yield Part("campaign", "Campaign", campaign_part.of(studies))
    clearance = clearance_part.of(studies, page)
    yield Part("clearance", "Clearance in single runs", clearance)
    yield Part("sensitivities", "Sensitivities", sensitivities_part.of(studies))
    yield Part("computation", "How it was computed", computation_part.of(studies))
    covered = not_covered_part.of(studies)
    yield Part("not_covered", "What the model does not cover", covered)
    yield Part("credibility", "Credibility", credibility_part.of(studies))
    provenance = provenance_part.of(studies)
    yield Part("provenance", "Provenance, and how to do it again", provenance)
    yield Part("case_file", "The case file", separation.lines)


def _environment() -> jinja2.Environment:
    loader = jinja2.FunctionLoader(_template)
    environment = jinja2.Environment(
        loader=loader,
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["broken"] = _broken
    return environment


def _template(name: str) -> str:
    return (_HOME / name).read_text(encoding="utf-8")


def _broken(text: str) -> Markup:
    """Return words that a line may break after underscores and dots, not in numbers."""
    places = r"(?<=[a-z0-9])(_|\.(?!\d))(?=\w)"
    return Markup(re.sub(places, r"\1<wbr>", str(escape(text))))
