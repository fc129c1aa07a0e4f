"""Calls that differ in numbers alone share a diagram; what they fly is the same."""

import dataclasses
import resource
import threading

import numpy as np
import pytest
from small_case import small_case

import drakesep
from drakesep.analysis.engines.drake_pool import DrakePool
from drakesep.case_file.reader import builtin_cases
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.parameters import parameters, with_values
from drakesep.systems.simulation import shared_simulation as shared
from drakesep.systems.simulation.shared_simulation import shared_simulation
from drakesep.systems.simulation.simulation import Simulation


def case(**sections):
    return drakesep.Case.model_validate(small_case(**sections)).in_si()


def separation(**sections):
    return case(**sections).separation


@pytest.fixture(autouse=True)
def none_known(monkeypatch):
    monkeypatch.setattr(shared, "_of_thread", shared._OfThread())


def test_one_for_equal_structures_another_for_others():
    one = shared_simulation(separation()).simulation
    assert shared_simulation(separation()).simulation is one
    longer = separation(run={"duration_s": 1.9})
    finer = Integration(accuracy=3e-7)
    simulations = [
        shared_simulation(longer).simulation,
        shared_simulation(separation(), finer).simulation,
    ]
    assert len({id(s) for s in (one, *simulations)}) == 3
    assert [s.separation.duration for s in simulations] == [1.9, 0.8]
    assert [s.integration for s in simulations] == [Integration(), finer]


def test_another_in_another_thread():
    found = []
    mine = separation()

    def find():
        found.append(shared_simulation(mine).simulation)

    thread = threading.Thread(target=find)
    thread.start()
    thread.join()
    assert found[0] is not shared_simulation(mine).simulation


def test_no_more_than_a_few_are_kept(monkeypatch):
    monkeypatch.setattr(shared, "_MOST", 2)
    several = [separation(run={"duration_s": 1.5 + 0.1 * i}) for i in range(4)]
    kept = [shared_simulation(one).simulation for one in several]
    assert len(shared._of_thread.known) == 2
    assert shared_simulation(several[3]).simulation is kept[3]
    assert shared_simulation(several[0]).simulation is not kept[0]


@pytest.mark.parametrize("name", builtin_cases())
def test_what_is_flown_is_what_a_new_one_flies(name):
    """To the last bit, with every number that is read another than it was built for."""
    loaded = drakesep.load_case(name).in_si()
    built, integration = loaded.separation, loaded.integration
    first = shared_simulation(built, integration)
    rng = np.random.default_rng(0)
    changed = built
    for parameter, value in parameters(built).items():
        if first.simulation.reads([parameter]):
            new = value * (1.0 + 1e-3 * rng.uniform(-1.0, 1.0))
            changed = with_values(changed, {parameter: new})
    other = shared_simulation(changed, integration)
    assert other.simulation is first.simulation
    assert len(other.numbers) > 10
    mass = f"{changed.B}.mass"
    values = {mass: 1.01 * parameters(built)[mass]}
    run = other.run(values)
    new = Simulation(changed, integration).run(values)
    assert run.separation == new.separation
    assert np.array_equal(run.trajectory.states, new.trajectory.states)
    assert np.array_equal(run.motion.rate, new.motion.rate)
    assert run.releases == new.releases


def test_a_loop_does_not_fill_the_memory():
    """A hundred calls; a diagram for each would keep 0.6 MiB a call."""
    loaded = drakesep.Case.model_validate(small_case())
    mine = loaded.in_si()
    spring = mine.separation.attachments[0].spring.name

    def called(i):
        drakesep.simulate(mine, {"upper.mass_kg": 1200.0 + 0.1 * i})
        pushed = {f"{spring}.force_max": 1200.0 + 0.1 * i}
        heavier = with_values(mine.separation, pushed)
        drakesep.simulate(dataclasses.replace(mine, separation=heavier))
        before = {"attitude_deg": [2.0, -3.0, 4.0 + 0.01 * i]}
        drakesep.simulate(loaded.replaced(before_separation=before))
        with DrakePool(heavier, mine.integration, workers=1) as pool:
            pool.fly([{}])

    for i in range(10):
        called(-i)
    assert len(shared._of_thread.known) == 1
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for i in range(25):
        called(i)
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert after - before < 10_000  # KiB: a sixth of it
