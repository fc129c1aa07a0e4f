"""Searches side by side: order, waiting, errors."""

import threading
import time

import pytest

from drakesep.analysis.search.ask_tell import side_by_side


def counting(questions):
    """A task that asks so many times, and returns its answers."""
    return lambda ask: [ask(i) for i in range(questions)]


def test_results_are_in_order_and_questions_are_gathered():
    rounds = []

    def answer(questions):
        rounds.append(list(questions))
        return [10 * question for question in questions]

    results = side_by_side([counting(n) for n in (3, 0, 1)], answer)
    assert results == [[0, 10, 20], [], [0]]
    assert rounds == [[0, 0], [1], [2]]


def test_order_does_not_depend_on_who_is_slow():
    def slow(ask):
        time.sleep(0.05)
        return ask("slow")

    def quick(ask):
        return ask("quick")

    seen = []

    def answer(questions):
        seen.append(list(questions))
        return questions

    assert side_by_side([slow, quick], answer) == ["slow", "quick"]
    assert seen == [["slow", "quick"]]


def test_a_question_may_wait():
    """Even numbers are answered first."""
    rounds = []

    def answer(questions):
        even = [q for q in questions if q % 2 == 0]
        rounds.append(even or list(questions))
        return [q if q in (even or questions) else None for q in questions]

    def task(start):
        return lambda ask: [ask(start), ask(start + 1)]

    assert side_by_side([task(0), task(1)], answer) == [[0, 1], [1, 2]]
    # 1 waits for 0, and 1 of the first task joins it
    assert rounds == [[0], [1, 1], [2]]


def test_error_of_a_task_or_of_the_answer_ends_all():
    def bad(ask):
        ask(1)
        raise ValueError("mine")

    before = threading.active_count()
    with pytest.raises(ValueError, match="mine"):
        side_by_side([counting(5), bad], lambda questions: questions)

    def refuse(questions):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        side_by_side([counting(5), counting(5)], refuse)
    deadline = time.monotonic() + 5.0
    while threading.active_count() > before and time.monotonic() < deadline:
        time.sleep(0.01)
    assert threading.active_count() == before


def test_nothing_to_do():
    assert side_by_side([], lambda questions: questions) == []
