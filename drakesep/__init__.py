"""Launch vehicle separation in Drake: dynamics, worst case, verdict.

    import drakesep

    case = drakesep.load_case("vega")
    run = drakesep.simulate(case, {"payload.mass_kg": 1880})
    result = drakesep.verify(case)

Names are imported when they are first used: `import drakesep` stays fast.
"""

import lazy_loader


__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
