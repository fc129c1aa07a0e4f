"""The ports of the Drake systems, from their docstrings, as the page lists them.

A docstring says of a port: name, shape, unit, frame if it has one, and what it is.

    rate: (3,) rad/s in B: angular velocity of B in W.
"""

import re
from typing import Any, NamedTuple

from docstrings import listed

from drakesep.systems.diagram.gravity import Gravity
from drakesep.systems.diagram.joints import CfeBushing
from drakesep.systems.diagram.loads import Loads
from drakesep.systems.diagram.motion_analysis import MotionAnalysis
from drakesep.systems.diagram.preload import Preload
from drakesep.systems.diagram.release import Release
from drakesep.systems.diagram.separation_forces import SeparationForces
from drakesep.systems.diagram.separation_system import SeparationSystem
from drakesep.systems.diagram.springs import Springs


SYSTEMS = (
    SeparationSystem,
    SeparationForces,
    Release,
    Springs,
    CfeBushing,
    Preload,
    Loads,
    Gravity,
    MotionAnalysis,
)
ABSTRACT = "abstract"
"""Shape of a port that holds no numbers."""
_PORT = re.compile(
    r"(?:(?P<shape>\([^)]*\)) (?P<unit>[^:]*?)(?: in (?P<frame>[^:]*))?"
    rf"|(?P<abstract>{ABSTRACT})): (?P<meaning>.*)"
)


class Port(NamedTuple):
    """What a docstring says of a port."""

    shape: str
    unit: str
    """1 if it has none."""
    frame: str
    """In whose axes it is; empty if it has none."""
    meaning: str


def ports_of(system: type[Any], heading: str) -> dict[str, Port]:
    """Return the ports that the docstring of a system lists.

    Args:
        system: its class.
        heading: ``Input ports`` or ``Output ports``.

    Raises:
        ValueError: a port is not described as it must be.
    """
    ports = {}
    for name, text in listed(system, heading).items():
        found = _PORT.fullmatch(text)
        if not found:
            raise ValueError(f"{system.__name__}: {name}: got {text!r}")
        ports[name] = Port(
            found["shape"] or found["abstract"],
            found["unit"] or "",
            found["frame"] or "",
            found["meaning"],
        )
    return ports


def tables_of_ports() -> str:
    """Return the ports of all systems, as Markdown."""
    return "\n\n".join(map(_text, SYSTEMS))


def _text(system: type[Any]) -> str:
    first, *_ = (system.__doc__ or "").splitlines()
    parts = [f"## `{system.__name__}`", first]
    for heading in ("Input ports", "Output ports"):
        rows = "\n".join(
            f"| `{name}` | {' | '.join(port)} |"
            for name, port in ports_of(system, heading).items()
        )
        head = f"| {heading.lower()[:-1]} | shape | unit | frame | what it is |"
        parts.append(f"{head}\n|---|---|---|---|---|\n{rows}")
    return "\n\n".join(parts).replace("``", "`")
