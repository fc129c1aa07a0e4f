"""The equations of motion of a whole batch, on lanes.

Every scalar of the laws is an array here, whose last axis are the samples. An axis
before it runs over bodies, attachments, springs or loads, so that the size of the
traced program does not grow with the number of bodies.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from drakesep.systems import vectors
from drakesep.systems.equations import gravity as gravity_laws
from drakesep.systems.equations import joints as joint_laws
from drakesep.systems.equations import relative_motion as motion_laws
from drakesep.systems.equations import rigid_body as newton_euler_laws
from drakesep.systems.equations import springs as spring_laws
from drakesep.systems.equations.joints import NO_TURN, HeldJoint
from drakesep.systems.equations.mated_stack import (
    axis_on_B,
    mated_motion,
    mated_orientation,
    pad_on_B,
    place_in_stack,
)
from drakesep.systems.equations.relative_motion import BodyState, Wrench
from drakesep.systems.model.inertia import ENTRIES
from drakesep.systems.model.joints import JointType, holds_all_rotations
from drakesep.systems.model.loads import Load
from drakesep.systems.model.separation import STACK, Separation
from drakesep.systems.model.springs import DisplacementSpring, Spring
from drakesep.systems.vectors import Rotation, Symmetric, Vector


Lanes: TypeAlias = Any
"""A jax array whose last axis are the samples."""

STATES = 13
"""Of a body: quaternion, position, angular and linear velocity, as in Drake's plant."""
_VELOCITIES = 7
_XYZ = ("x", "y", "z")


class BatchParameters(NamedTuple):
    """The parameters of a separation on lanes: m bodies, a attachments, k springs."""

    mass: Lanes
    """(m, n), kg."""
    p_BoBcm_B: Vector
    """Of (m, n), m."""
    I_BBcm_B: Symmetric
    """Of (m, n), kg m^2."""
    inverse_I_BBcm_B: Symmetric
    """Of (m, n), 1/(kg m^2)."""
    p_AoPad_A: Vector
    """Of (a, n), m."""
    p_BoPad_B: Vector
    """Of (a, n), m."""
    release_time: Lanes
    """(a, n), s; infinite where there is none."""
    release_angle: Lanes
    """(a, n), rad; infinite where there is none."""
    force_max: Lanes
    """(k, n), N."""
    stroke: Lanes
    """(k, n), m."""
    frequency: Lanes
    """(k, n), rad/s; 1 for springs driven by displacement."""
    damping: Lanes
    """(k, n), N s/m."""
    push_axis_A: Vector
    """Of (k, n)."""
    p_BoQ_B: Vector
    """Where the loads act, of (l, n), m."""
    load_start: Lanes
    """(l, n), s."""
    load_factor: Lanes
    """(l, n)."""
    rpy_WA: Vector
    """Of (n,), rad."""
    w_WA_A: Vector
    """Of (n,), rad/s."""


class Mode(NamedTuple):
    """What has happened so far."""

    released: Lanes
    """(a, n) time of each attachment's release, s; infinite while it holds."""
    spent: Lanes
    """(k, n) whether each spring has let go of its pad."""
    passed: Lanes
    """(r, n) whether each row of the load tables has been passed, load after load."""


class Timed(NamedTuple):
    """What depends on time alone, at some times: lanes of the stages of a step."""

    spring_force: Lanes
    """(..., k, n) of the springs driven by time, N."""
    r_W: Vector | None
    """W's origin from the centre of the Earth, of (..., n), m; None: no gravity."""
    loads: Sequence[tuple[Vector, Vector]]
    """Force, N, and torque, N m, of each load, of (..., n)."""


class _Joints(NamedTuple):
    """Joints of one type and orientation between the same bodies."""

    attachments: list[int]
    type: JointType
    R_AJ: Rotation | None
    K_F: Vector
    """Of (j, 1), as the others."""
    D_F: Vector
    K_T: Vector
    D_T: Vector
    axis_B: Vector


def rows(lanes: Iterable[Lanes], n: int) -> Lanes:
    """Return (k, n) lanes from k of them, or numbers."""
    listed = [jnp.broadcast_to(jnp.asarray(x, dtype=float), (n,)) for x in lanes]
    return jnp.stack(listed) if listed else jnp.zeros((0, n))


def pick(lanes: Any, index: Any) -> Any:
    """Return one body, or some attachments, of tuples of lanes (..., k, n)."""
    return jax.tree.map(lambda x: x[..., index, :], lanes)


class BatchEquations:
    """The equations of motion of a separation, on lanes."""

    def __init__(self, separation: Separation, varied: Sequence[str] = ()):
        """Prepare.

        Args:
            separation: whose equations they are.
            varied: names of the parameters that vary.
        """
        self.separation = separation
        self.holds = any(
            a.release_time > 0.0 or f"{a.name}.release_time" in varied
            for a in separation.attachments
        )
        """Whether a joint holds at some time: joints are half of a program."""
        self.ends = [separation.ends(a) for a in separation.attachments]
        pushing = [i for i, a in enumerate(separation.attachments) if a.spring]
        self.spring_attachments = pushing
        springs = separation.springs
        self.timed = [k for k, s in enumerate(springs) if isinstance(s, Spring)]
        self.by_stroke = [
            k for k, s in enumerate(springs) if isinstance(s, DisplacementSpring)
        ]
        self.tilted = [
            spring.tilt_y != 0.0
            or spring.tilt_z != 0.0
            or any(f"{spring.name}.tilt_{axis}" in varied for axis in "yz")
            for spring in springs
        ]
        """Whether each spring may push along another axis than A's x axis."""
        self._joints = _group_joints(separation)
        names = [body.name for body in separation.bodies]
        self._load_bodies = [names.index(load.body) for load in separation.loads]
        attachments = [a.name for a in separation.attachments]
        self._load_after = [
            None if load.after is None else attachments.index(load.after)
            for load in separation.loads
        ]

    # The params, and the start.

    def params(self, p: Mapping[str, Lanes], n: int) -> BatchParameters:
        """Return the parameters of a batch.

        Args:
            p: every parameter of the separation by name, (n,) or a single number.
            n: of samples.
        """
        separation = self.separation
        bodies, springs = separation.bodies, separation.springs

        def of(owners: Iterable[Any], quantity: str, missing: float = 0.0) -> Lanes:
            keys = [f"{owner.name}.{quantity}" for owner in owners]
            return rows([p.get(key, missing) for key in keys], n)

        def vector(owners: Iterable[Any], stem: str) -> Vector:
            x, y, z = (of(owners, f"{stem}_{axis}") for axis in _XYZ)
            return x, y, z

        inertia = [of(bodies, f"inertia_{entry}") for entry in ENTRIES]
        pads_A = vector(separation.attachments, "position")
        pads_B = [
            pad_on_B(separation, attachment, tuple(x[i] for x in pads_A))
            for i, attachment in enumerate(separation.attachments)
        ]
        p_BoPad_B = tuple(rows([pad[c] for pad in pads_B], n) for c in range(3))
        force_max = of(springs, "force_max")
        stroke = of(springs, "stroke")
        design_mass = of(springs, "design_mass", missing=1.0)
        timed = np.isin(np.arange(len(springs)), self.timed)[:, None]
        return BatchParameters(
            mass=of(bodies, "mass"),
            p_BoBcm_B=vector(bodies, "cg"),
            I_BBcm_B=inertia,
            inverse_I_BBcm_B=newton_euler_laws.inverse(inertia),
            p_AoPad_A=pads_A,
            p_BoPad_B=p_BoPad_B,
            release_time=of(separation.attachments, "release_time", math.inf),
            release_angle=of(separation.attachments, "release_angle", math.inf),
            force_max=force_max,
            stroke=stroke,
            frequency=jnp.where(
                timed, jnp.sqrt(force_max / (design_mass * stroke)), 1.0
            ),  # Eq. 5
            damping=of(springs, "damping"),
            push_axis_A=spring_laws.push_axis(
                of(springs, "tilt_y"), of(springs, "tilt_z"), jnp
            ),
            p_BoQ_B=vector(separation.loads, "position"),
            load_start=of(separation.loads, "start"),
            load_factor=of(separation.loads, "factor"),
            rpy_WA=tuple(p[f"{STACK}.attitude_{a}"] for a in ("roll", "pitch", "yaw")),
            w_WA_A=tuple(p[f"{STACK}.rate_{axis}"] for axis in _XYZ),
        )

    def start(self, params: BatchParameters) -> tuple[Lanes, Mode]:
        """Return the state (13, m, n) of the mated stack, and that nothing happened."""
        separation = self.separation
        _, n = params.mass.shape
        A, _ = self.pair
        motions = mated_motion(
            separation,
            params.rpy_WA,
            params.w_WA_A,
            pick(params.p_BoBcm_B, A),
            jnp,
        )
        flat = [[x for part in motion for x in part] for motion in motions]
        x = jnp.stack([rows(state, n) for state in zip(*flat, strict=True)])
        return x, Mode(
            jnp.full((len(self.ends), n), jnp.inf),
            jnp.full((len(self.spring_attachments), n), False),
            jnp.full((sum(len(load.times) for load in separation.loads), n), False),
        )

    def mated_place(self, params: BatchParameters) -> tuple[Vector, Vector]:
        """Return B's CG in B, and its place in A while mated, of (n,), m."""
        B = self.separation.body(self.separation.B)
        p_BoBcm_B = pick(params.p_BoBcm_B, self.pair[1])
        return p_BoBcm_B, place_in_stack(B, p_BoBcm_B)

    @property
    def pair(self) -> tuple[int, int]:
        """Indices of the bodies A and B."""
        names = [body.name for body in self.separation.bodies]
        return names.index(self.separation.A), names.index(self.separation.B)

    # What happens at known times.

    def stroke_end(self, params: BatchParameters, mode: Mode) -> Lanes:
        """Return (k, n) when springs driven by time reach their stroke, s."""
        released = mode.released[jnp.array(self.spring_attachments, dtype=int)]
        return released + 0.5 * jnp.pi / params.frequency  # Eq. 5

    def row_times(self, params: BatchParameters, mode: Mode) -> Lanes:
        """Return (r, n) the times of the rows of the load tables, s."""
        times = [jnp.zeros((0, *mode.released.shape[1:]))]
        for i, (load, after) in enumerate(
            zip(self.separation.loads, self._load_after, strict=True)
        ):
            begin = 0.0 if after is None else mode.released[after]
            start = begin + params.load_start[i]
            times.append(start + np.array(load.times)[:, None])
        return jnp.concatenate(times)

    def pushing(self, mode: Mode) -> Lanes:
        """Return (k, n) whether springs are released, and have not let go."""
        released = mode.released[jnp.array(self.spring_attachments, dtype=int)]
        return jnp.isfinite(released) & ~mode.spent

    def at_times(self, t: Lanes, params: BatchParameters, mode: Mode) -> Timed:
        """Return what depends on time alone.

        Args:
            t: (..., n) times within a step, s.
            params: of the batch.
            mode: what has happened by the start of the step.
        """
        orbit = self.separation.orbit
        r_W = None
        if orbit is not None:
            r_W = gravity_laws.orbit_position(t, orbit.radius, orbit.mean_motion, jnp)
        loads, first = [], 0
        times = self.row_times(params, mode)
        for i, load in enumerate(self.separation.loads):
            table = slice(first, first + len(load.times))
            first = table.stop
            count = mode.passed[table].sum(axis=0)
            factor = params.load_factor[i]
            loads.append(_load_between_rows(load, times[table], t, count, factor))
        return Timed(self._timed_forces(t, params, mode), r_W, loads)

    def _timed_forces(self, t: Lanes, params: BatchParameters, mode: Mode) -> Lanes:
        index = jnp.array(self.timed, dtype=int)
        pushing = self.pushing(mode)[index]
        shape = (*t.shape[:-1], *pushing.shape)

        def forces(_: None) -> Lanes:
            attachments = [self.spring_attachments[k] for k in self.timed]
            released = mode.released[jnp.array(attachments, dtype=int)]
            elapsed = jnp.where(pushing, t[..., None, :] - released, 0.0)
            force = spring_laws.spring_force(
                elapsed, params.force_max[index], params.frequency[index], jnp
            )
            return jnp.where(pushing, force, 0.0)

        return lax.cond(pushing.any(), forces, lambda _: jnp.zeros(shape), None)

    # The equations.

    def derivative(
        self, holding: bool, timed: Timed, x: Lanes, params: BatchParameters, mode: Mode
    ) -> Lanes:
        """Return the derivative (13, m, n) of a state (13, m, n).

        Args:
            holding: whether joints are computed: needless once all have let go.
            timed: what depends on time alone, at the state's time.
            x: the state.
            params: of the batch.
            mode: what has happened.
        """
        bodies = motion_laws.body_state(x, 0, _VELOCITIES)
        wrench = self._sum_wrenches(holding, timed, bodies, params, mode)
        alpha, a = newton_euler_laws.accelerations(
            bodies,
            params.mass,
            params.p_BoBcm_B,
            params.I_BBcm_B,
            params.inverse_I_BBcm_B,
            wrench,
        )
        q_dot = newton_euler_laws.quaternion_rate(bodies.q_WB, bodies.w_WB)
        return jnp.stack([*q_dot, *bodies.v_WBo, *alpha, *a])

    def _sum_wrenches(
        self,
        holding: bool,
        timed: Timed,
        bodies: BodyState,
        params: BatchParameters,
        mode: Mode,
    ) -> Wrench:
        orbit = self.separation.orbit
        total = _no_wrench(bodies)
        if orbit is not None and timed.r_W is not None:
            total = gravity_laws.gravity_wrench(
                bodies,
                params.mass,
                params.p_BoBcm_B,
                params.I_BBcm_B,
                timed.r_W,
                orbit.mu,
                jnp,
            )
        if self.spring_attachments:
            springs = self._spring_wrenches(timed, bodies, params, mode)
            total = _add(total, springs)
        if holding:
            total = _add(total, self._joint_wrenches(bodies, params, mode))
        if self.separation.loads:
            total = _add(total, self._load_wrenches(timed, bodies, params))
        return total

    def spring_forces(
        self, timed: Timed, bodies: BodyState, params: BatchParameters, mode: Mode
    ) -> list[Lanes]:
        """Return the force of each spring on B, (n,), N."""
        forces = [jnp.zeros(())] * len(self.spring_attachments)
        for i, k in enumerate(self.timed):
            forces[k] = timed.spring_force[..., i, :]
        pushing = self.pushing(mode)
        for k in self.by_stroke:
            force = spring_laws.positive_part(self.stroke_force(k, bodies, params))
            forces[k] = jnp.where(pushing[k], force, 0.0)
        return forces

    def displacement(
        self, k: int, bodies: BodyState, params: BatchParameters
    ) -> tuple[Lanes, Lanes]:
        """Return how far, m, and how fast, m/s, a spring's pad has moved."""
        i = self.spring_attachments[k]
        a, b = self.ends[i]
        return spring_laws.spring_displacement(
            pick(bodies, a),
            pick(bodies, b),
            pick(params.p_AoPad_A, i),
            pick(params.p_BoPad_B, i),
            self._push_axis(k, params),
        )

    def _push_axis(self, k: int, params: BatchParameters) -> Vector | None:
        axis: Vector = pick(params.push_axis_A, k)
        return axis if self.tilted[k] else None

    def stroke_force(self, k: int, bodies: BodyState, params: BatchParameters) -> Lanes:
        """Return the force of a spring driven by displacement, were it to pull, N."""
        spring = self.separation.springs[k]
        assert isinstance(spring, DisplacementSpring)
        return spring_laws.displacement_spring_force(
            *self.displacement(k, bodies, params),
            params.force_max[k],
            params.stroke[k],
            params.damping[k],
            spring.profile[0][1],
            spring_laws.ramps(spring.profile),
        )

    def spring_wrench_on(
        self,
        body: int,
        timed: Timed,
        bodies: BodyState,
        params: BatchParameters,
        mode: Mode,
    ) -> Wrench:
        """Return the wrench of all springs on one body."""
        return pick(self._spring_wrenches(timed, bodies, params, mode), body)

    def _spring_wrenches(
        self, timed: Timed, bodies: BodyState, params: BatchParameters, mode: Mode
    ) -> Wrench:
        forces = self.spring_forces(timed, bodies, params, mode)
        pairs: dict[tuple[int, int], list[spring_laws.Push]] = {}
        for k, (force, i) in enumerate(
            zip(forces, self.spring_attachments, strict=True)
        ):
            pad, axis = pick(params.p_BoPad_B, i), self._push_axis(k, params)
            pairs.setdefault(self.ends[i], []).append((force, pad, axis))
        total = _Sum(bodies)
        for (a, b), pushes in pairs.items():
            on_A, on_B = spring_laws.springs_wrenches(
                pick(bodies, a), pick(bodies, b), pushes
            )
            total.add(a, on_A)
            total.add(b, on_B)
        return total.wrench

    def _joint_wrenches(
        self, bodies: BodyState, params: BatchParameters, mode: Mode
    ) -> Wrench:
        total = _Sum(bodies)
        held = jnp.isinf(mode.released)
        for (a, b), groups in self._joints.items():
            A, B = pick(bodies, a), pick(bodies, b)
            motion = motion_laws.pair_state(A, B)
            turn = NO_TURN
            if any(holds_all_rotations(group.type) for group in groups):
                q_AB = mated_orientation(
                    self.separation.bodies[a], self.separation.bodies[b]
                )
                turn = joint_laws.rotation_deviation(A, B, q_AB, motion.w_AB, jnp)
            force = torque = moment = (0.0, 0.0, 0.0)
            for group in groups:
                index = jnp.array(group.attachments)
                joint = HeldJoint(
                    *group[1:7],
                    pick(params.p_AoPad_A, index),
                    pick(params.p_BoPad_B, index),
                    group.axis_B,
                )
                pull = joint_laws.pull_at_origin(
                    joint, *joint_laws.joint_pull(joint, motion, turn, jnp)
                )
                force, torque, moment = (
                    vectors.add(before, tuple(_sum_held(x, held[index]) for x in each))
                    for before, each in zip((force, torque, moment), pull, strict=True)
                )
            torque = vectors.add(torque, joint_laws.turning_torque(turn, moment))
            on_A, on_B = motion_laws.wrenches_at_origin(A, motion.p_AoBo, force, torque)
            total.add(a, on_A)
            total.add(b, on_B)
        return total.wrench

    def _load_wrenches(
        self, timed: Timed, bodies: BodyState, params: BatchParameters
    ) -> Wrench:
        total = _Sum(bodies)
        for i, (load, b) in enumerate(
            zip(self.separation.loads, self._load_bodies, strict=True)
        ):
            wrench = motion_laws.load_wrench(
                pick(bodies, b),
                pick(params.p_BoQ_B, i),
                *timed.loads[i],
                load.axes == "body",
            )
            total.add(b, wrench)
        return total.wrench


def _group_joints(separation: Separation) -> dict[tuple[int, int], list[_Joints]]:
    """Return the joints between each pair of bodies, by the bodies' indices."""
    alike: dict[Any, list[int]] = {}
    for i, attachment in enumerate(separation.attachments):
        joint = attachment.joint
        key = separation.ends(attachment), joint.type, joint.R_AJ_if_turned
        alike.setdefault(key, []).append(i)
    pairs: dict[tuple[int, int], list[_Joints]] = {}
    for (ends, joint_type, R_AJ), indices in alike.items():
        attachments = [separation.attachments[i] for i in indices]
        gains = np.array([a.joint.held_gains() for a in attachments])
        axes = np.array([axis_on_B(separation, a) for a in attachments])
        K_F, D_F, K_T, D_T = (
            tuple(gains[:, c : c + 3].T[..., None]) for c in range(0, 12, 3)
        )
        pairs.setdefault(ends, []).append(
            _Joints(
                indices,
                joint_type,
                R_AJ,
                K_F,
                D_F,
                K_T,
                D_T,
                tuple(axes.T[..., None]),
            )
        )
    return pairs


def _sum_held(values: Lanes, held: Lanes) -> Lanes:
    return jnp.where(held, values, 0.0).sum(axis=0)


def _load_between_rows(
    load: Load, times: Lanes, t: Lanes, passed: Lanes, factor: Lanes
) -> tuple[Vector, Vector]:
    """Return force and torque, of (..., n), of a load that has passed some rows."""
    last = len(load.times) - 2
    row = passed - 1
    acts = (row >= 0) & (row <= last)
    row = jnp.clip(row, 0, last)
    length = jnp.diff(jnp.array(load.times))
    begin = jnp.take_along_axis(times, row[None], axis=0)[0]
    s = jnp.where(acts, t - begin, 0.0) / length[row]
    factor = jnp.where(acts, factor, 0.0)

    def between(column: Sequence[Any]) -> Vector:
        values = jnp.array(column)
        before, after = tuple(values[row].T), tuple(values[row + 1].T)
        return motion_laws.between_rows(before, after, s, factor)

    return between(load.forces), between(load.torques)


def _no_wrench(bodies: BodyState) -> Wrench:
    zero = jnp.zeros_like(bodies.q_WB[0])
    return Wrench((zero, zero, zero), (zero, zero, zero))


def _add(first: Wrench, second: Wrench) -> Wrench:
    return Wrench(
        vectors.add(first.torque, second.torque), vectors.add(first.force, second.force)
    )


class _Sum:
    """Adds wrenches up, body by body."""

    def __init__(self, bodies: BodyState):
        count = bodies.q_WB[0].shape[-2]
        zero = jnp.zeros_like(bodies.q_WB[0][..., 0, :])
        none = (zero, zero, zero)
        self._wrenches = [Wrench(none, none)] * count

    def add(self, body: int, wrench: Wrench) -> None:
        self._wrenches[body] = _add(self._wrenches[body], wrench)

    @property
    def wrench(self) -> Wrench:
        return jax.tree.map(lambda *x: jnp.stack(x, axis=-2), *self._wrenches)
