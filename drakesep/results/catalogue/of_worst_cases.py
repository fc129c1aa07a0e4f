"""Files of searches for worst cases, and of verdicts."""

from drakesep.analysis.search.judge import CONFIDENCE
from drakesep.results.catalogue.columns import (
    BOUND,
    FAILURE,
    IDENTITY,
    LIMIT,
    LIMIT_KEY,
    OBJECTIVE,
    RUN,
    SAME,
    UNIT,
)
from drakesep.results.catalogue.file_kind import Column, FileKind
from drakesep.results.catalogue.names import SEARCHED, VERIFY


_VERDICT = (
    *LIMIT,
    Column("nominal", SAME, "In the nominal run."),
    Column(
        "worst",
        SAME,
        "Farthest beyond the limit; else nearest to it, and empty if a run "
        "does not tell.",
    ),
    Column("which_run", "", "Label of the worst, or of that run."),
    Column("margin", SAME, "Of the worst; negative beyond the limit."),
    Column(
        "growth_factor",
        "",
        "On all tolerances together at which it is first violated.",
    ),
    Column(
        "growth_by",
        "",
        "How that was looked for: `search`; `ray` to the worst case alone, to "
        "0.01, of what takes long to tell; `not looked at`; or `failed` with "
        "the reason.",
    ),
    Column("looked_up_to", "", "Largest factor that was looked at."),
    Column(
        "first_tolerance",
        "",
        "That alone violates it with least growth; or `not looked at`.",
    ),
    Column("its_growth_factor", "", "On that tolerance."),
    *BOUND,
    Column("proven", "", "`verdict` of proofs.csv; `not looked at` without `--prove`."),
    Column(
        "verdict",
        "",
        "`met`, `not met` or `not looked at`, which is also what may be broken "
        "by a run that failed, or by a worst case that is not confirmed; and what is "
        "required of a share of launches, unless a campaign tells; then also `not "
        "shown`.",
    ),
    *IDENTITY,
)

WORST_CASE_FILES = (
    FileKind(
        name="worst_cases.csv",
        studies=SEARCHED,
        what="All runs flown in Drake: nominal, published, ends of SQP, worst.",
        row="run",
        key=("label",),
        columns=RUN,
    ),
    FileKind(
        name="comparison.csv",
        studies=SEARCHED,
        what="The paper's objectives, where they are looked at.",
        row="objective of the paper",
        key=("objective",),
        columns=(
            Column("objective", "", "Its metric."),
            UNIT,
            Column("nominal", SAME, "In the nominal run."),
            Column("published", SAME, "The worst of the published runs."),
            Column("sqp", SAME, "Where SQP from the nominal ended."),
            Column("worst", SAME, "Of all runs."),
            Column("which_run", "", "Label of the worst."),
            Column("above_nominal_percent", "%", "Of the nominal's magnitude."),
            Column("above_published_percent", "%", "Of the published's magnitude."),
        ),
    ),
    FileKind(
        name="evidence.csv",
        studies=SEARCHED,
        what="Why worst cases may be believed, see worst_cases.md.",
        row="worst case",
        key=("objective",),
        columns=(
            OBJECTIVE,
            UNIT,
            Column("worst", SAME, "As the searches have it."),
            Column("in_drake", SAME, "In the run that Drake flew there."),
            Column("difference", SAME, "Of the two."),
            Column(
                "beaten_by",
                "",
                "Of a clearance or a function: the label of a run that is worse, if "
                "one is: then the search has failed.",
            ),
            Column("found_by", "", "The search that found it."),
            Column(
                "flown_by",
                "",
                "What told it to the searches: `batch`, by its metrics; or whole runs, "
                "`batch, run by run` or `Drake, run by run`.",
            ),
            Column(
                "run_by_run",
                "",
                "How many whole runs were asked for, known ones again; 0 by metrics.",
            ),
            Column("{search}", SAME, "The worst that this search found."),
            Column("starts", "", "Of the ascents."),
            Column("ended_there", "", "How many of them ended at the worst case."),
            Column("local_maxima", "", "Values of local maxima, and how many ended."),
            Column("unfinished", "", "Ascents that stopped at the iteration limit."),
            Column("at_bounds", "", "Parameters at a bound."),
            Column("active_constraints", "", "Others that hold it."),
            Column(
                "optimality_residual",
                "",
                "What is left of the slope, as a part of it, within the bounds.",
            ),
            Column("random_samples", "", "That were flown."),
            Column("failed_samples", "", "Of these."),
            Column(
                f"fraction_beyond_at_{CONFIDENCE:.0%}".replace("%", "_percent"),
                "",
                "Share of the tolerances that may be worse, at this confidence.",
            ),
        ),
    ),
    FileKind(
        name="searches.csv",
        studies=SEARCHED,
        what="What was searched.",
        row="search",
        key=("search",),
        columns=(
            Column("search", "", "Its name."),
            Column("what", "", "What it looked at."),
            Column("points", "", "Runs that it flew."),
            Column("failed", "", "Of these."),
            Column("first_failure", "", "Why the first failed."),
            Column(
                "unphysical_share_of_tolerances",
                "",
                "Share of the tolerances whose inertias no body can have.",
            ),
        ),
    ),
    FileKind(
        name="candidates.csv",
        studies=SEARCHED,
        what="The best point of each search.",
        row="objective and search",
        key=("objective", "search"),
        columns=(
            OBJECTIVE,
            Column("search", "", "Its name."),
            Column("value", SAME, "Of the objective's metric."),
            UNIT,
            Column("{parameter}", "in the name", "Its value there."),
        ),
    ),
    FileKind(
        name="iterates.csv",
        studies=SEARCHED,
        what="The way of every ascent by SQP, of one search after another.",
        row="iterate",
        key=("objective", "search", "start", "iteration"),
        columns=(
            OBJECTIVE,
            Column("search", "", "Its name."),
            Column(
                "start",
                "",
                "Number of the ascent among those of the objective, from 1; missing of "
                "one whose first run failed.",
            ),
            Column("iteration", "", "Its number; 0 is where the ascent starts."),
            Column("value", SAME, "Of the objective's metric."),
            UNIT,
            Column("evaluations", "", "So far."),
            Column("{parameter}", "in the name", "Its value there."),
        ),
    ),
    FileKind(
        name="worst_points.csv",
        studies=SEARCHED,
        what="Where worst cases are: M at the upper bound, m at the lower, or a value.",
        row="parameter",
        key=("parameter",),
        columns=(
            Column("parameter", "", "With its unit."),
            Column("{objective}", "in the row's name", "At its worst case."),
        ),
    ),
    FileKind(
        name="sensitivities.csv",
        studies=SEARCHED,
        what="What a whole tolerance upward does, and either of its sides, to first "
        "order.",
        row="worst case and parameter",
        key=("objective", "parameter"),
        columns=(
            OBJECTIVE,
            UNIT,
            Column("parameter", "", "With its unit."),
            Column("tolerance", "in `parameter`", "The larger of its sides."),
            Column("minus", "in `parameter`", "Its side below the nominal."),
            Column("plus", "in `parameter`", "Its side above the nominal."),
            Column("per_tolerance_at_nominal", SAME, "Change, at the nominal."),
            Column("per_tolerance_at_worst", SAME, "Change, at the worst case."),
            Column("downward_at_nominal", SAME, "Change for all of `minus`, there."),
            Column("downward_at_worst", SAME, "The same, at the worst case."),
            Column("upward_at_nominal", SAME, "Change for all of `plus`, there."),
            Column("upward_at_worst", SAME, "The same, at the worst case."),
            Column("at_worst", "", "M or m at a bound; empty within."),
            Column(
                "multiplier",
                SAME,
                "Gain of the worst case for a whole tolerance more.",
            ),
        ),
    ),
    FileKind(
        name="requirements.csv",
        studies=(VERIFY,),
        what="The verdict.",
        row="requirement and axis",
        key=LIMIT_KEY,
        columns=_VERDICT,
    ),
    FileKind(
        name="answers.csv",
        studies=(VERIFY,),
        what="The statistical answer and the worst case found, side by side, if a "
        "campaign was flown.",
        row="requirement and axis",
        key=LIMIT_KEY,
        columns=(
            *LIMIT,
            Column("nominal", SAME, "In the nominal run."),
            Column("bound_of", "", "The share of launches of which the bound is told."),
            Column("at_confidence", "", "At which it is."),
            Column(
                "bound",
                SAME,
                "Statistical: so large a share of launches is no worse, as "
                "campaign.csv has it.",
            ),
            Column(
                "failures",
                "",
                "Draws beyond the limit, of `sides: two` beyond either; empty if that "
                "was not looked at.",
            ),
            Column("allowed", "", "How many may be."),
            Column("worst_of_draws", SAME, "Of all draws that have not failed."),
            Column("worst_draw", "", "Number of the worst draw; of one that failed."),
            Column(
                "worst_failure_case",
                "",
                "That happens in the worst draw: beyond what was searched of the "
                "design; empty: nothing fails in it.",
            ),
            Column(
                "worst_case_beyond_bound",
                SAME,
                "How much worse the worst case found is than the bound.",
            ),
            Column(
                "by_campaign",
                "",
                "What the draws say, as `verdict` of campaign.csv; of a limit that "
                "every run must keep `not looked at`, unless one is beyond.",
            ),
            Column(
                "worst_case_found",
                SAME,
                "The worst that searches have found within the tolerances, flown in "
                "Drake: at least this bad can happen.",
            ),
            Column("which_run", "", "Label of that run."),
            Column(
                "missed_draw",
                "",
                "Number of a draw within the tolerances that is worse, if there is "
                "one: then the search has failed.",
            ),
            Column(
                "by_worst_case",
                "",
                "Whether all runs flown in Drake are within the limit.",
            ),
            *BOUND,
            Column(
                "proven", "", "`verdict` of proofs.csv; `not looked at` without one."
            ),
            Column(
                "decided_by",
                "",
                "`campaign`: of what is required of a share, and where a draw "
                "disproves what every run must keep; else `worst case`.",
            ),
            Column("verdict", "", "Of what decides."),
            *IDENTITY,
        ),
    ),
    FileKind(
        name="failure_cases.csv",
        studies=(VERIFY,),
        what="What came of the design and of each failure case, if they are verified.",
        row="failure case",
        key=("failure_case",),
        columns=(
            FAILURE,
            Column(
                "changed",
                "in the text",
                "Parameters that have failed; of the design none.",
            ),
            Column(
                "verdict",
                "",
                "On all requirements: `met`, `not met`, `not looked at`; `does not "
                "separate`, where a body stays that leaves in the design; or `failed`, "
                "where a run was not flown or not confirmed.",
            ),
            Column("not_met", "", "Rows of requirements that are not."),
            Column(
                "beyond",
                "",
                "Rows whose worst is beyond the limit; of a share of launches that is "
                "no verdict.",
            ),
            Column("requirements", "", "Rows of requirements in all."),
            Column(
                "nearest_requirement",
                "",
                "Of the least margin, as a share of its limit.",
            ),
            Column("nearest_axis", "", "Its axis."),
            Column("nearest_pair", "", "Its pair."),
            Column("nearest_limit", "as `nearest_unit` says", "Its limit."),
            Column("nearest_worst", "as `nearest_unit` says", "The worst of it."),
            Column("nearest_unit", "", "Of both."),
            Column(
                "joint_force_N",
                "N",
                "The largest of any joint in the nominal run of the case.",
            ),
            Column("joint_torque_N_m", "N m", "The same of torques, about B's pad."),
        ),
    ),
    FileKind(
        name="failure_requirements.csv",
        studies=(VERIFY,),
        what="requirements.csv of the design and of each failure case, in which "
        "tolerances do not grow.",
        row="failure case, requirement and axis",
        key=("failure_case", *LIMIT_KEY),
        columns=(FAILURE, *_VERDICT),
    ),
    FileKind(
        name="failure_runs.csv",
        studies=(VERIFY,),
        what="Runs of each failure case flown in Drake: its nominal and its worst.",
        row="run",
        key=("failure_case", "label"),
        columns=(FAILURE, *RUN),
    ),
    FileKind(
        name="tolerances.csv",
        studies=(VERIFY,),
        what="Tolerances that would violate requirements, the others as they are.",
        row="requirement and parameter",
        key=(*LIMIT_KEY, "parameter"),
        columns=(
            *LIMIT,
            Column("parameter", "", "With its unit."),
            Column("minus", "in `parameter`", "Its side below the nominal."),
            Column("plus", "in `parameter`", "Its side above the nominal."),
            Column(
                "violated_minus",
                "in `parameter`",
                "The side below, where the tolerance has grown until it violates.",
            ),
            Column("violated_plus", "in `parameter`", "The side above, there."),
            Column("factor", "", "On both sides."),
            Column("looked_up_to", "", "Largest factor that was looked at."),
            Column("status", "", "Why it could not be found; empty if it was."),
            *IDENTITY,
        ),
    ),
    FileKind(
        name="table_4.csv",
        studies=(VERIFY,),
        what="The paper's Table 4, where its objectives are looked at: conditions "
        "after separation, then M (maximum), m (minimum), Nom (nominal) or the value "
        "of each property.",
        row="condition or property",
        key=("condition or property",),
        columns=(
            Column("condition or property", "", "With its unit."),
            Column("{label}", "in the row's name", "In this run; printed ones in ()."),
        ),
    ),
)
