"""Work beside a study: in a process that is handed down, and ends with its caller."""

import multiprocessing
import os
import signal
import time

import pytest
from elsewhere import imported, warned_of
from toy_metrics import RELATIVE, registered

from drakesep.analysis.metrics.registry import find_metric
from drakesep.studies.background_process import BackgroundProcess


def test_a_process_takes_over_until_its_caller_ends():
    with BackgroundProcess(2) as background:
        assert background.is_another
        pid = background.submit(os.getpid).result()
        assert pid != os.getpid()
        assert background.submit(os.getpid).result() == pid
        assert not has_ended(pid)
    assert has_ended(pid)
    assert not background.is_another


def test_each_is_a_process_of_its_own():
    """None is found by another: a study works in that which it is given."""
    with BackgroundProcess(2) as outer, BackgroundProcess(2) as inner:
        outer_pid, inner_pid = (p.submit(os.getpid).result() for p in (outer, inner))
        assert outer_pid != inner_pid


def test_it_knows_the_callers_metrics():
    with registered(RELATIVE), BackgroundProcess(2) as background:
        found = background.submit(find_metric, RELATIVE.stem).result()
        assert found == (RELATIVE, "")


def test_who_fails_does_not_wait_for_it():
    with pytest.raises(KeyboardInterrupt), BackgroundProcess(2) as background:
        pid = background.submit(os.getpid).result()
        background.submit(time.sleep, 600.0)
        raise KeyboardInterrupt
    assert has_ended(pid)


def test_one_process_does_all_itself():
    with BackgroundProcess(1) as background:
        assert not background.is_another
        assert background.submit(os.getpid).result() == os.getpid()


def test_a_process_that_may_not_start_others_does_all_itself(monkeypatch):
    """As those of a multiprocessing.Pool, whose studies would fail."""
    config = multiprocessing.current_process()._config
    monkeypatch.setitem(config, "daemon", True)
    with BackgroundProcess(2) as background:
        assert not background.is_another


@pytest.mark.parametrize("workers", [1, 2])
def test_errors_come_when_results_are_asked_for(workers):
    with BackgroundProcess(workers) as background:
        refused = background.submit(int, "five")
        with pytest.raises(ValueError, match="'five'"):
            refused.result()


def test_an_interrupt_leaves_it_alone():
    with BackgroundProcess(2) as background:
        [pid] = background._process._processes  # it has hardly begun to start
        os.kill(pid, signal.SIGINT)
        assert background.submit(os.getpid).result() == pid
        os.kill(pid, signal.SIGINT)
        assert background.submit(os.getpid).result() == pid


def test_it_does_without_jax():
    """Which takes the longest to import, and has nothing to do there."""
    with BackgroundProcess(2) as background:
        assert "matplotlib" in background.submit(imported).result()
        assert "jax" not in background.submit(imported).result()


def test_only_doubtful_scales_are_not_warned_of_there():
    with BackgroundProcess(2) as background:
        warned = background.submit(warned_of).result()
    assert warned == ["another"]


def test_its_death_is_an_error_of_what_was_asked():
    with BackgroundProcess(2) as background:
        pid = background.submit(os.getpid).result()
        asleep = background.submit(time.sleep, 600.0)
        os.kill(pid, signal.SIGKILL)
        with pytest.raises(RuntimeError):
            asleep.result()
        with pytest.raises(RuntimeError):
            background.submit(os.getpid).result()


def has_ended(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    return False
