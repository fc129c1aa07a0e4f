"""What the verification of a case with sixty dispersed parameters takes.

The built-in case smallsat with all that a builder of such a separation has tolerances
for: masses, centres of gravity and inertias of both bodies, rates before separation,
and of each of the six springs its force, its stroke, where its pad is and how it is
tilted. There are 2^60 corners. Prints what was said beforehand, what it took, step by
step, and what came out.

    python benchmarks/sixty_parameters.py [CASE]
"""

import sys

from promises import kept

from drakesep import load_case


BODIES = {
    "smallsat": {
        "mass_kg": 3.0,
        **dict.fromkeys(("cg_x_mm", "cg_y_mm", "cg_z_mm"), 5.0),
        "inertia_xx_kg_m2": 1.2,
        "inertia_yy_kg_m2": 1.4,
        "inertia_zz_kg_m2": 1.0,
        "inertia_xy_kg_m2": 0.3,
    },
    "upper_stage": {
        "mass_kg": 20.0,
        **dict.fromkeys(("cg_x_mm", "cg_y_mm", "cg_z_mm"), 10.0),
        "inertia_xx_kg_m2": 40.0,
        "inertia_yy_kg_m2": 80.0,
        "inertia_zz_kg_m2": 80.0,
    },
    "before_separation": {f"rate_{axis}_deg_s": 0.3 for axis in "xyz"},
}
SPRING = {
    "force_max_N": 15.0,
    "stroke_mm": 0.5,
    "tilt_y_deg": 0.5,
    "tilt_z_deg": 0.5,
}
PAD = {f"position_{axis}_mm": 0.3 for axis in "xyz"}
PADS = 6


def sixty_tolerances() -> dict[str, float]:
    """Tolerances to either side, by the names that case files have."""
    owners = dict(BODIES)
    for i in range(1, PADS + 1):
        owners[f"spring_{i}"] = SPRING
        owners[f"spring_pad_{i}"] = PAD
    return {
        f"{owner}.{quantity}": tolerance
        for owner, quantities in owners.items()
        for quantity, tolerance in quantities.items()
    }


def main() -> None:
    case = load_case(sys.argv[1] if len(sys.argv) > 1 else "smallsat")
    tolerances = sixty_tolerances()
    assert len(tolerances) == 60
    study = kept(case.replaced(dispersions=tolerances))
    columns = ["objective", "worst", "found_by", "samples", "corners", "multistart"]
    print(study.evidence[columns].to_string(index=False))
    print(study.requirements[["requirement", "axis", "worst", "growth_factor"]])


if __name__ == "__main__":
    main()
