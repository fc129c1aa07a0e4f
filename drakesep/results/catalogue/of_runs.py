"""Files of runs: metrics, motion, loads, clearances."""

from drakesep.results.catalogue.columns import (
    IDENTITY,
    LIMIT,
    LIMIT_KEY,
    MOTION,
    RUN,
    SAME,
    TIME,
)
from drakesep.results.catalogue.file_kind import Column, FileKind
from drakesep.results.catalogue.names import (
    CLEARANCE,
    OF_KEPT_RUNS,
    RUNS,
    SIMULATE,
    TABLE,
    VERIFY,
)


FILES_OF_EACH_RUN = (
    FileKind(
        name="motion.csv",
        studies=(SIMULATE,),
        what="The motion of B.",
        row="sample time",
        key=("time_s",),
        is_long=True,
        columns=MOTION,
    ),
    FileKind(
        name="motion_{label}.csv",
        studies=(VERIFY,),
        what="The motion of B in a run.",
        row="sample time",
        key=("time_s",),
        is_long=True,
        columns=MOTION,
    ),
    FileKind(
        name="motion_{body}.csv",
        studies=(SIMULATE,),
        what="The same of another body that leaves.",
        row="sample time",
        key=("time_s",),
        is_long=True,
        columns=MOTION,
    ),
    FileKind(
        name="motion_{label}_{body}.csv",
        studies=(VERIFY,),
        what="The same of another body that leaves; of a worst case only for the body "
        "whose it is.",
        row="sample time",
        key=("time_s",),
        is_long=True,
        columns=MOTION,
    ),
    FileKind(
        name=f"{RUNS}/{{label}}{TABLE}",
        studies=OF_KEPT_RUNS,
        what="The motion of every body in W, and what joints and springs do, in SI: "
        "what plots and animations are made of. Compressed, which `pandas.read_csv` "
        "reads as it is.",
        row="sample time",
        key=("time_s",),
        is_long=True,
        columns=(
            TIME,
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
        studies=OF_KEPT_RUNS,
        what="What the run is: its role, the parameters that it changes, when "
        "attachments let go and strokes ended, how it ended, its metrics, contacts; "
        "all in SI.",
    ),
)

FILES_OF_RUNS = (
    FileKind(
        name="summary.csv",
        studies=(SIMULATE,),
        what="The run: parameters, metrics, how it ended.",
        row="run",
        key=("label",),
        columns=RUN,
    ),
    FileKind(
        name="requirements_of_run.csv",
        studies=(SIMULATE,),
        what="Whether the run alone meets the requirements, if there are any. That is "
        "no verdict, which is over the tolerances.",
        row="requirement and axis",
        key=LIMIT_KEY,
        columns=(
            *LIMIT,
            Column("value", SAME, "In the run; empty if it does not tell."),
            Column("margin", SAME, "Of that; negative beyond the limit."),
            Column(
                "verdict",
                "",
                "`met`, `not met` or `not looked at`, as how near parts come is not.",
            ),
            *IDENTITY,
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
            TIME,
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
            TIME,
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
