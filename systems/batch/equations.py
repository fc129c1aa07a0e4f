"""The equations of motion of a whole batch, on lanes.

Every scalar of the laws is an array here, whose last axis are the samples. An axis
before it runs over bodies, attachments, springs or loads, so that the size of the
traced program does not grow with the number of bodies.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from drakesep.systems.batch.holding_phases import holding_phases, rigid_in
from drakesep.systems.batch.joints import BatchJoints
from drakesep.systems.batch.lanes import (
    BatchParameters,
    Lanes,
    Mode,
    ParameterReader,
    pick,
    rows,
)
from drakesep.systems.batch.mated_places import BatchPlaces
from drakesep.systems.batch.rigid_joints import BatchRigidJoints
from drakesep.systems.batch.springs import BatchSprings
from drakesep.systems.batch.wrenches import WrenchSum, no_wrench
from drakesep.systems.equations import gravity as gravity_laws
from drakesep.systems.equations import loads as load_laws
from drakesep.systems.equations import relative_motion as motion_laws
from drakesep.systems.equations import rigid_body as newton_euler_laws
from drakesep.systems.equations.kepler import ellipse_of, orbit_position
from drakesep.systems.equations.mated_stack import (
    mated_motion,
    mated_spin,
    pad_on_B,
    place_in_A,
)
from drakesep.systems.equations.relative_motion import (
    BodyState,
    RelativeMotion,
    Wrench,
    add_wrenches,
)
from drakesep.systems.equations.rigid_joints import rigid_joints
from drakesep.systems.model.loads import Load
from drakesep.systems.model.parameters import SPIN, parameters
from drakesep.systems.model.separation import Attachment, Body, Pair, Separation
from drakesep.systems.vectors import Vector


STATES = 13
"""Of a body: quaternion, position, angular and linear velocity, as in Drake's plant."""
_VELOCITIES = 7


class Timed(NamedTuple):
    """What depends on time alone, at some times: lanes of the stages of a step."""

    spring_force: Lanes
    """(..., k, n) of the springs driven by time, N."""
    r_W: Vector | None
    """W's origin from the centre of the Earth, of (..., n), m; None: no gravity."""
    loads: Sequence[tuple[Vector, Vector]]
    """Force, N, and torque, N m, of each load, of (..., n)."""


class BatchEquations:
    """The equations of motion of a separation, on lanes."""

    def __init__(self, separation: Separation, varied: Sequence[str] = ()):
        """Prepare.

        Args:
            separation: whose equations they are.
            varied: names of the parameters that vary.
        """
        self.separation = separation
        rigid = rigid_joints(separation)
        self.phases = holding_phases(separation, rigid, varied)
        """Which attachments may hold: each phase is a program of its own."""
        self.ends = [separation.ends(a) for a in separation.attachments]
        self.springs = BatchSprings(separation, varied)
        self.places = BatchPlaces(separation, varied)
        """Of the bodies while mated."""
        self._joints = BatchJoints(separation, self.places)
        self._rigid_joints = [
            BatchRigidJoints(separation, rigid, may_hold, self.places)
            if may_hold
            else None
            for phase in self.phases
            for may_hold in [rigid_in(rigid, phase)]
        ]
        names = [body.name for body in separation.bodies]
        self._load_bodies = [names.index(load.body) for load in separation.loads]
        attachments = [a.name for a in separation.attachments]
        self._load_after = [
            None if load.after is None else attachments.index(load.after)
            for load in separation.loads
        ]
        reader = ParameterReader(parameters(separation), 1)
        jax.eval_shape(lambda: self._read(reader))  # reads, and computes nothing
        self.read = frozenset(reader.read)
        """Names of the parameters that the equations read."""

    # The params, and the start.

    def params(self, p: Mapping[str, Lanes], n: int) -> BatchParameters:
        """Return the parameters of a batch.

        Args:
            p: every parameter of the separation by name, (n,) or a single number.
            n: of samples.
        """
        return self._read(ParameterReader(p, n))

    def _read(self, reader: ParameterReader) -> BatchParameters:
        separation = self.separation
        bodies, attachments = separation.bodies, separation.attachments
        loads, initial = separation.loads, separation.initial
        of_bodies, of_loads = Body.PARAMETERS, Load.PARAMETERS
        of_attachments = Attachment.PARAMETERS
        inertia = reader.vector(of_bodies, bodies, "I_BBcm_B")
        pads_A = reader.vector(of_attachments, attachments, "p_AoPad_A")
        n = pads_A[0].shape[-1]
        places = self.places.read(reader, n)
        pads_B = [
            pad_on_B(places[a], places[b], tuple(x[i] for x in pads_A))
            for i, (a, b) in enumerate(self.ends)
        ]
        springs, push_axis_A = self.springs.read(reader)
        return BatchParameters(
            mass=reader.number(of_bodies, bodies, "mass"),
            p_BoBcm_B=reader.vector(of_bodies, bodies, "p_BoBcm_B"),
            I_BBcm_B=inertia,
            spin=rows([self._read_spin(reader, body) for body in bodies], n),
            inverse_I_BBcm_B=newton_euler_laws.inverse(inertia),
            mated=self.places.lanes(places, n),
            p_AoPad_A=pads_A,
            p_BoPad_B=tuple(rows([pad[c] for pad in pads_B], n) for c in range(3)),
            release_time=reader.number(of_attachments, attachments, "release_time"),
            release_angle=reader.number(of_attachments, attachments, "release_angle"),
            release_travel=reader.number(of_attachments, attachments, "release_travel"),
            springs=springs,
            push_axis_A=push_axis_A,
            push_time=self.springs.push_time(springs, n),
            p_BoQ_B=reader.vector(of_loads, loads, "p_BoQ_B"),
            load_start=reader.number(of_loads, loads, "start"),
            load_factor=reader.number(of_loads, loads, "factor"),
            rpy_WA=tuple(reader.entries(initial, "rpy_WA")),
            w_WA_A=tuple(reader.entries(initial, "w_WA_A")),
        )

    def _read_spin(self, reader: ParameterReader, body: Body) -> Lanes:
        spins = self.separation.spins_on(body) is not None
        return reader.entries(body, SPIN)[0] if spins else 0.0

    def start(self, params: BatchParameters) -> tuple[Lanes, Mode]:
        """Return the state (13, m, n) of the mated stack, and that nothing happened."""
        separation = self.separation
        _, n = params.mass.shape
        A, _ = self.bodies_of(separation.pairs[0])
        places = self.places.of(params)
        pads = [pick(params.p_AoPad_A, i) for i in range(len(self.ends))]
        motions = mated_motion(
            places,
            params.rpy_WA,
            params.w_WA_A,
            pick(params.p_BoBcm_B, A),
            jnp,
            [
                mated_spin(separation, body, places, pads, spin)
                for body, spin in zip(separation.bodies, params.spin, strict=True)
            ],
        )
        flat = [[x for part in motion for x in part] for motion in motions]
        x = jnp.stack([rows(state, n) for state in zip(*flat, strict=True)])
        rows_of_loads = sum(len(load.times) for load in separation.loads)
        return x, Mode(
            released=jnp.full((len(self.ends), n), jnp.inf),
            spent=jnp.full((self.springs.count, n), False),
            corners=jnp.full((len(self.springs.corners), n), False),
            lifted=jnp.full((self.springs.count, n), False),
            passed=jnp.full((rows_of_loads, n), False),
        )

    def mated_place(self, pair: Pair, params: BatchParameters) -> tuple[Vector, Vector]:
        """Return B's CG in B, and its place in A while mated, of (n,), m."""
        a, b = self.bodies_of(pair)
        p_BoBcm_B, places = pick(params.p_BoBcm_B, b), self.places.of(params)
        return p_BoBcm_B, place_in_A(places[a], places[b], p_BoBcm_B)

    def bodies_of(self, pair: Pair) -> tuple[int, int]:
        """Return the indices of a pair's bodies A and B."""
        names = [body.name for body in self.separation.bodies]
        return names.index(pair.A), names.index(pair.B)

    def relative_motion(
        self, pair: Pair, bodies: BodyState, params: BatchParameters
    ) -> RelativeMotion:
        """Return the motion of a pair's B; of bodies (..., m, n), it is of (..., n)."""
        A, B = (pick(bodies, i) for i in self.bodies_of(pair))
        place = self.mated_place(pair, params)
        return motion_laws.relative_motion(A, B, *place, jnp)

    def progress(self, body: str, mode: Mode) -> tuple[Lanes, Lanes]:
        """Return (n,) whether a body has begun to separate, and whether it has ended.

        Args:
            body: that leaves.
            mode: what has happened.
        """
        free = jnp.isfinite(mode.released)
        began, ended = jnp.full(free.shape[1:], False), jnp.full(free.shape[1:], True)
        for attachment in self.separation.attached_to(body):
            i = self.separation.attachments.index(attachment)
            began, ended = began | free[i], ended & free[i]
            if i in self.springs.attachments:
                ended = ended & mode.spent[self.springs.attachments.index(i)]
        return began, ended

    # What happens at known times.

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

    def at_times(self, t: Lanes, params: BatchParameters, mode: Mode) -> Timed:
        """Return what depends on time alone.

        Args:
            t: (..., n) times within a step, s.
            params: of the batch.
            mode: what has happened by the start of the step.
        """
        orbit = self.separation.orbit
        r_W = None if orbit is None else orbit_position(t, ellipse_of(orbit), jnp)
        loads, first = [], 0
        times = self.row_times(params, mode)
        for i, load in enumerate(self.separation.loads):
            table = slice(first, first + len(load.times))
            first = table.stop
            count = mode.passed[table].sum(axis=0)
            factor = params.load_factor[i]
            loads.append(_load_between_rows(load, times[table], t, count, factor))
        return Timed(self.springs.timed_forces(t, params, mode), r_W, loads)

    # The equations.

    @property
    def holds(self) -> bool:
        """Whether a joint holds at some time."""
        return len(self.phases) > 1

    def phase(self, mode: Mode) -> Lanes:
        """Return the place of the first phase that has all that hold in any lane."""
        held = jnp.isinf(mode.released).any(axis=1)
        place = jnp.zeros((), dtype=int)
        for phase in self.phases[:-1]:
            others = [i for i in range(len(self.ends)) if i not in phase]
            place = place + held[np.array(others)].any()
        return place

    def derivative(
        self, phase: int, timed: Timed, x: Lanes, params: BatchParameters, mode: Mode
    ) -> Lanes:
        """Return the derivative (13, m, n) of a state (13, m, n).

        Args:
            phase: place of one that has all joints that hold.
            timed: what depends on time alone, at the state's time.
            x: the state.
            params: of the batch.
            mode: what has happened.
        """
        bodies = motion_laws.body_state(x, 0, _VELOCITIES)
        wrench = self._sum_wrenches(phase, timed, bodies, params, mode)
        alpha, a = newton_euler_laws.accelerations(
            bodies,
            params.mass,
            params.p_BoBcm_B,
            params.I_BBcm_B,
            params.inverse_I_BBcm_B,
            wrench,
        )
        q_dot = newton_euler_laws.quaternion_rate(bodies.q_WB, bodies.w_WB)
        return jnp.stack([*q_dot, *bodies.v_WBo, *alpha, *a])  # Eq. 9

    def _sum_wrenches(
        self,
        phase: int,
        timed: Timed,
        bodies: BodyState,
        params: BatchParameters,
        mode: Mode,
    ) -> Wrench:
        orbit = self.separation.orbit
        total = no_wrench(bodies)
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
        if self.separation.springs:
            springs = self.spring_wrenches(timed, bodies, params, mode)
            total = add_wrenches(total, springs)
        if self.phases[phase] and self._joints:
            joints = self._joints.wrenches(bodies, params, mode)
            total = add_wrenches(total, joints)
        if self.separation.loads:
            total = add_wrenches(total, self._load_wrenches(timed, bodies, params))
        rigid_joints = self._rigid_joints[phase]
        if rigid_joints is not None:
            # Last: what they do follows from all else.
            rigid = rigid_joints.wrenches(bodies, total, params, mode)
            total = add_wrenches(total, rigid)
        return total

    def spring_wrenches(
        self, timed: Timed, bodies: BodyState, params: BatchParameters, mode: Mode
    ) -> Wrench:
        """Return the wrenches of all springs on each body."""
        return self.springs.wrenches(timed.spring_force, bodies, params, mode)

    def _load_wrenches(
        self, timed: Timed, bodies: BodyState, params: BatchParameters
    ) -> Wrench:
        total = WrenchSum(bodies)
        for i, (load, b) in enumerate(
            zip(self.separation.loads, self._load_bodies, strict=True)
        ):
            wrench = load_laws.load_wrench(
                pick(bodies, b),
                pick(params.p_BoQ_B, i),
                *timed.loads[i],
                load.axes == "body",
            )
            total.add(b, wrench)
        return total.wrench


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
        return load_laws.between_rows(before, after, s, factor)

    return between(load.forces), between(load.torques)
