"""Files that should hold a mesh: told as what they are, and links followed."""

import struct

import numpy as np
import pytest
import trimesh

from drakesep.systems.checks import DrakesepWarning, InputError
from drakesep.systems.design.mass_properties import mass_properties_of_mesh
from drakesep.systems.geometry.meshes import DoubtfulScale, read_mesh


BOX = trimesh.creation.box()
STL = trimesh.exchange.stl.export_stl(BOX)
TEXT = trimesh.exchange.stl.export_stl_ascii(BOX)
OBJ = trimesh.exchange.obj.export_obj(BOX)
NOISE = np.random.default_rng(0).bytes(2000)


def saying(count):
    return STL[:80] + struct.pack("<I", count) + STL[84:]


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
    with pytest.raises(InputError, match=r"^flat.obj: volume must be > 0"):
        read_mesh(file)


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
