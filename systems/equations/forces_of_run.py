"""What springs do over a run, from the motion of its bodies.

A run keeps its motion; forces follow from it by the laws that drove it.
"""

import numpy as np

from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.equations.pushers import (
    push_displacement,
    push_place,
)
from drakesep.systems.equations.relative_motion import BodyState, body_state
from drakesep.systems.equations.springs import law_of
from drakesep.systems.model.run import Run
from drakesep.systems.model.separation import Attachment, Separation


@typed
def spring_forces(run: Run) -> dict[str, Array]:
    """Return the force of each spring at the times of a run's trajectory.

    Args:
        run: a completed run.

    Returns:
        By the springs' names, what `spring_force_over` returns.

    Raises:
        RuntimeError: the run failed.
    """
    pushing = run.separation.pushing
    return {spring.name: spring_force_over(run, each) for each, spring in pushing}


def spring_force_over(run: Run, attachment: Attachment) -> Array:
    """Return the force of the spring of an attachment at the times of a run.

    Args:
        run: a completed run.
        attachment: of its separation, with a spring.

    Returns:
        (n,) N along its axis, on B; zero before the release, if there is one, and from
        the end of the stroke on.

    Raises:
        RuntimeError: the run failed.
    """
    spring = attachment.spring
    assert spring is not None
    time = run.completed_trajectory.time
    release, end = run.releases[attachment.name], run.stroke_ends[spring.name]
    pushes = (release <= time) & (time < end)
    return np.where(pushes, _force(run, attachment), 0.0)


def spring_work(run: Run, attachment: Attachment) -> float:
    """Return the energy that the spring of an attachment has given both bodies, J.

    Args:
        run: a completed run.
        attachment: of its separation, with a spring.

    Raises:
        RuntimeError: the run failed.
    """
    spring = attachment.spring
    assert spring is not None
    time = run.completed_trajectory.time
    release, end = run.releases[attachment.name], run.stroke_ends[spring.name]
    pushes = (release <= time) & (time <= end)
    A, B = (states_of(run, name) for name in (attachment.A, attachment.B))
    place = push_place(run.separation, attachment, spring)
    _, speed = push_displacement(A, B, *place)
    power = _force(run, attachment) * speed
    return float(np.trapezoid(power[pushes], time[pushes]))


def _force(run: Run, attachment: Attachment) -> Array:
    A, B = (states_of(run, name) for name in (attachment.A, attachment.B))
    time, release = run.completed_trajectory.time, run.releases[attachment.name]
    # Of one that is never released, some number.
    age = time - min(release, time[-1])
    return force_within_stroke(run.separation, attachment, A, B, age)


def force_within_stroke(
    separation: Separation,
    attachment: Attachment,
    A: BodyState,
    B: BodyState,
    age: Array,
) -> Array:
    """Return the force of the spring of an attachment, (n,) N along its axis, on B.

    From its release to the end of its stroke, which this does not look at.

    Args:
        separation: as it was flown.
        attachment: of it, with a spring.
        A: body pushed from, at n times.
        B: body pushed away.
        age: (n,) time since the release, s.
    """
    spring = attachment.spring
    assert spring is not None
    law = law_of(spring)
    if law.by_time:
        return np.asarray(law.force(spring, age, 0.0, (), np))
    place = push_place(separation, attachment, spring)
    displacement, speed = push_displacement(A, B, *place)
    passed = law.passed(spring, displacement, np)
    force = law.force(spring, displacement, speed, passed, np)
    return np.asarray(law.acting(force))


def states_of(run: Run, body: str) -> BodyState:
    """Return the states of a body at the times of a completed run, by its name."""
    return body_state(run.completed_trajectory.of(body).T, 0, 7)
