"""Where the motion of each body stands in the state of its plant."""

from collections.abc import Iterable
from typing import NamedTuple

from pydrake.multibody.plant import MultibodyPlant

from drakesep.systems.equations.relative_motion import BodyState, State, body_state


class StateLayout(NamedTuple):
    """Where each floating body's motion stands in the state of its plant."""

    size: int
    """Of the plant's state."""
    starts: tuple[tuple[int, int], ...]
    """Begin of each body's position and of its velocity."""

    def read(self, x: State) -> list[BodyState]:
        """Return the state of each body.

        Args:
            x: (size,) state of the plant, or (size, n) for n samples.
        """
        return [body_state(x, q, v) for q, v in self.starts]

    def bodies(self, x: State) -> "BodyStates":
        """Return the states of the bodies, each read when it is asked for."""
        return BodyStates(self, x)

    def read_one(self, x: State, index: int) -> BodyState:
        """Return the state of one body."""
        return body_state(x, *self.starts[index])


class BodyStates(dict[int, BodyState]):
    """The states of bodies at a moment by their indices, each read when asked for."""

    def __init__(self, layout: StateLayout, x: State):
        super().__init__()
        self._starts, self._x = layout.starts, x

    def __missing__(self, index: int) -> BodyState:
        """Read one."""
        state = self[index] = body_state(self._x, *self._starts[index])
        return state


def state_layout(plant: MultibodyPlant, names: Iterable[str]) -> StateLayout:
    """Return where the bodies' motion stands in the plant's state.

    Args:
        plant: finalized plant.
        names: the bodies, each floating in the world.
    """
    bodies = [plant.GetBodyByName(name) for name in names]
    return StateLayout(
        plant.num_multibody_states(),
        tuple(
            (
                body.floating_positions_start(),
                plant.num_positions() + body.floating_velocities_start_in_v(),
            )
            for body in bodies
        ),
    )
