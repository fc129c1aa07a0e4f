"""The study of what metrics depend on: Sobol' indices of the dispersed parameters."""

import functools
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import ClassVar

import pandas as pd

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.campaigns.of_case import dependences, sobol_indices_of
from drakesep.analysis.campaigns.plan import judged_metrics
from drakesep.analysis.campaigns.sensitivity import (
    SobolIndices,
    check_sobol,
    runs_of_sobol,
)
from drakesep.case_file.case import Case
from drakesep.results.asked import Asked
from drakesep.results.catalogue.names import SENSITIVITY
from drakesep.results.folder import Output, begun
from drakesep.studies.campaign.flight import seconds_of
from drakesep.studies.campaign.sample import not_confirmed, sample_of
from drakesep.studies.one_table import OneTable
from drakesep.studies.runs_progress import OnRuns, TellingRuns
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError, check_distinct
from drakesep.tables.sobol_table import sobol_table


@dataclass(frozen=True, kw_only=True)
class Sensitivity(OneTable):
    """What shares of the variance of metrics come from which parameters."""

    FILE: ClassVar = "sobol_indices.csv"

    metrics: tuple[str, ...]
    """By their names."""
    indices: SobolIndices = field(repr=False)
    """(n, m) of each parameter and metric."""

    @functools.cached_property
    def table(self) -> pd.DataFrame:
        """A row for each metric and parameter: its shares, with their errors."""
        names = self.case.tolerance_set.names
        return sobol_table(self.indices, names, self.metrics)


@typed
def sensitivity(
    case: Case | AnalysisCase | str | Path,
    metrics: Sequence[str] = (),
    *,
    base: int = 512,
    replicates: int = 10,
    confidence: float = 0.95,
    seed: int = 0,
    output: Output | None = None,
    on_progress: OnRuns | None = None,
) -> Sensitivity:
    """Tell which parameters the variance of metrics comes from, by Sobol' indices.

    Of launches in which nothing fails, over the distributions that the case states.

    Args:
        case: a case, in SI or as a file holds it, a case file, or the name of a
            built-in case; its parameters are independent.
        metrics: names of metrics; those that the requirements are judged by, if none.
        base: points of a replicate, a power of two.
        replicates: two or more; runs are replicates times base times two more than
            there are parameters.
        confidence: of the intervals.
        seed: of the points.
        output: folder that receives the table.
        on_progress: called as it goes on.

    Raises:
        ValueError: the case or an argument is wrong, parameters depend on each other, a
            run fails, the batch engine cannot fly the case, or the folder cannot be
            written.
    """
    check_distinct("metrics", metrics)
    how = {"base": base, "replicates": replicates, "confidence": confidence}
    arguments = {"metrics": list(metrics), **how, "seed": seed}
    asked = Asked.of(SENSITIVITY, case, arguments, seed=seed)
    of = tuple(dict.fromkeys(metrics or judged_metrics(asked.case)))
    if not of:
        raise InputError("metrics: must be one or more, got none, nor a requirement")
    parameters = len(asked.case.tolerance_set.names)
    check_sobol(
        parameters,
        base=base,
        replicates=replicates,
        confidence=confidence,
        dependences=dependences(asked.case),
    )
    flights = sample_of(asked, of, seed)
    total = runs_of_sobol(parameters, base, replicates)
    what = f"Sobol' indices of {len(of)} metrics and {parameters} parameters"
    with begun(output, asked) as folder:
        telling = TellingRuns(on_progress, what, total, seconds_of(flights, total))

        def told(values: Array) -> Array:
            found = flights.metrics_at(values)
            telling.flown(len(values))
            return found

        indices = sobol_indices_of(asked.case, told, seed=seed, **how)
        study = Sensitivity(
            asked=asked,
            metrics=of,
            indices=indices,
            failure=not_confirmed(asked, flights),
        )
        study = replace(study, asked=asked.over())
        if folder is not None:
            study.write(folder)
    return study
