"""What a study has found, read from its folder: tables that answer, and worst cases.

The three answers to "how bad" stand side by side where a folder has them: the worst
that was found, the statistical bound of a campaign, the proven bound.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import pandas as pd


if TYPE_CHECKING:  # imports Drake
    from drakesep.results.reading import Results

_LIMIT = {
    **{"requirement": "requirement", "axis": "axis"},
    **{"sense": "", "limit": "limit", "unit": ""},
}
_PROVEN = {
    **{"proven_bound": "proven bound", "gap_percent": "gap, %", "proven": "proof"}
}
"""Of tables that have nothing to say there, where nothing was to be proven."""
_GROWTH = "growth"
"""Of all tolerances together, in words; a column that is made here."""
_REQUIREMENTS = {
    **_LIMIT,
    "nominal": "nominal",
    "worst": "worst found",
    **_PROVEN,
    "margin": "margin",
    _GROWTH: "violated at tolerances times",
    "verdict": "verdict",
}
_ANSWERS = {
    **_LIMIT,
    "worst_case_found": "worst found",
    "bound": "statistical bound",
    "bound_of": "of launches",
    "at_confidence": "at confidence",
    **_PROVEN,
    "decided_by": "decided by",
    "verdict": "verdict",
}
_PROOFS = {
    **_LIMIT,
    "objective": "objective",
    "found": "worst found",
    "found_by": "in",
    "proven_bound": "proven bound",
    "gap_percent": "gap, %",
    "verdict": "proof",
    "reason": "why no more",
}
_SHARES = {
    **_LIMIT,
    "share": "share required",
    "share_shown": "share shown",
    "failures": "beyond",
    "allowed": "allowed",
    "bound": "bound",
    "margin": "margin",
    "worst": "worst draw",
    "verdict": "verdict",
}
_EVIDENCE = {
    "objective": "objective",
    "worst": "worst",
    "in_drake": "in Drake",
    "unit": "",
    "found_by": "found by",
    "starts": "starts",
    "ended_there": "ended there",
    "at_bounds": "at bounds",
    "optimality_residual": "residual",
    "local_maxima": "maxima (ascents)",
}
_FAILURES = {
    **{"failure_case": "failure case", "verdict": "verdict"},
    **_LIMIT,
    **{"worst": "worst", "margin": "margin", "message": ""},
}
EVIDENCE = "evidence.csv"
_REMARKS = "remarks.csv"
_PARTS = (
    ("requirements.csv", "Requirements", _REQUIREMENTS),
    ("answers.csv", "Found, statistical and proven, side by side", _ANSWERS),
    ("proofs.csv", "What is proven, and what is not", _PROOFS),
    ("campaign.csv", "Shares of launches", _SHARES),
    (EVIDENCE, "Worst cases, and why to believe them", _EVIDENCE),
    ("failure_requirements.csv", "Failure cases", _FAILURES),
    ("failure_cases.csv", "Failure cases by themselves", _FAILURES),
    (_REMARKS, "Remarks", {"about": "about", "remark": "", "run": "in"}),
)
_MOST = 200
"""Rows that are shown of a table."""


class Part(NamedTuple):
    """A table as it is shown."""

    file: str
    title: str
    table: pd.DataFrame
    columns: Mapping[str, str]
    """That are shown, and how they are headed."""


@dataclass(frozen=True)
class Found:
    """What a study has found.

    Attributes:
        parts: tables that answer.
        worst: parameters of worst cases with their units, by objective.
        wrong: why the folder cannot be read; empty if it can.
    """

    parts: Sequence[Part] = ()
    worst: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    wrong: str = ""


def read_found(folder: Path) -> Found:
    """Return the tables that answer, of those that a folder has.

    Of a study that has none of these, all of its short ones.

    Args:
        folder: with results.
    """
    from drakesep.results.reading import read_results
    from drakesep.tables.growth_words import all_by

    try:
        results = read_results(folder)
        tables = [f for f in results.record.files if "row" in f]
        there = {str(file["name"]) for file in tables}
        parts = [
            Part(name, title, results.table(name), columns)
            for name, title, columns in _PARTS
            if name in there
        ]
        for part in parts:
            if _GROWTH in part.columns:
                rows = part.table.to_dict("records")
                part.table[_GROWTH] = [*map(all_by, rows)]
        if all(part.file == _REMARKS for part in parts):
            parts = _all(results)
        if "proofs.csv" not in there:
            parts = [*map(_without_proofs, parts)]
        elif "answers.csv" in there:  # where they stand beside what draws say
            parts[:1] = [_without_proofs(parts[0])]
        return Found(parts, _worst(results, parts))
    except (OSError, KeyError, ValueError) as error:
        return Found(wrong=f"{folder.name} cannot be read: {error}")


def _without_proofs(part: Part) -> Part:
    shown = {k: head for k, head in part.columns.items() if k not in _PROVEN}
    return part._replace(columns=shown)


def _all(results: "Results") -> list[Part]:
    """Return the tables of a study as they stand, but for long ones of its runs."""
    from drakesep.results.catalogue.files import FILES

    long = {kind.row for kind in FILES if kind.is_long}
    short = [f for f in results.record.files if "row" in f and f["row"] not in long]
    parts = []
    for file in short:
        name = str(file["name"])
        table = results.table(name).head(_MOST)
        parts.append(
            Part(name, str(file["what"]), table, {str(c): str(c) for c in table})
        )
    return parts


def _worst(results: "Results", parts: Sequence[Part]) -> dict[str, dict[str, float]]:
    """Return the parameters of the worst cases."""
    from drakesep.units import with_unit

    evidence = [part.table for part in parts if part.file == EVIDENCE]
    if not evidence:
        return {}
    names = [with_unit(name) for name in results.case.box.names]
    runs = results.table("worst_cases.csv").set_index("label")[names]
    worst = {}
    for objective in evidence[0]["objective"]:
        row = runs.loc[f"worst_{objective}"].to_numpy(float)
        worst[objective] = dict(zip(names, map(float, row), strict=True))
    return worst
