"""Files that should hold a mesh: told as what they are, and links followed."""

import math
import struct

import numpy as np
import pytest
import trimesh

from drakesep.systems.checks import DrakesepWarning, InputError
from drakesep.systems.design.mass_properties import (
    mass_properties_of_mesh,
    mass_properties_of_model,
)
from drakesep.systems.geometry.distance import Proximity, is_inside
from drakesep.systems.geometry.meshes import (
    DoubtfulScale,
    mesh_bytes,
    read_mesh,
    read_solid,
)
from drakesep.systems.geometry.relative_path import Pose
from drakesep.systems.model.parts import Mesh, Part, Sphere


BOX = trimesh.creation.box()
STL = trimesh.exchange.stl.export_stl(BOX)
TEXT = trimesh.exchange.stl.export_stl_ascii(BOX)
OBJ = trimesh.exchange.obj.export_obj(BOX)
NOISE = np.random.default_rng(0).bytes(2000)


def saying(count):
    return STL[:80] + struct.pack("<I", count) + STL[84:]


PLY = b"""ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
3 0 1 2
"""
BAD = {
    "empty.stl": (b"", "an empty file"),
    "empty.obj": (b" \n", "an empty file"),
    "noise.stl": (NOISE, "2000 bytes where the header of an STL says"),
    "noise.obj": (NOISE, "binary data, no OBJ text"),
    "words.stl": (b"a mesh\n", "7 bytes that are no STL"),
    "words.obj": (b"a mesh\n", "text without a corner"),
    "picture.stl": (b"\x89PNG\r\n\x1a\n" + NOISE, "bytes where the header of an STL"),
    "obj.stl": (OBJ.encode(), "bytes where the header of an STL says"),
    "stl.obj": (STL, "binary data, no OBJ text"),
    "text.obj": (TEXT.encode(), "text without a corner"),
    "cut.stl": (STL[:-60], "624 bytes where .* STL says 12 triangles, 684 bytes"),
    "more.stl": (saying(1000), "684 bytes where .* says 1000 triangles, 50084 bytes"),
    "most.stl": (saying(2**32 - 1), "says 4294967295 triangles"),
    "fewer.stl": (saying(6), "684 bytes where .* says 6 triangles, 384 bytes"),
    "cut_text.stl": (TEXT[: len(TEXT) // 2].encode(), "ends before its endsolid"),
    "none.stl": (b"solid x\nendsolid x\n", "STL text without a facet"),
    "nan.stl": (
        STL[:96] + struct.pack("<f", np.nan) + STL[100:],
        "triangle 1 that is not finite",
    ),
    "nan.obj": (b"v 0 0 0\nv nan 0 0\nf 1 2 1\n", "finite numbers in line 2: v nan"),
    "two.obj": (b"v 0 0 0\nv 1 0\nf 1 2 1\n", "finite numbers in line 2: v 1 0"),
    "index.obj": (OBJ.replace("f 2", "f 999", 1).encode(), "corner 999 of 8 in line"),
    "words.ply": (b"a mesh\n", "PLY"),
    "none.ply": (PLY.replace(b" x", b" q"), "a PLY without corners"),
    "open.ply": (PLY[:40], "a file without the header of a PLY"),
    "bare.ply": (PLY.replace(b"element face", b"element edge"), "a PLY without faces"),
    "words.glb": (b"a mesh\n", "GLB"),
    "words.gltf": (b"a mesh\n", "a file that is no glTF"),
    "zero.obj": (OBJ.replace("f 2", "f 0", 1).encode(), "no triangle in line"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_wrong_is_said(name, tmp_path):
    data, message = BAD[name]
    file = tmp_path / name
    file.write_bytes(data)
    with pytest.raises(InputError, match=f"^{name}: must be a mesh, got .*{message}"):
        read_mesh(file)


def test_a_flat_mesh_has_no_volume(tmp_path):
    file = tmp_path / "flat.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 3 2\n")
    assert len(read_mesh(file).faces) == 2
    with pytest.raises(InputError, match=r"^flat.obj: volume must be > 0"):
        read_solid(file)


POINTER = b"""version https://git-lfs.github.com/spec/v1
oid sha256:0000000000000000000000000000000000000000000000000000000000000000
size 1000
"""


@pytest.mark.parametrize("name", ["part.stl", "part.glb", "part.urdf"])
def test_a_pointer_to_a_large_file_is_told_as_such(name, tmp_path):
    file = tmp_path / name
    file.write_bytes(POINTER)
    read = mass_properties_of_model if name.endswith("urdf") else read_mesh
    with pytest.raises(InputError, match=rf"^{name}: .* got a pointer of Git LFS to i"):
        read(file)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("part.dae", r"COLLADA, which `assimp export part.dae part.glb` or Blender"),
        ("part.STEP", r"STEP, which has no triangles: gmsh or FreeCAD make an STL"),
        ("part.txt", r"got '.*part.txt'$"),
    ],
)
def test_other_formats_are_refused_with_what_converts_them(name, message, tmp_path):
    with pytest.raises(InputError, match=rf"must end in .obj, .stl, .ply.*{message}"):
        read_mesh(tmp_path / name)


@pytest.mark.parametrize("form", ["ascii.ply", "binary.ply", "scene.glb", "scene.gltf"])
def test_formats_hold_the_same(form, tmp_path):
    """Two boxes, the second moved by its node where there are such."""
    small, large = trimesh.creation.box((1, 2, 3)), trimesh.creation.box((2, 2, 2))
    moved = trimesh.transformations.translation_matrix((5, 0, 0))
    scene = trimesh.Scene([small])
    scene.add_geometry(large, transform=moved)
    file = tmp_path / form
    if form.endswith("ply"):
        encoding = form.removesuffix(".ply")
        both = scene.to_mesh()
        file.write_bytes(trimesh.exchange.ply.export_ply(both, encoding=encoding))
    elif form.endswith("glb"):
        file.write_bytes(scene.export(file_type="glb"))
    else:
        options = {"merge_buffers": True, "embed_buffers": True}
        [data] = trimesh.exchange.gltf.export_gltf(scene, **options).values()
        file.write_bytes(data)
    got = mass_properties_of_mesh(file, density=100.0)
    assert got.mass == pytest.approx(1400.0, rel=1e-6)  # single precision
    assert got.p_BoBcm_B == pytest.approx((5.0 * 8.0 / 14.0, 0.0, 0.0), abs=1e-6)


def test_a_gltf_may_have_buffers_beside_it(tmp_path):
    """A box of 1 m: with them within it, it is the same alone, in another folder."""
    for name, data in trimesh.Scene([BOX]).export(file_type="gltf").items():
        (tmp_path / name).write_bytes(data)
    file, alone = tmp_path / "model.gltf", tmp_path / "alone" / "model.gltf"
    assert (tmp_path / "gltf_buffer_0.bin").is_file()
    alone.parent.mkdir()
    alone.write_bytes(mesh_bytes(file))
    for one in (file, alone):
        assert read_solid(one).volume == pytest.approx(1.0)  # of halves, exact
        assert read_solid(one).extents.tolist() == pytest.approx([1.0, 1.0, 1.0])


def test_a_gltf_without_its_buffers_is_refused(tmp_path):
    for name, data in trimesh.Scene([BOX]).export(file_type="gltf").items():
        (tmp_path / name).write_bytes(data)
    (tmp_path / "gltf_buffer_0.bin").unlink()
    with pytest.raises(InputError, match=r"beside it, got none at 'gltf_buffer_0.bin'"):
        read_mesh(tmp_path / "model.gltf")


def test_an_open_mesh_is_a_surface(tmp_path):
    """A box without a lid, and a ball above it, in it, and in the wall."""
    box = trimesh.creation.box((2, 2, 2))
    box.update_faces(box.face_normals[:, 2] < 0.5)
    file = tmp_path / "box.stl"
    box.export(file)
    with pytest.raises(InputError, match=r"^box.stl: mesh must be closed, got 4 open"):
        mass_properties_of_mesh(file, mass=1.0)
    part = Part(name="box", shape=Mesh(file=file))
    ball = Part(name="ball", shape=Sphere(radius=0.3))
    proximity = Proximity([part], [ball])
    for height, distance in (
        (1.6, math.hypot(1.0, 0.6) - 0.3),
        (0.0, 0.7),
        (-0.8, -0.1),
    ):
        centre = np.array([0.0, 0.0, height])
        none = np.zeros(3)
        pose = Pose(np.array([1.0, 0.0, 0.0, 0.0]), np.eye(3), centre, none, none)
        nearest = min(
            proximity.measure((leaf, proximity.roots["ball"]), pose).distance
            for leaf in proximity.roots["box"].leaves
        )
        assert nearest == pytest.approx(distance, abs=1e-5)  # as certain as Drake's
        assert not is_inside(part, centre)


@pytest.mark.parametrize("target", ["box.stl", "3f2a91"])
def test_a_link_is_followed(target, tmp_path):
    """To a store, too, where files have no suffix; a header may begin with "solid"."""
    (tmp_path / target).write_bytes(b"solid" + STL[5:])
    link = tmp_path / "link.stl"
    link.symlink_to(target)
    assert read_mesh(link).volume == pytest.approx(1.0)


@pytest.mark.parametrize("target", ["nothing", ".", "link.stl"])
def test_a_link_that_leads_nowhere(target, tmp_path):
    link = tmp_path / "link.stl"
    link.symlink_to(target)
    with pytest.raises(InputError, match=r"^mesh file must exist, got .*link.stl"):
        read_mesh(link)


def test_millimetres_taken_for_metres(tmp_path):
    """Of a solid as of a part: by its mass, or by its size where that has none."""
    file = tmp_path / "box.stl"
    trimesh.creation.box((1200.0, 800.0, 600.0)).export(file)
    assert mass_properties_of_mesh(file, mass=300.0, scale=1e-3).mass == 300.0
    assert issubclass(DoubtfulScale, DrakesepWarning)
    for how in ({"mass": 300.0}, {"mass": 300.0, "scale": 1e-6}):
        with pytest.warns(DoubtfulScale, match=r"^box.stl: .*check scale.*0.001 of"):
            mass_properties_of_mesh(file, **how)
