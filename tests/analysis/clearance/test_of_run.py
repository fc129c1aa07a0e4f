"""How near parts come, against motions whose clearance is known in closed form."""

import math
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import trimesh
from flights import run_of, straight, trajectory
from hypothesis import given, settings
from hypothesis import strategies as st
from tumbling import Tumbling

from drakesep.analysis.clearance.of_pair import ACCURACY
from drakesep.analysis.clearance.of_run import ClearanceAnalysis
from drakesep.systems.checks import InputError
from drakesep.systems.geometry.convex_pieces import FACET
from drakesep.systems.model.parts import Box, Capsule, Cone, Mesh, Part, Sphere


COARSE = np.linspace(0.0, 1.0, 9)
"""The minima of these tests lie between such samples."""
SOLVER = 1e-6
"""Of Drake's iteration between curved shapes, m."""


def clearance(motion, first, second, **options):
    run = run_of(motion, [first], [second])
    [found] = ClearanceAnalysis(run.separation, **options).of(run)
    return found


def ball(name, radius, place=(0.0, 0.0, 0.0)):
    return Part(name=name, shape=Sphere(radius=radius), p_BoGo_B=place)


@settings(max_examples=100, deadline=None)
@given(
    when=st.floats(0.1, 0.9),
    miss=st.floats(0.31, 1.0),
    speed=st.floats(0.5, 4.0),
    heading=st.floats(0.0, 2.0 * math.pi),
)
def test_spheres_that_pass_each_other(when, miss, speed, heading):
    """Nearest between samples; none of 100 is missed, nor are sampled ones better."""
    along = np.array([math.cos(heading), math.sin(heading), 0.0])
    across = np.array([-along[1], along[0], 0.0])
    motion = straight(COARSE, miss * across - when * speed * along, speed * along)
    first, second = ball("rock", 0.2), ball("payload_ball", 0.1)
    found = clearance(motion, first, second)
    assert found.contact is None
    # Over continuous time; the true one is never below what is found less ACCURACY.
    assert miss - 0.3 - SOLVER <= found.minimum <= miss - 0.3 + ACCURACY
    run = run_of(motion, [first], [second])
    sampled = ClearanceAnalysis(run.separation).over_time(run).min()
    assert found.minimum <= sampled + SOLVER
    r = np.hypot(miss, (COARSE - when) * speed).min() - 0.3
    assert sampled == pytest.approx(r, abs=SOLVER)


def test_nearest_points_are_in_body_axes():
    motion = straight(
        COARSE, (-0.5, 0.4, 0.0), (1.0, 0.0, 0.0),
        angle=np.full(9, math.pi / 2.0), axis=(0.0, 0.0, 1.0),
    )  # fmt: skip
    found = clearance(motion, ball("rock", 0.1), ball("payload_ball", 0.1))
    assert found.time == pytest.approx(0.5, abs=0.02)
    assert found.p_AoCa_A == pytest.approx((0.0, 0.1, 0.0), abs=5e-3)
    # A lies toward -y in W, which is -x of B.
    assert found.p_BoCb_B == pytest.approx((-0.1, 0.0, 0.0), abs=5e-3)


def test_spheres_that_collide():
    motion = straight(COARSE, (1.0, 0.1, 0.0), (-2.0, 0.0, 0.0))
    found = clearance(motion, ball("rock", 0.2), ball("payload_ball", 0.1))
    along = math.sqrt(0.3**2 - 0.1**2)
    assert found.minimum <= 0.0
    assert found.contact.time == pytest.approx((1.0 - along) / 2.0, abs=1e-6)
    assert found.contact.closing_speed == pytest.approx(2.0 * along / 0.3, rel=1e-4)


def test_cylinder_that_leaves_a_tube_at_a_tilt():
    """In the plane of the tilt: the rear corner nears the wall, then the rim the side.

    A cylinder of radius r, tilted by a, moves along the tube's axis. Its rear edge is
    at r cos(a) + (l / 2) sin(a) from the axis until it has left; what is left of its
    side comes nowhere nearer to the rim.
    """
    tilt, r, length, R = 0.02, 0.4, 1.0, 0.45
    tube = Part(
        name="tube",
        shape=Cone(
            radius_aft=R + 0.01, radius_fore=R + 0.01, length=2.0, thickness=0.01
        ),
        p_BoGo_B=(-1.0, 0.0, 0.0),
    )
    plug = Part(name="plug", shape=Cone(radius_aft=r, radius_fore=r, length=length))
    time = np.linspace(0.0, 2.0, 41)
    motion = straight(
        time, (-1.0, 0.0, 0.0), (1.0, 0.0, 0.0),
        angle=np.full(41, tilt), axis=(0.0, 0.0, 1.0),
    )  # fmt: skip
    found = clearance(motion, tube, plug)
    expected = R - (r * math.cos(tilt) + 0.5 * length * math.sin(tilt))
    assert expected - FACET - SOLVER <= found.minimum <= expected + ACCURACY
    # The plug is within the tube: Drake's hull would say that it overlaps it.
    assert found.minimum > 0.03


def test_box_past_an_edge():
    """A turning box passes the edge of another."""
    edge = Part(
        name="edge", shape=Box(size=(1.0, 1.0, 1.0)), p_BoGo_B=(-0.5, -0.5, 0.0)
    )
    half, spin = 0.2, 3.0
    box = Part(name="box", shape=Box(size=(2 * half, 2 * half, 0.5)))
    time = np.linspace(0.0, 1.0, 101)
    centre = np.array([0.2, 0.3, 0.0])
    motion = trajectory(
        time, np.tile(centre, (101, 1)), np.zeros((101, 3)),
        angle=spin * time, rate=np.full(101, spin), axis=(0.0, 0.0, 1.0),
    )  # fmt: skip
    found = clearance(motion, edge, box)
    # Its corners turn on a circle; the lowest passes over the face of the edge's box
    # where that is below, and the corner of the box is nearest to the edge otherwise.
    dense = min(
        _corner_gap(centre, half, spin * t) for t in np.linspace(0.0, 1.0, 200_001)
    )
    assert found.minimum == pytest.approx(dense, abs=ACCURACY)
    assert found.minimum >= dense - 1e-6


def _corner_gap(centre, half, angle):
    """The distance of a turned square to the quadrant x < 0, y < 0, in the plane."""
    c, s = math.cos(angle), math.sin(angle)
    corners = [
        (centre[0] + c * x - s * y, centre[1] + s * x + c * y)
        for x, y in ((half, half), (half, -half), (-half, -half), (-half, half))
    ]
    to_quadrant = min(math.hypot(max(x, 0.0), max(y, 0.0)) for x, y in corners)
    # The quadrant's corner to the square.
    x, y = -c * centre[0] - s * centre[1], s * centre[0] - c * centre[1]
    to_corner = math.hypot(max(abs(x) - half, 0.0), max(abs(y) - half, 0.0))
    return min(to_quadrant, to_corner)


def test_panel_whose_tip_grazes_a_wall():
    """A panel that unfolds touches where its tip reaches the wall, at a known time."""
    reach, spin, gap = 1.2, 0.8, 1.0
    panel = Part(
        name="panel",
        shape=Box(size=(reach, 0.02, 0.4)),
        p_BoGo_B=(reach / 2.0, 0.0, 0.0),
    )
    wall = Part(
        name="wall", shape=Box(size=(4.0, 0.2, 4.0)), p_BoGo_B=(0.0, gap + 0.1, 0.0)
    )
    time = np.linspace(0.0, 2.0, 101)
    motion = trajectory(
        time, np.zeros((101, 3)), np.zeros((101, 3)),
        angle=spin * time, rate=np.full(101, spin), axis=(0.0, 0.0, 1.0),
    )  # fmt: skip
    found = clearance(motion, wall, panel)
    tip, corner = math.hypot(reach, 0.01), math.atan2(0.01, reach)
    angle = math.asin(gap / tip) - corner
    assert found.contact.time == pytest.approx(angle / spin, abs=2e-6)
    assert found.contact.closing_speed == pytest.approx(
        spin * tip * math.cos(angle + corner), rel=1e-3
    )


@pytest.fixture
def tube_mesh(tmp_path):
    mesh = trimesh.creation.annulus(r_min=0.45, r_max=0.5, height=2.0, sections=48)
    mesh.apply_scale(1000.0)
    mesh.export(tmp_path / "tube.stl")
    return tmp_path / "tube.stl"


def test_plug_in_a_tube_of_triangles(tube_mesh):
    """Measured to the surface of the mesh, in mm along z, not to its hull."""
    tube = Part(
        name="tube",
        shape=Mesh(file=tube_mesh, scale=1e-3),
        rpy_BG=(0.0, math.pi / 2.0, 0.0),
    )
    plug = Part(name="plug", shape=Capsule(radius=0.2, length=0.5))
    motion = straight(np.linspace(0.0, 1.0, 21), (0.0, 0.05, 0.0), (1.5, 0.0, 0.0))
    found = clearance(motion, tube, plug)
    # The polygon of 48 sides, whose side or corner is toward y.
    inner = 0.45 * math.cos(math.pi / 48)
    assert inner - 0.25 - SOLVER <= found.minimum <= 0.45 - 0.25 + ACCURACY


def test_ball_inside_the_wall_of_a_mesh(tmp_path):
    """Far from the surface, but in what is solid."""
    thick = trimesh.creation.annulus(r_min=0.5, r_max=2.5, height=2.0, sections=48)
    thick.export(tmp_path / "thick.stl")
    ring = Part(name="ring", shape=Mesh(file=tmp_path / "thick.stl"))
    for place, solid in (((1.5, 0.0, 0.0), True), ((0.0, 0.0, 0.0), False)):
        motion = straight(COARSE, place, (0.0, 0.0, 1.0))
        if solid:
            with pytest.raises(InputError, match="one inside the other"):
                clearance(motion, ring, ball("payload_ball", 0.1))
        else:
            assert clearance(motion, ring, ball("payload_ball", 0.1)).minimum > 0.3


def test_mesh_in_millimetres_that_is_read_in_metres(tube_mesh):
    tube = Part(name="tube", shape=Mesh(file=tube_mesh))
    motion = straight(COARSE, (5e3, 0.0, 0.0), (1.0, 0.0, 0.0))
    with pytest.warns(UserWarning, match="tube: mesh is .* check scale"):
        clearance(motion, tube, ball("payload_ball", 0.1))


def test_mesh_that_is_not_closed(tmp_path):
    """A ball leaves a box through the end that is open, and another by its side."""
    mesh = trimesh.creation.box((2.0, 2.0, 2.0))
    mesh.update_faces(mesh.face_normals[:, 0] < 0.5)
    mesh.export(tmp_path / "open.stl")
    hull = Part(name="hull", shape=Mesh(file=tmp_path / "open.stl"))
    for side, expected in ((0.2, 0.7), (1.5, 0.4)):
        motion = straight(COARSE, (0.0, side, 0.0), (1.0, 0.0, 0.0))
        found = clearance(motion, hull, ball("payload_ball", 0.1))
        assert found.minimum == pytest.approx(expected, abs=1e-5)
        assert found.contact is None
    missing = Part(name="hull", shape=Mesh(file=tmp_path / "missing.stl"))
    with pytest.raises(InputError, match="mesh file must exist"):
        clearance(motion, missing, ball("payload_ball", 0.1))


def test_convex_mesh_is_taken_whole(tmp_path):
    trimesh.creation.icosphere(subdivisions=3, radius=0.2).export(tmp_path / "ball.obj")
    stone = Part(name="stone", shape=Mesh(file=tmp_path / "ball.obj"))
    motion = straight(COARSE, (-0.5, 0.6, 0.0), (1.0, 0.0, 0.0))
    found = clearance(motion, stone, ball("payload_ball", 0.1))
    assert found.minimum == pytest.approx(0.3, abs=2e-3)  # of its facets


def test_touching_pair_is_measured_once_it_has_parted():
    motion = straight(np.linspace(0.0, 1.0, 21), (0.3, 0.0, 0.0), (0.5, 0.0, 0.0))
    first, second = ball("ring", 0.2), ball("flange", 0.1)
    with pytest.raises(InputError, match="ring and flange must be apart while mated"):
        clearance(motion, first, second)
    found = clearance(motion, first, second, touching=[("flange", "ring")])
    assert found.contact is None
    assert found.minimum == pytest.approx(0.025, abs=1e-6)


def test_touching_pair_that_goes_deeper_is_in_contact():
    """Declared to touch: not to drive through each other and out on the other side."""
    motion = straight(np.linspace(0.0, 1.0, 101), (0.25, 0.0, 0.0), (-1.0, 0.0, 0.0))
    first, second = ball("ring", 0.2), ball("flange", 0.1)
    found = clearance(motion, first, second, touching=[("flange", "ring")])
    assert found.contact.time == pytest.approx(0.01)  # the first sample 1 mm deeper
    assert found.contact.closing_speed == pytest.approx(1.0, abs=1e-6)


def test_pair_said_to_touch_that_does_not_is_measured():
    motion = straight(np.linspace(0.0, 1.0, 21), (0.35, 0.0, 0.0), (0.5, 0.0, 0.0))
    first, second = ball("ring", 0.2), ball("flange", 0.1)
    found = clearance(motion, first, second, touching=[("flange", "ring")])
    assert (found.minimum, found.time) == (pytest.approx(0.05, abs=1e-6), 0.0)


def test_pair_that_never_parts():
    motion = straight(COARSE, (0.3, 0.0, 0.0), (0.0, 0.0, 0.0))
    first, second = ball("ring", 0.2), ball("flange", 0.1)
    found = clearance(motion, first, second, touching=[("ring", "flange")])
    assert found.contact.time == 0.0
    run = run_of(motion, [first], [second])
    analysis = ClearanceAnalysis(run.separation, touching=[("ring", "flange")])
    [nearest] = analysis.nearest(run, [0.5])
    assert nearest.names == ("ring", "flange")


def test_ball_that_leaves_the_wall_of_a_mesh(tmp_path):
    """Touching pairs are not taken for parted while one is inside the other."""
    thick = trimesh.creation.annulus(r_min=0.5, r_max=2.5, height=1.0, sections=48)
    thick.export(tmp_path / "thick.stl")
    ring = Part(name="ring", shape=Mesh(file=tmp_path / "thick.stl"))
    motion = straight(np.linspace(0.0, 1.0, 41), (1.5, 0.0, 0.0), (0.0, 0.0, 2.0))
    found = clearance(
        motion, ring, ball("payload_ball", 0.1), touching=[("ring", "payload_ball")]
    )
    assert found.contact is None
    assert 0.0 < found.minimum <= 0.0501  # of the first sample at which it is out


@pytest.mark.parametrize("until", [0.0, -1.0, 1.5, math.nan, math.inf])
def test_times_that_the_run_has_not_got(until):
    run = run_of(
        straight(COARSE, (1.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
        [ball("rock", 0.2)],
        [ball("payload_ball", 0.1)],
    )
    with pytest.raises(InputError, match="until"):
        ClearanceAnalysis(run.separation).of(run, until=until)


def test_spheres_that_graze():
    """An overlap of 3 um is contact, with a clearance of 0."""
    motion = straight(COARSE, (-0.5, 0.3 - 3e-6, 0.0), (1.0, 0.0, 0.0))
    found = clearance(motion, ball("rock", 0.2), ball("payload_ball", 0.1))
    assert found.minimum == 0.0
    assert found.time == found.contact.time == pytest.approx(0.5, abs=2e-3)


def test_mesh_with_textures_and_normals(tmp_path):
    """Corners that a file has once for each face are one."""
    box = trimesh.creation.box()
    lines = [f"v {x} {y} {z}" for x, y, z in box.vertices]
    lines += ["vt 0 0", "vt 1 0", "vt 1 1"]
    lines += [f"vn {x} {y} {z}" for x, y, z in box.face_normals]
    for k, (a, b, c) in enumerate(box.faces + 1):
        lines.append(f"f {a}/1/{k + 1} {b}/2/{k + 1} {c}/3/{k + 1}")
    (tmp_path / "box.obj").write_text("\n".join(lines))
    part = Part(name="part", shape=Mesh(file=tmp_path / "box.obj"))
    motion = straight(COARSE, (2.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    found = clearance(motion, part, ball("payload_ball", 0.1))
    assert found.minimum == pytest.approx(1.4, abs=1e-6)


@pytest.mark.parametrize(
    ("pairs", "message"),
    [
        ([("rock", "payload_bal")], "unknown part 'payload_bal'; did you mean"),
        ([("rock", "rock")], "parts of two bodies, got rock and rock of lower"),
        ([("rock",)], "must name two parts"),
        ([], "needs parts on two bodies"),
    ],
)
def test_pairs_that_make_no_sense(pairs, message):
    motion = straight(COARSE, (1.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    with pytest.raises(InputError, match=message):
        clearance(motion, ball("rock", 0.2), ball("payload_ball", 0.1), pairs=pairs)


def test_threads_that_measure_at_once_do_not_disturb_each_other():
    """Bodies are placed in scenes that all measurements share."""
    cone = Part(
        name="ring",
        shape=Cone(radius_aft=0.5, radius_fore=0.5, length=0.2, thickness=0.02),
    )
    runs = [
        run_of(
            straight(COARSE, (-0.3, y, 0.0), (0.6, 0.0, 0.0)),
            [cone],
            [ball("payload_ball", 0.1)],
        )
        for y in (0.1, 0.25)
    ]
    alone = [ClearanceAnalysis(run.separation).of(run) for run in runs]
    shared = ClearanceAnalysis(runs[0].separation)
    with ThreadPoolExecutor(2) as pool:
        for _ in range(3):
            assert list(pool.map(shared.of, runs)) == alone


@pytest.fixture
def hasty():
    """Threads that take turns after a few microseconds, within any measurement."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    yield
    sys.setswitchinterval(interval)


def test_two_threads_get_what_one_gets(hasty):
    """Bit for bit, of walls on both bodies that tumble past each other."""
    wall = Cone(radius_aft=0.05, radius_fore=0.04, length=0.02, thickness=0.005)
    parts = [Part(name="ring", shape=wall)], [Part(name="payload_ring", shape=wall)]
    time = np.linspace(0.0, 1.0, 41)
    runs = [run_of(Tumbling(k, distance=0.3).trajectory(time), *parts) for k in (1, 2)]

    def told(analysis, run):
        return repr(
            [
                analysis.of(run),
                analysis.smallest(run),
                analysis.at_times(run, time[::8]).tolist(),
                analysis.nearest(run, [0.1, 0.5, 0.9]),
            ]
        )

    alone = [told(ClearanceAnalysis(run.separation), run) for run in runs]
    shared = ClearanceAnalysis(runs[0].separation)
    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(told, [shared] * 4, 2 * runs)) == 2 * alone


def test_parts_that_all_but_touch_are_measured():
    """At less than Drake's 5 um no plane proves that they are apart, nor need it."""
    for gap in (1.5e-6, 3e-6, 6e-6):
        motion = straight(COARSE, (0.0, 0.3 + gap, 0.0), (0.2, 0.0, 0.0))
        found = clearance(motion, ball("ring", 0.2), ball("payload_ball", 0.1))
        assert found.minimum == pytest.approx(gap, abs=ACCURACY)


@pytest.mark.parametrize(("length", "sideways"), [(0.5, 0.0), (0.6, 0.0), (0.5, 3e-3)])
def test_coaxial_tubes_of_triangles(length, sideways, tmp_path):
    """Boxes around their halves overlap, turned: there Drake's own end the process."""
    radii = {"outer": (0.48, 0.5, 0.5), "payload_tube": (0.36, 0.4, length)}
    parts = []
    for name, (low, high, long) in radii.items():
        tube = trimesh.creation.annulus(low, high, long, sections=12)
        tube.export(tmp_path / f"{name}.stl")
        parts.append(Part(name=name, shape=Mesh(file=tmp_path / f"{name}.stl")))
    motion = straight(COARSE, (0.0, sideways, 0.0), (0.0, 0.0, 1.0))
    found = clearance(motion, parts[0], parts[1])
    # Between flat sides: 15 degrees from the middle of one to its corner.
    side = (0.48 - 0.4) * math.cos(math.radians(15.0))
    assert side - sideways - ACCURACY <= found.minimum <= side + ACCURACY
