"""Many sequential searches side by side, whose questions are answered all at once.

A search such as scipy's SLSQP asks for one point after another; a batch engine answers
hundreds for the price of one. Each search runs in a thread of its own, one after the
other, until it asks; when all have asked, their questions are answered together, in
their order. What is answered with what does not depend on timing, nor does any
result.
"""

import queue
import threading
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias, TypeVar


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


class _Abandoned(Exception):
    """Raised in a search whose question will not be answered."""


def _run(
    tasks: Sequence[Task[Any, Any, Result]], answer: Callable[[list[Any]], list[Any]]
) -> list[Result]:
    searches = [_Search(task) for task in tasks]
    try:
        waiting = {i: search for i, search in enumerate(searches) if search.go_on()}
        while waiting:
            questions = [search.question for search in waiting.values()]
            for i, reply in zip([*waiting], answer(questions), strict=True):
                if reply is not None and not waiting[i].go_on(reply):
                    del waiting[i]
    finally:
        for search in searches:
            search.abandon()
    return [search.result for search in searches]


class _Search:
    """A task in a thread of its own, which runs only while its caller waits for it.

    One at a time: threads that all want to run hold each other up.
    """

    def __init__(self, task: Task[Any, Any, Any]):
        self.question: Any = None
        self.result: Any = None
        self._error: BaseException | None = None
        self._task = task
        self._replies: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._rests: queue.SimpleQueue[bool] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._work, daemon=True)

    def go_on(self, reply: Any = None) -> bool:
        """Let it go on to its next question, or to its end; return whether it asks.

        Args:
            reply: to its last question.
        """
        if self._thread.ident is None:
            self._thread.start()
        else:
            self._replies.put(reply)
        asks = self._rests.get()
        if self._error is not None:
            raise self._error
        return asks

    def abandon(self) -> None:
        """End it, if it waits for an answer."""
        self._replies.put(_Abandoned())

    def _work(self) -> None:
        try:
            self.result = self._task(self._ask)
        except BaseException as error:
            self._error = error
        self._rests.put(False)

    def _ask(self, question: Any) -> Any:
        self.question = question
        self._rests.put(True)
        reply = self._replies.get()
        if isinstance(reply, _Abandoned):
            raise reply
        return reply
