"""How much of a study is done, and how long it still takes, as it goes on."""

import time
from collections.abc import Callable, Mapping
from typing import NamedTuple


_NEARLY = 0.95
"""Of a step that does not say how far it has come: it is never done before its end."""
_TELLING = 0.1
"""Share of a study from which its own pace tells how long it takes, not the plan's."""


class Remaining(NamedTuple):
    """What is left of a study."""

    share: float
    """That is done, from 0 to 1."""
    seconds: float
    """Until it ends, about."""


class Pace:
    """Where a study stands in its plan."""

    def __init__(
        self,
        seconds: Mapping[str, float],
        clock: Callable[[], float] = time.monotonic,
    ):
        """Begin.

        Args:
            seconds: that each step is planned to take, in their order.
            clock: tells the time, s.
        """
        self._seconds = dict(seconds)
        self._total = sum(seconds.values()) or 1.0
        self._clock = clock
        self._began = self._step_began = clock()
        self._step = ""
        self._share = 0.0

    def at(self, step: str, done: int, total: int | None) -> Remaining:
        """Return what is left.

        Args:
            step: that is under way.
            done: of it.
            total: of it; None if that is not known. Until something is done, a step is
                reckoned to come as far as it was planned to.
        """
        now = self._clock()
        if step != self._step:
            self._step, self._step_began = step, now
        planned = self._seconds.get(step, 0.0)
        known = done / total if total else 0.0
        if not known and planned:
            known = min((now - self._step_began) / planned, _NEARLY)
        before = 0.0
        for name, seconds in self._seconds.items():
            if name == step:
                break
            before += seconds
        share = (before + known * planned) / self._total
        if step in self._seconds:
            self._share = min(max(self._share, share), 1.0)
        spent = now - self._began
        left = (1.0 - self._share) * self._total
        if self._share > _TELLING:
            left = spent * (1.0 - self._share) / self._share
        return Remaining(self._share, left)
