"""Expensive objectives, searched beside others."""

import math
import threading
import time

import pytest
from runs import evaluator_of
from separations import generic_pair

from drakesep.analysis.metrics.objectives import Needs
from drakesep.analysis.search.effort import SearchSettings
from drakesep.analysis.search.judge import find_worst_cases
from drakesep.analysis.search.problem import Problem
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.analysis.tolerances.tolerance_set import ToleranceSet
from drakesep.systems.checks import InputError


PAIR = generic_pair()
NAMES = ("upper.cg_x", "upper.cg_y", "upper.mass")
SET = ToleranceSet(
    PAIR, ToleranceBox.around(PAIR, dict(zip(NAMES, (0.02, 0.01, 1.0), strict=True)))
)
ALL = ("samples", "vertices", "sqp", "multistart")
SETTINGS = SearchSettings(starts=8, samples=50)
LONG = 60.0
"""Seconds after which a test that waits for a thread has failed."""


def slope(u):
    return u[0] - 0.5 * u[1]


def problem(cheap, expensive, *, concurrent=False):
    evaluator = evaluator_of(cheap, expensive, tolerances=SET)
    evaluator.objectives[1].needs = Needs.MEASUREMENT
    evaluator.concurrent = concurrent
    return Problem(tolerances=SET, evaluator=evaluator)


def wavy(u):
    """A function of several maxima, so that which starts there are can be seen."""
    return math.sin(4.0 * u[0]) + math.cos(3.0 * u[1]) - u[2] ** 2


def test_they_are_searched_by_sqp_and_left_out_of_sweeps():
    told = []
    cheap, dear = find_worst_cases(
        problem(slope, slope), ALL, SETTINGS, on_search=told.append
    )
    assert dear.value == pytest.approx(1.5, abs=1e-6)
    assert cheap.value == pytest.approx(1.5, abs=1e-6)
    assert (cheap.evidence.samples, dear.evidence.samples) == (50, 0)
    assert dear.evidence.fraction == 1.0
    assert (cheap.evidence.starts, dear.evidence.starts) == (8, 3)
    assert set(dear.evidence.by_search) == set(ALL)
    assert math.isnan(dear.evidence.by_search["vertices"])
    assert [search.objectives for search in told] == [(0,), (0,), (0, 1), (0, 1)]
    assert [search.note for search in told[1:]] == [
        "all 8 vertices, for 1 of 2 objectives",
        "SQP from the nominal, slopes by differences",  # told once, of both
        "SQP from 7 more starts, slopes by differences, for 1 of 2 objectives; "
        "SQP from 2 more starts, slopes by differences, for 1 of 2 objectives",
    ]


def test_alone_there_is_nothing_to_leave_them_out_beside():
    evaluator = evaluator_of(slope, tolerances=SET)
    evaluator.objectives[0].needs = Needs.MEASUREMENT
    alone = Problem(tolerances=SET, evaluator=evaluator)
    [only] = find_worst_cases(alone, ("samples",), SETTINGS)
    assert only.evidence.samples == 50


def test_beside_or_afterwards_is_the_same():
    after = find_worst_cases(problem(wavy, wavy), ALL, SETTINGS)
    beside = find_worst_cases(problem(wavy, wavy, concurrent=True), ALL, SETTINGS)
    assert beside == after


def test_they_begin_while_others_are_swept():
    begun = threading.Event()

    def waits(u):
        assert begun.wait(LONG)
        return slope(u)

    def begins(u):
        begun.set()
        return slope(u)

    cheap, dear = find_worst_cases(
        problem(waits, begins, concurrent=True), ALL, SETTINGS
    )
    assert (cheap.value, dear.value) == (pytest.approx(1.5), pytest.approx(1.5))


def test_progress_is_told_in_the_callers_thread_and_the_same_each_time():
    told = []

    def tell(progress):
        told.append((threading.get_ident(), progress))

    for _ in range(2):
        find_worst_cases(
            problem(wavy, wavy, concurrent=True), ALL, SETTINGS, on_progress=tell
        )
    assert {thread for thread, _ in told} == {threading.get_ident()}
    half = len(told) // 2
    assert [p for _, p in told[:half]] == [p for _, p in told[half:]]
    searches = [p.search for _, p in told[:half]]
    assert list(dict.fromkeys(searches)) == list(ALL)
    assert {p.iterate.objective for _, p in told if p.iterate} == {0, 1}


def test_an_interrupt_abandons_them():
    swept, asked = threading.Event(), []

    def goes_on(u):
        assert swept.wait(LONG)
        asked.append(u)
        return wavy(u)

    def interrupt(_):
        swept.set()
        raise KeyboardInterrupt

    threads = threading.active_count()
    with pytest.raises(KeyboardInterrupt):
        find_worst_cases(
            problem(slope, goes_on, concurrent=True),
            ALL,
            SETTINGS,
            on_progress=interrupt,
        )
    # The start and its slopes, of an ascent of dozens, and of three.
    assert len(asked) <= 2 * (1 + len(SET))
    late = time.monotonic() + LONG
    while threading.active_count() > threads and time.monotonic() < late:
        time.sleep(0.01)  # they have been told to end
    assert threading.active_count() <= threads


def test_what_goes_wrong_in_them_is_raised():
    def broken(u):
        raise ZeroDivisionError

    with pytest.raises(InputError, match=r"objective_1 must give .*ZeroDivisionError"):
        find_worst_cases(problem(slope, broken, concurrent=True), ALL, SETTINGS)


def test_sweeps_alone_are_refused():
    with pytest.raises(
        InputError, match="must have sqp or multistart or best too, got samp"
    ):
        find_worst_cases(problem(slope, slope), ("samples", "vertices"), SETTINGS)


@pytest.mark.parametrize("concurrent", [False, True])
@pytest.mark.parametrize("known", range(len(ALL) + 1))
def test_searches_go_on_from_those_that_are_finished(known, concurrent):
    """To the same worst cases, and the same from each search."""
    all_told, told = [], []
    problem_ = problem(wavy, wavy, concurrent=concurrent)
    at_once = find_worst_cases(problem_, ALL, SETTINGS, on_search=all_told.append)
    later = find_worst_cases(
        problem(wavy, wavy, concurrent=concurrent),
        ALL,
        SETTINGS,
        finished=all_told[:known],
        on_search=told.append,
    )
    assert later == at_once
    assert told == all_told[known:]


def test_finished_searches_of_another_order():
    told = []
    find_worst_cases(problem(wavy, wavy), ALL, SETTINGS, on_search=told.append)
    with pytest.raises(InputError, match=r"^finished: must be the first of"):
        find_worst_cases(problem(wavy, wavy), ALL, SETTINGS, finished=told[1:])
