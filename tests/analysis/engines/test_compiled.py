"""Compiled programs of the batch engine, as they are called."""

import hashlib
import os
import signal
import threading

import numpy as np
import pytest

from drakesep.analysis.engines.jax.compiled import call


def test_an_interrupt_waits_for_no_compiler():
    """It is raised though nothing of Python's runs in the main thread meanwhile."""
    over = threading.Event()

    def compiles(values):
        os.kill(os.getpid(), signal.SIGINT)
        # As deaf to signals as a compiler; a second or so.
        hashlib.pbkdf2_hmac("sha256", b"", b"", 2_000_000)
        over.set()
        return values

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            call(compiles, np.zeros(1))
        assert not over.is_set()
    finally:
        signal.signal(signal.SIGINT, before)
    assert over.wait(60.0)
