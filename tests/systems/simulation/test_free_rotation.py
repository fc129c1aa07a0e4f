"""A torque-free asymmetric top against Jacobi's elliptic functions."""

import dataclasses

import numpy as np
import pytest
from scipy.special import ellipj
from separations import generic_pair

from drakesep.systems.model.integration import Integration
from drakesep.systems.model.separation import InitialMotion
from drakesep.systems.simulation.simulation import Simulation


def test_torque_free_top():
    """Landau and Lifshitz, Mechanics, section 37: started on the plane w_2 = 0."""
    I1, I2, I3 = 300.0, 500.0, 650.0
    w1, w3 = 0.6, 0.9
    separation = generic_pair(
        initial=InitialMotion(rpy_WA=(0.7, -0.5, 1.9), w_WA_A=(w1, 0.0, w3)),
        springs=False,
        duration=20.0,
    )
    lower, upper = separation.bodies
    upper = dataclasses.replace(upper, I_BBcm_B=(I1, I2, I3, 0.0, 0.0, 0.0))
    separation = dataclasses.replace(separation, bodies=(lower, upper))
    run = Simulation(separation, Integration(accuracy=1e-9)).run()

    energy = I1 * w1**2 + I3 * w3**2  # twice the kinetic energy
    M2 = (I1 * w1) ** 2 + (I3 * w3) ** 2
    assert M2 > energy * I2
    k2 = (I2 - I1) * (energy * I3 - M2) / ((I3 - I2) * (M2 - energy * I1))
    tau = np.sqrt((I3 - I2) * (M2 - energy * I1) / (I1 * I2 * I3)) * run.motion.time
    sn, cn, dn, _ = ellipj(tau, k2)
    w2 = np.sqrt((energy * I3 - M2) / (I2 * (I3 - I2)))
    expected = np.stack([w1 * cn, w2 * sn, w3 * dn], axis=1)
    # 1e-9 a step, over the 20 s and the several hundred steps of the tumble
    assert run.motion.rate == pytest.approx(expected, abs=3e-7)
