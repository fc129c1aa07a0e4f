"""The study that proves what nothing within the tolerances exceeds."""

from pathlib import Path

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.bounds.answers import PROVEN_MET as PROVEN_MET
from drakesep.analysis.bounds.answers import claims_of, proven_answers, questions_of
from drakesep.analysis.bounds.proving import ProofSettings
from drakesep.analysis.metrics.objectives import Objective
from drakesep.case_file.case import Case
from drakesep.case_file.objectives import (
    Wanted,
    case_objectives,
    choose_objectives,
    listed,
)
from drakesep.results.asked import Asked
from drakesep.results.catalogue.names import PROVE
from drakesep.results.folder import Output, results_folder
from drakesep.studies.kept_proofs import KeptProofs
from drakesep.studies.proof_progress import OnProof, TellingProof
from drakesep.studies.proofs import Proofs
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError, check_positive


GAP_PERCENT, PROOF_SECONDS = 0.5, 60.0
"""Unless asked for otherwise."""


@typed
def prove(
    case: Case | AnalysisCase | str | Path,
    objectives: Wanted = (),
    *,
    gap_percent: float = GAP_PERCENT,
    proof_seconds: float = PROOF_SECONDS,
    output: Output | None = None,
    resume: bool = False,
    on_progress: OnProof | None = None,
) -> Proofs:
    """Prove bounds of what a case requires, over all of its tolerances.

    What no bound covers is named, with its reason. Nothing is flown: what stands beside
    the bounds as found is what enclosures show to be attained, in inertias that no body
    can have, too; `verify` with `prove` has runs in its place.

    Args:
        case: a case, in SI or as a file holds it, a case file, or the name of a
            built-in case.
        objectives: that are bounded beside the requirements, and the paper's if the
            case says so; as `worst_case` takes them.
        gap_percent: of a bound beyond what is attained, at which it is good enough.
        proof_seconds: for each bound, about; what is known then is its bound.
        output: folder that receives proofs.csv, proof.json and proofs.png.
        resume: whether to go on from the bounds that the same study has proven in the
            folder, if it was interrupted or killed.
        on_progress: called as it goes on.

    Raises:
        ValueError: the case or an argument is wrong, nothing varies or is asked for, or
            the folder cannot be written, or has another study to resume.
    """
    settings = proof_settings(gap_percent, proof_seconds)
    how = {"gap_percent": gap_percent, "proof_seconds": proof_seconds}
    asked = Asked.of(PROVE, case, {"objectives": objectives, **how})
    if not asked.case.tolerances:
        raise InputError("dispersions: a bound needs some, got none")
    chosen = asked_objectives(asked.case, objectives)
    questions = questions_of(asked.case, chosen)
    if resume and output is None:
        raise InputError("output: must be the folder of the study to resume, got None")
    with results_folder(output, asked.study) as folder:
        if folder is not None:
            if resume:
                folder.resume(asked)
            folder.begin(asked)
        kept = KeptProofs(folder, claims_of(questions))
        telling = TellingProof(
            on_progress, questions, len(asked.case.box), proof_seconds, kept.known
        )
        bounds, answers = proven_answers(
            asked.case,
            questions,
            settings,
            known=kept.known,
            on_proof=kept.keep,
            on_progress=telling,
        )
        study = Proofs(asked=asked.over(), answers=answers, bounds=bounds)
        if folder is not None:
            study.write(folder)
    return study


def proof_settings(
    gap_percent: float = GAP_PERCENT, proof_seconds: float | None = None
) -> ProofSettings:
    """Return how hard to prove.

    Raises:
        ValueError: a number is none that it may be.
    """
    seconds = PROOF_SECONDS if proof_seconds is None else proof_seconds
    check_positive("gap_percent", gap_percent)
    check_positive("proof_seconds", seconds)
    return ProofSettings(gap=0.01 * gap_percent, seconds=seconds)


def asked_objectives(case: AnalysisCase, wanted: Wanted) -> tuple[Objective, ...]:
    """Return the objectives that are bounded beside requirements.

    Raises:
        ValueError: an objective is wrong, or nothing at all is asked for.
    """
    if case.requirements and not listed(wanted):
        return case.paper_objectives
    own = None if case_objectives(case) or not listed(wanted) else ()
    return choose_objectives(case, own, wanted)
