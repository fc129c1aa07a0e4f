"""Plots."""

from drakesep.results.catalogue.file_kind import FileKind
from drakesep.results.catalogue.names import (
    CLEARANCE,
    PROVEN,
    SEARCHED,
    SIMULATE,
    SWEEP,
    VERIFY,
)


PLOT_FILES = (
    FileKind(
        name="proofs.png",
        studies=PROVEN,
        what="proofs.csv as a plot: found, proven bound and limit, as shares of the "
        "limit.",
    ),
    FileKind(
        name="translation.png",
        studies=(SIMULATE, *SEARCHED),
        what="Velocity, acceleration and momentum change, after the paper's Fig. 6, of "
        "the push and over the whole run, with limits and the runs that decide them; "
        "and what else is required of speeds, displacements and forces.",
    ),
    FileKind(
        name="rotation.png",
        studies=(SIMULATE, *SEARCHED),
        what="Angles, rates and momentum change, after the paper's Fig. 7, likewise; "
        "and what else is required of angles, rates and torques.",
    ),
    FileKind(
        name="translation_{body}.png",
        studies=(SIMULATE, *SEARCHED),
        what="The same of another body that leaves.",
    ),
    FileKind(
        name="rotation_{body}.png",
        studies=(SIMULATE, *SEARCHED),
        what="The same of another body that leaves.",
    ),
    FileKind(
        name="tornado.png",
        studies=SEARCHED,
        what="What each tolerance does to each objective: sensitivities.csv as a plot.",
    ),
    FileKind(
        name="failure_cases.png",
        studies=(VERIFY,),
        what="failure_requirements.csv as a plot: nominal and worst of each case.",
    ),
    FileKind(
        name="worst_clearance.png",
        studies=SEARCHED,
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
