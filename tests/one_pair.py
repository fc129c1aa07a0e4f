"""VEGA with one pair of parts to measure: its clearance is quickly told."""

import drakesep


PAIRS = {"pairs": [["nozzle", "adapter_ring"]]}


def one_pair(**sections):
    """The case, with other sections changed too."""
    return drakesep.load_case("vega").replaced(clearance=PAIRS, **sections)
