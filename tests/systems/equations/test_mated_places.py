"""Where bodies are while mated, and what moves along with one that is displaced."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RollPitchYaw
from separations import generic_pair

from drakesep.systems.equations.mated_stack import mated_places
from drakesep.systems.model.carriers import carriers
from drakesep.systems.model.parameters import parameters, with_values
from drakesep.systems.model.separation import Separation


CLOSE = 1e-14
"""Round-off of products of a few turns and places of some metres."""
PAIR = generic_pair()
PLACES = {
    "adapter": ((0.5, 0.1, -0.2), (0.1, 0.2, -0.3)),
    "payload": ((1.5, -0.1, 0.3), (1.4, -0.2, 0.1)),
    "cap": ((2.5, 0.2, 0.1), (-0.3, 0.5, 2.0)),
    "side": ((0.1, 0.9, 0.0), (0.0, 0.0, 1.5)),
}


def stack(*more):
    """An adapter on lower, on it a payload, and a cap on that; beside them a side."""
    lower, upper = PAIR.bodies
    bodies = [
        dataclasses.replace(upper, name=name, p_ABo=p, rpy_AB=rpy)
        for name, (p, rpy) in PLACES.items()
    ]
    pad = PAIR.attachments[0]
    held = [
        ("lower", "adapter"),
        ("adapter", "payload"),
        ("payload", "cap"),
        ("lower", "side"),
        *more,
    ]
    return Separation(
        bodies=(lower, *bodies),
        attachments=tuple(
            dataclasses.replace(pad, name=f"a{i}", A=A, B=B, spring=None)
            for i, (A, B) in enumerate(held)
        ),
        A="lower",
        B="payload",
        duration=1.0,
    )


def pose(place):
    q = np.array(place.q_SB)
    assert q @ q == pytest.approx(1.0, abs=CLOSE)
    return RigidTransform(Quaternion(q / np.linalg.norm(q)), place.p_SBo)


def nominal(name):
    p, rpy = PLACES[name]
    return RigidTransform(RollPitchYaw(*rpy), p)


def poses(separation):
    return {name: pose(place) for name, place in mated_places(separation).items()}


def test_who_carries_whom():
    assert carriers(stack()) == {
        "adapter": None,
        "side": None,
        "payload": "adapter",
        "cap": "payload",
    }
    # Held from two sides, the cap hangs on neither; nor does what A holds too.
    assert carriers(stack(("side", "cap")))["cap"] is None
    assert carriers(stack(("lower", "payload")))["payload"] is None
    # Over a ring that the adapter carries it hangs on that.
    assert carriers(stack(("adapter", "cap")))["cap"] == "adapter"
    # The order in which an attachment names its bodies says nothing.
    assert carriers(stack(("cap", "adapter")))["cap"] == "adapter"


angles = st.floats(-0.5, 0.5)
vectors = st.tuples(angles, angles, angles)


def test_nominal_places_are_as_written():
    for name, X in poses(stack()).items():
        if name != "lower":
            assert X.IsNearlyEqualTo(nominal(name), CLOSE)


@given(first=vectors, turn=vectors, second=vectors, again=vectors)
def test_what_hangs_on_a_displaced_body_moves_with_it(first, turn, second, again):
    """Against products of Drake's transforms."""
    values = {}
    for name, offset, rpy in (("adapter", first, turn), ("payload", second, again)):
        values |= {
            f"{name}.mated_offset_{axis}": x
            for axis, x in zip("xyz", offset, strict=True)
        }
        values |= {
            f"{name}.mated_misalignment_{axis}": x
            for axis, x in zip(("roll", "pitch", "yaw"), rpy, strict=True)
        }
    found = poses(with_values(stack(), values))

    def displaced(name, offset, rpy):
        X = nominal(name)
        turned = X.rotation() @ RollPitchYaw(*rpy).ToRotationMatrix()
        return RigidTransform(turned, X.translation() + np.array(offset))

    adapter = displaced("adapter", first, turn)
    carried = adapter @ nominal("adapter").inverse()
    payload = carried @ displaced("payload", second, again)
    cap = payload @ nominal("payload").inverse() @ nominal("cap")
    for name, X in (("adapter", adapter), ("payload", payload), ("cap", cap)):
        assert found[name].IsNearlyEqualTo(X, CLOSE), name
    assert found["side"].IsNearlyEqualTo(nominal("side"), CLOSE)
    assert found["lower"].IsNearlyEqualTo(RigidTransform(), 0.0)


def test_the_base_sits_where_it_does():
    """The stack is placed in its frame: it has no such parameters."""
    names = parameters(PAIR)
    assert "upper.mated_offset_x" in names
    assert "lower.mated_offset_x" not in names
    with pytest.raises(ValueError, match=r"unknown parameter 'lower.mated_offset_x'"):
        with_values(PAIR, {"lower.mated_offset_x": 0.01})
    lower, upper = PAIR.bodies
    moved = dataclasses.replace(lower, mated_misalignment=(0.1, 0.0, 0.0))
    with pytest.raises(
        ValueError, match="lower: mated offset and misalignment must be"
    ):
        dataclasses.replace(PAIR, bodies=(moved, upper))
    with pytest.raises(ValueError, match="upper: mated offset must be finite, got nan"):
        dataclasses.replace(upper, mated_offset=(math.nan, 0.0, 0.0))
