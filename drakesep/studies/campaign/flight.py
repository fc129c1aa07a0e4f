"""The chunks of a campaign flown, those that are there left as they are."""

import contextlib
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from pathlib import Path

import numpy as np

from drakesep.analysis.campaigns.flights import CampaignFlights
from drakesep.analysis.campaigns.gathering import KeptDraws, findings_of_kept
from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.results.asked import Asked
from drakesep.results.campaign_files import RecordedPlan, gathered, write_chunk
from drakesep.results.folder import ResultsFolder
from drakesep.results.parts import parts_folder
from drakesep.studies.campaign.executors import flown_by, flown_here
from drakesep.studies.campaign.result import Campaign


class ChunksUnderWay:
    """A campaign's chunks: some there, read once, the others to be flown."""

    def __init__(self, recorded: RecordedPlan, flights: CampaignFlights, home: Path):
        """Read what is there.

        Args:
            recorded: the plan.
            flights: that fly it.
            home: folder of the campaign.

        Raises:
            ValueError: a chunk is of another plan.
        """
        parts_folder(home).mkdir(exist_ok=True)
        self._recorded, self._flights, self._home = recorded, flights, home
        self._chunks = gathered(home, recorded)

    @property
    def left(self) -> int:
        """Draws that are to be flown."""
        plan = self._recorded.plan
        return sum(len(plan.indices(number)) for number in self._chunks.missing)

    def seconds(self) -> float:
        """Return what draws that are left will take, s; programs are compiled."""
        return seconds_of(self._flights, self.left) if self.left else 0.0

    def flown(
        self,
        executor: Executor | None,
        on_progress: Callable[[int], None] = lambda _: None,
        on_chunk: Callable[[CampaignPlan, KeptDraws], None] = lambda *_: None,
    ) -> KeptDraws:
        """Return what is kept of all draws, once those left are flown and written.

        Args:
            executor: whose workers fly; None: this process does.
            on_progress: told how many draws of those that were left are done.
            on_chunk: told what is kept of each chunk of those that were left, once it
                is written, in whichever order they come.
        """
        recorded, home, chunks = self._recorded, self._home, self._chunks
        missing = [*chunks.missing]
        flown = (
            flown_here(self._flights, missing, on_progress)
            if executor is None
            else flown_by(executor, recorded, home, missing, on_progress)
        )
        for number, draws in flown:
            write_chunk(home, recorded, number, draws)
            chunks.add(number, draws)
            on_chunk(recorded.plan, draws)
        return chunks.whole()


def seconds_of(flights: CampaignFlights, runs: int) -> float:
    """Return what so many runs will take, s; programs are compiled."""
    few = np.arange(flights.together, dtype=np.int64)
    flights.fly(few)
    began = time.perf_counter()
    flights.fly(few)
    return (time.perf_counter() - began) * runs / len(few)


@contextlib.contextmanager
def home_of(folder: ResultsFolder | None) -> Iterator[Path]:
    """Give the folder that has the chunks; one for a while, if none is written."""
    if folder is not None:
        yield folder.path
    else:
        with tempfile.TemporaryDirectory(prefix="drakesep-") as scratch:
            yield Path(scratch)


def shown(
    asked: Asked, recorded: RecordedPlan, flights: CampaignFlights, flown: KeptDraws
) -> Campaign:
    """Return what the draws of a campaign show, before Drake has its say.

    Args:
        asked: of the campaign.
        recorded: its plan.
        flights: that can fly any draw again.
        flown: what is kept of all draws.
    """
    return Campaign(
        asked=asked,
        recorded=recorded,
        flights=flights,
        flown=flown,
        findings=tuple(findings_of_kept(recorded.plan, flown)),
    )
