"""Failure cases: what they may change, what is left to vary, and the usual ones."""

import dataclasses
import math

import pytest
from separations import FREE, generic_pair, vega

import drakesep
from drakesep.analysis.failure_cases import FailureCase
from drakesep.analysis.standard_failure_cases import LATE, standard_failure_cases
from drakesep.analysis.tolerances.ellipsoid import Ellipsoid
from drakesep.analysis.tolerances.sides import Sides
from drakesep.systems.checks import InputError
from drakesep.systems.model.connectors import Connector
from drakesep.systems.model.parameters import parameters, with_values


WEAK = FailureCase(name="weak", values={"spring_1.force_max": 700.0})


@pytest.fixture(scope="module")
def case():
    correlated = ((1.0, 0.1, 0.2), (0.1, 1.0, 0.3), (0.2, 0.3, 1.0))
    names = ("spring_1.force_max", "payload.cg_y", "spring_2.force_max")
    return drakesep.AnalysisCase(
        separation=vega(),
        tolerances={name: 1e-3 for name in (*names, "payload.mass")},
        ellipsoids=(Ellipsoid(names=names, correlation=correlated),),
        failure_cases=(WEAK,),
    )


def test_what_has_failed_does_not_vary(case):
    failed = case.in_failure(WEAK)
    before, now = parameters(case.separation), parameters(failed.separation)
    assert now == before | {"spring_1.force_max": 700.0}
    assert set(failed.tolerances) == {*case.tolerances} - {"spring_1.force_max"}
    [left] = failed.ellipsoids
    assert left.names == ("payload.cg_y", "spring_2.force_max")
    assert left.correlation == ((1.0, 0.3), (0.3, 1.0))
    assert failed.failure_cases == failed.published == ()
    assert failed.requirements == case.requirements


def test_ellipsoid_of_one_is_a_tolerance(case):
    both = {"spring_1.force_max": 700.0, "spring_2.force_max": 700.0}
    failed = case.in_failure(FailureCase(name="both", values=both))
    assert failed.ellipsoids == ()
    assert set(failed.tolerances) == {"payload.cg_y", "payload.mass"}


@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("a b", {"spring_1.force_max": 1.0}, "failure case must be made of letters"),
        ("design", {"spring_1.force_max": 1.0}, "failure case must not be 'design'"),
        ("x", {}, "x: must change a parameter, got none"),
        ("x", {"spring_9.force_max": 1.0}, "x: unknown parameter 'spring_9.force_max'"),
        ("x", {"payload.mass": -1.0}, "x: .*mass must be"),
        ("weak", {"payload.mass": 1e3}, "'weak' must stand once"),
    ],
)
def test_refused_by_name(case, name, values, message):
    with pytest.raises(InputError, match=f"failure_cases: .*{message}|{message}"):
        more = (*case.failure_cases, FailureCase(name=name, values=values))
        dataclasses.replace(case, failure_cases=more)


def test_what_changes_nothing_is_refused(case):
    nominal = parameters(case.separation)["payload.mass"]
    same = FailureCase(name="same", values={"payload.mass": nominal})
    with pytest.raises(InputError, match="must differ from the nominal values"):
        dataclasses.replace(case, failure_cases=(same,))


def test_the_usual_ones():
    """Of four springs on four attachments of two bodies, with tolerances of two."""
    separation = vega()
    tolerances = {"spring_1.force_max": 15.0, "spring_3.force_max": 10.0}
    usual = standard_failure_cases(separation, tolerances)
    cases = {one.name: one.values for one in usual}
    nominal = parameters(separation)
    force = {k: nominal[f"spring_{k}.force_max"] for k in (1, 3)}
    expected = {}
    for k in range(1, 5):
        expected[f"spring_{k}_out"] = {f"spring_{k}.force_max": 0.0}
        expected[f"spring_{k}_stuck"] = {f"spring_{k}.lost_stroke": 0.5}
        release = f"attachment_{k}.release_time"
        expected[f"attachment_{k}_late"] = {release: nominal[release] + LATE}
        expected[f"attachment_{k}_held"] = {release: math.inf}
    for name, sign in (("springs_cold", -1.0), ("springs_hot", 1.0)):
        expected[name] = {
            "spring_1.force_max": force[1] + 15.0 * sign,
            "spring_3.force_max": force[3] + 10.0 * sign,
        }
    assert cases == expected
    # Each may be looked at: no number is outside its range.
    drakesep.AnalysisCase(separation=separation, failure_cases=usual)


def test_what_holds_alone_is_not_late():
    """Where one attachment holds two bodies, nothing is late beside another."""
    pair = generic_pair()
    one = dataclasses.replace(pair, attachments=pair.attachments[:1])
    names = [case.name for case in standard_failure_cases(one, {})]
    assert not [name for name in names if name.endswith(("late", "held"))]


def test_what_holds_nothing_cannot_hold_for_ever():
    """A pad whose spring pushes may be late; pins are what they are."""
    separation = vega()
    pad, *others = separation.attachments
    pins = Connector(name="pins", force_max=80.0, travel=0.01)
    pad = dataclasses.replace(pad, joint=FREE)
    plug = dataclasses.replace(pad, name="plug", spring=pins)
    attachments = (pad, *others, plug)
    separation = dataclasses.replace(separation, attachments=attachments)
    names = [one.name for one in standard_failure_cases(separation, {})]
    assert [name for name in names if name.startswith(("plug", "pins"))] == []
    assert "attachment_1_late" in names and "attachment_1_held" not in names
    assert "attachment_2_late" in names and "attachment_2_held" in names


def test_the_usual_ones_change_something():
    """A spring that is out by design, and one whose tolerance has one side."""
    separation = with_values(vega(), {"spring_3.force_max": 0.0})
    tolerances = {"spring_1.force_max": Sides(minus=0.0, plus=10.0)}
    names = [one.name for one in standard_failure_cases(separation, tolerances)]
    assert "spring_1_out" in names and "spring_3_out" not in names
    assert "springs_hot" in names and "springs_cold" not in names
