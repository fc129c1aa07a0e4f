"""Every parameter of a separation acts, and alike in both engines.

Small cases in which each one can be felt: joints that hold for a while, tilted springs
with a damper, loads, an orbit, a hinge that lets go at its angle.
"""

import dataclasses
import functools
import math

import numpy as np
import pytest
from separations import GENERIC, generic_pair

from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.analysis.metrics.registry import METRICS
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.loads import Load
from drakesep.systems.model.parameters import declarations, parameters
from drakesep.systems.model.separation import EARTH_RADIUS, Orbit, Separation
from drakesep.systems.model.springs import DisplacementSpring
from drakesep.systems.simulation.simulation import Simulation


LIMITS = (math.inf,) * 3
STEP = {
    "mass": 5.0,
    "length": 2e-3,
    "angle": 5e-3,
    "angular_rate": 5e-3,
    "inertia": 2.0,
    "force": 10.0,
    "damping": 10.0,
    "time": 2e-3,
    "factor": 0.1,
}
"""By which a parameter is moved, in SI: far from what either engine is wrong by."""
WITHOUT_EFFECT: dict[str, str] = {}
"""Parameters that move no metric of their case, and why."""


def staged() -> Separation:
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


def hinged() -> Separation:
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


CASES = {"staged": staged(), "hinged": hinged()}


@functools.cache
def moved(case: str) -> tuple[tuple[str, ...], np.ndarray, np.ndarray, np.ndarray]:
    """Names, nominal metrics, and what each parameter changes in Drake and batch."""
    separation = CASES[case]
    nominal, declared = parameters(separation), declarations(separation)
    names = tuple(nominal)
    rows = np.array(list(nominal.values())) + np.vstack(
        [np.zeros(len(names)), np.diag([STEP[declared[name].kind] for name in names])]
    )
    simulation = Simulation(separation, Integration(accuracy=3e-8))
    drake = [
        list(metrics_of_run(simulation.run(values), LIMITS).values())
        for values in [
            {},
            *({name: rows[i, i - 1]} for i, name in enumerate(names, 1)),
        ]
    ]
    result = Batch(separation, names, tolerance=1e-8).run(rows)
    assert not result.failures
    batch = result.metrics.to_numpy()
    changes = [np.array(m)[1:] - np.array(m)[0] for m in (drake, batch)]
    return names, batch[0], *changes


@pytest.mark.parametrize(
    ("case", "name"), [(c, name) for c, s in CASES.items() for name in parameters(s)]
)
def test_moves_some_metric_alike_in_both_engines(case, name):
    names, nominal, in_drake, in_batch = moved(case)
    i = names.index(name)
    # What both engines together are wrong by, in SI, of motions of 0.1 rad and 1 m/s:
    # 1e-7 at most, from Drake's steps at this accuracy.
    error = 3e-7 * np.maximum(1.0, np.abs(nominal))
    most = np.argmax(np.abs(in_batch[i]) / error)
    felt = np.abs(in_batch[i, most]) > 20.0 * error[most]
    assert felt == (name not in WITHOUT_EFFECT), (METRICS[most], in_batch[i, most])
    assert (np.abs(in_drake[i] - in_batch[i]) < error).all()


def test_reasons_are_of_parameters_that_exist():
    known = {name for case in CASES.values() for name in parameters(case)}
    assert not set(WITHOUT_EFFECT) - known
