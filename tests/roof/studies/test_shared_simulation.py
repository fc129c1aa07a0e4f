"""Calls that differ in values alone share a diagram; what they fly is the same."""

import resource
import threading

import numpy as np
from small_case import small_case

import drakesep
from drakesep.studies import shared_simulation as shared
from drakesep.studies.shared_simulation import shared_simulation
from drakesep.systems.simulation.simulation import Simulation


def case(**sections):
    return drakesep.Case.model_validate(small_case(**sections)).in_si()


def test_one_for_equal_cases_another_for_others():
    one = shared_simulation(case())
    assert shared_simulation(case()) is one
    others = [
        case(run={"duration_s": 1.9}),
        case(run={"duration_s": 2.0, "accuracy": 3e-7}),
    ]
    simulations = [shared_simulation(other) for other in others]
    assert len({id(s) for s in (one, *simulations)}) == 3
    for other, simulation in zip(others, simulations, strict=True):
        assert simulation.separation == other.separation
        assert simulation.integration == other.integration


def test_another_in_another_thread():
    found = []
    thread = threading.Thread(target=lambda: found.append(shared_simulation(case())))
    thread.start()
    thread.join()
    assert found[0] is not shared_simulation(case())


def test_no_more_than_a_few_are_kept(monkeypatch):
    monkeypatch.setattr(shared, "_MOST", 2)
    cases = [case(run={"duration_s": 1.5 + 0.1 * i}) for i in range(4)]
    kept = [shared_simulation(one) for one in cases]
    assert len(shared._of_thread.known) == 2
    assert shared_simulation(cases[3]) is kept[3]
    assert shared_simulation(cases[0]) is not kept[0]


def test_what_is_flown_is_what_a_new_one_flies():
    """To the last bit, whatever was flown before."""
    mine = case()
    drakesep.simulate(mine, {"upper.mass_kg": 1250.0})
    run = drakesep.simulate(mine, {"upper.mass_kg": 1180.0}).run
    new = Simulation(mine.separation, mine.integration).run({"upper.mass": 1180.0})
    assert np.array_equal(run.trajectory.states, new.trajectory.states)
    assert np.array_equal(run.motion.rate, new.motion.rate)


def test_a_loop_does_not_fill_the_memory():
    """A hundred calls; a diagram for each would keep 0.6 MiB a call."""
    mine = case()
    for _ in range(20):
        drakesep.simulate(mine)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for i in range(100):
        drakesep.simulate(mine, {"upper.mass_kg": 1200.0 + 0.1 * i})
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert after - before < 10_000  # KiB: a sixth of it
