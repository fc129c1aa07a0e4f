"""A vehicle unlike VEGA: six springs of Eq. 5, products of inertia, wide tolerances.

A heavy stage releases a lighter payload from an adapter of 1.2 m, with the springs
beside each other in pairs. Tolerances are one and a half times VEGA's, relative to what
they are of.
"""

import math

from free_bodies import FREE

from drakesep.analysis import AnalysisCase, Requirement
from drakesep.systems.model.orbit import Orbit
from drakesep.systems.model.separation import (
    Attachment,
    Body,
    InitialMotion,
    Separation,
)
from drakesep.systems.model.springs import Spring


ANGLES = (10.0, 50.0, 130.0, 170.0, 250.0, 290.0)
"""Of the springs, from y toward z, deg."""
REDUCED_MASS = 1500.0 * 900.0 / 2400.0


def six_springs() -> Separation:
    stage = Body(
        name="stage",
        mass=1500.0,
        p_BoBcm_B=(-1.4, 0.02, -0.01),
        I_BBcm_B=(900.0, 1600.0, 1500.0, 40.0, -30.0, 25.0),
    )
    payload = Body(
        name="payload",
        mass=900.0,
        p_BoBcm_B=(0.9, 0.004, -0.006),
        I_BBcm_B=(330.0, 520.0, 480.0, 45.0, -35.0, 30.0),
    )
    attachments = tuple(
        Attachment(
            name=f"attachment_{i}",
            A="stage",
            B="payload",
            p_AoPad_A=(
                0.0,
                0.6 * math.cos(math.radians(angle)),
                0.6 * math.sin(math.radians(angle)),
            ),
            joint=FREE,
            spring=Spring(
                name=f"spring_{i}",
                force_max=700.0,
                stroke=0.09,
                design_mass=REDUCED_MASS / 6.0,
            ),
        )
        for i, angle in enumerate(ANGLES, 1)
    )
    return Separation(
        bodies=(stage, payload),
        attachments=attachments,
        A="stage",
        B="payload",
        initial=InitialMotion(
            rpy_WA=(0.01, -0.008, 0.006), w_WA_A=(0.006, -0.008, 0.005)
        ),
        orbit=Orbit(radius=6.98e6),
        duration=3.0,
    )


TOLERANCES = {
    "payload.mass": 15.0,
    "payload.cg_x": 0.014,
    "payload.cg_y": 0.009,
    "payload.cg_z": 0.009,
    "payload.inertia_xx": 50.0,
    "payload.inertia_yy": 80.0,
    "payload.inertia_zz": 73.0,
    "payload.inertia_xy": 30.0,
    "payload.inertia_xz": 30.0,
    "payload.inertia_yz": 30.0,
    **{f"spring_{i}.force_max": 700.0 * 0.015 for i in range(1, 7)},
    **{f"spring_{i}.stroke": 0.09 * 0.015 for i in range(1, 7)},
}


def six_springs_case() -> AnalysisCase:
    limits = [f"rate_after_separation_{axis}" for axis in "xyz"]
    return AnalysisCase(
        separation=six_springs(),
        name="six springs",
        tolerances=TOLERANCES,
        requirements=(
            *(Requirement(metric=m, sense="<=", limit=0.03) for m in limits),
            Requirement(
                metric="longitudinal_speed_after_separation", sense=">=", limit=0.5
            ),
        ),
    )
