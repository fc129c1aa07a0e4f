"""Compiled programs of the batch engine: how they are made, kept, cut up and called."""

import functools
import os
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from drakesep.analysis.engines.jax.compiling_threads import compiling_threads
from drakesep.systems.arrays import Array
from drakesep.systems.batch.lanes import Lanes
from drakesep.systems.checks import DrakesepWarning


_CHUNKS, _LANES = 8, 1024
"""In a call of a program, at most, but for one chunk: between calls threads wait for
Python."""
_CALL = 0.5
"""Of a call, which may be interrupted only at its end, s."""
_FIRST = 20
"""Steps of the first call, of which nothing is known: many bodies take long."""
_OPTIONS = {
    "cpu": {
        # As fast, and compiled in half the time.
        "xla_cpu_use_fusion_emitters": False,
        "xla_backend_optimization_level": 1,
        "xla_cpu_prefer_vector_width": 512,
    }
}
"""For the compiler, as far as it knows them: they change speed alone."""


class Flight(Protocol):
    """What is flown of lanes (n_p, n) of parameter values, some steps at a time."""

    def start(self, values: Lanes) -> Any:
        """Return their state before the first step."""

    def go_on(self, values: Lanes, state: Any, most: Lanes) -> tuple[Any, Lanes]:
        """Return their state after so many steps at most, and how many these were."""

    def is_under_way(self, state: Any) -> Lanes:
        """Return whether any of them flies."""

    def end(self, values: Lanes, state: Any) -> Any:
        """Return what has come of them, of (..., n)."""


class _UnderWay(NamedTuple):
    """How far chunks are."""

    chunk: Lanes
    """That flies: those before it have flown."""
    begun: Lanes
    """Whether it has."""
    left: Lanes
    """Steps that may still be taken."""
    state: Any
    """Of its lanes."""
    flown: Any
    """What has come of all lanes."""


class Program:
    """Flies lanes, chunk after chunk, in few calls."""

    def __init__(
        self,
        compiled: Callable[[Callable[..., Any]], Callable[..., Any]],
        flight: Flight,
        chunk: int,
    ):
        """Prepare.

        Args:
            compiled: makes programs of functions.
            flight: flies the lanes (n_p, chunk) of one chunk.
            chunk: lanes that are flown together.
        """
        self.chunk = chunk
        self.lanes = min(max(_LANES // chunk, 1), _CHUNKS) * chunk
        self._of_chunk = _CALL  # seconds: first of all, slow ones are reckoned with
        self._of_step = _CALL / _FIRST
        # They are looked at twice, and traced once.
        self._start, self._end = jax.jit(flight.start), jax.jit(flight.end)
        self._flight = flight
        self._program = compiled(self._fly)
        self._nothing = functools.cache(self._nothing_of)

    @property
    def affordable(self) -> int:
        """Chunks that are flown together, by how long the last ones took."""
        return min(self.lanes // self.chunk, int(_CALL / self._of_chunk))

    def __call__(
        self, values: Array, count: int, is_wanted: Callable[[], bool] = lambda: True
    ) -> Any:
        """Return what comes of the first lanes of values (n_p, lanes).

        Args:
            values: of all lanes.
            count: of those to be flown.
            is_wanted: whether to go on; asked between calls.

        Returns:
            None if it is wanted no more.
        """
        chunks = -(-count // self.chunk)
        begin = time.perf_counter()
        with jax.enable_x64(True):
            lanes, chunk = jnp.asarray(values), 0
            on = self._nothing(len(values))
            while chunk < chunks and is_wanted():
                called = time.perf_counter()
                most = max(int(_CALL / self._of_step), 1)
                on = self._program(lanes, np.array(chunks), np.array(most), on)
                chunk, taken = int(on.chunk), most - int(on.left)
                self._of_step = (time.perf_counter() - called) / max(taken, 1)
            if chunk < chunks:
                return None
        self._of_chunk = (time.perf_counter() - begin) / max(chunks, 1)
        return jax.tree.map(lambda x: np.asarray(x)[..., :count], on.flown)

    def _fly(
        self, values: Lanes, chunks: Lanes, most: Lanes, under_way: _UnderWay
    ) -> _UnderWay:
        """Take so many steps at most, in as many chunks as they last for."""

        def go_on(on: _UnderWay) -> _UnderWay:
            i = on.chunk * self.chunk

            def put(x: Lanes, mine: Lanes) -> Lanes:
                return lax.dynamic_update_slice_in_dim(x, mine, i, -1)

            mine = lax.dynamic_slice_in_dim(values, i, self.chunk, -1)
            state = jax.tree.map(
                lambda a, b: jnp.where(on.begun, a, b), on.state, self._start(mine)
            )
            state, taken = self._flight.go_on(mine, state, on.left)
            flies = self._flight.is_under_way(state)
            # Of lanes that fly, what is put is written over once they have flown.
            flown = jax.tree.map(put, on.flown, self._end(mine, state))
            return _UnderWay(on.chunk + ~flies, flies, on.left - taken, state, flown)

        on = lax.while_loop(
            lambda on: (on.chunk < chunks) & (on.left > 0),
            go_on,
            under_way._replace(left=most),
        )
        # Of the types that they come in with: else it would be compiled once more.
        stepped: _UnderWay = jax.tree.map(lambda x: x.astype(x.dtype), on)
        return stepped

    def _nothing_of(self, n_p: int) -> _UnderWay:
        """Return what there is before the first step of the first chunk."""

        def zeros(x: Any) -> Lanes:
            return jnp.zeros(x.shape, x.dtype)

        def of_all_lanes(x: Any) -> Lanes:
            return jnp.zeros((*x.shape[:-1], self.lanes), x.dtype)

        mine = np.zeros((n_p, self.chunk))
        state = jax.eval_shape(self._start, mine)
        flown = jax.eval_shape(self._end, mine, state)
        none = jnp.zeros((), dtype=np.int64)
        return _UnderWay(
            chunk=none,
            begun=jnp.zeros((), dtype=bool),
            left=none,
            state=jax.tree.map(zeros, state),
            flown=jax.tree.map(of_all_lanes, flown),
        )


def call(program: Callable[..., Any], *arrays: Array) -> Any:
    """Call a program in double precision, whatever the caller's JAX is set to.

    In a thread: it may have to be compiled, and an interrupt is raised meanwhile.
    """

    def called() -> Any:
        with jax.enable_x64(True):
            return jax.tree.map(np.asarray, program(*map(jnp.asarray, arrays)))

    pool = compiling_threads(1)
    try:
        return pool.submit(called).result()
    finally:
        pool.shutdown(wait=False)


@functools.cache
def compiler_options(platform: str) -> dict[str, Any]:
    """Return the compiler's options, without those that its version has not got."""

    def known(option: tuple[str, Any]) -> bool:
        trivial = jax.jit(lambda x: x, compiler_options=dict([option]))
        try:
            trivial.lower(0.0).compile()
        except jax.errors.JaxRuntimeError:
            return False
        return True

    return dict(filter(known, _OPTIONS.get(platform, {}).items()))


def keep_programs() -> None:
    """Let JAX keep compiled programs on disk, unless its user has said where."""
    if jax.config.values["jax_compilation_cache_dir"] is None:
        home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
        folder = Path(home) / "drakesep" / "jax"
        if _is_writable(folder):
            jax.config.update("jax_compilation_cache_dir", str(folder))  # type: ignore[no-untyped-call]


@functools.cache
def _is_writable(folder: Path) -> bool:
    """Return whether programs can be kept in a folder; warn once if not."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        warnings.warn(
            f"{folder}: {error.strerror}: programs are not kept, and compiled anew by "
            "each process",
            DrakesepWarning,
            stacklevel=5,
        )
        return False
    return True
