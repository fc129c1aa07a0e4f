"""Simulations that calls share whose separations differ in numbers alone.

A diagram with a system in Python is never freed (drake #22515): a script that flies one
separation ten thousand times would fill the memory, and build it each time. A run is
the same whatever was flown before it.
"""

import threading
from collections import OrderedDict
from collections.abc import Mapping
from typing import Any, NamedTuple, TypeAlias

from drakesep.systems.model.integration import Integration
from drakesep.systems.model.parameters import parameters, with_values
from drakesep.systems.model.parts import Mesh
from drakesep.systems.model.run import Run
from drakesep.systems.model.separation import Separation
from drakesep.systems.simulation.simulation import Simulation


_MOST = 16
"""That are kept; of those that are not, the longest unused goes."""


_Key: TypeAlias = tuple[Separation, Integration, Any]
"""What is flown, and how; and which files its meshes are."""


class _OfThread(threading.local):
    """The simulations of a thread, whose diagrams no other enters."""

    def __init__(self) -> None:
        self.known: OrderedDict[_Key, Simulation] = OrderedDict()


_of_thread = _OfThread()


class SharedSimulation(NamedTuple):
    """Flies a separation, with the simulation of one that has other numbers perhaps."""

    simulation: Simulation
    numbers: Mapping[str, float]
    """Parameters in which the two differ, with the values that it flies."""

    def run(self, values: Mapping[str, float] | None = None) -> Run:
        """Fly the separation with some of its parameters changed, as `Simulation.run`.

        Args:
            values: new values by parameter name, in SI.
        """
        return self.simulation.run({**self.numbers, **(values or {})})


def shared_simulation(
    separation: Separation, integration: Integration | None = None
) -> SharedSimulation:
    """Return what flies a separation, built unless one of its structure has been.

    Args:
        separation: to be flown.
        integration: how; the default of `Simulation` if None.
    """
    integration = integration or Integration()
    files = [
        part.shape.file.stat()
        for body in separation.bodies
        for part in body.parts
        if isinstance(part.shape, Mesh)
    ]
    changed = tuple((file.st_ino, file.st_size, file.st_mtime_ns) for file in files)
    known, kind = _of_thread.known, (integration, changed)
    for key in reversed(known):
        if (
            key[1:] == kind
            and (numbers := _numbers(known[key], separation)) is not None
        ):
            break
    else:
        key, numbers = (separation, *kind), {}
        known[key] = Simulation(separation, integration)
    known.move_to_end(key)
    simulation = known[key]
    while len(known) > _MOST:
        known.popitem(last=False)
    return SharedSimulation(simulation, numbers)


def _numbers(simulation: Simulation, separation: Separation) -> dict[str, float] | None:
    """Return the parameters with which a simulation flies a separation.

    None if it differs in anything else, or in what the simulation does not read.
    """
    if simulation.separation == separation:
        return {}
    built, wanted = parameters(simulation.separation), parameters(separation)
    if built.keys() != wanted.keys():
        return None
    numbers = {name: x for name, x in wanted.items() if x != built[name]}
    if not simulation.reads(numbers):
        return None
    try:
        same = with_values(simulation.separation, numbers) == separation
    except ValueError:
        return None
    return numbers if same else None
