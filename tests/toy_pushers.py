"""A pusher that tests add through the registry alone."""

from dataclasses import dataclass
from typing import ClassVar

from drakesep.systems.equations.pushers import PushLaw
from drakesep.systems.model.parameter_table import (
    NOT_NEGATIVE,
    POSITIVE,
    ParameterTable,
    scalar,
)
from drakesep.systems.model.pushers import TILTS


@dataclass(frozen=True, slots=True, kw_only=True)
class Strut:
    """Pushes with a constant force, less its seal's drag, over its stroke."""

    name: str
    force_max: float
    stroke: float
    seal_drag: float = 0.0
    axis_A: tuple[float, float, float] = (1.0, 0.0, 0.0)
    tilt_y: float = 0.0
    tilt_z: float = 0.0

    PARAMETERS: ClassVar[ParameterTable] = ParameterTable(
        scalar("force_max", "force", POSITIVE),
        scalar("stroke", "length", POSITIVE),
        scalar("seal_drag", "force", NOT_NEGATIVE),
        *TILTS,
    )
    duration: ClassVar[None] = None

    def __post_init__(self) -> None:
        self.PARAMETERS.check(f"{self.name}: ", self)


@dataclass(frozen=True)
class StrutLaw(PushLaw):
    by_time: ClassVar[bool] = False
    dampers: ClassVar[tuple[str, ...]] = ("seal_drag",)

    def end(self, p, ops):
        return p.stroke

    def force(self, p, at, speed, passed, ops):
        return p.force_max - p.seal_drag

    def ends_in_jump(self, p):
        return True

    def frequency(self, p, count, lightness, ops):
        return ops.sqrt(count * p.force_max / p.stroke * lightness)
