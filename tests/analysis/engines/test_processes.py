"""Processes beside ours, which no interrupt reaches, and interrupts as they start."""

import os
import signal
import threading

import pytest
from loky.process_executor import ShutdownExecutorError

from drakesep.analysis.engines import processes


@pytest.fixture
def interruptible():
    """A test run in the background inherits that interrupts are ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def another_thread():
    """Which takes signals that the main thread has blocked."""
    over = threading.Event()
    thread = threading.Thread(target=over.wait)
    thread.start()
    yield
    over.set()
    thread.join()


def blocked():
    return signal.pthread_sigmask(signal.SIG_BLOCK, ())


def test_they_hear_of_no_interrupt_and_no_hang_up():
    mine = blocked()
    pool = processes.start_processes(2, os.getpid)
    try:
        theirs = pool.submit(signal.pthread_sigmask, signal.SIG_BLOCK, ()).result()
        other = pool.submit(os.getpid).result()
    finally:
        processes.end_processes(pool)
    assert {signal.SIGINT, signal.SIGHUP} <= theirs
    assert other != os.getpid()
    assert blocked() == mine


def test_an_interrupt_as_they_start_comes_after(
    interruptible, another_thread, monkeypatch
):
    """It is not lost, and leaves no process behind."""
    pools, submit = [], processes.ProcessPoolExecutor.submit

    def interrupted(pool, function):
        future = submit(pool, function)
        pools.append(pool)
        os.kill(os.getpid(), signal.SIGINT)
        return future

    monkeypatch.setattr(processes.ProcessPoolExecutor, "submit", interrupted)
    with pytest.raises(KeyboardInterrupt):
        processes.start_processes(2, os.getpid)
    assert len(pools) == 2  # both were started all the same
    with pytest.raises(ShutdownExecutorError):
        submit(pools[0], os.getpid)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
