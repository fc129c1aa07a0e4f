"""Files of campaigns, of their sensitivities and of rare events."""

from drakesep.results.catalogue.columns import IDENTITY, LIMIT, LIMIT_KEY, SAME, UNIT
from drakesep.results.catalogue.file_kind import Column, FileKind
from drakesep.results.catalogue.names import OF_CAMPAIGN, RARE_EVENTS, SENSITIVITY


_DRAW = (
    Column("failure_case", "", "Its failure case; empty: none."),
    Column("status", "", "`completed`, or `failed` with the reason."),
    Column("{parameter}", "in the name", "Value of the parameter in the draw."),
)

_ESTIMATES = (
    Column("mean", SAME, "Of these draws."),
    Column("mean_from", SAME, "Where its interval begins, at 95 %."),
    Column("mean_to", SAME, "Where that ends."),
    Column("deviation", SAME, "Standard deviation."),
    Column("least", SAME, "Of all."),
    Column("greatest", SAME, "Of all."),
    *(
        Column(f"{name}{end}", SAME, f"{words}{what}")
        for name, words in (
            ("low_3_sigma", "The value below which 0.135 % are"),
            ("median", "The value below which half are"),
            ("high_3_sigma", "The value below which 99.865 % are"),
        )
        for end, what in (
            ("", "."),
            ("_from", ": where its interval begins, at 95 %."),
            ("_to", ": where that ends."),
        )
    ),
)

CAMPAIGN_FILES = (
    FileKind(
        name="campaign.csv",
        studies=OF_CAMPAIGN,
        what="What share of launches meets each requirement, by the draws.",
        row="requirement and axis",
        key=LIMIT_KEY,
        columns=(
            *LIMIT,
            Column("runs", "", "Draws, all independent."),
            Column(
                "failures",
                "",
                "Draws beyond the limit, runs that failed among them; empty if that "
                "was not looked at. Of `sides: two`, beyond either of two limits, as "
                "are `allowed` and the shares.",
            ),
            Column("allowed", "", "How many may be, for the share to be shown."),
            Column("share_shown", "", "That is within at least, at `at_confidence`."),
            Column("share_at_most", "", "That is within at most, likewise."),
            Column("bound_of", "", "The share of which the bound is told."),
            Column("at_confidence", "", "At which it is."),
            Column(
                "bound",
                SAME,
                "No worse is so large a share of launches, at the confidence; empty if "
                "that is a run that failed. Of two limits together, as far beyond each "
                "as the draw is that decides.",
            ),
            Column("margin", SAME, "Of the bound; negative beyond the limit."),
            Column("worst", SAME, "Of all draws that have not failed."),
            Column("worst_margin", SAME, "Of the worst; negative beyond the limit."),
            Column("worst_draw", "", "Number of the worst draw; of one that failed."),
            Column(
                "worst_failure_case",
                "",
                "That happens in the worst draw; empty: nothing fails in it.",
            ),
            Column(
                "worst_case_found",
                SAME,
                "That searches have found within the tolerances; in `verify` alone.",
            ),
            Column("deciding_draw", "", "Number of the draw that is the bound."),
            Column("failed", "", "Runs that failed, which count as beyond."),
            Column(
                "measured",
                "",
                "Draws whose clearance was measured: the others are proven not to come "
                "as near as decides it. Empty of what every draw tells.",
            ),
            Column(
                "consumers_risk",
                "",
                "The chance that a design with just too small a share would pass.",
            ),
            Column(
                "share_that_passes",
                "",
                "The producer's risk: how large a share of launches must be within, "
                "for a design to pass so many draws with a chance of `at_confidence`; "
                "1 if nothing passes.",
            ),
            Column(
                "verdict",
                "",
                "`met`: the share is shown; `not met`: that it is not met is shown, or "
                "a run is beyond what every run must keep; `not shown`: neither, by so "
                "few runs; `not looked at`: no run tells, Drake does not confirm, or "
                "every run must, and none of these is beyond.",
            ),
            *IDENTITY,
        ),
    ),
    FileKind(
        name="campaign_worst.csv",
        studies=OF_CAMPAIGN,
        what="Draws that decide the verdicts, and some at random, flown in Drake.",
        row="draw and quantity",
        key=("quantity", "decides", "rank"),
        columns=(
            Column("quantity", "", "That is compared, with its unit."),
            Column("decides", "", "The limit that it decides; empty at random."),
            Column("rank", "", "1: the worst of all draws; empty at random."),
            Column("draw", "", "Its number, from 0, as `replay --run` takes it."),
            UNIT,
            Column(
                "value",
                SAME,
                "By the batch engine; of a clearance that was not measured, what it is "
                "at least.",
            ),
            Column("in_drake", SAME, "In Drake."),
            *_DRAW[:1],
            Column("status", "", "`confirmed`, or what is different in Drake."),
            *_DRAW[2:],
        ),
    ),
    FileKind(
        name="campaign_statistics.csv",
        studies=OF_CAMPAIGN,
        what="How each metric is distributed over the draws that tell it.",
        row="metric",
        key=("metric",),
        columns=(
            Column("metric", "", "With its unit."),
            UNIT,
            Column("draws", "", "That tell it."),
            Column("untold", "", "That do not: runs that failed."),
            *_ESTIMATES,
        ),
    ),
    FileKind(
        name="campaign_convergence.csv",
        studies=OF_CAMPAIGN,
        what="What the first draws say of each requirement, more and more of them, to "
        "all; without clearances, and of campaigns that keep rows.",
        row="requirement, axis and number of draws",
        key=(*LIMIT_KEY, "draws"),
        columns=(
            *LIMIT,
            Column("draws", "", "The first of the campaign: so many."),
            Column("mean", SAME, "Of those that tell."),
            Column("mean_from", SAME, "Where its interval begins, at 95 %."),
            Column("mean_to", SAME, "Where that ends."),
            Column("deviation", SAME, "Standard deviation."),
            Column(
                "quantile_of",
                "",
                "The share of launches below the quantile: by its limit, as many are "
                "to be within.",
            ),
            Column("quantile", SAME, "The value below which that share is."),
            Column(
                "quantile_from",
                SAME,
                "Where its interval begins, at 95 %; infinite by too few draws.",
            ),
            Column("quantile_to", SAME, "Where that ends; likewise."),
            Column("failures", "", "Draws beyond the limit, as in campaign.csv."),
            Column("share_beyond", "", "Of these draws."),
            Column("share_beyond_from", "", "Where its interval begins, at 95 %."),
            Column("share_beyond_to", "", "Where that ends."),
            *IDENTITY,
        ),
    ),
    FileKind(
        name="campaign_sensitivities.csv",
        studies=OF_CAMPAIGN,
        what="Spearman's rank correlation of each metric with each parameter, over the "
        "first 100 000 draws.",
        row="metric and parameter",
        key=("metric", "parameter"),
        columns=(
            Column("metric", "", "With its unit."),
            Column("parameter", "", "With its unit."),
            Column("rank_correlation", "", "1: it grows whenever the parameter does."),
            Column("from", "", "Where its interval begins, at 95 %."),
            Column("to", "", "Where that ends."),
        ),
    ),
    FileKind(
        name="campaign_runs.csv.gz",
        studies=OF_CAMPAIGN,
        what="All draws, of a campaign of at most 20 000.",
        row="draw",
        key=("draw",),
        is_long=True,
        columns=(
            Column("draw", "", "Its number, from 0."),
            *_DRAW,
            Column(
                "{metric}",
                "in the name",
                "The metric of the run, see metrics.md; of clearances those measured.",
            ),
            Column(
                "at_least_{clearance}",
                "in the name",
                "How near parts come at least: as measured, or as is proven.",
            ),
        ),
    ),
    FileKind(
        name="campaign_runs.npz",
        studies=OF_CAMPAIGN,
        what="All draws: `metrics` by `metric_names`, in SI; `failure_case` by its "
        "place among those that may happen, -1 for none; `attempts`, how often values "
        "were drawn before that cannot be; `failed` draws and `reasons`; of the "
        "clearances in `clearance_names` what is known at least, "
        "`clearance_at_least`, and whether it was measured, `clearance_measured`. What "
        "draws vary comes again from their numbers.",
    ),
    FileKind(
        name="campaign_tallies.npz",
        studies=OF_CAMPAIGN,
        what="What is kept of all draws instead, if not rows: of each metric the exact "
        "`sums` and `sums_of_squares`, in units of 2^-1126, `least`, `greatest`, and "
        "`counts` between the `edges` of a histogram, in SI; of each requirement that "
        "is `judged` how many are `beyond`, and the `worst_margins` and `worst_draws`, "
        "`kept` of each, after them the same of each of two limits by itself; "
        "`runs_failed`.",
    ),
    FileKind(
        name="campaign_histograms.csv",
        studies=OF_CAMPAIGN,
        what="How many draws lie in each bin of each metric, where no rows are kept.",
        row="metric and bin",
        key=("metric", "from"),
        columns=(
            Column("metric", "", "With its unit."),
            UNIT,
            Column("from", SAME, "Its lower edge; infinite of what is below all."),
            Column("below", SAME, "Its upper edge, which is not in it; likewise."),
            Column("draws", "", "In it."),
        ),
    ),
    FileKind(
        name="plan.json",
        studies=OF_CAMPAIGN,
        what="The frozen plan: case, draws, seed, metrics, tolerance and versions, by "
        "which its chunks are known.",
    ),
    FileKind(
        name="campaign.png",
        studies=OF_CAMPAIGN,
        what="How each quantity that is required is distributed over the draws, with "
        "its limit, the bound of the share, the worst draw and, in `verify`, the worst "
        "case found.",
    ),
    FileKind(
        name="campaign_scatter.png",
        studies=OF_CAMPAIGN,
        what="The first 2000 draws of each quantity that is required, at most six of "
        "them, of the axis of the least margin, over the two parameters of largest "
        "rank correlation, with the limit and the draw that decides; of campaigns "
        "that keep rows.",
    ),
)

DISTRIBUTION_FILES = (
    FileKind(
        name="sobol_indices.csv",
        studies=(SENSITIVITY,),
        what="What shares of the variance of each metric come from which parameters; "
        "of launches in which nothing fails.",
        row="metric and parameter",
        key=("metric", "parameter"),
        columns=(
            Column("metric", "", "With its unit."),
            Column("parameter", "", "With its unit."),
            Column("first", "", "The share that comes from it alone."),
            Column("first_error", "", "Half the width of its interval, at 95 %."),
            Column("total", "", "With all in which it has a part with others."),
            Column("total_error", "", "Half the width of its interval, at 95 %."),
        ),
    ),
    FileKind(
        name="rare_events.csv",
        studies=(RARE_EVENTS,),
        what="How probable it is to be beyond each limit; of launches in which nothing "
        "fails.",
        row="requirement and axis",
        key=LIMIT_KEY,
        columns=(
            *LIMIT,
            Column("probability", "", "That a launch is beyond the limit."),
            Column("from", "", "Where its interval begins, at 95 %."),
            Column("to", "", "Where that ends."),
            Column("variation", "", "Its coefficient of variation."),
            Column("simulations", "", "That are independent of each other."),
            Column(
                "unreached",
                "",
                "Of them, those that have not reached the limit: they count with the "
                "least probability that was looked for.",
            ),
            Column("runs", "", "That it took."),
            Column("untold", "", "Of them, those that failed: they count as beyond."),
            *IDENTITY,
        ),
    ),
)
