"""States and attitudes of a run in the formats of other programs."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Literal, TypeAlias

from drakesep.reports.ccsds_files import save_aem, save_oem
from drakesep.reports.data_files import save_json, save_mat, save_parquet
from drakesep.reports.frames import InertialFrame
from drakesep.reports.handed_run import HandedRun
from drakesep.reports.handover_provenance import save_provenance
from drakesep.reports.handover_tables import handover_table, statistics_table
from drakesep.results.catalogue.names import CAMPAIGN
from drakesep.results.folder import writable_folder
from drakesep.results.reading import Results, read_results
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError, check_entries, unknown
from drakesep.tables.columns import write_csv
from drakesep.tables.labelled_run import LabelledRun
from drakesep.tables.roles import Changed, Nominal


ExportFormat: TypeAlias = Literal["oem", "aem", "mat", "parquet", "json", "csv"]
_CCSDS, _TABLES = ("oem", "aem"), "csv"
HANDOVER, STATISTICS = "handover.csv", "handover_statistics.csv"


@typed
def export(
    results: Results | str | Path,
    format: ExportFormat,
    *,
    run: str | None = None,
    epoch: str | None = None,
    frame: str | None = None,
    plane: Sequence[float] | None = None,
    time_system: str | None = None,
    output: str | Path,
) -> list[Path]:
    """Hand states and attitudes of every body of a run over to another program.

    ``handover.csv`` is written with every format: the state of every body after
    separation, in every run that the folder keeps. Of a campaign, which keeps none,
    ``csv`` writes ``handover_statistics.csv``: mean and covariance of its metrics.
    ``RUN_FORMAT_provenance.json`` says where these come from, and what was said here
    alone.

    Args:
        results: a folder, or what `read_results` returns of it.
        format: ``oem`` and ``aem``, CCSDS messages in KVN, one for each body; ``mat``,
            ``parquet`` or ``json``, one for all; ``csv``: tables of the handover alone.
        run: its label; if None, the nominal or the changed run.
        epoch: of t = 0, in ISO 8601, if the case has none.
        frame: name of the inertial frame, if the case has none.
        plane: how the orbit lies in the frame, if the case does not say it:
            inclination, right ascension of the ascending node, and argument of latitude
            at t = 0, deg.
        time_system: of the epoch; if neither says it, UTC.
        output: the folder, made if need be.

    Returns:
        The files.

    Raises:
        ValueError: the folder keeps no such run, the run has failed, epoch, frame or
            orbit are missing or stand twice, or the format needs a package that is
            missing.
    """
    if format not in (*_WRITERS, _TABLES):
        raise InputError(unknown("format", format, (*_WRITERS, _TABLES)))
    read = results if isinstance(results, Results) else read_results(results)
    if read.record.study == CAMPAIGN:
        return _export_campaign(read, format, output)
    if plane is not None:
        check_entries("plane", plane, 3)
    inertial = InertialFrame.of(
        read.case.separation.orbit,
        epoch=epoch,
        frame=frame,
        plane=plane,
        time_system=time_system,
    )
    chosen = _chosen(read, run)
    if format in _CCSDS and inertial is None:
        needed = "epoch, frame and plane: must be given, where the case has none"
        if read.case.separation.orbit is None:
            needed = "orbit: the case must have one to hand over, got none"
        raise InputError(f"{needed}; format {format} is of states about the Earth")
    folder = writable_folder(output)
    handed = HandedRun(read.case.name, chosen, inertial)
    files = [] if format == _TABLES else _WRITERS[format](handed, folder)
    kept = [one for one in read.runs if one.run.trajectory is not None]
    table = handover_table(kept, read.case.separation, inertial)
    write_csv(table, folder / HANDOVER)
    files.append(folder / HANDOVER)
    given = {} if inertial is None else inertial.given
    return [*files, save_provenance(read, files, format, chosen.label, given)]


def _export_campaign(results: Results, format: str, output: str | Path) -> list[Path]:
    if format != _TABLES:
        raise InputError(
            f"format: must be csv of a campaign, which keeps no runs, got {format}; "
            "`drakesep replay` flies one of its draws"
        )
    table = statistics_table(results.folder)
    file = writable_folder(output) / STATISTICS
    write_csv(table, file)
    return [file, save_provenance(results, [file], format)]


def _chosen(results: Results, label: str | None) -> LabelledRun:
    """Return the run that is handed over.

    Raises:
        ValueError: there is none of this label, or it has failed.
    """
    if not results.labels:
        raise InputError(
            f"{results.folder}: must keep a run, got none: {results.record.study!r} "
            "keeps none"
        )
    first = [k for k, r in results.roles.items() if isinstance(r, Nominal | Changed)]
    if label is None:
        label = first[0] if first else results.labels[0]
    if label not in results.labels:
        raise InputError(f"run: {unknown('run', label, results.labels)}")
    one = results.run(label)
    if one.run.trajectory is None:
        raise InputError(f"run: {label} must have completed, got: {one.status}")
    return one


_WRITERS: Mapping[str, Callable[[HandedRun, Path], list[Path]]] = {
    "oem": save_oem,
    "aem": save_aem,
    "mat": save_mat,
    "parquet": save_parquet,
    "json": save_json,
}
