"""Which files a results folder has, of every study."""

from drakesep.results.catalogue.file_kind import Column, FileKind
from drakesep.results.catalogue.names import CASE, OF_KEPT_RUNS, STUDIES, STUDY, SWEEP
from drakesep.results.catalogue.of_campaigns import CAMPAIGN_FILES, DISTRIBUTION_FILES
from drakesep.results.catalogue.of_proofs import PROOF_FILES
from drakesep.results.catalogue.of_runs import FILES_OF_EACH_RUN, FILES_OF_RUNS
from drakesep.results.catalogue.of_worst_cases import WORST_CASE_FILES
from drakesep.results.catalogue.plots import PLOT_FILES


_REMARKS = FileKind(
    name="remarks.csv",
    studies=(*OF_KEPT_RUNS, SWEEP),
    what="What should be told although nothing failed, if anything: a body that moves "
    "against its direction, one whose roll and yaw swing as it tumbles, springs of "
    "Eq. 5 that give another energy than they store.",
    row="remark",
    key=("about",),
    columns=(
        Column("about", "", "The bodies or springs; each is told of once."),
        Column("remark", "", "In a sentence."),
        Column(
            "run",
            "",
            "Label of the first run in which it is so; of a sweep, as `variant 3`.",
        ),
    ),
)

_VARIANTS = (
    FileKind(
        name="sweep.csv",
        studies=(SWEEP,),
        what="Variants of the case, one run each, and how they fare.",
        row="variant",
        key=("variant",),
        columns=(
            Column("variant", "", "Its number, from 1."),
            Column("{parameter}", "in the name", "Value of the parameter."),
            Column("{metric}", "in the name", "The metric of the run, see metrics.md."),
            Column("verdict", "", "`met`, `not met` or `not looked at`; of this run."),
            Column("violated", "", "Limits that are not met."),
            Column("status", "", "`completed`, or `failed` with the reason."),
        ),
    ),
)

_MEMORY = (
    FileKind(
        name=STUDY,
        studies=STUDIES,
        what="What was asked, with what, and how it ended; this list.",
    ),
    FileKind(
        name=CASE,
        studies=STUDIES,
        what="The case in SI and radians, with its geometry: exact, and read back by "
        "`drakesep.read_results`.",
    ),
)

EFFORT = frozenset(
    {
        *("iterations", "evaluations", "run_by_run", "points", "failed_samples"),
        *("starts", "ended_there", "unfinished", "local_maxima", "random_samples"),
        "boxes",
    }
)
"""Columns that say how hard something was, not what was found."""

LABELS = frozenset({"draw", "worst_draw", "deciding_draw", "missed_draw"})
"""Columns whose numbers are names: nothing lies between two of them."""
FILES = (
    *_MEMORY,
    _REMARKS,
    *FILES_OF_RUNS,
    *_VARIANTS,
    *CAMPAIGN_FILES,
    *DISTRIBUTION_FILES,
    *WORST_CASE_FILES,
    *PROOF_FILES,
    *PLOT_FILES,
    *FILES_OF_EACH_RUN,
)
"""All but those of `GEOMETRY`."""
