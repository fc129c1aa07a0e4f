"""What the verification of a case with sixty dispersed parameters takes.

The built-in case smallsat with all that a builder of such a separation has tolerances
for: masses, centres of gravity and inertias of both bodies, rates before separation,
and of each of the six springs its force, its stroke, where its pad is and how it is
tilted. There are 2^60 corners. Prints what was planned, what it took, step by step, and
what came out.

    python benchmarks/sixty_parameters.py [CASE]
"""

import sys
import time

from drakesep import load_case, verify


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
    began = time.perf_counter()
    case = load_case(sys.argv[1] if len(sys.argv) > 1 else "smallsat")
    tolerances = sixty_tolerances()
    assert len(tolerances) == 60
    begun: dict[str, float] = {}
    effort = None

    def tell(progress) -> None:
        nonlocal effort
        if effort is None:
            effort = progress.effort
            print(effort, flush=True)
        begun.setdefault(progress.search.search, time.perf_counter())

    study = verify(case.replaced(dispersions=tolerances), on_progress=tell)
    ended = time.perf_counter()
    print(f"{'before':14} {begun['plan'] - began:7.1f} s")
    steps = [name for name in begun if name != "plan"]
    for name, end in zip(steps, [*(begun[s] for s in steps[1:]), ended], strict=True):
        planned = effort.seconds.get(name, 0.0)
        print(f"{name:14} {end - begun[name]:7.1f} s, planned {planned:7.1f} s")
    print(f"{'all':14} {ended - began:7.1f} s")
    columns = ["objective", "worst", "found_by", "samples", "corners", "multistart"]
    print(study.evidence[columns].to_string(index=False))
    print(study.requirements[["requirement", "axis", "worst", "growth_factor"]])


if __name__ == "__main__":
    main()
