"""What springs press the joints with while these hold."""

import math

from pydrake.systems.framework import BasicVector, Context, LeafSystem

from drakesep.systems.diagram.rows import Rows
from drakesep.systems.equations.mated_stack import Place, mated_places
from drakesep.systems.equations.preload import Pressed, preloads, pressed_at
from drakesep.systems.model.separation import Separation


class Preload(LeafSystem):
    """Tells the preload of each joint that holds: what springs press it with.

    It moves nothing, and is shared by statics: see `equations.preload`.

    Input ports:
        released: (n,) s: time of each attachment's release; infinite while it holds.

    Output ports:
        loads: (6 n,) N m and N in the joints' frames: the part of `joint_loads` that
            holds against springs that press; zero after release.

    Parameters:
        0: for each attachment a `Pressed`.
        1: for each body its `Place` while mated.
    """

    def __init__(self, separation: Separation):
        super().__init__()
        self._separation = separation  # of which only the structure is read
        count = len(separation.attachments)
        self._released = self.DeclareVectorInputPort("released", count)
        self._pressed = Rows(self, [*map(pressed_at, separation.attachments)])
        self._places = Rows(self, [*mated_places(separation).values()])
        self.DeclareVectorOutputPort(
            "loads",
            6 * count,
            self._calc_loads,
            {self._released.ticket(), self.all_parameters_ticket()},
        )

    def set_pressed(self, context: Context, separation: Separation) -> None:
        """Write what presses in a separation into this system's Context."""
        self._pressed.write(context, [*map(pressed_at, separation.attachments)])
        self._places.write(context, [*mated_places(separation).values()])

    def _calc_loads(self, context: Context, output: BasicVector) -> None:
        loads = [0.0] * output.size()
        released = self._released.Eval(context).tolist()
        held = [i for i, t in enumerate(released) if math.isinf(t)]
        pressed: list[Pressed] = self._pressed.read(context)
        places: list[Place] = self._places.read(context)
        for i, (torque, force) in preloads(
            self._separation, held, places, pressed
        ).items():
            loads[6 * i : 6 * i + 6] = [*torque, *force]
        output.SetFromVector(loads)
