"""Many sequential searches side by side, whose questions are answered all at once.

A search such as scipy's SLSQP asks for one point after another; a batch engine answers
hundreds for the price of one. Each search runs in a thread of its own and waits for its
answer; when all have asked, their questions are answered together, in their order. What
is answered with what does not depend on timing, nor does any result.
"""

import queue
import threading
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias, TypeVar


Question = TypeVar("Question")
Answer = TypeVar("Answer")
Result = TypeVar("Result")
Task: TypeAlias = Callable[[Callable[[Question], Answer]], Result]
"""A search: given a function that answers its questions, it returns its result."""

SIDE_BY_SIDE = 512
"""Searches at a time, each a thread."""


def side_by_side(
    tasks: Sequence[Task[Question, Answer, Result]],
    answer: Callable[[list[Question]], list[Answer | None]],
) -> list[Result]:
    """Run tasks side by side, and return their results in order.

    Args:
        tasks: each is called with a function that answers its questions.
        answer: answers the questions of all tasks that wait, in the tasks' order; a
            question that it answers with None goes on waiting for the others.

    Raises:
        BaseException: what a task or `answer` raised; no task goes on then.
    """
    results: list[Result] = []
    for first in range(0, len(tasks), SIDE_BY_SIDE):
        results += _run(tasks[first : first + SIDE_BY_SIDE], answer)
    return results


class _Asked(NamedTuple):
    question: Any


class _Ended(NamedTuple):
    result: Any
    error: BaseException | None


class _Abandoned(Exception):
    """Raised in a search whose question will not be answered."""


def _seat(heard: tuple[int, Any]) -> int:
    return heard[0]


def _run(
    tasks: Sequence[Task[Any, Any, Result]], answer: Callable[[list[Any]], list[Any]]
) -> list[Result]:
    said: queue.SimpleQueue[tuple[int, _Asked | _Ended]] = queue.SimpleQueue()
    answers: list[queue.SimpleQueue[Any]] = [queue.SimpleQueue() for _ in tasks]

    def work(i: int) -> None:
        def ask(question: Any) -> Any:
            said.put((i, _Asked(question)))
            reply = answers[i].get()
            if isinstance(reply, _Abandoned):
                raise reply
            return reply

        try:
            said.put((i, _Ended(tasks[i](ask), None)))
        except BaseException as error:
            said.put((i, _Ended(None, error)))

    for i in range(len(tasks)):
        threading.Thread(target=work, args=(i,), daemon=True).start()
    results: dict[int, Result] = {}
    waiting: dict[int, Any] = {}
    try:
        while len(results) < len(tasks):
            busy = len(tasks) - len(results) - len(waiting)
            for i, what in sorted((said.get() for _ in range(busy)), key=_seat):
                if isinstance(what, _Asked):
                    waiting[i] = what.question
                elif what.error is not None:
                    raise what.error
                else:
                    results[i] = what.result
            asking = sorted(waiting)
            replies = answer([waiting[i] for i in asking]) if asking else []
            for i, reply in zip(asking, replies, strict=True):
                if reply is not None:
                    del waiting[i]
                    answers[i].put(reply)
    finally:
        for mailbox in answers:
            mailbox.put(_Abandoned())
    return [results[i] for i in range(len(tasks))]
