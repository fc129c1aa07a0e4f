"""What came of a verification: findings, verdict, growth of tolerances, failures."""

import functools
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import pandas as pd

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.bounds.answers import ProvenAnswer
from drakesep.analysis.failure_cases import DESIGN, FailureCase
from drakesep.analysis.metrics.requirements import (
    Finding,
    Requirement,
    Verdict,
    assess,
    verdict_on_all,
)
from drakesep.plots.pictures import OfFailures, Pictures
from drakesep.plots.shown_runs import bodies_shown_by
from drakesep.results.folder import ResultsFolder
from drakesep.studies.campaign.result import Campaign
from drakesep.studies.proofs import Proofs
from drakesep.studies.tolerance_growth import Growths, ways_out
from drakesep.studies.worst_case.result import WorstCases
from drakesep.tables.answers_table import answers_table
from drakesep.tables.columns import write_csv
from drakesep.tables.failure_tables import HELD, outcome_row, under_each_other
from drakesep.tables.labelled_run import LabelledRun, nominal_of
from drakesep.tables.requirement_tables import requirements_table, tolerances_table
from drakesep.tables.run_tables import runs_table


@dataclass(frozen=True, kw_only=True)
class Verification(WorstCases):
    """The worst cases held against the requirements."""

    growths: Growths = field(default=())
    """Of all tolerances together: the smallest of each requirement's directions."""
    single_growths: Growths = field(default=())
    """Of one tolerance, the others as they are: the smallest of the directions."""
    failed_cases: tuple["FailedCase", ...] = ()
    """The failure cases, each verified as the design is."""
    campaign: Campaign | None = None
    """That was flown beside the worst cases."""
    proofs: Proofs | None = None
    """What is proven, if that was asked for."""
    missed: Mapping[Requirement, int] = field(default_factory=dict)
    """Draws of it that are worse than the worst case found, though within what was
    searched."""

    @property
    def findings(self) -> list[Finding]:
        """How each requirement fares over all runs."""
        runs = {
            one.label: {**one.metrics, **one.of_functions}
            for one in self.runs
            if one.metrics
        }
        of_functions = (limit for f in self.functions for limit in f.limits)
        required = [*self.case.requirements, *of_functions]
        at_most = {one.label: one.at_most for one in self.runs}
        findings = assess(required, runs, nominal_of(self.runs).label, at_most)
        unsettled = self._unsettled
        shares = self.campaign.findings if self.campaign else ()
        by_campaign = {one.requirement: one.verdict for one in shares}
        return [
            replace(
                one,
                settled=one.requirement not in unsettled,
                by_campaign=by_campaign.get(one.requirement),
            )
            for one in findings
        ]

    @property
    def _unsettled(self) -> set[Requirement]:
        """What may be broken by a run that was not flown, or not as it was found.

        A run that cannot be flown, or does not separate, may break any; of a worst case
        that is not confirmed, what it was searched for; and what no search led out of.
        """
        ways = ways_out(self.case, self.functions)
        required = {*self.case.requirements, *(requirement for requirement, _ in ways)}
        if self.failed_searches or any(one.tells_nothing for one in self.runs):
            return required
        unconfirmed = {one.objective for one in self.runs if one.outcome.failed}
        broken = {requirement for requirement, name in ways if name in unconfirmed}
        broken |= self.missed.keys()
        if not self.case.tolerances:  # there is nothing to search
            return broken
        searched = {objective.name for objective in self.objectives}
        led = {requirement for requirement, name in ways if name in searched}
        return broken | (required - led)

    @property
    def requirements(self) -> pd.DataFrame:
        """A row for each requirement and axis, with its margins and verdict."""
        return requirements_table(
            self.findings,
            self.growths,
            self.single_growths,
            self.case.box,
            self._bodies,
            self.functions,
            self._proven,
        )

    @property
    def answers(self) -> pd.DataFrame:
        """A row for each requirement: campaign, worst case found and proven bound."""
        shares = self.campaign.findings if self.campaign else ()
        return answers_table(
            *(self.findings, shares, self.missed, self._bodies, self.functions),
            self.campaign.worst_failure_cases if self.campaign else {},
            self._proven,
        )

    @property
    def _proven(self) -> Mapping[Requirement, ProvenAnswer]:
        """What is proven of the requirements."""
        return self.proofs.by_requirement if self.proofs else {}

    @property
    def tolerances(self) -> pd.DataFrame:
        """For each requirement and parameter, the tolerance that would violate it."""
        return tolerances_table(
            self.single_growths, self.case.box, self._bodies, self.functions
        )

    @property
    def _bodies(self) -> list[str]:
        """Names of those that leave, the first first."""
        return [pair.B for pair in self.case.separation.pairs]

    def write_tables(self, results: ResultsFolder) -> None:
        """Write the tables, as far as there are any, into a folder that is locked."""
        super().write_tables(results)
        folder = results.path
        # No verdict before the worst cases are known.
        if self.worst or (self.runs and not self.objectives):
            write_csv(self.requirements, folder / "requirements.csv")
            if self.looks_at_paper:
                write_csv(self.table_4, folder / "table_4.csv")
        if self.single_growths:
            write_csv(self.tolerances, folder / "tolerances.csv")
        self.write_proofs(results)
        self.write_campaign(results)
        self.write_failures(results)

    def write_proofs(self, results: ResultsFolder) -> None:
        """Write what is proven, and the verdicts with it beside them."""
        if self.proofs is not None:
            self.proofs.write_tables(results.path)
            write_csv(self.requirements, results.path / "requirements.csv")

    def write_campaign(self, results: ResultsFolder) -> None:
        """Write the tables of the campaign, and the verdicts with what it says."""
        if self.campaign is not None:
            folder = results.path
            self.campaign.recorded.write(folder)
            self.campaign.write_tables(results)
            write_csv(self.requirements, folder / "requirements.csv")
            write_csv(self.answers, folder / "answers.csv")

    def write_failures(self, results: ResultsFolder) -> None:
        """Write the tables of the failure cases that are verified."""
        folder = results.path
        if self.failed_cases:
            write_csv(self.failure_cases, folder / "failure_cases.csv")
            write_csv(self.failure_requirements, folder / "failure_requirements.csv")
            write_csv(self.failure_runs, folder / "failure_runs.csv")

    @property
    def failure_cases(self) -> pd.DataFrame:
        """A row for the design and each failure case, with what came of it."""
        nominal, verdict = nominal_of(self.runs), self.design_verdict
        design = outcome_row(DESIGN, {}, nominal, self.requirements, verdict)
        return pd.DataFrame([design, *(one.outcome for one in self.failed_cases)])

    @property
    def failure_requirements(self) -> pd.DataFrame:
        """The requirements of the design, and of each failure case."""
        cases = {DESIGN: self.requirements}
        cases |= {one.failure.name: one.requirements for one in self.failed_cases}
        return under_each_other(cases)

    @property
    def failure_runs(self) -> pd.DataFrame:
        """The runs of each failure case: its nominal, and its worst cases in Drake."""
        return under_each_other(
            {one.failure.name: one.runs for one in self.failed_cases}
        )

    @property
    def failure(self) -> str:
        """What failed, of failure cases too; empty if the study is completed."""
        of_cases = [
            f"failure case {one.failure.name}: {one.study.failure}"
            for one in self.failed_cases
            if one.study.failure and not one.held
        ]
        return "; ".join(filter(None, [self._failure_of_design, *of_cases]))

    @property
    def _failure_of_design(self) -> str:
        """What failed of the design, of its campaign too."""
        return "; ".join(filter(None, [super().failure, self.failure_beside]))

    @property
    def failure_beside(self) -> str:
        """What failed of what is beside the worst cases: proofs and campaign."""
        proofs = self.proofs.failure if self.proofs else ""
        return "; ".join(filter(None, [proofs, self.campaign_failure]))

    @property
    def campaign_failure(self) -> str:
        """What of the campaign failed, or which worst cases it shows to be missed."""
        missed = [
            f"draw {draw} of the campaign is worse than the worst case found of "
            f"{requirement.judged_by}: the searches have missed it"
            for requirement, draw in self.missed.items()
        ]
        of_draws = self.campaign.failure if self.campaign else ""
        return "; ".join(filter(None, [of_draws, *missed]))

    @property
    def passed(self) -> bool:
        """Whether every requirement is met, with no run and no search failed.

        In every failure case, too, if they were looked at.
        """
        return self.verdict == Verdict.MET.value

    @property
    def design_verdict(self) -> str | None:
        """Of the design alone: ``met``, ``not met``, ``not shown``, ``not looked at``.

        What a run is beyond stays so, whatever else failed; without it, a study that is
        not completed has no verdict: None.
        """
        found = verdict_on_all(one.verdict for one in self.findings)
        if found is Verdict.NOT_MET or not self._failure_of_design:
            return found.value
        return None

    @property
    def verdict(self) -> str | None:
        """Of the design and of all failure cases that were looked at: the worst."""
        verdicts = [self.design_verdict, *(one.verdict for one in self.failed_cases)]
        if {Verdict.NOT_MET.value, HELD} & {*verdicts}:
            return Verdict.NOT_MET.value
        if None in verdicts:
            return None
        if Verdict.NOT_SHOWN.value in verdicts:
            return Verdict.NOT_SHOWN.value
        if Verdict.NOT_LOOKED_AT.value in verdicts:
            return Verdict.NOT_LOOKED_AT.value
        return Verdict.MET.value

    def draw(self, folder: Path) -> None:
        """Draw what shows it into a folder."""
        super().draw(folder)
        if self.proofs is not None:
            self.proofs.picture.save(folder)
        if self.campaign is not None:
            self.campaign.draw(folder)
        if self.failed_cases:
            OfFailures(self.failure_requirements).save(folder)

    @property
    def pictures(self) -> Pictures:
        """What shows the runs, and their motions."""
        motions = {}
        for one in self.runs:
            if one.run.motion is not None:
                for body in bodies_shown_by(one):
                    first = body == one.run.separation.B
                    name = one.label if first else f"{one.label}_{body}"
                    motions[name] = one.run, body
        return replace(super().pictures, motions=motions)


@dataclass(frozen=True, kw_only=True)
class FailedCase:
    """A failure case, verified as the design is."""

    failure: FailureCase
    study: Verification
    """Of the case in which it has failed."""
    design: AnalysisCase
    """In which nothing has."""
    held: tuple[str, ...] = ()
    """Bodies that leave in the design, and do not here, even nominally."""

    @functools.cached_property
    def requirements(self) -> pd.DataFrame:
        """The requirements' rows; told once, as what follows: it is over."""
        return self.study.requirements

    @functools.cached_property
    def runs(self) -> pd.DataFrame:
        """Its runs, with each parameter that varies, or that a failure case changes."""
        changed = [name for one in self.design.failure_cases for name in one.values]
        names = list(dict.fromkeys([*self.design.box.names, *changed]))
        return runs_table(self.study.runs, names, self.study.functions)

    @functools.cached_property
    def outcome(self) -> dict[str, object]:
        """What came of it, in a row."""
        failure = self.failure
        return outcome_row(
            failure.name, failure.values, self.nominal, self.requirements, self.verdict
        )

    @property
    def nominal(self) -> LabelledRun:
        """Its run without tolerances."""
        return nominal_of(self.study.runs)

    @property
    def verdict(self) -> str | None:
        """Of it, as of a design; ``does not separate`` if a body stays."""
        return HELD if self.held else self.study.design_verdict
