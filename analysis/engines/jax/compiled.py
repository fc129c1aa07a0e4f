"""Compiled programs of the batch engine: how they are made, kept, cut up and called."""

import functools
import os
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from drakesep.systems.arrays import Array
from drakesep.systems.batch.lanes import Lanes
from drakesep.systems.checks import DrakesepWarning


_CHUNKS, _LANES = 8, 1024
"""In a call of a program, at most, but for one chunk: between calls threads wait for
Python."""
_CALL = 0.5
"""Of a call that may be interrupted only at its end, at most, s."""
_OPTIONS = {
    "cpu": {
        # As fast, and compiled in half the time.
        "xla_cpu_use_fusion_emitters": False,
        "xla_backend_optimization_level": 1,
        "xla_cpu_prefer_vector_width": 512,
    }
}
"""For the compiler, as far as it knows them: they change speed alone."""


class Program:
    """Flies lanes, chunk after chunk, in a single call."""

    def __init__(
        self,
        compiled: Callable[[Callable[..., Any]], Callable[..., Any]],
        fly: Callable[[Lanes], Any],
        chunk: int,
    ):
        """Prepare.

        Args:
            compiled: makes programs of functions.
            fly: flies the lanes (n_p, chunk) of one chunk.
            chunk: lanes that are flown together.
        """
        self.chunk = chunk
        self.lanes = min(max(_LANES // chunk, 1), _CHUNKS) * chunk
        self._seconds = _CALL  # of a chunk: first of all, slow ones are reckoned with
        self._fly = jax.jit(fly)  # it is looked at twice, and traced once
        self._program = compiled(self._fly_chunks)

    @property
    def affordable(self) -> int:
        """Chunks in a call, by how long the last one took."""
        return min(self.lanes // self.chunk, int(_CALL / self._seconds))

    def __call__(self, values: Array, count: int) -> Any:
        """Return what comes of the first lanes of values (n_p, lanes)."""
        chunks = -(-count // self.chunk)
        begin = time.perf_counter()
        flown = call(self._program, values, np.array(chunks))
        self._seconds = (time.perf_counter() - begin) / max(chunks, 1)
        return jax.tree.map(lambda x: x[..., :count], flown)

    def _fly_chunks(self, values: Lanes, chunks: Lanes) -> Any:
        def chunk(i: int) -> Lanes:
            return lax.dynamic_slice_in_dim(values, i * self.chunk, self.chunk, -1)

        def fly(i: int, flown: Any) -> Any:
            def put(x: Lanes, mine: Lanes) -> Lanes:
                return lax.dynamic_update_slice_in_dim(x, mine, i * self.chunk, -1)

            return jax.tree.map(put, flown, self._fly(chunk(i)))

        def nothing(x: Any) -> Lanes:
            return jnp.zeros((*x.shape[:-1], self.lanes), x.dtype)

        shapes = jax.eval_shape(self._fly, chunk(0))
        return lax.fori_loop(0, chunks, fly, jax.tree.map(nothing, shapes))


def call(program: Callable[..., Any], *arrays: Array) -> Any:
    """Call a program in double precision, whatever the caller's JAX is set to."""
    with jax.enable_x64(True):
        return jax.tree.map(np.asarray, program(*map(jnp.asarray, arrays)))


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
