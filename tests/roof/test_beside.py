"""Work beside a study: in a process, which ends with what fails."""

import os
import signal
import time

import pytest

from drakesep.beside import beside


def test_a_process_takes_over_and_is_kept_for_the_next():
    with beside(2) as aside:
        pid = aside.submit(os.getpid).result()
    assert pid != os.getpid()
    with beside(2) as aside:
        assert aside.submit(os.getpid).result() == pid


def test_one_process_does_all_itself():
    with beside(1) as aside:
        assert aside.submit(os.getpid).result() == os.getpid()


def test_errors_come_back():
    with beside(2) as aside:
        refused = aside.submit(int, "five")
        with pytest.raises(ValueError, match="'five'"):
            refused.result()


def test_who_fails_does_not_wait_for_it():
    with pytest.raises(KeyboardInterrupt), beside(2) as aside:
        pid = aside.submit(os.getpid).result()
        aside.submit(time.sleep, 600.0)
        raise KeyboardInterrupt
    assert has_ended(pid)
    with beside(2) as aside:
        assert aside.submit(os.getpid).result() != pid


def test_it_ends_with_its_caller():
    with beside(2, keep=False) as aside:
        pid = aside.submit(os.getpid).result()
    assert has_ended(pid)


def test_one_that_was_killed_is_replaced():
    with beside(2) as aside:
        pid = aside.submit(os.getpid).result()
    os.kill(pid, signal.SIGKILL)
    time.sleep(1.0)  # until that is noticed
    with beside(2) as aside:
        assert aside.submit(os.getpid).result() != pid


def test_who_fails_leaves_it_to_others():
    with beside(2) as other:
        pid = other.submit(os.getpid).result()
        with pytest.raises(RuntimeError), beside(2):
            raise RuntimeError
        assert other.submit(os.getpid).result() == pid


def has_ended(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    return False
