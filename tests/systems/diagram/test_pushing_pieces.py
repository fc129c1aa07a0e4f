"""Faces that press each other, at rest and sliding: forces by closed forms."""

import dataclasses

import numpy as np
import pytest
import trimesh
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.math import SpatialVelocity
from separations import coaxial, generic_pair

from drakesep.systems.checks import InputError
from drakesep.systems.diagram.separation_system import SeparationSystem
from drakesep.systems.model.parts import Box, Cone, Mesh, Part, Sphere
from drakesep.systems.model.recontact import Recontact
from drakesep.systems.model.separation import InitialMotion


STIFFNESS = 2e5
SIZE = (0.2, 0.3, 0.4)
SURFACE = 2.0 * (0.2 * 0.3 + 0.3 * 0.4 + 0.4 * 0.2)
GAP = 0.05
PLATE = Part(name="plate", shape=Box(size=(0.2, 4.0, 4.0)), p_BoGo_B=(-0.1, 0.0, 0.0))
DEEP = 1e-3
APART = 1e-6
"""By which the second body's faces lie deeper than drawn: see `pushing_pieces`."""


def block(shape):
    """Its back is 50 mm in front of the plate."""
    return Part(name="block", shape=shape, p_BoGo_B=(GAP + 0.5 * SIZE[0], 0.0, 0.0))


def pressed(part, *, deep=DEEP, turned=None, sliding=0.0, on=PLATE, **contact):
    """Force on the part, in W, where its body has moved back by gap and depth."""
    apart = coaxial(generic_pair(springs=False, initial=InitialMotion()))
    lower, upper = apart.bodies
    separation = dataclasses.replace(
        apart,
        bodies=(
            dataclasses.replace(lower, parts=(on,)),
            dataclasses.replace(upper, parts=(part,)),
        ),
        initial=InitialMotion(),
        recontact=Recontact(**({"stiffness": STIFFNESS} | contact)),
    )
    system = SeparationSystem(separation)
    context = system.CreateDefaultContext()
    system.set_separation(context, separation)
    plant = system.plant
    own = plant.GetMyMutableContextFromRoot(context)
    body = plant.GetBodyByName("upper")
    pose = RigidTransform(turned or RotationMatrix(), [-GAP - deep, 0.0, 0.0])
    plant.SetFloatingBaseBodyPoseInWorldFrame(own, body, pose)
    velocity = SpatialVelocity(np.zeros(3), np.array([0.0, sliding, 0.0]))
    plant.SetFreeBodySpatialVelocity(own, body, velocity)
    return system.contact_forces(context).get((on.name, part.name), (0.0,) * 3)


def test_faces_share_the_stiffness_over_their_area():
    """Of the smallest piece, a quarter of its surface; or as it is given."""
    face, edges = SIZE[1] * SIZE[2], 2.0 * (SIZE[1] + SIZE[2])
    deep = DEEP - APART
    # Within half the depth from an edge the pressure is that below the side: it falls.
    area = face - 0.25 * deep * edges
    for given, kappa in ((None, STIFFNESS / (0.25 * SURFACE)), (5e6, 5e6)):
        force = pressed(block(Box(size=SIZE)), face_stiffness=given)
        expected = (kappa * deep * area, 0.0, 0.0)
        # Corners: squares of that width; and edges lie deeper by a micrometre too.
        assert force == pytest.approx(expected, rel=2e-5, abs=1e-9)
    assert pressed(block(Box(size=SIZE)), deep=-1e-4) == (0.0, 0.0, 0.0)


def test_an_edge_presses_over_its_length():
    """A wedge: its pressure rises to both sides with the depth, from edge to face."""
    angle, kappa = 0.3, 5e6
    turned = RotationMatrix.MakeYRotation(angle)
    # The lower corner of the back is what comes first.
    corner = turned @ np.array([GAP, 0.0, 0.5 * SIZE[2]])
    corners = [turned @ np.array([GAP, 0.0, z * SIZE[2] / 2]) for z in (-1.0, 1.0)]
    lowest = min(c[0] for c in (*corners, corner))
    deep = lowest - GAP + 2e-3
    force = pressed(
        block(Box(size=SIZE)), deep=deep, turned=turned, face_stiffness=kappa
    )
    # Planes of equal pressure, 2 kappa d of each: with a depth d below the face of the
    # plate, as deep below each of the two faces that meet at the edge.
    reach = 2e-3
    n = [
        np.array([np.cos(angle), np.sin(angle)]),
        np.array([np.sin(angle), -np.cos(angle)]),
    ]
    # In the plane of z and x, where the corner is the origin and the plate's face at
    # x = reach: below each face of the block n . r, below the plate reach - x.
    peak = np.linalg.solve(np.stack([*[]] or n), np.ones(2))
    depth = reach / (1.0 + peak[0])
    apex = depth * peak
    ends = [np.array([reach, reach * -m[0] / m[1]]) for m in n]
    expected = np.zeros(2)
    for end in ends:
        side = end - apex
        across = np.array([side[1], -side[0]])
        across *= np.sign(across[0]) or 1.0
        expected += 2.0 * kappa * 0.5 * depth * across * SIZE[1]
    assert force[0] == pytest.approx(expected[0], rel=5e-3)


def test_faces_slide_with_friction():
    still, force = (
        pressed(block(Box(size=SIZE)), sliding=v, friction=0.3) for v in (0.0, 0.5)
    )
    # Drake's Coulomb friction, 1 mm/s from creeping; near edges across its planes.
    expected = (still[0], -0.3 * still[0], 0.0)
    assert force == pytest.approx(expected, rel=2e-3, abs=1e-6)


def test_a_polytope_presses_as_its_pressure_rises_to_its_middle(tmp_path):
    """From the back 0.1 m, and 0.2 from the farthest face: twice as stiff as a box."""
    file = tmp_path / "box.obj"
    trimesh.creation.box(SIZE).export(file)
    mesh, box = (pressed(block(s))[0] for s in (Mesh(file=file), Box(size=SIZE)))
    both = 1.0 / (0.5 + 0.25)  # 2 and 4 in series, over 2 and 2
    assert mesh == pytest.approx(both * box, rel=0.01)  # edges press otherwise


@pytest.mark.parametrize("thickness", [None, 0.02])
def test_a_round_end_presses_with_its_area(thickness):
    """A cylinder on its end, and a tube, whose staves press with theirs."""
    shape = Cone(radius_aft=0.3, radius_fore=0.3, length=SIZE[0], thickness=thickness)
    force = pressed(block(shape), face_stiffness=5e6, deep=1e-4)
    inner = 0.0 if thickness is None else 0.3 - thickness
    area = np.pi * (0.3**2 - inner**2)
    if thickness is None:
        assert force == pytest.approx((5e6 * 1e-4 * area, 0.0, 0.0), rel=0.02, abs=0.1)
    else:
        # A stave is as stiff along the wall as is asked for, and stiffer across it.
        assert force[0] == pytest.approx(5e6 * 1e-4 * area, rel=0.05)
        assert np.abs(force[1:]).max() < 1e-3 * force[0]


def test_a_ball_touches_at_a_point():
    ball = block(Sphere(radius=0.5 * SIZE[0]))
    force = pressed(ball)
    assert force == pytest.approx((STIFFNESS * DEEP, 0.0, 0.0), rel=1e-9)


def test_bad_stiffness():
    with pytest.raises(InputError, match="recontact: face_stiffness must be > 0"):
        Recontact(stiffness=1.0, face_stiffness=0.0)
