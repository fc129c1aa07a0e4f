"""Springs by displacement in a batch: as exact as springs by time, in as few steps."""

import dataclasses
import math

import numpy as np
import pytest
from batches import (
    NONE,
    around,
    assert_close,
    assert_slopes,
    central_differences,
    drake_figures,
    random_rows,
)
from scipy.optimize import brentq
from separations import FREE, by_displacement, coaxial, generic_pair

from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.analysis.metrics.registry import METRICS
from drakesep.analysis.metrics.requirements import deviation_limits
from drakesep.case_file.reader import load_case
from drakesep.systems import sampling
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.loads import Load
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.profiles import LINEAR
from drakesep.systems.model.separation import Separation
from drakesep.systems.model.springs import DisplacementSpring
from drakesep.systems.simulation.simulation import Simulation


pytestmark = pytest.mark.slow  # compiles programs of its own, for minutes


TABLE = ((0.0, 0.75), (0.2, 1.0), (0.5, 0.5), (1.0, 0.2))
"""It rises, has two corners, and pushes to the end of its stroke."""


# VEGA and the smallsat: as exact as the engine promises, in a few steps. A push is a
# quarter of a period, flown in steps of at most 0.6 rad: three to the first of the k
# ends, one to each of the others, one to the end of the run, and room for one more.


@pytest.mark.parametrize(("name", "ends"), [("vega", 4), ("smallsat", 6)])
def test_cases_against_drake_in_few_steps(name, ends):
    case = load_case(name)
    separation = by_displacement(case.separation)
    limits = deviation_limits(case.limits)
    batch = Batch(separation, case.box.names, deviation_limits=limits)
    rows = random_rows(case, 128)
    result = batch.run(rows)
    assert not result.failures
    assert result.steps.max() <= 3 + (ends - 1) + 1 + 1
    expected = drake_figures(separation, case.box.names, rows[:12], limits)
    assert_close(result.metrics.to_numpy()[:12], expected)


# Corners, jumps and dampers.

PEAKS = [
    i for i, name in enumerate(METRICS) if "max" in name or name in ("G_Linf", "G_PM")
]


@pytest.fixture
def closely_sampled(monkeypatch):
    """Drake's runs every millisecond: their splines know of no corner."""
    monkeypatch.setattr(sampling, "_ROWS", 3000)
    return {"workers": 1}  # in this process, where the patch is


@pytest.mark.parametrize(
    ("profile", "damping", "ends"),
    [(TABLE, 0.0, 3), (LINEAR, 400.0, 2), (TABLE, 300.0, 4)],
    ids=["table", "damper", "both"],
)
def test_corners_and_dampers_against_drake(closely_sampled, profile, damping, ends):
    """In generic motion, with what varies of each spring.

    Each spring has some ends: its corners, where its pad lifts off, and its stroke. The
    first of all is three steps away, as above.
    """
    separation = by_displacement(generic_pair(joint=FREE), profile, damping)
    names = ("spring_1.stroke", "spring_2.force_max", "spring_3.damping", "upper.cg_y")
    rows = around(separation, names, 0.1, 8)
    result = Batch(separation, names).run(rows)
    assert result.steps.max() <= 3 + 4 * ends + 1 + 1
    expected = drake_figures(separation, names, rows, NONE, **closely_sampled)
    got = result.metrics.to_numpy().copy()
    # A peak where a pad lifts off is a kink, which splines of samples round off.
    got[:, PEAKS] = expected[:, PEAKS]
    assert_close(got, expected)
    finer = Batch(separation, names, tolerance=1e-10).run(rows)
    assert_close(result.metrics.to_numpy(), finer.metrics.to_numpy())


def reduced_mass(separation: Separation) -> float:
    lower, upper = (body.mass for body in separation.bodies)
    return lower * upper / (lower + upper)


def test_the_work_of_a_table():
    """v = sqrt(2 E / mu), with E the area under four tables."""
    separation = by_displacement(coaxial(generic_pair()), TABLE)
    area = np.trapezoid([f for _, f in TABLE], [u for u, _ in TABLE])
    strokes = np.array([0.1, 0.13])
    names = [f"spring_{i}.stroke" for i in (1, 2, 3, 4)]
    result = Batch(separation, names).run(np.column_stack([strokes] * 4))
    speed = np.sqrt(2.0 * 4.0 * 1200.0 * strokes * area / reduced_mass(separation))
    # what the engine promises
    assert result.metrics["longitudinal_speed_after_separation"].to_numpy() == (
        pytest.approx(speed, rel=1e-8)
    )


# A damper whose pad lifts off, is met again while the bodies are pressed together, and
# lifts off for good.

FORCE, STROKE, DAMPING = 1500.0, 0.08, 20_000.0
PRESSED, UNTIL = 75.0, 0.4


def pressed() -> Separation:
    """The coaxial pair on strong dampers, pressed together for a while."""
    pair = coaxial(generic_pair(joint=FREE, duration=3.0))
    spring = DisplacementSpring(
        name="s", force_max=FORCE, stroke=STROKE, damping=DAMPING
    )
    attachments = tuple(
        dataclasses.replace(a, spring=dataclasses.replace(spring, name=a.spring.name))
        for a in pair.attachments
    )
    back = Load(
        name="back",
        body="upper",
        p_BoQ_B=pair.body("upper").p_BoBcm_B,
        times=(0.0, UNTIL),
        forces=((-PRESSED, 0.0, 0.0),) * 2,
        axes="body",
    )
    return dataclasses.replace(pair, attachments=attachments, loads=(back,))


def closed_form(damping: float) -> list[tuple[str, float, float]]:
    """What happens, when, and the speed then: two exponentials, then a parabola."""
    pair = pressed()
    mass = reduced_mass(pair)
    s = v = t = 0.0
    off, happened = False, []
    while True:
        slowed = PRESSED / pair.body("upper").mass if t < UNTIL else 0.0

        def motion(h, s=s, v=v, off=off, slowed=slowed):
            if off:
                return s + h * (v - 0.5 * slowed * h), v - slowed * h
            square, rate = 4.0 * FORCE / STROKE / mass, 4.0 * damping / mass
            root = math.sqrt(0.25 * rate**2 - square)
            a, b = root - 0.5 * rate, -root - 0.5 * rate
            rest = STROKE - slowed / square
            A = (v - b * (s - rest)) / (a - b)
            B = s - rest - A
            at, bt = A * math.exp(a * h), B * math.exp(b * h)
            return rest + at + bt, a * at + b * bt

        def force(h, motion=motion):
            at, speed = motion(h)
            return FORCE * (1.0 - at / STROKE) - damping * speed

        sides = {
            ("met" if off else "off"): lambda h, force=force, off=off: (
                -force(h) if off else force(h)
            ),
            "end": lambda h, motion=motion: STROKE - motion(h)[0],
        }
        last = UNTIL - t if t < UNTIL else 3.0
        grid = np.linspace(0.0, last, 4001)[1:]
        ahead = [(last, "free")]
        for what, side in sides.items():
            crossed = [i for i, h in enumerate(grid) if side(h) < 0.0]
            if crossed:
                i = crossed[0]
                assert i > 0, what  # nothing is over before it has begun
                ahead.append((brentq(side, grid[i - 1], grid[i], xtol=1e-15), what))
        h, what = min(ahead)
        s, v = motion(h)
        t += h
        happened.append((what, t, v))
        if what == "end":
            return happened
        off = {"off": True, "met": False}.get(what, off)


def test_a_pad_that_lifts_off_and_is_met_again():
    """Closed form, Drake and the batch."""
    separation = pressed()
    names = [f"spring_{i}.damping" for i in (1, 2, 3, 4)]
    dampings = np.array([DAMPING, 1.01 * DAMPING])
    forms = [closed_form(damping) for damping in dampings]
    assert [what for what, *_ in forms[0]] == ["off", "met", "free", "off", "end"]
    expected = np.array([form[-1][1:] for form in forms])
    chosen = ["separation_end", "longitudinal_speed_after_separation"]

    result = Batch(separation, names).run(np.column_stack([dampings] * 4))
    # What the engine promises, of the speed; at 0.05 m/s an end is as much later as
    # its place is off.
    got = result.metrics[chosen].to_numpy()
    assert got[:, 1] == pytest.approx(expected[:, 1], abs=1e-9)
    assert got[:, 0] == pytest.approx(expected[:, 0], abs=2e-8)
    # Three crossings of each of four pads, and its stroke; between them dampers of
    # 180 1/s shape the motion, in steps that follow it.
    assert result.steps.max() <= 4 * 4 + 40

    simulation = Simulation(separation, Integration(accuracy=1e-11))
    for damping, wanted in zip(dampings, expected, strict=True):
        run = simulation.run(dict.fromkeys(names, damping))
        metrics = metrics_of_run(run, NONE)
        assert [metrics[name] for name in chosen] == pytest.approx(wanted, abs=2e-8)


# Derivatives.


def test_jacobian_of_springs_by_displacement():
    """In as many steps as the rows alone, of ends that are found and foreseen."""
    case = load_case("smallsat")
    names = ("spring_1.force_max", "spring_2.stroke", "smallsat.mass", "smallsat.cg_y")
    batch = Batch(case.separation, names, tolerance=1e-9)
    # Away from the nominal, whose ends are in order of nothing but its CG.
    row = np.array([310.0, 0.0251, 150.0, 0.003])
    result = batch.jacobian(row[None])
    assert result.steps[0] == batch.run(row[None]).steps[0]
    steps = np.array([0.3, 1e-5, 0.1, 1e-4])
    differences = central_differences(batch, row, steps)
    assert_slopes(result.jacobian[0], differences, steps)


def test_jacobian_of_lifting_off():
    separation = pressed()
    names = ("spring_1.damping", "spring_1.stroke", "back.factor")
    batch = Batch(separation, names, tolerance=1e-9)
    row = np.array([parameters(separation)[name] for name in names]) * [0.99, 1.01, 1.0]
    steps = 1e-4 * row
    result = batch.jacobian(row[None])
    assert result.steps[0] <= 4 * 4 + 60  # as above, at a hundredth of the tolerance
    differences = central_differences(batch, row, steps)
    assert_slopes(result.jacobian[0], differences, steps)
    speed = METRICS.index("longitudinal_speed_after_separation")
    assert (result.jacobian[0, speed] != 0.0).all()
