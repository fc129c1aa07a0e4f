"""Batches that hold different values, flown side by side: their rows share calls.

A call costs as much for one row as for a chunk, and a search asks for few at a time.
Where many searches go on side by side, each of another batch by the same programs, what
they ask for is flown together. What a row tells does not depend on what flies beside,
but for round-off.
"""

import enum
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from drakesep.analysis.engines.jax.batch import Batch, BatchResult, Progress
from drakesep.systems.arrays import Array
from drakesep.systems.model.run import Run


class Wanted(enum.Enum):
    """What is wanted of rows."""

    METRICS = enum.auto()
    RUNS = enum.auto()


class Question(NamedTuple):
    """Rows that a batch is asked to fly."""

    batch: Batch
    rows: Array
    """(n, n_p) of its parameters, in SI."""
    wanted: Wanted


Ask: TypeAlias = Callable[[Question], Any]
"""Answers with what `Batch.run` tells, or `Batch.runs`."""


class OneOfMany:
    """A batch whose rows are flown with those of others, by whom it asks."""

    def __init__(self, batch: Batch, ask: Ask):
        """Prepare.

        Args:
            batch: that is asked to fly.
            ask: answers, as `flown_together` does.
        """
        self._batch, self._ask = batch, ask

    def run(self, values: Array, *, on_progress: Progress | None = None) -> BatchResult:
        """Fly each row of values, as `Batch.run` does."""
        told: BatchResult = self._ask(Question(self._batch, values, Wanted.METRICS))
        if on_progress is not None:
            on_progress(len(values), len(values))
        return told

    def runs(self, values: Array) -> list[Run]:
        """Fly each row of values, as `Batch.runs` does."""
        runs: list[Run] = self._ask(Question(self._batch, values, Wanted.RUNS))
        return runs


def flown_together(questions: Sequence[Question]) -> list[Any]:
    """Return the answers to questions of batches by the same programs, in their order.

    Args:
        questions: one or more.
    """
    answers: list[Any] = [None] * len(questions)
    for wanted in Wanted:
        asked = [i for i, question in enumerate(questions) if question.wanted is wanted]
        if asked:
            told = _flown([questions[i] for i in asked], wanted)
            for i, answer in zip(asked, told, strict=True):
                answers[i] = answer
    return answers


def _flown(questions: Sequence[Question], wanted: Wanted) -> list[Any]:
    whole = questions[0].batch.whole
    rows = [question.batch.whole_rows(question.rows) for question in questions]
    stops = np.cumsum([len(mine) for mine in rows]).tolist()
    parts = [slice(s - len(mine), s) for s, mine in zip(stops, rows, strict=True)]
    if wanted is Wanted.RUNS:
        runs = whole.runs(np.concatenate(rows))
        return [runs[part] for part in parts]
    told = whole.run(np.concatenate(rows))
    return [
        BatchResult(
            names=question.batch.names,
            metrics=told.metrics.iloc[part].reset_index(drop=True),
            failures={
                i - part.start: why
                for i, why in told.failures.items()
                if part.start <= i < part.stop
            },
            steps=told.steps[part],
        )
        for question, part in zip(questions, parts, strict=True)
    ]
