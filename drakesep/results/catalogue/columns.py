"""Columns that several tables have."""

from drakesep.results.catalogue.file_kind import Column


SAME = "as `unit` says"
LIMIT_KEY = ("pair", "requirement", "axis", "sense", "share", "id")
LABEL = Column("label", "", "Of the run, by which plots and files name it.")
ROLE = Column(
    "role",
    "",
    "What the run is: `nominal`, `changed`, `published`, `worst`, or the name of the "
    "search that ended there.",
)

RUN = (
    LABEL,
    ROLE,
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

TIME = Column("time_s", "s", "Since the start of the run.")
MOTION = (
    TIME,
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

OBJECTIVE = Column("objective", "", "Whose worst case it is.")
UNIT = Column("unit", "", "Of the values in the row.")
LIMIT = (
    Column("requirement", "", "Its quantity, and when it holds."),
    Column("axis", "", "Empty if it has none."),
    UNIT,
    Column("sense", "", "`<=` or `>=`; `<` or `>` if the limit itself is beyond it."),
    Column("limit", SAME, "That is required."),
    Column("share", "", "Of launches that must be within it; empty: every run must."),
    Column("confidence", "", "At which a campaign is to show that share."),
    Column("sides", "", "Of a share: `one`; `two`, both limits together."),
)

IDENTITY = (
    Column(
        "pair",
        "",
        "The body that leaves, or the attachment or spring; empty: all that leave.",
    ),
    Column("id", "", "By which others know the requirement."),
    Column("source", "", "Where it comes from."),
)

FAILURE = Column(
    "failure_case", "", "Its name; in other tables than of runs also `design`."
)

BOUND = (
    Column(
        "proven_bound",
        SAME,
        "No run within the tolerances is beyond it, as is proven: of every value and "
        "combination, inertias that no body can have and what ellipsoids leave out "
        "included; see proof.md. Empty: there is none.",
    ),
    Column("gap_percent", "%", "Of the bound beyond the worst found, of that."),
)
