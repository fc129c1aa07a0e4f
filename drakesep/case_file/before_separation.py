"""Motion of the mated stack at t = 0 in a case file: by numbers, or from files."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator
from scipy.spatial.transform import Rotation

from drakesep.case_file.section import File, Section, Vector, to_si
from drakesep.exchange.epochs import parse_epoch
from drakesep.exchange.taken import TakenState, taken_from
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError, Vector3, unknown
from drakesep.systems.equations.mated_stack import mated_places, place_in_stack
from drakesep.systems.model.orbit import Orbit
from drakesep.systems.model.separation import InitialMotion, Separation


def _as_list(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


Files = Annotated[list[File], BeforeValidator(_as_list), Field(min_length=1)]
_ZERO: Vector3 = (0.0, 0.0, 0.0)
_OF_FILES = ("at", "of", "run", "body")


class BeforeSeparationSection(Section):
    """Motion of the mated stack at t = 0: by numbers, or from files.

    With `from`, W's origin is where A's origin is at t = 0, and moves as A's CG does.
    """

    attitude_deg: Vector | None = None
    """Roll, pitch and yaw of A in W; 0 if absent."""
    rate_deg_s: Vector | None = None
    """Angular velocity of A in W, in A's axes; 0 if absent."""
    from_: Files | None = None
    """In place of the attitude, and of the rate if they have one: an AEM, an AEM and an
    OEM, or a `handover.csv`, from the folder of the case file. With an OEM or a table,
    which have the orbit, the case has no `orbit`."""
    at: str | None = None
    """The epoch of t = 0; the files must have it, since nothing is interpolated."""
    of: str | None = None
    """The body whose CG has the position and velocity of the files; if absent, they are
    those of the CG of the mated stack."""
    run: str | None = None
    """Of a `handover.csv`, the label of the run that is gone on with."""
    body: str | None = None
    """Of a `handover.csv`, its body that is the stack now."""

    @model_validator(mode="after")
    def _check_source(self) -> Self:
        if self.from_ is None:
            given = [key for key in _OF_FILES if getattr(self, key) is not None]
            if given:
                raise ValueError(f"{given[0]} must stand with 'from'")
            return self
        if self.attitude_deg is not None:
            raise ValueError("attitude_deg must not stand with 'from', which has it")
        if self.at is None:
            raise ValueError("must have 'at', the epoch of t = 0, got none")
        parse_epoch("at", self.at)
        return self

    def in_si(self) -> InitialMotion:
        """Return the motion by the numbers that are given; see `taken`."""
        return InitialMotion(
            rpy_WA=to_si("attitude", self.attitude_deg or _ZERO),
            w_WA_A=to_si("rate", self.rate_deg_s or _ZERO),
        )

    def taken(self, mated: Separation) -> Separation:
        """Return a separation with the motion and the orbit that files have.

        Args:
            mated: with the bodies in their places, and the orbit of the case.

        Raises:
            ValueError: files cannot be read, or do not fit the case.
        """
        if self.from_ is None or self.at is None:
            return mated
        files = [Path(file) for file in self.from_]
        state = taken_from(files, self.at, self.run, self.body)
        if state.orientation is None:
            raise InputError(
                f"from: must have an attitude, got {', '.join(self.from_)}"
            )
        R_FA = Rotation.from_quat(state.orientation, scalar_first=True)
        rate = self._rate(state)
        orbit = self._orbit(state, R_FA, rate, mated)
        assert orbit.axes is not None
        R_WA = Rotation.from_matrix(np.array(orbit.axes)) * R_FA
        initial = InitialMotion(rpy_WA=_roll_pitch_yaw(R_WA), w_WA_A=_vector(rate))
        return replace(mated, initial=initial, orbit=orbit)

    def _rate(self, state: TakenState) -> Array:
        """Return the rate that is given, or taken: one of them."""
        if self.rate_deg_s is None:
            if state.rate is None:
                raise InputError("rate_deg_s: must be given, the files have none")
            return state.rate
        if state.rate is not None:
            raise InputError("rate_deg_s: must not stand with 'from', which has a rate")
        return np.array(to_si("rate", self.rate_deg_s))

    def _orbit(
        self, state: TakenState, R_FA: Rotation, rate: Array, mated: Separation
    ) -> Orbit:
        orbit = mated.orbit
        if state.position is None or state.velocity is None:
            return self._checked(orbit, state)
        if orbit is not None:
            raise InputError("orbit: must be left out, since the files have it")
        p_AP, p_AAcm = self._point(mated)
        r = state.position - R_FA.apply(p_AP)
        v = state.velocity - R_FA.apply(np.cross(rate, p_AP - p_AAcm))
        return Orbit.of_state(
            _vector(r),
            _vector(v),
            frame=state.frame,
            epoch=state.epoch,
            time_system=state.time_system,
        )

    def _checked(self, orbit: Orbit | None, state: TakenState) -> Orbit:
        """Return the orbit of the case, if it fits an attitude that is taken."""
        if orbit is None or orbit.axes is None:
            raise InputError(
                "orbit: must say how it lies in the frame of the files, "
                f"{state.frame}, or they must have it, got neither"
            )
        wanted = state.frame, state.time_system, parse_epoch("at", state.epoch)
        got = orbit.frame, orbit.time_system, parse_epoch("epoch", orbit.epoch)
        if wanted != got:
            raise InputError(
                f"orbit: must be in {state.frame} at {state.epoch} "
                f"{state.time_system}, as the files are, got {orbit.frame} at "
                f"{orbit.epoch} {orbit.time_system}"
            )
        return orbit

    def _point(self, mated: Separation) -> tuple[Array, Array]:
        """Return the point whose state the files have, and A's CG, both in A, m."""
        places = mated_places(mated)
        at = {
            body.name: np.array(place_in_stack(places[body.name], body.p_BoBcm_B))
            for body in mated.bodies
        }
        if self.of is not None:
            if self.of not in at:
                raise InputError(f"of: {unknown('body', self.of, at)}")
            return at[self.of], at[mated.A]
        masses = [body.mass for body in mated.bodies]
        stack = np.average(np.array(list(at.values())), axis=0, weights=masses)
        return stack, at[mated.A]


def _roll_pitch_yaw(R: Rotation) -> Vector3:
    yaw, pitch, roll = R.as_euler("ZYX", suppress_warnings=True)
    return float(roll), float(pitch), float(yaw)


def _vector(values: Array) -> Vector3:
    x, y, z = values.tolist()
    return x, y, z
