"""The same two bodies in MuJoCo, many at once: a yardstick for `throughput.py`.

Springs are actuators at the pads along the launch vehicle's x axis, driven by the mean
of Eq. 5 over each step. Gravity, which falls off along the stack, is left out. RK4,
without contacts.
"""

import math

import mujoco
import numpy as np
from mujoco.rollout import Rollout

from drakesep.systems.equations.mated_stack import (
    mated_ends,
    mated_motion,
    mated_places,
    pad_on_B,
)
from drakesep.systems.model.inertia import inertia_matrix
from drakesep.systems.model.parameters import with_values
from drakesep.systems.model.separation import Separation


class MujocoRollout:
    """Flies variations of a separation of two bodies, all released at t = 0."""

    def __init__(
        self,
        separation: Separation,
        variations: list[dict[str, float]],
        *,
        timestep: float,
        threads: int,
    ):
        flown = [with_values(separation, values) for values in variations]
        self._models = [_model(each, timestep) for each in flown]
        self._data = [mujoco.MjData(self._models[0]) for _ in range(threads)]
        self._initial = np.array(
            [_state(m, each) for m, each in zip(self._models, flown, strict=True)]
        )
        steps = round(separation.duration / timestep)
        edges = timestep * np.arange(steps + 1)
        self._control = np.array([_mean_forces(each, edges) for each in flown])
        self._pool = Rollout(nthread=threads)

    def fly(self) -> np.ndarray:
        """Return (n, 3) final rates of B in W, in B, rad/s."""
        states, _ = self._pool.rollout(
            self._models, self._data, self._initial, self._control
        )
        # time, q (7 + 7), v: a free joint's angular velocity is in the body's axes.
        last = np.asarray(states)[:, -1]
        return last[:, 1 + 14 + 6 + 3 : 1 + 14 + 12]


def _model(separation: Separation, timestep: float) -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    spec.option.timestep = timestep
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    spec.option.gravity = [0.0, 0.0, 0.0]
    bodies = {}
    for body in separation.bodies:
        inertia = inertia_matrix(body.I_BBcm_B)
        order = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
        bodies[body.name] = spec.worldbody.add_body(
            name=body.name,
            mass=body.mass,
            ipos=body.p_BoBcm_B,
            fullinertia=[inertia[i] for i in order],
            explicitinertial=True,
        )
        bodies[body.name].add_freejoint()
    for a in separation.attachments:
        on_A = bodies[a.A].add_site(name=f"{a.name}_A", pos=a.p_AoPad_A)
        on_B = bodies[a.B].add_site(
            name=f"{a.name}_B", pos=pad_on_B(*mated_ends(separation, a), a.p_AoPad_A)
        )
        spec.add_actuator(
            name=a.name,
            target=on_B.name,
            refsite=on_A.name,
            trntype=mujoco.mjtTrn.mjTRN_SITE,
            gear=[1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        )
    return spec.compile()


def _state(model: mujoco.MjModel, separation: Separation) -> np.ndarray:
    data = mujoco.MjData(model)
    initial = separation.initial
    c_A = separation.body(separation.A).p_BoBcm_B
    places = mated_places(separation).values()
    motions = mated_motion(places, initial.rpy_WA, initial.w_WA_A, c_A, math)
    for i, motion in enumerate(motions):
        data.qpos[7 * i : 7 * i + 7] = [*motion.p_WBo, *motion.q_WB]
        # The stack moves as one: every body has A's rate, in axes that coincide.
        data.qvel[6 * i : 6 * i + 6] = [*motion.v_WBo, *initial.w_WA_A]
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.empty(mujoco.mj_stateSize(model, kind))
    mujoco.mj_getState(model, data, state, kind)
    return state


def _mean_forces(separation: Separation, edges: np.ndarray) -> np.ndarray:
    """Return (steps, k) mean forces of the springs: their impulse is exact."""
    columns = []
    for spring in separation.springs:
        t = np.minimum(edges, spring.duration)
        impulse = spring.force_max / spring.frequency * np.sin(spring.frequency * t)
        columns.append(np.diff(impulse) / np.diff(edges))
    return np.stack(columns, axis=1)
