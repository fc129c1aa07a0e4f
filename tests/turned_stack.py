"""A body that stands askew in the stack, and spins, pushed along any axes.

Some springs are stuck, some tilted: all that may vary of the stack does.
"""

import dataclasses

from separations import FREE, generic_pair

from drakesep.systems.model.joints import Joint
from drakesep.systems.model.orbit import Orbit
from drakesep.systems.model.separation import Separation


TOLERANCES = {
    "upper.mated_offset_x": 0.004,
    "upper.mated_offset_y": 0.003,
    "upper.mated_offset_z": 0.002,
    "upper.mated_misalignment_roll": 0.01,
    "upper.mated_misalignment_pitch": 0.015,
    "upper.mated_misalignment_yaw": 0.01,
    "upper.spin": 0.1,
    "upper.cg_x": 0.02,
    "before_separation.rate_y": 0.01,
    "attachment_1.position_y": 0.004,
    "attachment_2.position_z": 0.004,
    "spring_1.tilt_y": 0.03,
    "spring_1.tilt_z": 0.02,
    "spring_2.tilt_z": 0.03,
    "spring_2.force_max": 30.0,
    "spring_3.lost_stroke": 0.05,
    "spring_3.stroke": 0.002,
    "spring_3.tilt_y": 0.02,
    "spring_4.lost_stroke": 0.1,
    "spring_4.design_mass": 2.0,
}
OF_EACH_KIND = (
    "upper.mated_offset_y",
    "upper.mated_misalignment_pitch",
    "upper.spin",
    "attachment_1.position_y",
    "spring_3.tilt_y",
    "spring_4.lost_stroke",
)


def _turned_pair() -> Separation:
    """Springs along any axes, some stuck, push a body that is turned, and spins."""
    pair = generic_pair(orbit=Orbit(radius=7.0e6), duration=0.3)
    axes = ((0.8, 0.6, 0.0), (0.6, 0.0, 0.8), (0.36, 0.48, -0.8), (1.0, 0.0, 0.0))
    lost, tilts = (0.0, 0.0, 0.3, 0.15), (0.05, 0.0, -0.1, 0.0)
    hinge = Joint(
        type="revolute", rigid=True, x_axis_A=(0.6, 0.0, -0.8), y_axis_A=(0.0, 1.0, 0.0)
    )
    attachments = tuple(
        dataclasses.replace(
            a,
            joint=FREE if i else hinge,
            spring=dataclasses.replace(
                a.spring, axis_A=axes[i], lost_stroke=lost[i], tilt_y=tilts[i]
            ),
        )
        for i, a in enumerate(pair.attachments)
    )
    lower, upper = pair.bodies
    upper = dataclasses.replace(
        upper,
        p_ABo=(0.1, 0.03, -0.05),
        rpy_AB=(0.3, -0.2, 0.4),
        mated_offset=(0.002, -0.001, 0.003),
        mated_misalignment=(0.02, -0.01, 0.03),
        spin=0.4,
    )
    return dataclasses.replace(
        pair, bodies=(lower, upper), attachments=attachments, duration=0.3
    )


TURNED = _turned_pair()
