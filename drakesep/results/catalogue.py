"""Which files a results folder has, and what their columns mean.

Said once: `study.json` and the page ``docs/results.md`` list them from here. A name in
braces stands for many: ``{label}`` for that of a run, ``{metric}`` for each metric,
whose meaning is that of its registry.
"""

from dataclasses import dataclass
from typing import NamedTuple

from drakesep.analysis.search.judge import CONFIDENCE


SIMULATE, CLEARANCE = "simulate", "clearance"
WORST_CASE, VERIFY = "worst-case", "verify"
SWEEP, CAMPAIGN = "sweep", "campaign"
SENSITIVITY, RARE_EVENTS = "sensitivity", "rare-events"
PROVE = "prove"
_OF_KEPT_RUNS = (SIMULATE, CLEARANCE, WORST_CASE, VERIFY)
STUDIES = (*_OF_KEPT_RUNS, SWEEP, CAMPAIGN, SENSITIVITY, RARE_EVENTS, PROVE)
"""Those that write a folder."""
STUDY, CASE = "study.json", "case.json"
RUNS = "runs"
"""Folder of what is kept of each run."""
TABLE = ".csv.gz"
"""Ending of their motion: of many bodies it takes megabytes, a third of them so."""
GEOMETRY = "geometry"
"""Folder of the meshes, as they were when they were measured."""


class Column(NamedTuple):
    """A column of a table, or many by a name in braces."""

    name: str
    unit: str
    what: str


@dataclass(frozen=True, kw_only=True)
class FileKind:
    """A file, or many by a name in braces."""

    name: str
    studies: tuple[str, ...]
    """That write it."""
    what: str
    row: str = ""
    """What a row of the table is for; empty if it is no table."""
    columns: tuple[Column, ...] = ()
    key: tuple[str, ...] = ()
    """Columns that tell its rows apart; what has the same values there is told by its
    order."""
    is_long: bool = False
    """Whether its rows are so many that of each column only the greatest difference
    from another such table is worth telling."""

    def named(self, label: str, body: str) -> str:
        """Return its name for a run and a body, if it has one for each."""
        return self.name.replace("{label}", label).replace("{body}", body)

    @property
    def of_each_run(self) -> bool:
        """Whether there is one for each run."""
        return "{label}" in self.name

    @property
    def of_each_body(self) -> bool:
        """Whether there is one for each body that leaves, but the first."""
        return "{body}" in self.name


_SAME = "as `unit` says"
_LIMIT_KEY = ("pair", "requirement", "axis", "sense", "share", "id")
_LABEL = Column("label", "", "Of the run, by which plots and files name it.")
_ROLE = Column(
    "role",
    "",
    "What the run is: `nominal`, `changed`, `published`, `worst`, or the name of the "
    "search that ended there.",
)
_RUN = (
    _LABEL,
    _ROLE,
    Column("{parameter}", "in the name", "Value of the parameter in the run."),
    Column("{metric}", "in the name", "The metric of the run, see metrics.md."),
    Column(
        "nearest",
        "",
        "The parts that come nearest, if that was measured; of several clearances the "
        "nearest.",
    ),
    Column("nearest_time_s", "s", "When they do."),
    Column("{function}", "in the name", "A function of the run that is required."),
    Column("iterations", "", "Of the search that ended there; empty if none did."),
    Column(
        "evaluations",
        "",
        "Runs flown for it; of a worst case, by all searches for all objectives.",
    ),
    Column(
        "status",
        "",
        "How the run ended, or the search: `completed`, `confirmed` (in Drake), "
        "`converged`, ..., or `failed` with the reason.",
    ),
)
_TIME = Column("time_s", "s", "Since the start of the run.")
_MOTION = (
    _TIME,
    Column("rate_{axis}_deg_s", "deg/s", "Angular velocity of B in W, in B's axes."),
    Column(
        "relative_rate_{axis}_deg_s",
        "deg/s",
        "Angular velocity of B in A, in B's axes.",
    ),
    Column("angle_{axis}_deg", "deg", "Roll, pitch and yaw of B in W."),
    Column(
        "relative_position_{axis}_m", "m", "B's CG from its mated place, in A's axes."
    ),
    Column(
        "relative_velocity_{axis}_m_s",
        "m/s",
        "Velocity of B's CG as seen from A, in A's axes.",
    ),
    Column("acceleration_{axis}_m_s2", "m/s²", "Acceleration of B's CG in W."),
    Column(
        "linear_momentum_change_{axis}_N_s",
        "N s",
        "Given to B by the springs, in B's axes (Eq. 6).",
    ),
    Column(
        "angular_momentum_change_{axis}_N_m_s",
        "N m s",
        "Given to B by the springs about its CG, in B's axes (Eq. 7).",
    ),
    Column(
        "rotation_{axis}_deg",
        "deg",
        "Integral of B's rate in W, in B's axes: all turns counted.",
    ),
    Column(
        "total_rotation_deg",
        "deg",
        "Integral of the modulus of B's rate in W: the angle that it has turned.",
    ),
)
_OBJECTIVE = Column("objective", "", "Whose worst case it is.")
_UNIT = Column("unit", "", "Of the values in the row.")
_LIMIT = (
    Column("requirement", "", "Its quantity, and when it holds."),
    Column("axis", "", "Empty if it has none."),
    _UNIT,
    Column("sense", "", "`<=` or `>=`; `<` or `>` if the limit itself is beyond it."),
    Column("limit", _SAME, "That is required."),
    Column("share", "", "Of launches that must be within it; empty: every run must."),
    Column("confidence", "", "At which a campaign is to show that share."),
    Column("sides", "", "Of a share: `one`; `two`, both limits together."),
)
_IDENTITY = (
    Column(
        "pair",
        "",
        "The body that leaves, or the attachment or spring; empty: all that leave.",
    ),
    Column("id", "", "By which others know the requirement."),
    Column("source", "", "Where it comes from."),
)

_OF_RUNS = (
    FileKind(
        name="motion.csv",
        studies=(SIMULATE,),
        what="The motion of B.",
        row="sample time",
        key=("time_s",),
        is_long=True,
        columns=_MOTION,
    ),
    FileKind(
        name="motion_{label}.csv",
        studies=(VERIFY,),
        what="The motion of B in a run.",
        row="sample time",
        key=("time_s",),
        is_long=True,
        columns=_MOTION,
    ),
    FileKind(
        name="motion_{body}.csv",
        studies=(SIMULATE,),
        what="The same of another body that leaves.",
        row="sample time",
        key=("time_s",),
        is_long=True,
        columns=_MOTION,
    ),
    FileKind(
        name="motion_{label}_{body}.csv",
        studies=(VERIFY,),
        what="The same of another body that leaves; of a worst case only for the body "
        "whose it is.",
        row="sample time",
        key=("time_s",),
        is_long=True,
        columns=_MOTION,
    ),
    FileKind(
        name=f"{RUNS}/{{label}}{TABLE}",
        studies=_OF_KEPT_RUNS,
        what="The motion of every body in W, and what joints and springs do, in SI: "
        "what plots and animations are made of. Compressed, which `pandas.read_csv` "
        "reads as it is.",
        row="sample time",
        key=("time_s",),
        is_long=True,
        columns=(
            _TIME,
            Column("{body}.orientation_{axis}", "", "Quaternion q_WB, w first."),
            Column("{body}.position_{axis}_m", "m", "Of the body's origin in W."),
            Column(
                "{body}.angular_velocity_{axis}_rad_s", "rad/s", "In W, in W's axes."
            ),
            Column("{body}.velocity_{axis}_m_s", "m/s", "Of the body's origin in W."),
            Column("{body}.acceleration_{axis}_m_s2", "m/s²", "Of B's CG in W."),
            Column(
                "{body}.linear_momentum_change_{axis}_N_s",
                "N s",
                "Given to B by the springs, in B's axes (Eq. 6).",
            ),
            Column(
                "{body}.angular_momentum_change_{axis}_N_m_s",
                "N m s",
                "Given to B by the springs about its CG, in B's axes (Eq. 7).",
            ),
            Column(
                "{attachment}.torque_{axis}_N_m",
                "N m",
                "Of the joint on B about its pad, in the joint's frame, fixed in A.",
            ),
            Column(
                "{attachment}.force_{axis}_N",
                "N",
                "Of the joint on B, in the joint's frame, fixed in A.",
            ),
            Column("{spring}.force_N", "N", "Of the spring on B, along its axis."),
        ),
    ),
    FileKind(
        name=f"{RUNS}/{{label}}.json",
        studies=_OF_KEPT_RUNS,
        what="What the run is: its role, the parameters that it changes, when "
        "attachments let go and strokes ended, how it ended, its metrics, contacts; "
        "all in SI.",
    ),
)

_OF_ONE_RUN = (
    FileKind(
        name="summary.csv",
        studies=(SIMULATE,),
        what="The run: parameters, metrics, how it ended.",
        row="run",
        key=("label",),
        columns=_RUN,
    ),
    FileKind(
        name="requirements_of_run.csv",
        studies=(SIMULATE,),
        what="Whether the run alone meets the requirements, if there are any. That is "
        "no verdict, which is over the tolerances.",
        row="requirement and axis",
        key=_LIMIT_KEY,
        columns=(
            *_LIMIT,
            Column("value", _SAME, "In the run; empty if it does not tell."),
            Column("margin", _SAME, "Of that; negative beyond the limit."),
            Column(
                "verdict",
                "",
                "`met`, `not met` or `not looked at`, as how near parts come is not.",
            ),
            *_IDENTITY,
        ),
    ),
    FileKind(
        name="contacts.csv",
        studies=(SIMULATE,),
        what="Contacts of parts that push each other, if the case has `recontact`.",
        row="contact",
        key=("first", "second"),
        columns=(
            Column("first", "", "One part."),
            Column("second", "", "The other."),
            Column("contact_time_s", "s", "When they touch."),
            Column("contact_end_s", "s", "When they have parted."),
            Column("force_max_N", "N", "The largest force between them."),
            Column("impulse_N_s", "N s", "Integral of the force on the second."),
        ),
    ),
    FileKind(
        name="contact_forces.csv",
        studies=(SIMULATE,),
        what="Forces between parts that touch again.",
        row="integration step in contact",
        key=("first", "second", "time_s"),
        is_long=True,
        columns=(
            _TIME,
            Column("first", "", "One part."),
            Column("second", "", "The other."),
            Column("force_N", "N", "Magnitude of the force."),
            Column("force_{axis}_N", "N", "On the second, in W."),
        ),
    ),
    FileKind(
        name="clearance_summary.csv",
        studies=(CLEARANCE,),
        what="How near parts of two bodies come, the nearest first.",
        row="pair of parts",
        key=("first", "second"),
        columns=(
            Column("{side}", "", "Name of the part."),
            Column("{side}_body", "", "Its body."),
            Column("{side}_role", "", "What it is, if the case says so."),
            Column("clearance_mm", "mm", "Smallest distance; 0 if they touch."),
            Column("time_s", "s", "When."),
            Column(
                "separation_mm",
                "mm",
                "How far the body that leaves has moved in its direction then, by its "
                "origin; of two that leave, the one that leaves the other, or that "
                "stands first in the case.",
            ),
            Column(
                "{side}_position_{axis}_mm", "mm", "Nearest point, in its body's axes."
            ),
            Column("contact_time_s", "s", "When they first touch; empty if never."),
            Column(
                "closing_speed_m_s", "m/s", "At which they approach along the normal."
            ),
            Column("status", "", "`clear`, `contact`, or `parted` of touching parts."),
        ),
    ),
    FileKind(
        name="clearance.csv",
        studies=(CLEARANCE,),
        what="How near parts are over time.",
        row="sample time",
        key=("time_s",),
        is_long=True,
        columns=(
            _TIME,
            Column(
                "separation_mm",
                "mm",
                "How far B of the first pair has moved in its direction, by its "
                "origin.",
            ),
            Column(
                "{body}.separation_mm", "mm", "The same of another body that leaves."
            ),
            Column("{part}_to_{part}_mm", "mm", "Distance of the two parts."),
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

_DRAW = (
    Column("failure_case", "", "Its failure case; empty: none."),
    Column("status", "", "`completed`, or `failed` with the reason."),
    Column("{parameter}", "in the name", "Value of the parameter in the draw."),
)
_ESTIMATES = (
    Column("mean", _SAME, "Of these draws."),
    Column("mean_from", _SAME, "Where its interval begins, at 95 %."),
    Column("mean_to", _SAME, "Where that ends."),
    Column("deviation", _SAME, "Standard deviation."),
    Column("least", _SAME, "Of all."),
    Column("greatest", _SAME, "Of all."),
    *(
        Column(f"{name}{end}", _SAME, f"{words}{what}")
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
_OF_CAMPAIGN = (CAMPAIGN, VERIFY)
"""In `verify`, if one was flown beside the worst cases."""
_CAMPAIGN = (
    FileKind(
        name="campaign.csv",
        studies=_OF_CAMPAIGN,
        what="What share of launches meets each requirement, by the draws.",
        row="requirement and axis",
        key=_LIMIT_KEY,
        columns=(
            *_LIMIT,
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
                _SAME,
                "No worse is so large a share of launches, at the confidence; empty if "
                "that is a run that failed. Of two limits together, as far beyond each "
                "as the draw is that decides.",
            ),
            Column("margin", _SAME, "Of the bound; negative beyond the limit."),
            Column("worst", _SAME, "Of all draws that have not failed."),
            Column("worst_margin", _SAME, "Of the worst; negative beyond the limit."),
            Column("worst_draw", "", "Number of the worst draw; of one that failed."),
            Column(
                "worst_failure_case",
                "",
                "That happens in the worst draw; empty: nothing fails in it.",
            ),
            Column(
                "worst_case_found",
                _SAME,
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
            *_IDENTITY,
        ),
    ),
    FileKind(
        name="campaign_worst.csv",
        studies=_OF_CAMPAIGN,
        what="Draws that decide the verdicts, and some at random, flown in Drake.",
        row="draw and quantity",
        key=("quantity", "decides", "rank"),
        columns=(
            Column("quantity", "", "That is compared, with its unit."),
            Column("decides", "", "The limit that it decides; empty at random."),
            Column("rank", "", "1: the worst of all draws; empty at random."),
            Column("draw", "", "Its number, from 0, as `replay --run` takes it."),
            _UNIT,
            Column(
                "value",
                _SAME,
                "By the batch engine; of a clearance that was not measured, what it is "
                "at least.",
            ),
            Column("in_drake", _SAME, "In Drake."),
            *_DRAW[:1],
            Column("status", "", "`confirmed`, or what is different in Drake."),
            *_DRAW[2:],
        ),
    ),
    FileKind(
        name="campaign_statistics.csv",
        studies=_OF_CAMPAIGN,
        what="How each metric is distributed over the draws that tell it.",
        row="metric",
        key=("metric",),
        columns=(
            Column("metric", "", "With its unit."),
            _UNIT,
            Column("draws", "", "That tell it."),
            Column("untold", "", "That do not: runs that failed."),
            *_ESTIMATES,
        ),
    ),
    FileKind(
        name="campaign_convergence.csv",
        studies=_OF_CAMPAIGN,
        what="What the first draws say of each requirement, more and more of them, to "
        "all; without clearances, and of campaigns that keep rows.",
        row="requirement, axis and number of draws",
        key=(*_LIMIT_KEY, "draws"),
        columns=(
            *_LIMIT,
            Column("draws", "", "The first of the campaign: so many."),
            Column("mean", _SAME, "Of those that tell."),
            Column("mean_from", _SAME, "Where its interval begins, at 95 %."),
            Column("mean_to", _SAME, "Where that ends."),
            Column("deviation", _SAME, "Standard deviation."),
            Column(
                "quantile_of",
                "",
                "The share of launches below the quantile: by its limit, as many are "
                "to be within.",
            ),
            Column("quantile", _SAME, "The value below which that share is."),
            Column(
                "quantile_from",
                _SAME,
                "Where its interval begins, at 95 %; infinite by too few draws.",
            ),
            Column("quantile_to", _SAME, "Where that ends; likewise."),
            Column("failures", "", "Draws beyond the limit, as in campaign.csv."),
            Column("share_beyond", "", "Of these draws."),
            Column("share_beyond_from", "", "Where its interval begins, at 95 %."),
            Column("share_beyond_to", "", "Where that ends."),
            *_IDENTITY,
        ),
    ),
    FileKind(
        name="campaign_sensitivities.csv",
        studies=_OF_CAMPAIGN,
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
        studies=_OF_CAMPAIGN,
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
        studies=_OF_CAMPAIGN,
        what="All draws: `metrics` by `metric_names`, in SI; `failure_case` by its "
        "place among those that may happen, -1 for none; `attempts`, how often values "
        "were drawn before that cannot be; `failed` draws and `reasons`; of the "
        "clearances in `clearance_names` what is known at least, "
        "`clearance_at_least`, and whether it was measured, `clearance_measured`. What "
        "draws vary comes again from their numbers.",
    ),
    FileKind(
        name="campaign_tallies.npz",
        studies=_OF_CAMPAIGN,
        what="What is kept of all draws instead, if not rows: of each metric the exact "
        "`sums` and `sums_of_squares`, in units of 2^-1126, `least`, `greatest`, and "
        "`counts` between the `edges` of a histogram, in SI; of each requirement that "
        "is `judged` how many are `beyond`, and the `worst_margins` and `worst_draws`, "
        "`kept` of each, after them the same of each of two limits by itself; "
        "`runs_failed`.",
    ),
    FileKind(
        name="campaign_histograms.csv",
        studies=_OF_CAMPAIGN,
        what="How many draws lie in each bin of each metric, where no rows are kept.",
        row="metric and bin",
        key=("metric", "from"),
        columns=(
            Column("metric", "", "With its unit."),
            _UNIT,
            Column("from", _SAME, "Its lower edge; infinite of what is below all."),
            Column("below", _SAME, "Its upper edge, which is not in it; likewise."),
            Column("draws", "", "In it."),
        ),
    ),
    FileKind(
        name="plan.json",
        studies=_OF_CAMPAIGN,
        what="The frozen plan: case, draws, seed, metrics, tolerance and versions, by "
        "which its chunks are known.",
    ),
    FileKind(
        name="campaign.png",
        studies=_OF_CAMPAIGN,
        what="How each quantity that is required is distributed over the draws, with "
        "its limit, the bound of the share, the worst draw and, in `verify`, the worst "
        "case found.",
    ),
    FileKind(
        name="campaign_scatter.png",
        studies=_OF_CAMPAIGN,
        what="The first 2000 draws of each quantity that is required, at most six of "
        "them, of the axis of the least margin, over the two parameters of largest "
        "rank correlation, with the limit and the draw that decides; of campaigns "
        "that keep rows.",
    ),
)

_DISTRIBUTIONS = (
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
        key=_LIMIT_KEY,
        columns=(
            *_LIMIT,
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
            *_IDENTITY,
        ),
    ),
)

_REMARKS = FileKind(
    name="remarks.csv",
    studies=(*_OF_KEPT_RUNS, SWEEP),
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

_FAILURE = Column(
    "failure_case", "", "Its name; in other tables than of runs also `design`."
)
_BOUND = (
    Column(
        "proven_bound",
        _SAME,
        "No run within the tolerances is beyond it, as is proven: of every value and "
        "combination, inertias that no body can have and what ellipsoids leave out "
        "included; see proof.md. Empty: there is none.",
    ),
    Column("gap_percent", "%", "Of the bound beyond the worst found, of that."),
)

_VERDICT = (
    *_LIMIT,
    Column("nominal", _SAME, "In the nominal run."),
    Column(
        "worst",
        _SAME,
        "Farthest beyond the limit; else nearest to it, and empty if a run "
        "does not tell.",
    ),
    Column("which_run", "", "Label of the worst, or of that run."),
    Column("margin", _SAME, "Of the worst; negative beyond the limit."),
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
    *_BOUND,
    Column("proven", "", "`verdict` of proofs.csv; `not looked at` without `--prove`."),
    Column(
        "verdict",
        "",
        "`met`, `not met` or `not looked at`, which is also what may be broken "
        "by a run that failed, or by a worst case that is not confirmed; and what is "
        "required of a share of launches, unless a campaign tells; then also `not "
        "shown`.",
    ),
    *_IDENTITY,
)

_SEARCHED = (WORST_CASE, VERIFY)
_WORST_CASES = (
    FileKind(
        name="worst_cases.csv",
        studies=_SEARCHED,
        what="All runs flown in Drake: nominal, published, ends of SQP, worst.",
        row="run",
        key=("label",),
        columns=_RUN,
    ),
    FileKind(
        name="comparison.csv",
        studies=_SEARCHED,
        what="The paper's objectives, where they are looked at.",
        row="objective of the paper",
        key=("objective",),
        columns=(
            Column("objective", "", "Its metric."),
            _UNIT,
            Column("nominal", _SAME, "In the nominal run."),
            Column("published", _SAME, "The worst of the published runs."),
            Column("sqp", _SAME, "Where SQP from the nominal ended."),
            Column("worst", _SAME, "Of all runs."),
            Column("which_run", "", "Label of the worst."),
            Column("above_nominal_percent", "%", "Of the nominal's magnitude."),
            Column("above_published_percent", "%", "Of the published's magnitude."),
        ),
    ),
    FileKind(
        name="evidence.csv",
        studies=_SEARCHED,
        what="Why worst cases may be believed, see worst_cases.md.",
        row="worst case",
        key=("objective",),
        columns=(
            _OBJECTIVE,
            _UNIT,
            Column("worst", _SAME, "As the searches have it."),
            Column("in_drake", _SAME, "In the run that Drake flew there."),
            Column("difference", _SAME, "Of the two."),
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
            Column("run_by_run", "", "How many whole runs that took; 0 by metrics."),
            Column("{search}", _SAME, "The worst that this search found."),
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
        studies=_SEARCHED,
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
        studies=_SEARCHED,
        what="The best point of each search.",
        row="objective and search",
        key=("objective", "search"),
        columns=(
            _OBJECTIVE,
            Column("search", "", "Its name."),
            Column("value", _SAME, "Of the objective's metric."),
            _UNIT,
            Column("{parameter}", "in the name", "Its value there."),
        ),
    ),
    FileKind(
        name="iterates.csv",
        studies=_SEARCHED,
        what="The way of every ascent by SQP, of one search after another.",
        row="iterate",
        key=("objective", "search", "start", "iteration"),
        columns=(
            _OBJECTIVE,
            Column("search", "", "Its name."),
            Column(
                "start",
                "",
                "Number of the ascent among those of the objective, from 1; missing of "
                "one whose first run failed.",
            ),
            Column("iteration", "", "Its number; 0 is where the ascent starts."),
            Column("value", _SAME, "Of the objective's metric."),
            _UNIT,
            Column("evaluations", "", "So far."),
            Column("{parameter}", "in the name", "Its value there."),
        ),
    ),
    FileKind(
        name="worst_points.csv",
        studies=_SEARCHED,
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
        studies=_SEARCHED,
        what="What a whole tolerance upward does, and either of its sides, to first "
        "order.",
        row="worst case and parameter",
        key=("objective", "parameter"),
        columns=(
            _OBJECTIVE,
            _UNIT,
            Column("parameter", "", "With its unit."),
            Column("tolerance", "in `parameter`", "The larger of its sides."),
            Column("minus", "in `parameter`", "Its side below the nominal."),
            Column("plus", "in `parameter`", "Its side above the nominal."),
            Column("per_tolerance_at_nominal", _SAME, "Change, at the nominal."),
            Column("per_tolerance_at_worst", _SAME, "Change, at the worst case."),
            Column("downward_at_nominal", _SAME, "Change for all of `minus`, there."),
            Column("downward_at_worst", _SAME, "The same, at the worst case."),
            Column("upward_at_nominal", _SAME, "Change for all of `plus`, there."),
            Column("upward_at_worst", _SAME, "The same, at the worst case."),
            Column("at_worst", "", "M or m at a bound; empty within."),
            Column(
                "multiplier",
                _SAME,
                "Gain of the worst case for a whole tolerance more.",
            ),
        ),
    ),
    FileKind(
        name="requirements.csv",
        studies=(VERIFY,),
        what="The verdict.",
        row="requirement and axis",
        key=_LIMIT_KEY,
        columns=_VERDICT,
    ),
    FileKind(
        name="answers.csv",
        studies=(VERIFY,),
        what="The statistical answer and the worst case found, side by side, if a "
        "campaign was flown.",
        row="requirement and axis",
        key=_LIMIT_KEY,
        columns=(
            *_LIMIT,
            Column("nominal", _SAME, "In the nominal run."),
            Column("bound_of", "", "The share of launches of which the bound is told."),
            Column("at_confidence", "", "At which it is."),
            Column(
                "bound",
                _SAME,
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
            Column("worst_of_draws", _SAME, "Of all draws that have not failed."),
            Column("worst_draw", "", "Number of the worst draw; of one that failed."),
            Column(
                "worst_failure_case",
                "",
                "That happens in the worst draw: beyond what was searched of the "
                "design; empty: nothing fails in it.",
            ),
            Column(
                "worst_case_beyond_bound",
                _SAME,
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
                _SAME,
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
            *_BOUND,
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
            *_IDENTITY,
        ),
    ),
    FileKind(
        name="failure_cases.csv",
        studies=(VERIFY,),
        what="What came of the design and of each failure case, if they are verified.",
        row="failure case",
        key=("failure_case",),
        columns=(
            _FAILURE,
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
        key=("failure_case", *_LIMIT_KEY),
        columns=(_FAILURE, *_VERDICT),
    ),
    FileKind(
        name="failure_runs.csv",
        studies=(VERIFY,),
        what="Runs of each failure case flown in Drake: its nominal and its worst.",
        row="run",
        key=("failure_case", "label"),
        columns=(_FAILURE, *_RUN),
    ),
    FileKind(
        name="tolerances.csv",
        studies=(VERIFY,),
        what="Tolerances that would violate requirements, the others as they are.",
        row="requirement and parameter",
        key=(*_LIMIT_KEY, "parameter"),
        columns=(
            *_LIMIT,
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
            *_IDENTITY,
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

_PROVEN = (PROVE, VERIFY)
"""In `verify`, if it is asked for."""
_PROOFS = (
    FileKind(
        name="proofs.csv",
        studies=_PROVEN,
        what="Proven bounds beside the worst found and the limits, see worst_cases.md; "
        "what no bound covers, with the reason.",
        row="requirement and axis, then objective",
        key=(*_LIMIT_KEY, "objective"),
        columns=(
            Column("requirement", "", "Its quantity; empty of an objective."),
            Column("axis", "", "Empty if it has none."),
            _UNIT,
            Column("sense", "", "`<=` or `<`: it is bounded from above; else below."),
            Column("limit", _SAME, "That is required; empty of an objective."),
            *_LIMIT[5:],
            Column("objective", "", "Of a row that is of no requirement."),
            *_BOUND,
            Column(
                "found",
                _SAME,
                "The worst found: in runs within the tolerances, flown in Drake; in "
                "`prove`, what enclosures show to be attained, in inertias that no "
                "body can have, too.",
            ),
            Column("found_by", "", "Label of that run; or `enclosure`."),
            Column(
                "verdict",
                "",
                "`proven met`: the bound is within the limit; `not proven`; `not "
                "covered`: there is no bound; `bounded`: of an objective, there is; "
                "`contradicted`: a run is beyond the bound, and one of the two is "
                "wrong. Of a share of launches, too, it is over the tolerances, beyond "
                "which draws may be.",
            ),
            Column("reason", "", "Why no more is proven."),
            Column("claim", "", "Its name in proof.json."),
            Column("boxes", "", "That were enclosed for it."),
            *_IDENTITY,
        ),
    ),
    FileKind(
        name="proof.json",
        studies=_PROVEN,
        what="The certificate: the problem, and of each bound the tree of boxes that "
        "proves it, in the form that proof.md says; "
        "`drakesep check-proof proof.json` checks it.",
    ),
)

_PLOTS = (
    FileKind(
        name="proofs.png",
        studies=_PROVEN,
        what="proofs.csv as a plot: found, proven bound and limit, as shares of the "
        "limit.",
    ),
    FileKind(
        name="translation.png",
        studies=(SIMULATE, *_SEARCHED),
        what="Velocity, acceleration and momentum change, after the paper's Fig. 6, of "
        "the push and over the whole run, with limits and the runs that decide them; "
        "and what else is required of speeds, displacements and forces.",
    ),
    FileKind(
        name="rotation.png",
        studies=(SIMULATE, *_SEARCHED),
        what="Angles, rates and momentum change, after the paper's Fig. 7, likewise; "
        "and what else is required of angles, rates and torques.",
    ),
    FileKind(
        name="translation_{body}.png",
        studies=(SIMULATE, *_SEARCHED),
        what="The same of another body that leaves.",
    ),
    FileKind(
        name="rotation_{body}.png",
        studies=(SIMULATE, *_SEARCHED),
        what="The same of another body that leaves.",
    ),
    FileKind(
        name="tornado.png",
        studies=_SEARCHED,
        what="What each tolerance does to each objective: sensitivities.csv as a plot.",
    ),
    FileKind(
        name="failure_cases.png",
        studies=(VERIFY,),
        what="failure_requirements.csv as a plot: nominal and worst of each case.",
    ),
    FileKind(
        name="worst_clearance.png",
        studies=_SEARCHED,
        what="The distance of the nearest pair, nominal and worst, with limits.",
    ),
    FileKind(
        name="sweep.png",
        studies=(SWEEP,),
        what="What is required over the parameter, with its limits, where one is "
        "swept.",
    ),
    FileKind(
        name="clearance.png", studies=(CLEARANCE,), what="clearance.csv as a plot."
    ),
    FileKind(
        name="swept.png",
        studies=(CLEARANCE,),
        what="The space that parts of B sweep past those of A.",
    ),
    FileKind(
        name="swept_{body}.png",
        studies=(CLEARANCE,),
        what="The same of another body that leaves.",
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
    *_OF_ONE_RUN,
    *_VARIANTS,
    *_CAMPAIGN,
    *_DISTRIBUTIONS,
    *_WORST_CASES,
    *_PROOFS,
    *_PLOTS,
    *_OF_RUNS,
)
"""All but those of `GEOMETRY`."""
