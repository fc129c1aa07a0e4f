"""What is drawn of the mated stack stands where the case puts it."""

import numpy as np
import pytest
from small_case import small_case

from drakesep.case_file.case import Case
from drakesep.page.stack import stack_of
from drakesep.plots.stack import _places
from drakesep.systems.geometry.bounding_tree import support_point, tree_of
from drakesep.systems.vectors import rotation_matrix


@pytest.fixture(scope="module")
def separation():
    data = small_case()
    data["bodies"]["upper"]["mated"] = {
        "position_mm": [100.0, 50.0, -20.0],
        "attitude_deg": [30.0, 5.0, -4.0],
    }
    return Case(**data).separation


def support(solid, direction):
    """How far a solid reaches in a direction."""
    R = np.reshape(rotation_matrix(solid.place.q_SB), (3, 3))
    along, centre = R.T @ direction, np.dot(direction, solid.place.p_SBo)
    match solid.kind:
        case "box":
            return centre + 0.5 * np.abs(along) @ solid.sizes
        case "sphere":
            return centre + solid.sizes[0]
    fore, aft, length = solid.sizes  # along y
    across = np.hypot(along[0], along[2])
    ends = (
        0.5 * length * along[1] + fore * across,
        -0.5 * length * along[1] + (aft * across),
    )
    return centre + max(ends)


def test_parts_reach_as_far_as_those_that_are_measured(separation):
    """Held against the geometry of clearances, in directions of all kinds."""
    places, solids = _places(separation), stack_of(separation).solids
    drawn = iter(solids)
    for body in separation.bodies:
        R, p = places[body.name]
        for part in body.parts:
            pieces = [next(drawn) for _ in range(3 if part.name == "mast" else 1)]
            for direction in np.random.default_rng(1).normal(size=(8, 3)):
                direction /= np.linalg.norm(direction)
                point = support_point(tree_of(part), R.T @ direction)
                expected = direction @ (R @ point + p)
                reach = max(support(piece, direction) for piece in pieces)
                # Round parts are measured as polygons of many sides.
                assert reach == pytest.approx(expected, abs=2e-3)


def test_pads_springs_and_centres(separation):
    stack, places = stack_of(separation), _places(separation)
    for pad, attachment in zip(stack.pads, separation.attachments, strict=True):
        R, p = places[attachment.A]
        np.testing.assert_allclose(pad, R @ attachment.p_AoPad_A + p, atol=1e-12)
    for spring, one in zip(stack.springs, separation.springs, strict=True):
        length = np.linalg.norm(np.subtract(spring.end, spring.start))
        assert length == pytest.approx(one.stroke, rel=1e-12)
    for body in separation.bodies:
        R, p = places[body.name]
        np.testing.assert_allclose(
            stack.centres[body.name], R @ body.p_BoBcm_B + p, atol=1e-12
        )


def test_all_of_it_is_within_its_extent(separation):
    stack = stack_of(separation)
    middle, radius = stack.extent()
    for solid in stack.solids:
        for direction in np.eye(3):
            assert support(solid, direction) <= direction @ middle + radius + 1e-12
