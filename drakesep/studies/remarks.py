"""What a user should be told of a study's runs, although nothing in them has failed."""

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from drakesep.analysis.metrics.of_run import metric_named, signal_of_run
from drakesep.systems.arrays import Array
from drakesep.systems.equations.forces_of_run import spring_work
from drakesep.systems.equations.loads_of_run import joint_loads, largest_loads
from drakesep.systems.equations.mated_stack import mated_places, place_in_stack
from drakesep.systems.equations.pair_signals import PairFacts
from drakesep.systems.model.run import Run
from drakesep.systems.model.separation import Attachment, Pair, Separation
from drakesep.systems.model.springs import Spring
from drakesep.tables.columns import write_csv


_STILL = 1e-6
"""Speed below which nothing moves, m/s."""
_ACROSS = math.cos(math.radians(80.0))
"""Of a speed, along a direction: with less, a body leaves across it."""
_OFF = 0.1
"""Share of its energy by which a spring of Eq. 5 may miss it without a word."""
_STEEP = math.radians(80.0)
"""Pitch above which roll and yaw are said to say little."""
_ANGLE, _TURNED = metric_named("angle_at_end_pitch"), metric_named("total_rotation")


@dataclass(frozen=True, kw_only=True)
class Remark:
    """What is told of a study's runs once."""

    about: tuple[str, ...]
    """The bodies or springs that it names."""
    text: str
    """In a sentence."""
    run: str
    """Label of the first run in which it is so: the numbers are those of this one."""
    subject: str
    """What is said of them, of `_SUBJECTS`."""


def remarks(runs: Mapping[str, Run], known: Sequence[Remark] = ()) -> list[Remark]:
    """Return what should be told of runs, the same of a body or a spring once.

    Args:
        runs: by their labels; of those that failed nothing is told.
        known: what has been told of other runs, which comes first.
    """
    found = list(known)
    for label, run in runs.items():
        if run.motion is None:
            continue
        for subject, tell in _SUBJECTS.items():
            same = [remark for remark in found if remark.subject == subject]
            told = {name for remark in same for name in remark.about}
            found += [
                Remark(about=about, text=text, run=label, subject=subject)
                for about, text in tell(run, told)
            ]
    return found


_Told = Iterator[tuple[tuple[str, ...], str]]
"""What is remarked of, and the sentence."""


def notes_of(found: Sequence[Remark], plain: str) -> list[str]:
    """Return the sentences, with the labels of their runs but for that of the plain."""
    return [
        each.text if each.run == plain else f"{each.run}: {each.text}" for each in found
    ]


def save_remarks(found: Sequence[Remark], folder: Path) -> None:
    """Write remarks.csv into a folder, if there are any remarks."""
    if found:
        write_csv(remarks_table(found), folder / "remarks.csv")


def remarks_table(found: Sequence[Remark]) -> pd.DataFrame:
    """Return a row for each remark."""
    return pd.DataFrame(
        {"about": ", ".join(each.about), "remark": each.text, "run": each.run}
        for each in found
    )


def _of_angles(run: Run, told: set[str]) -> _Told:
    """Yield of which bodies roll and yaw swing, as pitch nears a quarter turn."""
    for pair in run.separation.pairs:
        if pair.B in told:
            continue
        pitch = np.abs(signal_of_run(run, _ANGLE.of(pair.B))[:, 1]).max()
        if pitch > _STEEP:
            turned = signal_of_run(run, _TURNED.of(pair.B))[-1, 0]
            yield (
                (pair.B,),
                f"{pair.B} turns by {math.degrees(turned):.4g} deg in all and comes to "
                f"a pitch of {math.degrees(pitch):.3g} deg, where roll and yaw swing "
                "by half a turn: its angles are better told by rotation_deg and "
                "total_rotation_deg.",
            )


def _of_held(run: Run, told: set[str]) -> _Told:
    """Yield which attachments never let go; see below."""
    held = [a for a in run.separation.attachments if a.name in run.held]
    names = [a.name for a in held if a.name not in told]
    if names:
        kept = dict.fromkeys(run.separation.leaving_at(a) for a in held)
        holds, does = _verbs(names, "holds", "hold"), _verbs(kept, "does", "do")
        loads = joint_loads(run)
        force, torque = largest_loads(loads[name] for name in names)
        yield (
            tuple(names),
            f"{_listed(names)} {holds} to the end, with up to {force:.4g} N and "
            f"{torque:.4g} N m: {_listed([*kept])} {does} not separate.",
        )
    back = [name for name in run.held_back if name not in told]
    if back:
        yield (
            tuple(back),
            f"{_listed(back)} {_verbs(back, 'has', 'have')} not reached the end of the "
            "stroke when the run ends: the bodies do not separate.",
        )


def _verbs(names: Collection[str], one: str, several: str) -> str:
    return one if len(names) == 1 else several


def _of_directions(run: Run, told: set[str]) -> _Told:
    """Yield which bodies do not leave in their direction, or not away from the other.

    Args:
        run: completed.
        told: names of what has been told of.
    """
    for pair in run.separation.pairs:
        leaves = math.isfinite(run.end_of(pair.B)) and pair.B not in told
        text = _of_direction(run, pair) if leaves else ""
        if text:
            yield (pair.B,), text


def _of_direction(run: Run, pair: Pair) -> str:
    velocity = _velocity_as_it_leaves(run, pair)
    along, speed = float(velocity @ pair.direction), float(np.linalg.norm(velocity))
    written = f"[{', '.join(f'{x:g}' for x in pair.direction)}]"
    if speed <= _STILL:
        return ""
    if along < -_ACROSS * speed:
        return (
            f"{pair.B} moves against its direction {written}, at {along:.6g} m/s as "
            "it leaves: see the direction of its pair."
        )
    if along < _ACROSS * speed:
        return (
            f"{pair.B} leaves across its direction {written}: at {speed:.6g} m/s, "
            f"{_rounded(along, speed):.3g} m/s of it in that direction, which alone "
            "is told by longitudinal speeds and displacements: see the direction of "
            "its pair."
        )
    if _place_along(run.separation, pair) < 0.0:
        return (
            f"{pair.B} moves in its direction {written} and stands behind {pair.A} "
            "while mated, by their CGs: it passes through, if nothing leads it past."
        )
    return ""


def _velocity_as_it_leaves(run: Run, pair: Pair) -> Array:
    """Return (3,) the relative velocity at the first sample in which B is free."""
    motion = run.motion_of(pair.B)
    k = int(np.searchsorted(motion.time, run.end_of(pair.B)))
    velocity: Array = motion.relative_velocity[min(k, len(motion.time) - 1)]
    return velocity


def _rounded(part: float, whole: float) -> float:
    """Return a part of a whole; zero, if it is round-off."""
    return part if abs(part) > 1e-9 * whole else 0.0


def _place_along(separation: Separation, pair: Pair) -> float:
    """Return how far B's CG stands from A's in the direction while mated, m."""
    places = mated_places(separation)
    from_A, to_B = (
        np.array(place_in_stack(places[name], separation.body(name).p_BoBcm_B))
        for name in (pair.A, pair.B)
    )
    return float((to_B - from_A) @ np.array(PairFacts.of(separation, pair).direction_S))


class _Push(NamedTuple):
    """What a spring of Eq. 5 stores, what it gives, and what holds the bodies."""

    spring: str
    stored: float
    """J."""
    given: float
    """J."""
    held_by: tuple[str, ...]
    """Attachments that let go after the spring is spent."""

    @property
    def gives_more(self) -> bool:
        """Whether it gives more than it stores."""
        return self.given > self.stored


def _of_springs(run: Run, told: set[str]) -> _Told:
    """Yield which springs of Eq. 5 give another energy than they store; see above."""
    pushes = []
    for attachment, spring in run.separation.pushing:
        spent = run.stroke_ends[spring.name] < math.inf
        if isinstance(spring, Spring) and spring.name not in told and spent:
            push = _push(run, attachment, spring)
            if abs(push.given - push.stored) > _OFF * push.stored:
                pushes.append(push)
    # Those that give more and those that give less stand apart: their misses would
    # cancel in the sums.
    groups: dict[tuple[tuple[str, ...], bool], list[_Push]] = {}
    for push in pushes:
        groups.setdefault((push.held_by, push.gives_more), []).append(push)
    for (held_by, _), alike in groups.items():
        yield tuple(push.spring for push in alike), _of_energy(alike, held_by)


def _push(run: Run, attachment: Attachment, spring: Spring) -> _Push:
    end = run.stroke_ends[spring.name]
    bodies = {attachment.A, attachment.B}
    held_by = tuple(
        other.name
        for other in run.separation.attachments
        if {other.A, other.B} == bodies and run.releases[other.name] >= end
    )
    return _Push(spring.name, spring.energy, spring_work(run, attachment), held_by)


def _of_energy(pushes: Sequence[_Push], held_by: tuple[str, ...]) -> str:
    given, stored = sum(p.given for p in pushes), sum(p.stored for p in pushes)
    springs = _listed([push.spring for push in pushes])
    one = len(pushes) == 1
    force = "its force follows" if one else "their force follows"
    if held_by:
        spent, holds = "is" if one else "are", "holds" if len(held_by) == 1 else "hold"
        return (
            f"{springs} {spent} spent while {_listed(held_by)} still {holds}: "
            f"{given:.3g} of {stored:.4g} J stored {'comes' if one else 'come'} out, "
            f"since {force} time (Eq. 5) and waits for nothing."
        )
    return (
        f"{springs} {'gives' if one else 'give'} {given:.4g} J and "
        f"{'stores' if one else 'store'} {stored:.4g} J: {force} time (Eq. 5), as for "
        "the design mass, whatever is moved."
    )


def _listed(names: Sequence[str]) -> str:
    *most, last = names
    return f"{', '.join(most)} and {last}" if most else last


_SUBJECTS: Mapping[str, Callable[[Run, set[str]], _Told]] = {
    "held": _of_held,
    "direction": _of_directions,
    "angles": _of_angles,
    "energy": _of_springs,
}
