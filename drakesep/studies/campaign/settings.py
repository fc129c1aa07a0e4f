"""What is asked of a campaign, whoever flies it, beside worst cases or alone."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypedDict

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.campaigns.plan import CampaignPlan, Keep
from drakesep.analysis.campaigns.shares import CONFIDENCE, check_size
from drakesep.case_file.case import Case
from drakesep.results.asked import Asked, is_given
from drakesep.results.catalogue.names import CAMPAIGN
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError, check_distinct


RUNS = 100_000
"""Draws, if nothing is said: a design that is good hardly fails by chance."""


class CampaignOptions(TypedDict, total=False):
    """Settings of a campaign, beside its runs; see `CampaignSettings`."""

    seed: int
    share: float | None
    confidence: float | None
    metrics: Sequence[str]
    chunk: int | None
    keep: Keep | None


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignSettings:
    """What is drawn, and what of it is kept and asked.

    Raises:
        ValueError: a confidence stands without a share, or a metric twice.
    """

    runs: int = RUNS
    """Draws; their number is fixed beforehand, or their confidence is void."""
    seed: int = 0
    """Of the draws."""
    share: float | None = None
    """Of launches that must meet each requirement that says nothing of that; None:
    every run must, which a campaign may disprove and never shows."""
    confidence: float | None = None
    """At which that is to be shown; None: 0.9."""
    metrics: Sequence[str] = ()
    """Names of metrics that are kept beside those of the requirements."""
    chunk: int | None = None
    """Draws that are flown, written and lost together; None: as many as suit."""
    keep: Keep | None = None
    """What is kept of draws: ``rows``, the metrics of each; or ``worst``: counts, exact
    sums, histograms and the worst. None: rows, of ten million draws at most."""

    def __post_init__(self) -> None:
        """Check that the confidence is of something, and metrics are several."""
        check_distinct("metrics", self.metrics)
        if self.confidence is not None and self.share is None:
            raise InputError("confidence: must stand with a share, got no share")

    @property
    def arguments(self) -> dict[str, Any]:
        """The settings, as a study keeps what was asked."""
        return {
            "runs": self.runs,
            "seed": self.seed,
            "share": self.share,
            "confidence": self.confidence,
            "metrics": [*self.metrics],
            "chunk": self.chunk,
            "keep": self.keep,
        }

    def asked(self, case: Case | AnalysisCase | str | Path) -> Asked:
        """Return what is asked of a campaign of a case.

        Args:
            case: as studies take it.

        Raises:
            ValueError: the case is wrong, or a share or confidence is.
        """
        asked = Asked.of(CAMPAIGN, case, self.arguments, seed=self.seed)
        return replace(asked, case=self.of_shares(asked.case))

    def beside(self, asked: Asked) -> Asked:
        """Return what is asked of a campaign beside another study.

        Args:
            asked: of the other, whose case has these shares.
        """
        given = {k: v for k, v in self.arguments.items() if is_given(v)}
        return replace(asked, study=CAMPAIGN, arguments=given, seed=self.seed)

    def of_shares(self, case: AnalysisCase) -> AnalysisCase:
        """Return a case whose requirements that say nothing of a share have this one.

        Args:
            case: with requirements.

        Raises:
            ValueError: the share or the confidence is none.
        """
        if self.share is None:
            return case
        confidence = CONFIDENCE if self.confidence is None else self.confidence
        required = tuple(
            one
            if one.statistical
            else replace(one, share=self.share, confidence=confidence)
            for one in case.requirements
        )
        return replace(case, requirements=required)

    def plan(self, case: AnalysisCase) -> CampaignPlan:
        """Return the plan of a campaign.

        Args:
            case: with requirements, of shares or of every run.

        Raises:
            ValueError: a setting is wrong, nothing is kept, or so few runs can show
                nothing.
        """
        plan = CampaignPlan.of(
            case,
            self.runs,
            seed=self.seed,
            also=self.metrics,
            chunk=self.chunk,
            keep=self.keep,
        )
        if not plan.metrics and not plan.clearances:
            raise InputError(
                "requirements: a campaign needs one that runs tell, or a metric to "
                "keep, got none"
            )
        check_size(plan)
        return plan
