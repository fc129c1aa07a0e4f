"""When is a spring driven by time right? Eq. 5 against a real spring.

    python examples/spring_laws.py [PICTURE]

Flies VEGA with payloads from a tenth to ten times the nominal mass, once with the
paper's springs, whose force is a cosine of time with a fixed design mass, and once with
springs whose force falls with displacement, and draws what the payload gets.
"""

import sys

from matplotlib.figure import Figure

import drakesep
from drakesep.systems import Simulation


FACTORS = (0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.5, 5.0, 10.0)


def by_displacement(case: drakesep.Case) -> drakesep.Case:
    """Return the case with each spring driven by displacement."""
    data = case.model_dump()
    for attachment in data["attachments"].values():
        attachment["spring"] |= {"law": "displacement", "design_mass_kg": None}
    return drakesep.Case.model_validate(data)


def fly(case: drakesep.Case) -> list[tuple[float, float]]:
    """Return speed, m/s, and displacement at the end of the push, m, by factor."""
    simulation = Simulation(case.separation, case.integration)
    payload = case.separation.body("payload")
    results = []
    for factor in FACTORS:
        values = {"payload.mass": factor * payload.mass}
        for axes, moment in zip(
            ("xx", "yy", "zz", "xy", "xz", "yz"), payload.I_BBcm_B, strict=True
        ):
            values[f"payload.inertia_{axes}"] = factor * moment
        run = simulation.run(values)
        motion = run.completed_motion
        at_end = motion.time.searchsorted(run.separation_end)
        results.append(
            (
                float(motion.relative_velocity[at_end, 0]),
                float(motion.relative_position[at_end, 0]),
            )
        )
    return results


def main() -> None:
    """Fly, print and draw."""
    case = drakesep.load_case("vega")
    timed, real = fly(case), fly(by_displacement(case))
    print("mass factor   speed (m/s)          pushed over (mm)")
    print("              Eq. 5  displacement  Eq. 5  displacement")
    for factor, (v5, s5), (v, s) in zip(FACTORS, timed, real, strict=True):
        print(f"{factor:11g}   {v5:5.3f}  {v:12.3f}  {1e3 * s5:5.0f}  {1e3 * s:12.0f}")

    figure = Figure(figsize=(10, 4.2), layout="constrained")
    for axes, i, scale, label in zip(
        figure.subplots(1, 2),
        (0, 1),
        (1.0, 1e3),
        ("speed at the end of the push (m/s)", "pushed over (mm)"),
        strict=True,
    ):
        for rows, name, style in (
            (timed, "Eq. 5, by time", "o--"),
            (real, "by displacement", "s-"),
        ):
            axes.plot(FACTORS, [scale * row[i] for row in rows], style, label=name)
        axes.axvline(1.0, color="#555555", ls=":", lw=1.0)
        axes.set(xscale="log", xlabel="payload mass over nominal", ylabel=label)
        axes.grid(alpha=0.3, which="both")
        axes.legend()
    figure.suptitle("VEGA's springs on lighter and heavier payloads")
    figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "spring_laws.png", dpi=110)


if __name__ == "__main__":
    main()
