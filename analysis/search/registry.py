"""The searches by name.

See `drakesep.analysis.search.problem` for what they have in common.
"""

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from drakesep.analysis.search.corners import flip_bounds
from drakesep.analysis.search.evolution import evolve
from drakesep.analysis.search.problem import FROM_NOMINAL, Search
from drakesep.analysis.search.sqp_searches import sqp_from_many, sqp_from_nominal
from drakesep.analysis.search.sweeps import sample, sweep_vertices
from drakesep.systems.checks import InputError, unknown


SEARCHES: Mapping[str, Search] = MappingProxyType(
    {
        FROM_NOMINAL: sqp_from_nominal,
        "multistart": sqp_from_many,
        "vertices": sweep_vertices,
        "corners": flip_bounds,
        "samples": sample,
        "evolution": evolve,
    }
)
"""The searches by name."""
SQP_SEARCHES = (FROM_NOMINAL, "multistart")
"""Those that go uphill; the others sweep: they fly very many runs."""


def check_search(name: str, also: Iterable[str] = ()) -> None:
    """Raise ValueError if there is no such search; others that are known are named."""
    if name not in SEARCHES:
        raise InputError(unknown("search", name, [*SEARCHES, *also]))
