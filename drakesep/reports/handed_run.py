"""A run that is handed over: its bodies, their states, and what these mean."""

from collections.abc import Mapping
from dataclasses import dataclass

from drakesep.reports.body_states import BodyStates, in_inertial_frame, states_in_W
from drakesep.reports.frames import InertialFrame
from drakesep.systems.arrays import Array
from drakesep.tables.labelled_run import LabelledRun
from drakesep.version import __version__


def given_words(given: Mapping[str, str]) -> str:
    """Return what was said at the export, such as ``epoch 2026-03-01T12:00:00``.

    Args:
        given: as `InertialFrame` has it.
    """
    said = [f"{name} {value}" for name, value in given.items() if name != "plane"]
    if "plane" in given:
        said.append(
            "inclination, ascending node and argument of latitude at t = 0 "
            f"{given['plane']} deg"
        )
    return "; ".join(said)


@dataclass(frozen=True)
class HandedRun:
    """A completed run, and the frame into which it is handed over."""

    case: str
    """Its name."""
    one: LabelledRun
    inertial: InertialFrame | None
    """None: W alone."""

    @property
    def label(self) -> str:
        """Of the run."""
        return self.one.label

    @property
    def time(self) -> Array:
        """(n,) of the samples, s."""
        return self.one.run.completed_trajectory.time

    @property
    def bodies(self) -> list[str]:
        """Their names."""
        return [body.name for body in self.one.run.separation.bodies]

    def in_W(self, body: str) -> BodyStates:
        """Return the motion of a body in W."""
        return states_in_W(self.one.run, body)

    def in_frame(self, body: str) -> BodyStates:
        """Return the motion of a body in the inertial frame, if there is one."""
        assert self.inertial is not None
        return in_inertial_frame(self.in_W(body), self.inertial.orbit)

    @property
    def notes(self) -> dict[str, str]:
        """What numbers mean, for files that have no comments."""
        notes = {
            "case": self.case,
            "run": self.label,
            "made_by": f"drakesep {__version__}",
            "position": "of the body's centre of mass, m",
            "velocity": "of the body's centre of mass, m/s",
            "orientation": "unit quaternion, scalar first, of the body's axes in the "
            "frame: it takes components in body axes into those in the frame",
            "rate": "angular velocity of the body, in body axes, rad/s",
            "W": "falls freely along the reference orbit; its axes do not turn; at "
            "t = 0 z points to the centre of the Earth, and x lies across the radius, "
            "in the orbit and along the motion",
        }
        if self.inertial is not None:
            notes |= {
                "epoch": self.inertial.orbit.epoch,
                "time_system": self.inertial.time_system,
                "frame": self.inertial.name,
            }
            if self.inertial.given:
                notes["given_at_the_export"] = given_words(self.inertial.given)
        return notes
