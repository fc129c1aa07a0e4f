"""The searches by name; see `drakesep.analysis.search` for what they have in common."""

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from drakesep.analysis.climbs import climb, climb_from_many
from drakesep.analysis.evolution import evolve
from drakesep.analysis.search import Search
from drakesep.analysis.sweeps import sample, sweep_vertices
from drakesep.systems.checks import InputError, unknown


SEARCHES: Mapping[str, Search] = MappingProxyType(
    {
        "sqp": climb,
        "multistart": climb_from_many,
        "vertices": sweep_vertices,
        "samples": sample,
        "evolution": evolve,
    }
)
"""The searches by name."""
CLIMBS = ("sqp", "multistart")
"""Those that go uphill; the others sweep: they fly very many runs."""


def check_search(name: str, also: Iterable[str] = ()) -> None:
    """Raise ValueError if there is no such search; others that are known are named."""
    if name not in SEARCHES:
        raise InputError(unknown("search", name, [*SEARCHES, *also]))
