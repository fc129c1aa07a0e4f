"""Rigid joints in the batch engine against Drake's runs."""

import dataclasses
import math

import numpy as np
import pytest
from batches import NONE, assert_close, drake_figures
from separations import generic_pair

from drakesep.analysis.engines.jax.batch import Batch
from drakesep.systems.model.joints import JOINT_TYPES, Joint
from drakesep.systems.model.loads import Load
from drakesep.systems.model.parameters import parameters


AXES = {"x_axis_A": (0.6, 0.8, 0.0), "y_axis_A": (-0.8, 0.6, 0.0)}


def held_by(type, releases=(0.3,)):
    """A pair on rigid joints, turned and pushed by a load, that lets go and goes on."""
    pair = generic_pair(
        release_times=releases, joint=Joint(type=type, rigid=True, **AXES), duration=0.6
    )
    load = Load(
        name="load",
        body="upper",
        p_BoQ_B=(0.4, 0.3, -0.2),
        times=(0.0, 0.6),
        forces=((200.0, -300.0, 150.0), (100.0, 200.0, 300.0)),
    )
    return dataclasses.replace(pair, loads=(load,))


@pytest.mark.parametrize(
    "type",
    [
        pytest.param(type, marks=() if type == "revolute" else pytest.mark.slow)
        for type in JOINT_TYPES
    ],
)
def test_metrics_are_drakes(type):
    separation = held_by(type)
    names = ("lower.mass", "upper.cg_y", "upper.inertia_xy")
    nominal = np.array([parameters(separation)[name] for name in names])
    rows = nominal * [[1.0, 1.0, 1.0], [1.02, 0.9, 1.1]]
    result = Batch(separation, names).run(rows)
    assert not result.failures
    assert_close(
        result.metrics.to_numpy(), drake_figures(separation, names, rows, NONE)
    )


@pytest.mark.slow
def test_joints_that_let_go_one_by_one():
    """Four pads that are one weld until the last lets go."""
    separation = held_by("fixed", (0.1, 0.2, 0.25, 0.3))
    rows = np.array([[parameters(separation)["lower.mass"]]])
    result = Batch(separation, ("lower.mass",)).run(rows)
    expected = drake_figures(separation, ("lower.mass",), rows, NONE)
    assert_close(result.metrics.to_numpy(), expected)


@pytest.mark.slow
def test_jacobian():
    """By central differences of runs, of what has no kink: rates at the end."""
    separation = held_by("revolute")
    names = ("lower.mass", "upper.cg_y")
    batch = Batch(separation, names)
    row = np.array([parameters(separation)[name] for name in names])
    jacobian = batch.jacobian(row[None]).jacobian[0]
    columns = [list(batch.metrics).index(f"final_rate_{axis}") for axis in "xyz"]
    for k, step in enumerate((0.5, 1e-4)):
        probes = row + np.outer([1.0, -1.0], step * np.eye(2)[k])
        up, down = batch.run(probes).metrics.to_numpy()
        slopes = (up - down)[columns] / (2.0 * step)
        # Third derivatives leave (step / value)^2, 1e-6, and runs 1e-9 over the step.
        allowed = 1e-5 * np.abs(slopes).max() + 2e-9 / step
        assert jacobian[columns, k] == pytest.approx(slopes, abs=allowed)


@pytest.mark.slow
def test_released_at_an_angle():
    """Two hinges of one axis, redundant, that let go where they have turned."""
    separation = held_by("revolute", (math.inf, math.inf))
    hinges = tuple(
        dataclasses.replace(
            attachment,
            p_AoPad_A=tuple(0.5 * s * x for x in AXES["x_axis_A"]),
            release_angle=math.radians(1.0),
        )
        for attachment, s in zip(separation.attachments, (1.0, -1.0), strict=True)
    )
    separation = dataclasses.replace(separation, attachments=hinges, duration=1.5)
    rows = np.array([[parameters(separation)["lower.mass"]]])
    result = Batch(separation, ("lower.mass",)).run(rows)
    assert not result.failures
    expected = drake_figures(separation, ("lower.mass",), rows, NONE)
    # An angle is met to 1e-10 of a second by Drake's event isolation at 1e-10.
    assert_close(result.metrics.to_numpy(), expected)


@pytest.mark.slow
@pytest.mark.parametrize("type", JOINT_TYPES)
def test_springs_tend_to_it(type):
    """As 1 / K: a spring that is ten times as stiff is a tenth as far from it."""
    rigid = held_by(type)

    def final_rates(separation):
        row = np.array([[parameters(separation)["lower.mass"]]])
        result = Batch(separation, ("lower.mass",)).run(row)
        assert not result.failures
        return result.metrics[[f"final_rate_{axis}" for axis in "xyz"]].to_numpy()[0]

    exact, errors = final_rates(rigid), []
    for K in (1e7, 1e8):
        D, arm2 = 1.4 * math.sqrt(K * 442.0), 0.25
        gains = {"K_F": K, "D_F": D, "K_T": K * arm2, "D_T": D * arm2}
        joint = Joint(type=type, **gains, **AXES)
        soft = [dataclasses.replace(a, joint=joint) for a in rigid.attachments]
        separation = dataclasses.replace(rigid, attachments=tuple(soft))
        errors.append(np.abs(final_rates(separation) - exact).max())
    # Beside 1 / K the damper leaves 1 / K^(3/2), a few percent here.
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.1)
