"""What is registered beside drakesep's own is known to other processes, or refused."""

import dataclasses
import pickle
from dataclasses import dataclass

import cloudpickle
import numpy as np
import pytest
from small_case import small_case
from toy_metrics import OTHERS, RELATIVE, RELATIVE_MIN, registered
from toy_pushers import Strut, StrutLaw

import drakesep
from drakesep.analysis.engines import registered as registered_module
from drakesep.analysis.engines.registered import Registered
from drakesep.analysis.metrics.registry import (
    find_metric,
    forget_metric,
    own_metrics,
    register_metric,
)
from drakesep.case_file.case import Case
from drakesep.results.campaign_files import RecordedPlan
from drakesep.studies.campaign.executors import fly_chunk, own_processes
from drakesep.systems.equations.springs import (
    PUSHERS,
    PusherKind,
    forget_own_pushers,
    own_pushers,
)


TOY = RELATIVE.stem
NOTHING = Registered((), {})


@pytest.fixture
def strut(monkeypatch):
    monkeypatch.setitem(PUSHERS, "toy", PusherKind(Strut, StrutLaw))


def case():
    """The small case, with struts in place of springs."""
    data = small_case(published=None, objectives=None, failure_cases=None)
    data["requirements"] = data["requirements"][:1]
    data["dispersions"] = {"upper.mass_kg": 50.0}
    made = Case.model_validate(data).in_si()
    attachments = tuple(
        dataclasses.replace(
            one,
            spring=Strut(
                name=one.spring.name,
                force_max=one.spring.force_max,
                stroke=one.spring.stroke,
                seal_drag=20.0,
            ),
        )
        for one in made.separation.attachments
    )
    separation = dataclasses.replace(made.separation, attachments=attachments)
    return dataclasses.replace(made, separation=separation)


def test_bytes_bring_it_and_replace_others_of_the_same_name(monkeypatch):
    assert own_metrics() == () and own_pushers() == {}
    with monkeypatch.context() as patch, registered(*OTHERS):
        patch.setitem(PUSHERS, "toy", PusherKind(Strut, StrutLaw))
        packed = Registered.here().as_bytes()
        mine = own_metrics()
        Registered.known_from(packed)  # this process knows it
        assert own_metrics() is not mine and own_metrics() == mine
    assert own_metrics() == () and own_pushers() == {}
    monkeypatch.setattr(registered_module, "_HERE", "another process")
    first = OTHERS[0]
    register_metric(dataclasses.replace(first, kind=OTHERS[1].kind))
    PUSHERS["time"] = PusherKind(PUSHERS["time"].record, StrutLaw)
    try:
        Registered.known_from(packed)
        assert set(own_metrics()) == set(mine) == set(OTHERS)
        assert [*own_pushers()] == ["toy"]
        assert PUSHERS["toy"].record is Strut
        Registered.known_from(pickle.dumps(("a third", cloudpickle.dumps(NOTHING))))
        assert own_metrics() == () and own_pushers() == {}
    finally:
        forget_own_pushers()
        for metric in own_metrics():
            forget_metric(metric.stem)


def test_a_kind_in_place_of_drakeseps_own_is_told(monkeypatch):
    kind = PusherKind(PUSHERS["time"].record, StrutLaw)
    monkeypatch.setitem(PUSHERS, "time", kind)
    assert own_pushers() == {"time": kind}


def test_what_cannot_be_imported_is_refused():
    with pytest.raises(ValueError, match=r"^what is registered .* must be importable"):
        Registered.known_from(b"cnowhere\nnobody\n.")


def test_a_plan_is_flown_where_the_same_is_registered(strut, tmp_path, monkeypatch):
    how = {"metrics": [f"{TOY}_y"], "output": tmp_path}
    with registered(RELATIVE_MIN, RELATIVE):
        recorded = drakesep.plan_campaign(case(), 8, **how)
        assert RecordedPlan.read(tmp_path).sha256 == recorded.sha256
    with pytest.raises(ValueError, match=f"flown where {TOY} are registered"):
        drakesep.run_chunk(tmp_path, 0)
    with registered(
        RELATIVE_MIN, dataclasses.replace(RELATIVE, signal=OTHERS[1].signal)
    ):
        with pytest.raises(ValueError, match=f"{TOY!r} is registered as it was"):
            drakesep.run_chunk(tmp_path, 0)
    with registered(RELATIVE_MIN, RELATIVE), monkeypatch.context() as patch:

        @dataclass(frozen=True)
        class StrutLaw2(StrutLaw):
            def force(self, p, at, speed, passed, ops):
                return p.force_max

        patch.setitem(PUSHERS, "toy", PusherKind(Strut, StrutLaw2))
        with pytest.raises(ValueError, match="'toy' is registered as it was"):
            drakesep.run_chunk(tmp_path, 0)
        patch.delitem(PUSHERS, "toy")
        with pytest.raises(ValueError, match="flown where toy are registered"):
            drakesep.run_chunk(tmp_path, 0)


def test_what_is_not_used_is_not_asked_for(tmp_path):
    with registered(*OTHERS):
        data = small_case(published=None, objectives=None)
        drakesep.plan_campaign(Case.model_validate(data), 8, output=tmp_path)
    assert RecordedPlan.read(tmp_path).plan.runs == 8


@pytest.mark.slow
def test_workers_fly_what_they_are_told_of(strut):
    """A spawned process knows nothing of its own; it flies what this one does."""
    with registered(RELATIVE_MIN, RELATIVE), own_processes(1) as executor:
        how = {"metrics": [f"{TOY}_y"], "chunk": 8, "workers": 1}
        there = drakesep.campaign(case(), 16, executor=executor, **how)
        here = drakesep.campaign(case(), 16, **how)
        np.testing.assert_array_equal(there.flown.metrics, here.flown.metrics)
        assert np.isfinite(here.flown.metrics).all()
        nothing = NOTHING.as_bytes()
        text = there.recorded.text
        with pytest.raises(ValueError, match="unknown record 'Strut'"):
            executor.submit(fly_chunk, text, ".", nothing, 0).result()
    assert find_metric(TOY) is None
