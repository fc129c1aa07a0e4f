"""What is proven of a case, and written down: a table, a certificate, a picture."""

import functools
import warnings
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.bounds.answers import (
    CONTRADICTED,
    NOT_PROVEN,
    PROVEN_MET,
    ProvenAnswer,
)
from drakesep.analysis.bounds.certificate import MOST
from drakesep.analysis.bounds.proving import Bounds
from drakesep.analysis.metrics.functions import FunctionRequirement
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.plots.pictures import OfProofs
from drakesep.results.asked import Asked
from drakesep.results.folder import ResultsFolder
from drakesep.studies.saved import SavedStudy
from drakesep.tables.columns import write_csv
from drakesep.tables.proofs_table import proofs_table


CERTIFICATE = "proof.json"


class LongCertificate(UserWarning):
    """Proofs of some bounds, which hold, are too long to be written down."""


@dataclass(frozen=True, kw_only=True)
class Proofs(SavedStudy):
    """Bounds that nothing within the tolerances exceeds, and why others are missing."""

    asked: Asked = field(repr=False)
    """With the case."""
    answers: tuple[ProvenAnswer, ...]
    """Of each requirement, then of each objective."""
    bounds: Bounds = field(repr=False)
    """With their certificates."""
    functions: tuple[FunctionRequirement, ...] = ()
    """That are required, some of the answers are of them."""

    @property
    def case(self) -> AnalysisCase:
        """The case."""
        return self.asked.case

    @functools.cached_property
    def table(self) -> pd.DataFrame:
        """A row for each requirement and axis, then for each objective."""
        bodies = [pair.B for pair in self.case.separation.pairs]
        return proofs_table(self.answers, bodies, self.functions)

    @property
    def by_requirement(self) -> Mapping[Requirement, ProvenAnswer]:
        """The answers, by their requirements."""
        answers = ((one.question.requirement, one) for one in self.answers)
        return {required: one for required, one in answers if required is not None}

    @property
    def verdict(self) -> str | None:
        """``proven met`` or ``not proven`` of all requirements; None: there is none."""
        verdicts = {one.verdict for one in self.by_requirement.values()}
        if not verdicts:
            return None
        return PROVEN_MET if verdicts == {PROVEN_MET} else NOT_PROVEN

    @property
    def why_nothing(self) -> str:
        """Why there is no bound at all, in a line; empty if there is one."""
        if any(one.bound is not None for one in self.answers):
            return ""
        reasons = Counter(one.reason for one in self.answers)
        return "; ".join(reasons)

    @property
    def failure(self) -> str:
        """Which bounds runs are beyond: one of the two is wrong; empty: none."""
        return "; ".join(
            f"{one.found_by} is beyond the proven bound of {one.question.claim}: "
            f"{one.found:.9g} is found where {one.value:.9g} is proven (SI); "
            "one of the two is wrong"
            for one in self.answers
            if one.verdict == CONTRADICTED
        )

    @property
    def completed(self) -> bool:
        """Whether no run is beyond a bound."""
        return not self.failure

    @property
    def picture(self) -> OfProofs:
        """What shows it."""
        return OfProofs(self.table)

    def write_tables(self, folder: Path) -> None:
        """Write the table and the certificate into a folder that is locked."""
        write_csv(self.table, folder / "proofs.csv")
        if self.bounds.proven and (
            left_out := self.bounds.write_certificate(folder / CERTIFICATE)
        ):
            warnings.warn(
                f"{CERTIFICATE}: has no proof of {', '.join(left_out)}, with which it "
                f"would be larger than {MOST // 1_000_000} MB: a larger gap takes less",
                LongCertificate,
                stacklevel=2,
            )

    def write(self, results: ResultsFolder) -> None:
        """Write it into the folder of its study, which ends."""
        self.write_tables(results.path)
        self.picture.save(results.path)
        results.end(failed=self.failure, verdict=self.verdict)
