"""Runs of a case as a page that a browser plays."""

from collections.abc import Mapping
from pathlib import Path

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.case_file.case import Case
from drakesep.case_file.reader import analysis_case_of
from drakesep.case_file.values import values_in_si
from drakesep.studies.clearance import check_geometry
from drakesep.studies.output import writable_folder
from drakesep.systems.simulation.simulation import Simulation
from drakesep.tables.roles import Nominal, label_of


def animate(
    case: Case | AnalysisCase | str | Path,
    runs: Mapping[str, Mapping[str, float]] | None = None,
    *,
    output: str | Path,
) -> list[str]:
    """Write an HTML page that animates runs of a case, to be opened in a browser.

    Args:
        case: a case, in SI or as a file holds it, a case file, or the name of a
            built-in case.
        runs: values by parameter name with unit, by the runs' labels; they are shown
            after the nominal run. The published ones if None.
        output: the file.

    Returns:
        The labels of the runs that it shows.

    Raises:
        ValueError: the case or a value is wrong, or no two bodies have geometry.
        RuntimeError: a run fails.
    """
    case = analysis_case_of(case)
    check_geometry(case.separation)
    values: dict[str, Mapping[str, float]] = {label_of(Nominal()): {}}
    if runs is None:
        values |= {published.label: published.values for published in case.published}
    else:
        for label, changed in runs.items():
            values[label] = values_in_si(case.separation, changed)
    simulation = Simulation(case.separation, case.integration)
    flown = {label: simulation.run(changed) for label, changed in values.items()}
    # Imported here, where something is drawn.
    from drakesep.plots.animation import animation

    separation, measured = case.separation, case.clearance
    page = animation(
        flown,
        measured.pairs,
        touching=measured.touching,
        title=f"{case.name}: separation of {separation.B} from {separation.A}",
    )
    file = Path(output)
    writable_folder(file.parent)
    file.write_text(page, encoding="utf-8")
    return list(flown)
