"""Two bodies that leave a third, each pushed in a direction of its own."""

import dataclasses

from separations import FREE, generic_pair

from drakesep.systems.model.separation import Pair, Separation


ASIDE = (0.0, 0.6, 0.8)


def three_bodies() -> Separation:
    """A generic pair, and a third body that is pushed aside, later, from the lower."""
    pair = generic_pair(release_times=(0.05, 0.02, 0.09, 0.03), joint=FREE)
    lower, upper = pair.bodies
    third = dataclasses.replace(
        upper,
        name="third",
        mass=300.0,
        p_ABo=(-1.0, 0.9, 1.2),
        rpy_AB=(0.4, -0.2, 0.9),
        I_BBcm_B=(60.0, 70.0, 80.0, 3.0, -2.0, 4.0),
        p_BoBcm_B=(0.2, -0.1, 0.15),
    )
    spring = dataclasses.replace(pair.springs[0], name="spring_5", axis_A=ASIDE)
    port = dataclasses.replace(
        pair.attachments[0],
        name="port",
        B="third",
        p_AoPad_A=(-1.0, 0.9, 1.2),
        release_time=0.2,
        spring=spring,
    )
    return dataclasses.replace(
        pair, bodies=(lower, upper, third), attachments=(*pair.attachments, port)
    )


TO_UPPER = Pair(A="lower", B="upper")
TO_THIRD = Pair(A="lower", B="third", direction=ASIDE)


def with_pairs(first: Pair, *others: Pair) -> Separation:
    return dataclasses.replace(
        three_bodies(), A=first.A, B=first.B, direction=first.direction, others=others
    )
