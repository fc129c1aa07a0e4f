"""Processes beside ours, which no interrupt reaches, and interrupts as they start."""

import os
import signal
import subprocess
import sys
import threading

import pytest
from left_behind import descendants, nothing_is_left, semaphores
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


BUSY = """
import os, signal, time
from drakesep.analysis.engines import processes
# Who runs in the background inherits that interrupts are ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)
pool = processes.start_processes(2, os.getpid)
try:
    pool.submit(os.getpid).result()
    for _ in range(2):
        pool.submit(time.sleep, 600)
    print("ready", flush=True)
    time.sleep(600)
finally:
    processes.end_processes(pool)
"""


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT, signal.SIGHUP])
@pytest.mark.parametrize("end", [os.kill, os.killpg], ids=["one", "group"])
def test_nothing_is_left_of_who_is_killed(end, number):
    """Nor of its group, as a terminal or `timeout` kills: semaphores are unlinked."""
    command = [sys.executable, "-c", BUSY]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, process_group=0
    ) as process:
        assert process.stdout.readline() == b"ready\n"
        theirs = descendants(process.pid)
        assert len(theirs) >= 4  # workers and trackers
        assert semaphores(process.pid)
        end(process.pid, number)
        try:
            process.wait(timeout=30)
        finally:
            process.kill()
    nothing_is_left(process.pid, theirs)
