"""Mass properties from shapes, meshes and model files."""

import math

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from drakesep.systems.design.mass_properties import (
    mass_properties_of_mesh,
    mass_properties_of_model,
    mass_properties_of_shape,
)
from drakesep.systems.model.inertia import inertia_matrix
from drakesep.systems.model.separation import Body


ROUND_OFF = 1e-12
PLACE, TURN = (0.5, -0.2, 0.3), (0.4, -0.7, 1.1)


def test_solid_cylinder():
    """VEGA's stand-in for the launch vehicle: along x, behind the plane."""
    mass, cg, inertia = mass_properties_of_shape(
        "cylinder", (0.95, 1.7), mass=750.0, p_BoSo_B=(-0.85, 0.0, 0.0)
    )
    across = 750.0 * (0.95**2 / 4 + 1.7**2 / 12)
    assert mass == pytest.approx(750.0)
    assert cg == (-0.85, 0.0, 0.0)
    assert inertia == pytest.approx((338.4375, across, across, 0, 0, 0), abs=1e-9)


@pytest.mark.parametrize("axis", range(3))
def test_box_turned_about_one_axis(axis):
    """A product of inertia is the difference of two moments, sin cos of the turn."""
    sides, mass, turn = np.array([0.3, 0.8, 0.5]), 12.0, 0.4
    moments = mass * ((sides**2).sum() - sides**2) / 12.0
    first, second = (axis + 1) % 3, (axis + 2) % 3
    expected = np.diag(moments)
    c, s = math.cos(turn), math.sin(turn)
    expected[first, first] = c**2 * moments[first] + s**2 * moments[second]
    expected[second, second] = s**2 * moments[first] + c**2 * moments[second]
    product = (moments[first] - moments[second]) * s * c
    expected[first, second] = expected[second, first] = product
    rpy = [0.0, 0.0, 0.0]
    rpy[axis] = turn
    found = mass_properties_of_shape("box", sides, mass=mass, rpy_BS=tuple(rpy))
    assert inertia_matrix(found.I_BBcm_B) == pytest.approx(expected, abs=ROUND_OFF)


@pytest.mark.parametrize(
    ("shape", "dimensions", "volume"),
    [
        ("box", (0.3, 0.4, 0.5), 0.06),
        ("sphere", (0.3,), 4 / 3 * math.pi * 0.027),
        ("ellipsoid", (0.3, 0.4, 0.5), 4 / 3 * math.pi * 0.06),
        ("capsule", (0.3, 0.4), math.pi * (4 / 3 * 0.027 + 0.09 * 0.4)),
        ("cylinder", (0.3, 0.4), math.pi * 0.09 * 0.4),
    ],
)
def test_shapes_against_their_meshes(tmp_path, shape, dimensions, volume):
    """In a generic place: by density and by mass, against a fine mesh of the shape."""
    mesh = {
        "box": lambda: trimesh.creation.box(dimensions),
        "sphere": lambda: trimesh.creation.icosphere(5, dimensions[0]),
        "ellipsoid": lambda: trimesh.creation.icosphere(5).apply_scale(dimensions),
        "capsule": lambda: on_x(trimesh.creation.capsule(0.4, 0.3, count=[64, 64])),
        "cylinder": lambda: on_x(trimesh.creation.cylinder(0.3, 0.4, sections=128)),
    }[shape]()
    file = tmp_path / "shape.stl"
    mesh.apply_scale(1000.0).export(file)  # in millimetres
    options = {"p_BoSo_B": PLACE, "rpy_BS": TURN}
    ours = mass_properties_of_shape(shape, dimensions, density=500.0, **options)
    by_mass = mass_properties_of_shape(shape, dimensions, mass=ours.mass, **options)
    of_mesh = mass_properties_of_mesh(file, mass=ours.mass, scale=1e-3, **options)
    assert ours.mass == pytest.approx(500.0 * volume, rel=ROUND_OFF)
    assert by_mass.I_BBcm_B == pytest.approx(ours.I_BBcm_B, rel=ROUND_OFF)
    # facets of a round body lie inside it, by 1 - cos(pi / 64)
    for a, b in zip(of_mesh[1:], ours[1:], strict=True):
        assert a == pytest.approx(b, abs=3e-3 * max(map(abs, b)))
    Body(name="it", **of_mesh._asdict())


def on_x(mesh):
    mesh.apply_translation(-mesh.center_mass)
    return mesh.apply_transform(trimesh.geometry.align_vectors([0, 0, 1], [1, 0, 0]))


@pytest.mark.parametrize("suffix", ["obj", "stl"])
def test_box_mesh_is_exact(tmp_path, suffix):
    file = tmp_path / f"box.{suffix}"
    box = trimesh.creation.box((1.0, 2.0, 3.0))
    box.apply_translation((0.5, 1.0, 1.5))
    box.export(file)
    mass, cg, inertia = mass_properties_of_mesh(file, density=2.0)
    assert mass == pytest.approx(12.0, rel=1e-6)  # an STL holds single precision
    assert cg == pytest.approx((0.5, 1.0, 1.5), rel=1e-6)
    assert inertia == pytest.approx((13, 10, 5, 0, 0, 0), abs=1e-5)


def test_products_of_a_skew_mesh(tmp_path):
    """A tetrahedron against samples of its volume."""
    corners = np.array([[0, 0, 0], [2, 0.3, 0.1], [0.4, 1.5, 0.2], [0.3, 0.2, 1.0]])
    file = tmp_path / "skew.obj"
    trimesh.convex.convex_hull(corners).export(file)
    _, cg, inertia = mass_properties_of_mesh(file, mass=10.0)
    rng = np.random.default_rng(3)
    points = rng.dirichlet(np.ones(4), 200_000) @ corners
    about = points - points.mean(axis=0)
    second = 10.0 * about.T @ about / len(points)
    expected = np.trace(second) * np.eye(3) - second
    # samples: the square root of their number
    assert cg == pytest.approx(points.mean(axis=0), abs=5e-3)
    assert inertia_matrix(inertia) == pytest.approx(expected, abs=2e-2)


def test_mesh_is_read_again_when_it_has_changed(tmp_path):
    file = tmp_path / "box.obj"
    for size in (1.0, 2.0):
        trimesh.creation.box((size,) * 3).export(file)
        assert mass_properties_of_mesh(file, density=1.0).mass == pytest.approx(size**3)


URDF = """<robot name="payload">
  <link name="bus"><inertial>
    <origin xyz="0.5 0 0"/><mass value="8"/>
    <inertia ixx="1" iyy="2" izz="2.5" ixy="0.1" ixz="0" iyz="0"/>
  </inertial></link>
  <link name="panel"><inertial>
    <origin xyz="0 0 0.25"/><mass value="2"/>
    <inertia ixx="0.2" iyy="0.2" izz="0.1" ixy="0" ixz="0" iyz="0"/>
  </inertial></link>
  <joint name="hinge" type="revolute">
    <parent link="bus"/><child link="panel"/><axis xyz="0 1 0"/>
    <origin xyz="1 0 1" rpy="0 0.3 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
</robot>"""
SDF = """<sdf version="1.9"><model name="ball"><link name="ball">
  <inertial><mass>3</mass>
  <inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial>
</link></model></sdf>"""
MJCF = """<mujoco model="ball"><worldbody><body name="ball"><freejoint/>
  <inertial pos="0 0 1" mass="3" diaginertia="0.1 0.1 0.1"/>
</body></worldbody></mujoco>"""


def test_model_of_two_links(tmp_path):
    """The composite body, with the joint as it stands, in the frame of either."""
    file = tmp_path / "payload.urdf"
    file.write_text(URDF)
    mass, cg, inertia = mass_properties_of_model(file)
    R = Rotation.from_euler("y", 0.3).as_matrix()
    panel = np.array([1.0, 0.0, 1.0]) + R @ [0.0, 0.0, 0.25]
    c = (8.0 * np.array([0.5, 0.0, 0.0]) + 2.0 * panel) / 10.0

    def about_c(m, r, I_cm):
        d = r - c
        return I_cm + m * (d @ d * np.eye(3) - np.outer(d, d))

    bus = inertia_matrix((1, 2, 2.5, 0.1, 0, 0))
    expected = about_c(8.0, np.array([0.5, 0.0, 0.0]), bus)
    expected += about_c(2.0, panel, R @ np.diag([0.2, 0.2, 0.1]) @ R.T)
    assert mass == pytest.approx(10.0)
    assert cg == pytest.approx(c, abs=ROUND_OFF)
    assert inertia_matrix(inertia) == pytest.approx(expected, abs=ROUND_OFF)
    in_panel = mass_properties_of_model(file, frame="panel")
    assert in_panel.p_BoBcm_B == pytest.approx(R.T @ (c - [1, 0, 1]), abs=ROUND_OFF)


@pytest.mark.parametrize(
    ("suffix", "text", "cg"),
    [("sdf", SDF, (0, 0, 0)), ("xml", MJCF, (0, 0, 1))],
)
def test_other_formats(tmp_path, suffix, text, cg):
    file = tmp_path / f"ball.{suffix}"
    file.write_text(text)
    properties = mass_properties_of_model(file)
    assert properties.mass == 3.0
    assert properties.p_BoBcm_B == pytest.approx(cg, abs=ROUND_OFF)
    assert properties.I_BBcm_B == pytest.approx((0.1,) * 3 + (0,) * 3, abs=ROUND_OFF)


def test_bad_meshes(tmp_path):
    def refuse(message, file, **options):
        with pytest.raises(ValueError, match=message):
            mass_properties_of_mesh(file, **({"density": 1.0} | options))

    box = trimesh.creation.box((1, 1, 1))
    box.export(tmp_path / "box.stl")
    refuse("mesh file must exist, got '.*none.stl'", tmp_path / "none.stl")
    refuse("mesh file must end in .obj, .stl", tmp_path / "none.step")
    refuse("must have a mass or a density, got both", tmp_path / "box.stl", mass=1.0)
    refuse("mass or a density, got neither", tmp_path / "box.stl", density=None)
    refuse("mesh: scale must be > 0, got 0", tmp_path / "box.stl", scale=0.0)
    refuse("density must be > 0, got -1", tmp_path / "box.stl", density=-1.0)
    box.update_faces([True] * 11 + [False])
    box.export(tmp_path / "open.stl")
    refuse("open.stl: mesh must be closed, got 3 open edges", tmp_path / "open.stl")
    (tmp_path / "empty.obj").write_text("# nothing\n")
    refuse("empty.obj: must be a mesh, got", tmp_path / "empty.obj")
    (tmp_path / "text.stl").write_text("no mesh")
    refuse("text.stl: must be a mesh, got", tmp_path / "text.stl")


def test_bad_shapes():
    for shape, dimensions, options, message in (
        ("cone", (1.0,), {"mass": 1.0}, "unknown shape 'cone'"),
        ("box", (1.0,), {"mass": 1.0}, "box must have 3 dimensions, got 1"),
        ("sphere", (-1.0,), {"mass": 1.0}, "dimension must be > 0, got -1"),
        ("sphere", (1.0,), {}, "must have a mass or a density, got neither"),
        ("sphere", (1.0,), {"mass": math.nan}, "mass must be finite, got nan"),
        (
            "sphere",
            (1.0,),
            {"mass": 1.0, "rpy_BS": (0, 0, math.nan)},
            "solid: attitude must be finite, got nan",
        ),
        (
            "sphere",
            (1.0,),
            {"mass": 1.0, "p_BoSo_B": (0, 0)},
            "solid: position must have 3 entries, got 2",
        ),
    ):
        with pytest.raises(ValueError, match=message):
            mass_properties_of_shape(shape, dimensions, **options)


def test_bad_models(tmp_path):
    def refuse(message, name, text=None, **options):
        file = tmp_path / name
        if text is not None:
            file.write_text(text)
        with pytest.raises(ValueError, match=message):
            mass_properties_of_model(file, **options)

    refuse("model file must exist", "none.urdf")
    refuse("model file must end in .sdf, .urdf, .xml", "ball.txt", "")
    refuse("bad.urdf: must be a model, got: .*XML", "bad.urdf", "<robot")
    refuse(
        "frame 'wing' must be one of it; unknown frame 'wing'",
        "p.urdf",
        URDF,
        frame="wing",
    )
    negative = URDF.replace('mass value="8"', 'mass value="-8"')
    refuse("negative.urdf: must be a model, got: .*mass", "negative.urdf", negative)
    odd = URDF.replace('izz="2.5"', 'izz="25"')
    refuse("odd.urdf: must be a model, got: .*nertia", "odd.urdf", odd)
    weightless = SDF.replace("<mass>3</mass>", "<mass>0</mass>").replace("0.1", "0")
    refuse("weightless.sdf: mass must be > 0", "weightless.sdf", weightless)
