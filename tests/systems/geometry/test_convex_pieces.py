"""Parts of geometry refuse what cannot be."""

import math

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from drakesep.systems.checks import InputError
from drakesep.systems.geometry.convex_pieces import FACET, pieces_of
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
