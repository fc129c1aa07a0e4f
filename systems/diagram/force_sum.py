"""All that acts on the bodies, evaluated at once."""

from pydrake.common.value import Value
from pydrake.systems.framework import Context, LeafSystem

from drakesep.systems.diagram.state_layout import StateLayout
from drakesep.systems.diagram.wrenches import Force, Forces


class ForceSum(LeafSystem):
    """The sum of the wrenches of several systems, from one look at the bodies' motion.

    The same as the sum of their ports ``wrenches``, to round-off, for one crossing into
    Python instead of as many as there are systems.

    Input ports:
        plant_state: (s,) 1, m, rad/s and m/s in W: state of the plant, in which the
            layout finds the motion of each body.
        acting_0, ...: abstract: what acts by each system, its port ``acting``; in this
            order, since what rigid joints do follows from all before it.
        external_wrenches: (6 m,) N m and N in W: torque about the origin, then force,
            on each of the m bodies, that acts before all; if asked for.

    Output ports:
        acting: abstract: what acts by all of them.
        wrenches: (6 m,) N m and N in W: torque about the origin, then force, on each of
            the m bodies.
    """

    def __init__(self, layout: StateLayout, count: int, *, external: bool = False):
        """Prepare.

        Args:
            layout: where `plant_state` holds the motion of each body.
            count: of systems.
            external: whether to have the input port `external_wrenches`.
        """
        super().__init__()
        state = self.DeclareVectorInputPort("plant_state", layout.size)
        self._parts = [
            self.DeclareAbstractInputPort(f"acting_{i}", Value[object]())
            for i in range(count)
        ]
        parts = {part.ticket() for part in self._parts}
        given = None
        if external:
            size = 6 * len(layout.starts)
            given = self.DeclareVectorInputPort("external_wrenches", size)
        Forces(self, state, layout, self._find_acting, parts, given)

    def _find_acting(self, context: Context) -> list[Force]:
        return [force for part in self._parts for force in part.Eval(context)]
