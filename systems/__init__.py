"""Ground floor: one separation, its equations, its Drake systems, its simulation."""

import lazy_loader

from drakesep.systems.former_names import or_former


_get, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
__getattr__ = or_former(
    __name__, _get, {"Element": "Part", "SeparationElements": "SeparationForces"}
)
