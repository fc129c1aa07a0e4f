"""The sum of all that acts is that of the systems' own wrenches."""

import numpy as np
import pytest
from flying import start
from separations import hinged_pair, staged_pair


SYSTEMS = ("springs", "cfe_bushing", "loads", "gravity")


@pytest.mark.parametrize("separation", [staged_pair(), hinged_pair()])
def test_sum_is_that_of_the_public_systems(separation):
    """At random states, before, between and after releases, strokes and loads."""
    system, context, simulator = start(separation, 1e-6)
    forces = system.forces
    parts = [
        forces.GetSubsystemByName(name)
        for name in SYSTEMS
        if forces.HasSubsystemNamed(name)
    ]
    rng = np.random.default_rng(1)
    largest = []
    for now in (0.0, 0.025, 0.04, 0.07, 0.3):
        simulator.AdvanceTo(now)
        simulator.AdvancePendingEvents()
        state = context.get_continuous_state_vector().CopyToVector()
        for _ in range(5):
            moved = state + rng.normal(scale=0.02, size=len(state))
            context.SetTimeAndContinuousState(now, moved)
            alone = [
                part.GetOutputPort("wrenches").Eval(part.GetMyContextFromRoot(context))
                for part in parts
            ]
            total = forces.GetOutputPort("wrenches").Eval(
                forces.GetMyContextFromRoot(context)
            )
            # round-off of the largest of the summands
            room = 1e-14 * np.abs(alone).max()
            assert total == pytest.approx(np.sum(alone, axis=0), abs=room)
            largest.append(np.abs(alone).max(axis=1))
        context.SetTimeAndContinuousState(now, state)
    assert (np.max(largest, axis=0) > 0.0).all()


def test_systems_without_motion_analysis_move_alike():
    """Only what measures is left out."""
    separation = staged_pair()
    states = []
    for measured in (True, False):
        system, context, simulator = start(separation, 1e-8, motion_analysis=measured)
        assert system.HasOutputPort("rate") == measured
        simulator.AdvanceTo(separation.duration)
        plant_context = system.plant.GetMyContextFromRoot(context)
        states.append(system.plant.GetPositionsAndVelocities(plant_context))
    with_it, without = states
    # Steps differ, where momentum asked for shorter ones: 1e-8 a step.
    assert without == pytest.approx(with_it, abs=1e-6)
