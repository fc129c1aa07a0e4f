"""Runs made of what a batch samples of their motion."""

from collections.abc import Mapping
from dataclasses import dataclass

from drakesep.systems.arrays import Array
from drakesep.systems.batch.integrator import FinalState
from drakesep.systems.batch.motion import sampled
from drakesep.systems.model.parameters import with_values
from drakesep.systems.model.run import Run, RunStatus
from drakesep.systems.model.separation import Separation
from drakesep.systems.sampling import find_breaks, sample_times


@dataclass(frozen=True, slots=True, kw_only=True)
class SampledRun:
    """A run that is to be sampled."""

    lane: int
    """In which its motion is sampled."""
    separation: Separation
    releases: Mapping[str, float]
    stroke_ends: Mapping[str, float]
    times: Array
    steps: int
    evaluations: int

    @classmethod
    def of(
        cls,
        separation: Separation,
        final: FinalState,
        row: int,
        lane: int,
        values: Mapping[str, float],
    ) -> "SampledRun":
        """Return what is to be sampled of a row.

        Args:
            separation: of the batch.
            final: how the rows of the batch ended.
            row: its number.
            lane: in which its motion is sampled.
            values: of its parameters, in SI.
        """
        flown = with_values(separation, values)
        releases = {
            attachment.name: float(t)
            for attachment, t in zip(
                flown.attachments, final.released[:, row], strict=True
            )
        }
        ends = {
            spring.name: float(t)
            for spring, t in zip(flown.springs, final.stroke_ends[:, row], strict=True)
        }
        return cls(
            lane=lane,
            separation=flown,
            releases=releases,
            stroke_ends=ends,
            times=sample_times(flown, releases, ends),
            steps=int(final.steps[row]),
            evaluations=int(final.evaluations[row]),
        )

    def run(self, signals: Array) -> Run:
        """Return the run, from the signals (T, ..., n) at the times of all."""
        mine = signals[: len(self.times), :, self.lane]
        trajectory, motions = sampled(self.separation, self.times, mine)
        return Run(
            separation=self.separation,
            status=RunStatus.COMPLETED,
            motion=motions.pop(self.separation.B),
            others=motions,
            trajectory=trajectory,
            breaks=find_breaks(self.separation, self.releases, self.stroke_ends),
            releases=self.releases,
            stroke_ends=self.stroke_ends,
            steps=self.steps,
            evaluations=self.evaluations,
        )
