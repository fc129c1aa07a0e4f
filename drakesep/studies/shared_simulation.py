"""Simulations that calls share which differ in values alone.

A diagram with a system in Python is never freed (drake #22515): a script that flies one
case ten thousand times would fill the memory, and build it each time. A run is the same
whatever was flown before it.
"""

import threading
from collections import OrderedDict
from collections.abc import Hashable

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.systems.model.parts import Mesh
from drakesep.systems.simulation.simulation import Simulation


_MOST = 16
"""That are kept; of those that are not, the longest unused goes."""


class _OfThread(threading.local):
    """The simulations of a thread, whose diagrams no other enters."""

    def __init__(self) -> None:
        self.known: OrderedDict[Hashable, Simulation] = OrderedDict()


_of_thread = _OfThread()


def shared_simulation(case: AnalysisCase) -> Simulation:
    """Return the simulation of a case, built unless an equal one has been.

    Args:
        case: whose separation it flies, as the case integrates it.
    """
    files = [
        part.shape.file.stat()
        for body in case.separation.bodies
        for part in body.parts
        if isinstance(part.shape, Mesh)
    ]
    changed = tuple((file.st_ino, file.st_size, file.st_mtime_ns) for file in files)
    key = case.separation, case.integration, changed
    known = _of_thread.known
    if key not in known:
        known[key] = Simulation(case.separation, case.integration)
    known.move_to_end(key)
    simulation = known[key]
    while len(known) > _MOST:
        known.popitem(last=False)
    return simulation
