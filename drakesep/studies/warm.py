"""What takes long in a study of worst cases done before it is asked: it begins at once.

Programs are compiled and diagrams built for a case and its objectives. A study of the
same process has them, whatever is asked of it beside; its results are the same.
"""

from drakesep.analysis.engines.jax.batch_evaluator import BatchEvaluator
from drakesep.case_file.case import Case
from drakesep.case_file.objectives import choose_objectives
from drakesep.results.asked import Asked
from drakesep.results.catalogue.names import VERIFY, WORST_CASE
from drakesep.studies.verification import planned
from drakesep.studies.worst_case.plan import StudyPlan
from drakesep.studies.worst_case.searches import WantedSearches
from drakesep.studies.worst_case.session import checked_batch
from drakesep.studies.worst_case.speed import measured_speed
from drakesep.systems.simulation.shared_simulation import shared_simulation


def warm_up(
    case: Case | str, objectives: list[str] | None = None, *, verifies: bool = False
) -> None:
    """Compile and build what a study of worst cases will need.

    Args:
        case: a case, a case file, or the name of a built-in case.
        objectives: as `worst_case` takes them; or, if it verifies, as `verify` does.
        verifies: whether requirements are verified.

    Raises:
        ValueError: as the study would raise.
    """
    asked = Asked.of(VERIFY if verifies else WORST_CASE, case)
    record = asked.case
    plan = (
        planned(asked, objectives or ())
        if verifies
        else StudyPlan(
            asked=asked,
            objectives=choose_objectives(record, objectives),
            searches=WantedSearches.named(None, record.separation),
        )
    )
    simulation = shared_simulation(record.separation, record.integration)
    nominal = simulation.run({})
    batch = checked_batch(plan)
    if batch is not None and nominal.motion is not None:
        evaluator = BatchEvaluator(
            batch, plan.objectives, record.limits_of_pairs, derivatives=False
        )
        evaluator.prepare()
        evaluator.wait()
        # It flies, measures and writes a little of all that a study does.
        measured_speed(record, plan.objectives, batch, nominal, drake=1.0)
