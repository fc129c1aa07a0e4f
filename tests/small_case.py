"""A case that takes a second: two bodies, two springs, three tolerances.

Every requirement is met, in the failure case too, and those that can be reached are as
tolerances grow.
"""

import copy
from pathlib import Path

from ruamel.yaml import YAML


_FREE = {
    "stiffness_N_m": 0.0,
    "damping_N_s_m": 0.0,
    "angular_stiffness_N_m_rad": 0.0,
    "angular_damping_N_m_s_rad": 0.0,
}
_SMALL = {
    "name": "small",
    "pair": {"A": "lower", "B": "upper"},
    "bodies": {
        "lower": {
            "mass_kg": 700.0,
            "cg_mm": [-800.0, 50.0, -30.0],
            "inertia_kg_m2": {
                **{"xx": 300.0, "yy": 420.0, "zz": 380.0},
                **{"xy": 12.0, "xz": -15.0, "yz": 8.0},
            },
            "geometry": {
                "post": {
                    "box": {"size_mm": [100.0, 100.0, 900.0]},
                    "position_mm": [420.0, 400.0, 30.0],
                    "role": "guide",
                },
                "deck": {
                    "box": {"size_mm": [100.0, 500.0, 500.0]},
                    "position_mm": [-150.0, -100.0, 50.0],
                },
            },
        },
        "upper": {
            "mass_kg": 1200.0,
            "cg_mm": [1100.0, -20.0, 40.0],
            "inertia_kg_m2": {
                **{"xx": 500.0, "yy": 820.0, "zz": 780.0},
                **{"xy": -22.0, "xz": 25.0, "yz": 18.0},
            },
            "geometry": {
                "ball": {
                    "sphere": {"radius_mm": 100.0},
                    "position_mm": [250.0, 200.0, -80.0],
                },
                "mast": {
                    "capsule": {"radius_mm": 30.0, "length_mm": 400.0},
                    "position_mm": [320.0, -300.0, 200.0],
                    "attitude_deg": [0.0, 20.0, 10.0],
                    "role": "antenna",
                },
            },
        },
    },
    "attachments": {
        "one": {
            "A": "lower",
            "B": "upper",
            "position_mm": [0.0, 500.0, 0.0],
            "joint": _FREE,
            "spring": {
                "name": "s1",
                "force_max_N": 1200.0,
                "stroke_mm": 100.0,
                "design_mass_kg": 110.0,
            },
        },
        "two": {
            "A": "lower",
            "B": "upper",
            "position_mm": [0.0, -400.0, 300.0],
            "joint": _FREE,
            "spring": {
                "name": "s2",
                "force_max_N": 1300.0,
                "stroke_mm": 110.0,
                "design_mass_kg": 110.0,
            },
        },
    },
    "before_separation": {
        "attitude_deg": [2.0, -3.0, 4.0],
        "rate_deg_s": [0.5, -0.4, 0.3],
    },
    "dispersions": {
        "upper.mass_kg": 50.0,
        "s1.force_max_N": 60.0,
        "upper.cg_y_mm": 8.0,
    },
    "requirements": [
        {"quantity": "longitudinal_speed_after_separation_m_s", "at_least": 0.49},
        {"quantity": "rate_after_separation_deg_s", "at_most": [0.66, 1.72, 1.25]},
        {"quantity": "deviation_at_separation_deg", "at_most": [2.1, 2.87, 4.0]},
    ],
    "objectives": "paper",
    "failure_cases": {"s1_worn": {"s1.force_max_N": 1180.0}},
    "run": {"duration_s": 0.8},
    "published": [
        {
            "label": "theirs",
            "objectives": ["L1", "PM"],
            "values": {
                "upper.mass_kg": "M",
                "s1.force_max_N": "m",
                "s2.stroke_mm": 112,
            },
            "printed": {
                "rate_deg_s": [0.5, 2.1, 1.1],
                "deviation_within_limits_until_s": 0.7,
                "longitudinal_speed_m_s": 0.52,
                "iterations": 6,
            },
        }
    ],
}


def small_case(**sections) -> dict:
    """The case as a file has it, with sections changed, or left out where None."""
    data = copy.deepcopy(_SMALL) | sections
    return {key: value for key, value in data.items() if value is not None}


def write_case(folder: Path, data: dict, name: str = "case.yaml") -> Path:
    """A file of the case."""
    path = folder / name
    with path.open("w") as file:
        YAML(typ="safe").dump(data, file)
    return path
