"""First floor: many separations, what is asked of them, and the worst of them."""

import lazy_loader

from drakesep.systems.former_names import or_former


_get, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
__getattr__ = or_former(__name__, _get, {"Box": "ToleranceBox", "Fleet": "DrakePool"})
