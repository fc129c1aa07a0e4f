"""Separations that tests share."""

import dataclasses
import math

import numpy as np

from drakesep.case_file.reader import load_case
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.loads import Load
from drakesep.systems.model.orbit import EARTH_RADIUS, Orbit
from drakesep.systems.model.parameters import with_values
from drakesep.systems.model.profiles import LINEAR
from drakesep.systems.model.separation import (
    Attachment,
    Body,
    InitialMotion,
    Separation,
)
from drakesep.systems.model.springs import DisplacementSpring, Spring


FREE = Joint(K_F=0.0, D_F=0.0, K_T=0.0, D_T=0.0)
STIFF = Joint(K_F=1e7, D_F=5e4, K_T=1e6, D_T=5e3)
GENERIC = InitialMotion(rpy_WA=(0.7, -0.5, 1.9), w_WA_A=(0.05, -0.03, 0.08))
"""Far from the world's axes, where mistakes between frames show."""


def vega() -> Separation:
    return load_case("vega").separation


def inertia_of_points(seed: int, mass: float) -> tuple[float, ...]:
    """Inertia of a cloud of point masses: physical, with products."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(8, 3)) * [1.0, 0.7, 0.5]
    points -= points.mean(axis=0)
    second = mass / len(points) * points.T @ points
    inertia = np.trace(second) * np.eye(3) - second
    order = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
    return tuple(float(inertia[i]) for i in order)


def generic_pair(
    *,
    release_times: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0),
    joint: Joint = STIFF,
    springs: bool = True,
    initial: InitialMotion = GENERIC,
    orbit: Orbit | None = None,
    duration: float = 1.0,
) -> Separation:
    """Two bodies of generic mass properties, on pads around a ring."""
    lower = Body(
        name="lower",
        mass=700.0,
        p_BoBcm_B=(-0.8, 0.05, -0.03),
        I_BBcm_B=inertia_of_points(1, 700.0),
    )
    upper = Body(
        name="upper",
        mass=1200.0,
        p_BoBcm_B=(1.1, -0.02, 0.04),
        I_BBcm_B=inertia_of_points(2, 1200.0),
    )
    attachments = []
    for i, release_time in enumerate(release_times):
        angle = 0.3 + 2.0 * math.pi * i / len(release_times)
        spring = Spring(
            name=f"spring_{i + 1}",
            force_max=1200.0 + 40.0 * i,
            stroke=0.1 + 0.002 * i,
            design_mass=110.0,
        )
        attachments.append(
            Attachment(
                name=f"attachment_{i + 1}",
                A="lower",
                B="upper",
                p_AoPad_A=(0.0, 0.5 * math.cos(angle), 0.5 * math.sin(angle)),
                joint=joint,
                spring=spring if springs else None,
                release_time=release_time,
            )
        )
    return Separation(
        bodies=(lower, upper),
        attachments=tuple(attachments),
        A="lower",
        B="upper",
        initial=initial,
        orbit=orbit,
        duration=duration,
    )


def staged_pair() -> Separation:
    """Tilted springs of both laws, stage by stage, under loads and in orbit."""
    pair = generic_pair(
        release_times=(0.0, 0.03, 0.05),
        joint=Joint(type="revolute", K_F=2e5, D_F=2e3, K_T=2e4, D_T=2e2),
        initial=dataclasses.replace(GENERIC, w_WA_A=(0.2, -0.3, 0.25)),
        orbit=Orbit(radius=EARTH_RADIUS + 7e5),
        duration=0.35,
    )
    first, second, third = (
        dataclasses.replace(spring, tilt_y=0.1 * i, tilt_z=0.15 - 0.1 * i)
        for i, spring in enumerate(pair.springs, 1)
    )
    second = DisplacementSpring(
        name=second.name,
        force_max=2500.0,
        stroke=0.05,
        damping=300.0,
        profile=((0.0, 0.8), (0.3, 1.0), (1.0, 0.4)),
        tilt_y=second.tilt_y,
        tilt_z=second.tilt_z,
    )
    attachments = tuple(
        dataclasses.replace(a, spring=spring)
        for a, spring in zip(pair.attachments, (first, second, third), strict=True)
    )
    rows = ((900.0, 150.0, -80.0), (-100.0, 700.0, 300.0))
    jet = Load(
        name="jet",
        body="upper",
        p_BoQ_B=(0.1, 0.2, 0.0),
        times=(0.0, 0.1),
        forces=rows,
        start=0.02,
    )
    retro = Load(
        name="retro",
        body="lower",
        p_BoQ_B=(0.2, -0.1, 0.3),
        axes="world",
        times=(0.01, 0.1),
        forces=rows,
        torques=rows[::-1],
        start=0.01,
        after=attachments[2].name,
    )
    return dataclasses.replace(pair, attachments=attachments, loads=(jet, retro))


def hinged_pair() -> Separation:
    """Two bodies on one hinge, which lets go at an angle; a spring turns them."""
    pair = generic_pair(release_times=(0.0, math.inf), duration=0.35)
    pushed, hung = pair.attachments
    pushed = dataclasses.replace(
        pushed,
        p_AoPad_A=(0.0, 0.1, 0.6),
        spring=DisplacementSpring(
            name="spring_1", force_max=2e4, stroke=0.1, damping=30.0, tilt_y=0.1
        ),
    )
    hung = dataclasses.replace(
        hung,
        joint=Joint(
            type="revolute",
            K_F=2e5,
            D_F=2e3,
            K_T=2e4,
            D_T=2e2,
            x_axis_A=(0.0, 1.0, 0.0),
            y_axis_A=(0.0, 0.0, 1.0),
        ),
        p_AoPad_A=(0.05, 0.0, -0.6),
        release_angle=0.15,
        spring=None,
    )
    return dataclasses.replace(pair, attachments=(pushed, hung))


def by_displacement(
    separation: Separation, profile=LINEAR, damping: float = 0.0
) -> Separation:
    """The same separation, its springs' forces and strokes by displacement."""
    attachments = tuple(
        dataclasses.replace(
            a,
            spring=DisplacementSpring(
                name=a.spring.name,
                force_max=a.spring.force_max,
                stroke=a.spring.stroke,
                damping=damping,
                profile=profile,
            ),
        )
        for a in separation.attachments
    )
    return dataclasses.replace(separation, attachments=attachments)


def on_axis(separation: Separation) -> tuple[Body, ...]:
    """The bodies with CGs on the axis, and principal axes along it."""
    return tuple(
        dataclasses.replace(
            body,
            p_BoBcm_B=(body.p_BoBcm_B[0], 0.0, 0.0),
            I_BBcm_B=(*body.I_BBcm_B[:3], 0.0, 0.0, 0.0),
        )
        for body in separation.bodies
    )


def coaxial(separation: Separation) -> Separation:
    """CGs on the axis, principal axes along it, equal springs: no rotation."""
    values = {f"{spring.name}.force_max": 1200.0 for spring in separation.springs}
    values |= {f"{spring.name}.stroke": 0.1 for spring in separation.springs}
    separation = dataclasses.replace(
        separation,
        bodies=on_axis(separation),
        initial=InitialMotion(rpy_WA=GENERIC.rpy_WA),
    )
    return with_values(separation, values)


def pushed_on_axis(separation: Separation, springs: int = 1) -> Separation:
    """Bodies that springs push through their CGs: nothing turns."""
    A, B = separation.bodies
    attachments = tuple(
        dataclasses.replace(a, p_AoPad_A=(0.0, 0.0, 0.0))
        for a in separation.attachments[:springs]
    )
    return dataclasses.replace(
        separation,
        bodies=(
            dataclasses.replace(A, p_BoBcm_B=(-0.8, 0.0, 0.0)),
            dataclasses.replace(B, p_BoBcm_B=(1.1, 0.0, 0.0)),
        ),
        attachments=attachments,
    )
