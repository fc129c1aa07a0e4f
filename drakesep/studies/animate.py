"""Runs of a case as a page that a browser plays."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.case_file.case import Case
from drakesep.case_file.reader import analysis_case_of
from drakesep.case_file.values import values_in_si
from drakesep.files import path_of, write_text
from drakesep.results.folder import writable_folder
from drakesep.results.reading import Results
from drakesep.studies.clearance import check_geometry
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError
from drakesep.systems.model.run import Run
from drakesep.systems.model.separation import Separation
from drakesep.systems.simulation.shared_simulation import shared_simulation
from drakesep.tables.roles import Changed, Nominal, Worst, label_of
from drakesep.tables.run_tables import shown_first


_NAMED = 3
"""Bodies whose names stand in a title, at most."""


@typed
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
    file = path_of("output", output)
    case = analysis_case_of(case)
    check_geometry(case.separation)
    values: dict[str, Mapping[str, float]] = {label_of(Nominal()): {}}
    if runs is None:
        values |= {published.label: published.values for published in case.published}
    else:
        for label, changed in runs.items():
            values[label] = values_in_si(case.separation, changed)
    simulation = shared_simulation(case.separation, case.integration)
    flown = {label: simulation.run(changed) for label, changed in values.items()}
    return _write(case, flown, file)


@typed
def animate_results(
    results: Results, labels: Sequence[str] | None = None, *, output: str | Path
) -> list[str]:
    """Write an HTML page that animates runs of a results folder; nothing is flown.

    Args:
        results: as `read_results` returns them.
        labels: of the runs; the first is shown first. If None, the nominal or changed
            run, then the worst cases of the paper's objectives and of the clearance,
            all worst cases if there are none of these, and if there are none at all
            the published runs.
        output: the file.

    Returns:
        The labels of the runs that it shows.

    Raises:
        ValueError: the folder has no such run, or no two bodies have geometry.
        RuntimeError: a run has failed.
    """
    file = path_of("output", output)
    check_geometry(results.case.separation)
    chosen = labels or _shown_unasked(results)
    if not chosen:
        raise InputError(f"{results.folder}: must keep a completed run, got none")
    flown = {label: results.run(label).run for label in chosen}
    return _write(results.case, flown, file)


def _shown_unasked(results: Results) -> list[str]:
    """Return the labels of the runs that are shown if none is asked for."""
    roles = results.roles
    first = [k for k, role in roles.items() if isinstance(role, Nominal | Changed)]
    worst = [k for k, role in roles.items() if isinstance(role, Worst)]
    others = [k for k in roles if k not in first]
    return [*first, *(shown_first(worst) or others)]


def _write(case: AnalysisCase, flown: Mapping[str, Run], file: Path) -> list[str]:
    """Write the page; return the labels of its runs."""
    # Imported here, where something is drawn.
    from drakesep.plots.animation import animation

    separation, measured = case.separation, case.clearance
    page = animation(
        flown,
        measured.pairs,
        touching=measured.touching,
        title=f"{case.name}: separation of {_all_that_leave(separation)}",
    )
    writable_folder(file.parent)
    write_text(file, page)
    return list(flown)


def _all_that_leave(separation: Separation) -> str:
    """Return which bodies leave which, in words."""
    leaving: dict[str, list[str]] = {}
    for pair in separation.pairs:
        leaving.setdefault(pair.A, []).append(pair.B)
    return "; ".join(
        f"{', '.join(Bs) if len(Bs) <= _NAMED else f'{len(Bs)} bodies'} from {A}"
        for A, Bs in leaving.items()
    )
