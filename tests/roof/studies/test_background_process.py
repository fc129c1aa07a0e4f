"""Work beside a study: in a process, which ends with its caller."""

import multiprocessing
import os
import signal
import sys
import time

import pytest
from toy_metrics import RELATIVE, registered

from drakesep.analysis.metrics.registry import find_metric
from drakesep.studies.background_process import beside, submitted


def test_a_process_takes_over_until_its_caller_ends():
    with beside(2) as aside:
        pid = submitted(aside, os.getpid).result()
        assert pid != os.getpid()
        with beside(2) as within:
            assert submitted(within, os.getpid).result() == pid
        with beside(1) as within:
            assert within is None
        assert not has_ended(pid)
    assert has_ended(pid)


def test_it_knows_the_callers_metrics():
    with registered(RELATIVE), beside(2) as aside:
        assert submitted(aside, find_metric, RELATIVE.stem).result() == (RELATIVE, "")


def test_who_fails_does_not_wait_for_it():
    with pytest.raises(KeyboardInterrupt), beside(2) as aside:
        pid = submitted(aside, os.getpid).result()
        submitted(aside, time.sleep, 600.0)
        raise KeyboardInterrupt
    assert has_ended(pid)


def test_one_process_does_all_itself():
    with beside(1) as aside:
        assert aside is None
        assert submitted(aside, os.getpid).result() == os.getpid()


def test_a_process_that_may_not_start_others_does_all_itself(monkeypatch):
    """As those of a multiprocessing.Pool, whose studies would fail."""
    config = multiprocessing.current_process()._config
    monkeypatch.setitem(config, "daemon", True)
    with beside(2) as aside:
        assert aside is None


@pytest.mark.parametrize("workers", [1, 2])
def test_errors_come_when_results_are_asked_for(workers):
    with beside(workers) as aside:
        refused = submitted(aside, int, "five")
        with pytest.raises(ValueError, match="'five'"):
            refused.result()


def test_an_interrupt_leaves_it_alone():
    with beside(2) as aside:
        [pid] = aside._processes  # it has hardly begun to start
        os.kill(pid, signal.SIGINT)
        assert submitted(aside, os.getpid).result() == pid
        os.kill(pid, signal.SIGINT)
        assert submitted(aside, os.getpid).result() == pid


def test_it_does_without_jax():
    """Which takes the longest to import, and has nothing to do there."""
    with beside(2) as aside:
        assert "matplotlib" in submitted(aside, imported).result()
        assert "jax" not in submitted(aside, imported).result()


def imported():
    return {name.partition(".")[0] for name in sys.modules}


def test_its_death_is_an_error_of_what_was_asked():
    with beside(2) as aside:
        pid = submitted(aside, os.getpid).result()
        asleep = submitted(aside, time.sleep, 600.0)
        os.kill(pid, signal.SIGKILL)
        with pytest.raises(RuntimeError):
            asleep.result()
        with pytest.raises(RuntimeError):
            submitted(aside, os.getpid).result()


def has_ended(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    return False
