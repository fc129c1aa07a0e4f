"""The motion of each body, read out of the state of its plant."""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from pydrake.common.value import AbstractValue
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context, InputPort, LeafSystem

from drakesep.systems.laws import BodyState, body_state


class StateLayout(NamedTuple):
    """Where each floating body's motion stands in the state of its plant."""

    size: int
    """Of the plant's state."""
    starts: tuple[tuple[int, int], ...]
    """Begin of each body's position and of its velocity."""

    def read(self, x: Sequence[Any]) -> list[BodyState]:
        """Return the state of each body.

        Args:
            x: (size,) state of the plant, or (size, n) for n samples.
        """
        return [body_state(x, q, v) for q, v in self.starts]


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


class BodyStates(LeafSystem):
    """Reads the plant's state once an evaluation, for every system that needs it.

    Input port:
        plant_state: state of the plant.

    Output port:
        body_states: list of `BodyState`, one for each body.
    """

    def __init__(self, layout: StateLayout):
        super().__init__()
        self._layout = layout
        self._state = self.DeclareVectorInputPort("plant_state", layout.size)
        self.DeclareAbstractOutputPort(
            "body_states", lambda: AbstractValue.Make(object()), self._calc
        )

    def _calc(self, context: Context, output: AbstractValue) -> None:
        output.set_value(self._layout.read(self._state.Eval(context).tolist()))


def declare_body_states_input(system: LeafSystem) -> InputPort:
    """Declare the input port that takes what `BodyStates` puts out."""
    return system.DeclareAbstractInputPort("body_states", AbstractValue.Make(object()))
