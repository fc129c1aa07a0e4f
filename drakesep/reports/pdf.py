"""Reports as PDF, from the same page: by its print styles."""

import types
from pathlib import Path

from drakesep.files import written
from drakesep.systems.checks import InputError


def write_pdf(page: str, file: Path) -> None:
    """Write the page of a report as PDF: the same for the same page.

    Args:
        page: its HTML.
        file: that is written, whole or not at all.

    Raises:
        ValueError: WeasyPrint, or Pango that it draws letters with, is not there.
    """
    weasyprint = _weasyprint()
    within = weasyprint.URLFetcher(allowed_protocols=["data"])  # nothing is fetched
    document = weasyprint.HTML(string=page, url_fetcher=within)
    with written(file) as beside:
        document.write_pdf(beside, pdf_identifier=_SAME)


_SAME = b"drakesep"
"""In the place of one that is drawn at random."""


def _weasyprint() -> types.ModuleType:
    try:
        import weasyprint
    except (ImportError, OSError) as error:  # OSError: no Pango
        raise InputError(
            "pdf: needs WeasyPrint, which drakesep[pdf] installs, and the system's "
            f"library Pango; got: {error}"
        ) from None
    module: types.ModuleType = weasyprint
    return module
