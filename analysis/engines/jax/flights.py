"""What is flown of a batch's lanes, some steps at a time: metrics, and their slopes."""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import jax
import jax.numpy as jnp

from drakesep.systems.batch.integrator import (
    BatchIntegrator,
    FinalState,
    Fold,
    LaneState,
)
from drakesep.systems.batch.lanes import BatchParameters, Lanes


class Flown(NamedTuple):
    """What comes of lanes."""

    metrics: Lanes
    """(n_m, n)."""
    final: FinalState
    slopes: Any
    """(n_p, n_m, n), if asked for."""


class FinishedFold(Fold, Protocol):
    """A fold that makes numbers of lanes."""

    def finish(self, folded: Any) -> Lanes:
        """Return (n_m, n) numbers, of what there is after the last step."""


class MetricsFlight:
    """Tells the metrics of lanes of parameter values, or what else a fold does."""

    def __init__(
        self,
        integrator: BatchIntegrator,
        fold: FinishedFold,
        params: Callable[[Lanes], BatchParameters],
    ):
        """Prepare.

        Args:
            integrator: flies them.
            fold: tells them.
            params: returns all parameters of lanes, of those (n_p, n) that vary.
        """
        self._integrator, self._fold, self._params = integrator, fold, params

    def start(self, values: Lanes) -> LaneState:
        """Return the lanes before their first step."""
        return self._integrator.start(self._params(values), self._fold)

    def go_on(
        self, values: Lanes, state: LaneState, most: Lanes
    ) -> tuple[LaneState, Lanes]:
        """Return the lanes after so many steps at most, and how many these were."""
        return self._integrator.go_on(state, self._params(values), self._fold, most)

    def is_under_way(self, state: LaneState) -> Lanes:
        """Return whether any lane flies."""
        return self._integrator.is_under_way(state)

    def end(self, values: Lanes, state: LaneState) -> Flown:
        """Return what has come of lanes."""
        final = self._integrator.end(state)
        metrics = self._fold.finish(final.folded)
        return Flown(metrics, final._replace(folded=None), None)


class _Dual(NamedTuple):
    """Lanes with their derivatives."""

    smooth: Any
    """Their state, what is no real number left out."""
    slopes: Any
    """Derivatives of that."""
    rest: Any
    """What was left out."""


class SlopesFlight:
    """Tells the metrics of lanes, with their derivatives.

    A lane for each row and parameter: a run costs less than what it takes to share it,
    and the program is smaller.
    """

    def __init__(self, flight: MetricsFlight):
        """Prepare.

        Args:
            flight: tells the metrics.
        """
        self._flight = flight

    def start(self, values: Lanes) -> _Dual:
        """Return the lanes before their first step."""

        def start(lanes: Lanes) -> tuple[Any, Any]:
            return _parted(self._flight.start(lanes))

        return _Dual(*jax.jvp(start, *_directed(values), has_aux=True))

    def go_on(self, values: Lanes, state: _Dual, most: Lanes) -> tuple[_Dual, Lanes]:
        """Return the lanes after so many steps at most, and how many these were."""

        def go_on(lanes: Lanes, smooth: Any) -> tuple[Any, Any]:
            whole = _joined(smooth, state.rest)
            new, taken = self._flight.go_on(lanes, whole, most)
            smooth, rest = _parted(new)
            return smooth, (rest, taken)

        (lanes,), (directions,) = _directed(values)
        smooth, slopes, (rest, taken) = jax.jvp(
            go_on, (lanes, state.smooth), (directions, state.slopes), has_aux=True
        )
        return _Dual(smooth, slopes, rest), taken

    def is_under_way(self, state: _Dual) -> Lanes:
        """Return whether any lane flies."""
        return self._flight.is_under_way(_joined(state.smooth, state.rest))

    def end(self, values: Lanes, state: _Dual) -> Flown:
        """Return what has come of lanes."""

        def end(smooth: Any) -> tuple[Lanes, FinalState]:
            flown = self._flight.end(values, _joined(smooth, state.rest))
            return flown.metrics, flown.final

        metrics, slopes, final = jax.jvp(
            end, (state.smooth,), (state.slopes,), has_aux=True
        )
        n_p, n = values.shape
        slopes = jnp.moveaxis(slopes.reshape(-1, n, n_p), 2, 0)
        first: Flown = jax.tree.map(
            lambda x: x[..., ::n_p], Flown(metrics, final, None)
        )
        return first._replace(slopes=slopes)


def _directed(values: Lanes) -> tuple[tuple[Lanes], tuple[Lanes]]:
    """Return a lane for each row and parameter, and the direction of each."""
    n_p, n = values.shape
    return (jnp.repeat(values, n_p, axis=1),), (jnp.tile(jnp.eye(n_p), n),)


def _parted(state: Any) -> tuple[Any, Any]:
    """Return what is smooth of a state, and the rest: each without the other."""
    smooth = jax.tree.map(lambda x: x if _is_smooth(x) else None, state)
    return smooth, jax.tree.map(lambda x: None if _is_smooth(x) else x, state)


def _joined(smooth: Any, rest: Any) -> Any:
    return jax.tree.map(
        lambda one, other: other if one is None else one,
        smooth,
        rest,
        is_leaf=lambda x: x is None,
    )


def _is_smooth(x: Lanes) -> bool:
    return bool(jnp.issubdtype(x.dtype, jnp.floating))
