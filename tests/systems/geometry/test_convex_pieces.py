"""Parts of geometry refuse what cannot be."""

import math

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.math import RollPitchYaw

from drakesep.systems.checks import InputError
from drakesep.systems.geometry.convex_pieces import FACET, pieces_of
from drakesep.systems.geometry.distance import TOUCHING, Proximity, nearest_of
from drakesep.systems.model.parts import Box, Capsule, Cone, Mesh, Part, Sphere


BAD = st.one_of(
    st.floats(max_value=0.0), st.just(math.nan), st.just(math.inf), st.just(-math.inf)
)


@given(BAD)
def test_dimensions_that_no_shape_has(bad):
    for make in (
        lambda: Box(size=(1.0, bad, 1.0)),
        lambda: Sphere(radius=bad),
        lambda: Capsule(radius=bad, length=1.0),
        lambda: Capsule(radius=1.0, length=bad),
        lambda: Cone(radius_aft=1.0, radius_fore=1.0, length=bad),
        lambda: Cone(radius_aft=1.0, radius_fore=1.0, length=1.0, thickness=bad),
        lambda: Mesh(file="part.obj", scale=bad),
    ):
        with pytest.raises(InputError, match="must be"):
            make()


def test_walls_thinner_than_their_radius():
    with pytest.raises(InputError, match=r"below the smaller radius, 0.2 m, got 0.3 m"):
        Cone(radius_aft=1.0, radius_fore=0.2, length=1.0, thickness=0.3)


@given(aft=st.floats(0.05, 2.0), fore=st.floats(0.05, 2.0), length=st.floats(0.1, 3.0))
def test_polygons_hold_the_wall_that_they_stand_for(aft, fore, length):
    """Corners inside are on the circle; those outside at most `FACET` beyond it."""
    thickness = 0.04
    shape = Cone(radius_aft=aft, radius_fore=fore, length=length, thickness=thickness)
    for piece in pieces_of(Part(name="wall", shape=shape))[:3]:
        for x, y, z in piece.points:
            r, outer = math.hypot(y, z), aft if x < 0.0 else fore
            inside = abs(r - (outer - thickness)) < 1e-9
            # The larger radius sets how many sides there are.
            assert inside or outer <= r <= outer + 1.01 * FACET


SHAPES = {
    "box": Box(size=(1.0, 0.8, 0.04)),
    "cylinder": Cone(radius_aft=0.5, radius_fore=0.5, length=1.0),
    "cone": Cone(radius_aft=0.4, radius_fore=0.08, length=0.45),
    "capsule": Capsule(radius=0.1, length=0.6),
    "ball": Sphere(radius=0.3),
}


def measured(first, second, rpy, place):
    parts = [Part(name=n, shape=s) for n, s in (("a", first), ("b", second))]
    proximity = Proximity(parts[:1], parts[1:])
    R_AB = RollPitchYaw(*rpy).ToRotationMatrix().matrix()
    proximity.place(R_AB, np.array(place))
    pair = proximity.roots["a"], proximity.roots["b"]
    told = proximity.measure(pair)
    return pair, told if told.is_sharp else proximity.sharpen(pair, told), R_AB


@settings(max_examples=300, deadline=None)
@given(
    names=st.tuples(st.sampled_from(list(SHAPES)), st.sampled_from(list(SHAPES))),
    rpy=st.tuples(*[st.floats(-0.1, 0.1)] * 3),
    heading=st.tuples(st.floats(0.0, math.pi), st.floats(0.0, 2.0 * math.pi)),
    apart=st.floats(0.7, 2.0),
)
def test_distances_are_certain(names, rpy, heading, apart):
    """A plane between the pieces proves them, and the points are as far apart."""
    polar, around = heading
    place = apart * np.array(
        [
            math.cos(polar),
            math.sin(polar) * math.cos(around),
            math.sin(polar) * math.sin(around),
        ]
    )
    pair, told, R_AB = measured(*(SHAPES[name] for name in names), rpy, place)
    if told.distance <= TOUCHING:
        return
    # 5 um let pass, and the round-off of points a metre away.
    assert told.low <= told.distance + 1e-9
    assert told.distance - told.low <= 5.1e-6
    nearest = nearest_of(pair, told)
    between = R_AB @ nearest.p_BoCb_B + place - nearest.p_AoCa_A
    assert np.linalg.norm(between) == pytest.approx(told.distance, abs=1e-6)


def test_pose_at_which_drake_ends_early():
    """Drake 1.51.1 says 0.14708 m; bounded least squares over both boxes 0.14662."""
    box = SHAPES["box"]
    _, told, _ = measured(
        box,
        box,
        (math.pi / 2.0, 1e-3, 1e-3),
        (-0.08465616944689719, -0.5671229915926608, 0.4200356296874088),
    )
    assert told.distance == pytest.approx(0.14662, abs=1e-5)


def test_shallow_dish_is_not_taken_for_its_hull(tmp_path):
    """The angles at its edges are all but straight."""
    profile = [(0.0, -0.05), (0.5, -0.05)]
    profile += [(r, 0.04 * r * r) for r in np.linspace(0.5, 0.0, 60)]
    dish = trimesh.creation.revolve(np.array(profile), sections=24)
    dish.export(tmp_path / "dish.stl")
    shape = Mesh(file=tmp_path / "dish.stl")
    pieces = pieces_of(Part(name="dish", shape=shape))
    assert len(pieces) > 1000
    trimesh.creation.icosphere(subdivisions=2).export(tmp_path / "ball.stl")
    ball = Part(name="ball", shape=Mesh(file=tmp_path / "ball.stl"))
    assert len(pieces_of(ball)) == 1
