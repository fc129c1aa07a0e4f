"""A certificate made by hand, of what is known in closed form.

A spring pushes two bodies through their CGs; bounded is the speed, over its force and a
mass.
"""

import math
from typing import Any


MASS_A, MASS_B = 700.0, 1900.0
FORCE, STROKE, DESIGN_MASS = 1500.0, 0.12, 500.0
FORCE_SPAN, MASS_SPAN = 15.0, 20.0
IDENTITY = (1, 0, 0, 0, 1, 0, 0, 0, 1)
END_OF_STROKE = math.pi / 2 * math.sqrt(DESIGN_MASS * STROKE / FORCE)


def speed(force: float, mass_B: float) -> float:
    """Return the relative speed that one spring through both CGs leaves (Eq. 5)."""
    return math.sqrt(force * DESIGN_MASS * STROKE) * (1 / MASS_A + 1 / mass_B)


def hexadecimal(x: float) -> str:
    return float(x).hex()


def value(x: float, parameter: int | None = None) -> dict[str, Any]:
    return {"value": hexadecimal(x)} | (
        {} if parameter is None else {"parameter": parameter}
    )


def parameter(name: str, nominal: float, scale: float) -> dict[str, Any]:
    return {
        "name": name,
        "nominal": hexadecimal(nominal),
        "scale": hexadecimal(scale),
        "lower": hexadecimal(-1),
        "upper": hexadecimal(1),
    }


def body(name: str, mass: dict[str, Any], inertia: tuple[float, ...]) -> dict[str, Any]:
    return {
        "name": name,
        "mass": mass,
        "cg": [value(0)] * 3,
        "inertia": [value(x) for x in inertia],
        "orientation": [hexadecimal(x) for x in IDENTITY],
        "turn": [value(0)] * 3,
        "place": [hexadecimal(0)] * 3,
        "offset": [value(0)] * 3,
    }


def push(bound: float) -> dict[str, Any]:
    """Return a certificate: a spring pushes two bodies through their CGs."""
    times = [END_OF_STROKE * i / 4 for i in range(4)] + [1.01 * END_OF_STROKE, 1.0]
    best, middle = [hexadecimal(1), hexadecimal(-1)], [hexadecimal(0)] * 2
    return {
        "format": "drakesep proof 2",
        "made_by": {},
        "problem": {
            "duration": hexadecimal(1),
            "parameters": [
                parameter("spring.force_max", FORCE, FORCE_SPAN),
                parameter("B.mass", MASS_B, MASS_SPAN),
            ],
            "bodies": [
                body("A", value(MASS_A), (300, 350, 360, 0, 0, 0)),
                body("B", value(MASS_B, 1), (700, 3100, 3200, 0, 0, 0)),
            ],
            "pairs": [
                {"A": 0, "B": 1, "reference": [hexadecimal(0)] * 3, "spin": None}
            ],
            "springs": [
                {
                    "name": "spring",
                    "pair": 0,
                    "force_max": value(FORCE, 0),
                    "stroke": value(STROKE),
                    "design_mass": value(DESIGN_MASS),
                    "lost_stroke": value(0),
                    "place": [value(0)] * 3,
                    "frame": [hexadecimal(x) for x in IDENTITY],
                    "tilt": [value(0)] * 2,
                }
            ],
            "attitude": [value(0)] * 3,
            "rate": [value(0.0)] * 3,
            "gravity": None,
        },
        "grid": {"times": [hexadecimal(t) for t in times], "push": 4},
        "method": {},
        "claims": [
            {
                "name": "speed",
                "quantity": {
                    "kind": "peak",
                    "terms": [
                        {
                            "field": "relative_velocity",
                            "pair": 0,
                            "law": "component",
                            "component": 0,
                            "signs": [1],
                            "pieces": [3, 4],
                        }
                    ],
                },
                "bound": hexadecimal(bound),
                "found": hexadecimal(0.999 * bound),
                "at": best,
                "tree": [
                    ["cut", 0, hexadecimal(0)],
                    ["leaf", middle],
                    ["collapse", {"0": "upper"}],
                    ["cut", 1, hexadecimal(0)],
                    ["collapse", {"1": "lower"}],
                    ["leaf", best],
                    ["leaf", [hexadecimal(1), hexadecimal(0)]],
                ],
            }
        ],
    }


LARGEST = speed(FORCE + FORCE_SPAN, MASS_B - MASS_SPAN)
TIGHT = LARGEST * (1 + 1e-9)  # after the push the enclosure of a point is round-off
