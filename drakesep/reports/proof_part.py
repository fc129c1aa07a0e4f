"""What is proven: bounds, over which set, and the certificate that says why."""

from collections.abc import Sequence
from typing import NamedTuple

from drakesep.analysis.bounds.answers import CONTRADICTED, NOT_COVERED
from drakesep.reports.cells import Cell, Columns, Row, Table, table_of
from drakesep.reports.pictures import Picture, proof_pictures
from drakesep.reports.studies import Studies, Study
from drakesep.studies.proofs import CERTIFICATE


_BOUNDS: Columns = {
    "requirement axis objective pair": "requirement or objective",
    "unit": "unit",
    "sense": "",
    "limit": "limit",
    "found": "worst found",
    "found_by": "in",
    "proven_bound": "proven bound",
    "gap_percent": ("gap", "%"),
    "verdict": "verdict",
    "reason": "why no more",
}
_UNCOVERED: Columns = {
    "requirement axis objective pair": "requirement or objective",
    "reason": "why there is no bound",
}


class ProofPart(NamedTuple):
    """Of the study that proves."""

    bounds: Table
    uncovered: Table
    certificate: str
    """The file, as seen from the folder of the results; empty: nothing is proven."""
    folder: Cell
    """Of the results."""
    excluded: bool
    """Whether the box has what searches leave out: inertias, corners of ellipsoids."""
    contradicted: Sequence[Row]
    pictures: Sequence[Picture]


def of(studies: Studies) -> ProofPart | None:
    """Return what a report says of proven bounds; None if none were asked for."""
    proving = [study for study in studies.all if study.has("proofs.csv")]
    if not proving:
        return None
    [study] = proving
    rows = study.rows("proofs.csv")
    covered = [row for row in rows if row.get("verdict") != NOT_COVERED]
    case = studies.case
    return ProofPart(
        bounds=table_of(covered, _BOUNDS),
        uncovered=table_of(
            [row for row in rows if row.get("verdict") == NOT_COVERED], _UNCOVERED
        ),
        certificate=CERTIFICATE if study.has(CERTIFICATE) else "",
        folder=Cell(study.tag),
        excluded=bool(case.share_unphysical or case.ellipsoids),
        contradicted=[row for row in rows if row.get("verdict") == CONTRADICTED],
        pictures=_pictures(study) if covered else (),
    )


def _pictures(study: Study) -> Sequence[Picture]:
    return tuple(proof_pictures(study))
