"""How far the bounds of a case are proven."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from drakesep.analysis.bounds.answers import Question, claims_of
from drakesep.analysis.bounds.branch_and_bound import Progress
from drakesep.studies.worst_case.effort import in_time
from drakesep.studies.worst_case.pace import Pace, Remaining


@dataclass(frozen=True, kw_only=True)
class ProofProgress:
    """Where a study stands that proves bounds."""

    claim: str
    """That is being proven; empty: none yet."""
    done: int
    """Bounds that are proven, or given up."""
    total: int
    parameters: int
    """Over whose tolerances."""
    boxes: int
    """That were enclosed for it."""
    remaining: Remaining
    """What is left, at most."""

    def __str__(self) -> str:
        """Return what it will do, in a line."""
        several = "a bound" if self.total == 1 else f"{self.total} bounds"
        one = self.parameters == 1
        over = "a parameter" if one else f"{self.parameters} parameters"
        return (
            f"proof of {several} over {over}, all "
            f"corners and everything between: at most "
            f"{in_time(self.remaining.seconds)}"
        )


OnProof: TypeAlias = Callable[[ProofProgress], None]


class TellingProof:
    """Tells the user how far bounds are proven."""

    def __init__(
        self,
        on_progress: OnProof | None,
        questions: Sequence[Question],
        parameters: int,
        seconds: float,
        known: Collection[str] = (),
    ):
        """Tell what will be done, and how long it takes at most.

        Args:
            on_progress: called as it goes on; None: nobody is told.
            questions: that are answered.
            parameters: that vary.
            seconds: for each bound, at most.
            known: claims that are proven already.
        """
        self._claims = claims_of(questions)
        self._on_progress, self._parameters = on_progress, parameters
        self._pace = Pace(
            {claim: 0.0 if claim in known else seconds for claim in self._claims}
        )
        self._tell("", 0)

    def __call__(self, claim: str, progress: Progress) -> None:
        """Tell how far one is."""
        self._tell(claim, progress.boxes)

    def _tell(self, claim: str, boxes: int) -> None:
        if self._on_progress is None or not self._claims:
            return
        done = self._claims.index(claim) if claim else 0
        self._on_progress(
            ProofProgress(
                claim=claim,
                done=done,
                total=len(self._claims),
                parameters=self._parameters,
                boxes=boxes,
                remaining=self._pace.at(claim, 0, None),
            )
        )
