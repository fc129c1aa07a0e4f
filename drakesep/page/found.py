"""What a study has found, read from its folder: worst cases, verdicts, evidence."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pandas as pd
from nicegui import run, ui

from drakesep.page.frames import show_frame
from drakesep.systems.checks import InputError


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
_GROWTH = "growth"
"""Of all tolerances together, in words; a column that is made here."""
_REQUIREMENTS = {
    "requirement": "requirement",
    "axis": "axis",
    "sense": "",
    "limit": "limit",
    "unit": "",
    "nominal": "nominal",
    "worst": "worst",
    "margin": "margin",
    _GROWTH: "violated at tolerances times",
    "verdict": "verdict",
}
_FAILURES = {
    "failure_case": "failure case",
    "verdict": "verdict",
    "requirement": "requirement",
    "axis": "axis",
    "sense": "",
    "limit": "limit",
    "unit": "",
    "worst": "worst",
    "margin": "margin",
    "message": "",
}
_SHARES = {
    "requirement": "requirement",
    "axis": "axis",
    "sense": "",
    "limit": "limit",
    "unit": "",
    "share": "share required",
    "share_shown": "share shown",
    "failures": "beyond",
    "allowed": "allowed",
    "bound": "bound",
    "margin": "margin",
    "worst": "worst draw",
    "verdict": "verdict",
}
_PARTS = (
    ("requirements.csv", "Requirements", _REQUIREMENTS),
    ("campaign.csv", "Shares of launches", _SHARES),
    ("evidence.csv", "Worst cases, and why to believe them", _EVIDENCE),
    ("failure_requirements.csv", "Failure cases", _FAILURES),
    ("failure_cases.csv", "Failure cases by themselves", _FAILURES),
)
OnWorst = Callable[[str, Mapping[str, float]], Any]
"""Called with a worst case's objective, and its parameters with units."""


async def show_found(folder: Path, on_worst: OnWorst | None = None) -> None:
    """Show the tables that answer, of those that a folder has.

    Args:
        folder: with results.
        on_worst: called for a worst case whose run is to be shown.
    """
    found = await run.io_bound(_read, folder)
    if found is None:
        return
    tables, worst = found

    def show_run(row: Mapping[str, Any]) -> Any:
        assert on_worst is not None
        return on_worst(row["objective"], worst[row["objective"]])

    for name, title, columns in _PARTS:
        if name not in tables:
            continue
        ui.label(title).classes("study-title")
        of_worst = name == "evidence.csv" and on_worst is not None
        show_frame(
            tables[name],
            columns,
            on_row=show_run if of_worst else None,
            button="Show run",
        )


_Found = tuple[dict[str, pd.DataFrame], dict[str, dict[str, float]]]


def _read(folder: Path) -> _Found | None:
    """Return the tables of a folder, and the parameters of its worst cases."""
    from drakesep.results.reading import read_results
    from drakesep.tables.growth_words import all_by
    from drakesep.units import with_unit

    try:
        results = read_results(folder)
        there = {str(f["name"]) for f in results.record.files if "row" in f}
        names = [name for name, *_ in _PARTS if name in there]
        tables = {name: results.table(name) for name in names}
        if (found := tables.get("requirements.csv")) is not None:
            found[_GROWTH] = [*map(all_by, found.to_dict("records"))]
        worst: dict[str, dict[str, float]] = {}
        if "evidence.csv" in tables:
            parameters = [with_unit(name) for name in results.case.box.names]
            runs = results.table("worst_cases.csv").set_index("label")[parameters]
            for objective in tables["evidence.csv"]["objective"]:
                row = runs.loc[f"worst_{objective}"].to_numpy(float)
                worst[objective] = dict(zip(parameters, map(float, row), strict=True))
    except (InputError, OSError, KeyError):
        return None
    return tables, worst
