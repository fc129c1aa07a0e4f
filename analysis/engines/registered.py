"""What a user has registered beside drakesep's own, for other processes to know.

A worker that does not know a metric or a pusher cannot fly it; one that knows another
of the same name would fly something else, and nobody would see it.
"""

import hashlib
import inspect
import pickle
import uuid
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Self

import cloudpickle

from drakesep.analysis.metrics.metric import Metric
from drakesep.analysis.metrics.registry import (
    find_metric,
    forget_metric,
    own_metrics,
    register_metric,
)
from drakesep.systems.checks import InputError
from drakesep.systems.equations.springs import (
    PUSHERS,
    PusherKind,
    forget_own_pushers,
    own_pushers,
)
from drakesep.systems.model.separation import Separation


_HERE = uuid.uuid4().hex
"""By which this process knows what it has packed itself."""


@dataclass(frozen=True, eq=False)
class Registered:
    """Metrics and kinds of pushers that are not drakesep's own."""

    metrics: tuple[Metric, ...]
    pushers: Mapping[str, PusherKind]

    @classmethod
    def here(cls) -> Self:
        """Return what is registered in this process."""
        return cls(own_metrics(), own_pushers())

    def as_bytes(self) -> bytes:
        """Return it as bytes, which need none of the caller's `__main__`."""
        return pickle.dumps((_HERE, cloudpickle.dumps(self)))

    @staticmethod
    def known_from(packed: bytes) -> None:
        """Register what bytes hold, and nothing else that is not drakesep's own.

        In the process that has made them all is registered already.

        Raises:
            ValueError: it is of a module that is not there.
        """
        try:
            where, inner = pickle.loads(packed)
            if where == _HERE:
                return
            told: Registered = cloudpickle.loads(inner)
        except Exception as error:  # whatever its modules raise
            raise InputError(
                "what is registered (metrics, pushers) must be importable wherever "
                f"chunks are flown, got: {error}"
            ) from error
        forget_own_pushers()
        PUSHERS.update(told.pushers)
        for metric in own_metrics():
            forget_metric(metric.stem)
        for metric in told.metrics:
            register_metric(metric)

    def definitions(
        self, metrics: Iterable[str], separation: Separation
    ) -> dict[str, str]:
        """Return how what is used of it is defined, by name, as hashes of its source.

        Args:
            metrics: names of those that are used.
            separation: whose pushers are.
        """
        found = [find_metric(name) for name in metrics]
        stems = {one[0].stem_of_any for one in found if one is not None}
        records = {type(pusher) for _, pusher in separation.pushing}
        return {
            **{m.stem: _hash(m) for m in self.metrics if m.stem in stems},
            **{k: _hash(p) for k, p in self.pushers.items() if p.record in records},
        }


def _hash(thing: object) -> str:
    return hashlib.sha256(_source(thing).encode()).hexdigest()


def _source(thing: Any) -> str:
    """Return what a record of data, classes and functions says, with their sources."""
    if isinstance(thing, PusherKind):
        return _source((thing.record, thing.law, thing.make, dict(thing.columns)))
    if isinstance(thing, Metric):
        names = thing.__dataclass_fields__
        return _source([(name, getattr(thing, name)) for name in names])
    if isinstance(thing, Mapping):
        return _source(list(thing.items()))
    if isinstance(thing, tuple | list):
        return f"({', '.join(map(_source, thing))})"
    if inspect.isclass(thing) or callable(thing):
        named = f"{getattr(thing, '__qualname__', type(thing).__qualname__)}"
        try:
            return f"{named}: {inspect.getsource(thing)}"
        except (OSError, TypeError):  # made where no file is
            return named
    return repr(thing)
