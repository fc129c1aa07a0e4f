"""A plain case of the trade, that tests vary."""

import copy
import math

from drakesep.case_file.case import Case


JOINT = {
    "stiffness_N_m": 1e6,
    "damping_N_s_m": 5e3,
    "angular_stiffness_N_m_rad": 1e5,
    "angular_damping_N_m_s_rad": 500.0,
}
PAD = 400.0 / math.sqrt(2.0)
PADS = [(PAD, PAD), (-PAD, PAD), (-PAD, -PAD), (PAD, -PAD)]
BODIES = {
    "lv": {
        "mass_kg": 2000.0,
        "cg_mm": [-1200.0, 0.0, 0.0],
        "inertia_kg_m2": {"xx": 1500.0, "yy": 2500.0, "zz": 2500.0},
    },
    "sc": {
        "mass_kg": 500.0,
        "cg_mm": [600.0, 0.0, 0.0],
        "inertia_kg_m2": {"xx": 180.0, "yy": 120.0, "zz": 120.0},
    },
}
SPEED = math.sqrt(2.0 * (4.0 * 0.5 * 500.0 * 0.08) / 400.0)
"""Four springs of 500 N over 80 mm on a reduced mass of 400 kg: sqrt(2 E / mu), m/s."""


def symmetric_design(**changes: object) -> Case:
    """Four equal springs by displacement, all CGs on the axis: nothing turns."""
    data: dict[str, object] = {
        "name": "symmetric",
        "pair": {"A": "lv", "B": "sc"},
        "bodies": BODIES,
        "attachments": {
            f"a{i}": {
                "A": "lv",
                "B": "sc",
                "position_mm": [0.0, y, z],
                "joint": JOINT,
                "spring": {
                    "name": f"s{i}",
                    "law": "displacement",
                    "force_max_N": 500.0,
                    "stroke_mm": 80.0,
                },
                "release_time_s": 0.0,
            }
            for i, (y, z) in enumerate(PADS, 1)
        },
        "run": {"duration_s": 1.0, "accuracy": 1e-8},
    }
    return Case.model_validate(copy.deepcopy(data | changes))
