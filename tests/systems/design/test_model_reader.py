"""Model files that do harm, or name others: read apart, from whatever directory."""

import shutil

import pytest

from drakesep.systems.checks import InputError
from drakesep.systems.design import model_reader
from drakesep.systems.design.mass_properties import mass_properties_of_model


LINK = (
    '<link name="l"><inertial><mass>1860</mass><inertia><ixx>669</ixx><iyy>3136</iyy>'
    "<izz>3265</izz><ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial></link>"
)
INCLUDE = "<include><uri>{}</uri><name>x</name></include>"
SDF = '<?xml version="1.0"?><sdf version="1.7"><model name="m">{}</model></sdf>'
OK = SDF.format(LINK)
MJCF = (
    '<mujoco model="m"><include file="{}"/><worldbody><body name="b">'
    '<inertial pos="0 0 0" mass="1860" diaginertia="669 3136 3265"/>'
    "</body></worldbody></mujoco>"
)


def including(uri):
    return SDF.format(LINK + INCLUDE.format(uri))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Where models stand; the caller is elsewhere, beside a file of the same name."""
    there, elsewhere = tmp_path / "there", tmp_path / "elsewhere"
    there.mkdir()
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    (elsewhere / "ok.sdf").write_text(OK.replace("1860", "7"))
    (there / "ok.sdf").write_text(OK)
    (there / "notes.txt").write_text("not a model")
    (there / "trunc.sdf").write_text(OK[:100])
    (there / "page.sdf").write_text("<html></html>")
    (there / "sub").mkdir()
    (there / "sub" / "lost.sdf").write_text(including("ok.sdf"))
    late = including("../ok.sdf").replace('link name="l"', "link")
    (there / "sub" / "late.sdf").write_text(late)
    return there


def test_an_include_is_looked_for_beside_the_file(folder):
    """Two links of 1860 kg, not one, and not that of another directory."""
    (folder / "good.sdf").write_text(including("ok.sdf"))
    assert mass_properties_of_model(folder / "good.sdf").mass == 3720.0


@pytest.mark.parametrize(
    "uri", ["sub/next.sdf", "sub", "file://{}/sub/next.sdf", "{}/sub/next.sdf"]
)
def test_an_include_of_an_include_is_looked_for_beside_that(uri, folder):
    """Not beside the first file, where there is another: 1860, 1000 and 100 kg."""
    (folder / "ok.sdf").write_text(OK.replace("1860", "100"))
    name = "next.sdf" if uri.endswith(".sdf") else "model.sdf"
    (folder / "sub" / name).write_text(including("in/ok.sdf").replace("1860", "1000"))
    (folder / "sub" / "in").mkdir()
    (folder / "sub" / "in" / "ok.sdf").write_text(including("../../ok.sdf"))
    (folder / "a.sdf").write_text(including(uri.format(folder)))
    mass = mass_properties_of_model(folder / "a.sdf").mass
    assert mass == 1860.0 + 1000.0 + 1860.0 + 100.0


@pytest.mark.parametrize("beside_the_first", [True, False])
def test_an_mjcf_looks_beside_the_first_too(beside_the_first, folder):
    """As MuJoCo does: there first."""
    (folder / "sub" / "part.xml").write_text(
        MJCF.format("last.xml").replace('"b"', '"p"')
    )
    last = '<mujocoinclude><worldbody><body name="l"><inertial pos="0 0 0" mass="{}"'
    last += ' diaginertia="1 1 1"/></body></worldbody></mujocoinclude>'
    (folder / "sub" / "last.xml").write_text(last.format(1))
    if beside_the_first:
        (folder / "last.xml").write_text(last.format(2))
    (folder / "a.xml").write_text(MJCF.format("sub/part.xml"))
    mass = mass_properties_of_model(folder / "a.xml").mass
    assert mass == 2 * 1860.0 + (2.0 if beside_the_first else 1.0)


def test_an_sdf_includes_other_models(folder):
    """MJCF, with an include of its own, and URDF."""
    (folder / "sub" / "part.xml").write_text(MJCF.format("last.xml"))
    last = '<mujoco><worldbody><body name="l"><inertial pos="0 0 0" mass="2"'
    last += ' diaginertia="1 1 1"/></body></worldbody></mujoco>'
    (folder / "sub" / "last.xml").write_text(last)
    inertia = 'ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"'
    urdf = '<robot name="r"><link name="r"><inertial><mass value="3"/><inertia '
    (folder / "u.urdf").write_text(f"{urdf}{inertia}/></inertial></link></robot>")
    both = INCLUDE.format("sub/part.xml") + INCLUDE.format("u.urdf").replace("x<", "y<")
    (folder / "a.sdf").write_text(SDF.format(LINK + both))
    assert mass_properties_of_model(folder / "a.sdf").mass == 2 * 1860.0 + 2.0 + 3.0


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("self.sdf", including("self.sdf"), "must not include itself, got self.sdf"),
        ("self.xml", MJCF.format("self.xml"), "must not include itself, got self.xml"),
        ("a.sdf", including("notes.txt"), "include notes.txt must be a model, got:"),
        (
            "a.sdf",
            including("page.sdf"),
            "include page.sdf must be a model, got <html>",
        ),
        ("a.sdf", including("trunc.sdf"), "include trunc.sdf must be a model, got:"),
        ("a.sdf", including("missing.sdf"), "include missing.sdf must be a model, got"),
        ("a.xml", MJCF.format("missing.xml"), "include missing.xml must be a model"),
        (
            "a.sdf",
            including("sub/lost.sdf"),
            "include ok.sdf must be a model, got no file",
        ),
        (
            "a.sdf",
            including("sub/late.sdf"),
            "must be a model, got: late.sdf:1: error: ",
        ),
        (
            "a.sdf",
            including("package://drake_models/veggies/bell_pepper.sdf"),
            "must be a model, got: .*drake_models",
        ),
    ],
)
def test_refused_in_one_line(name, text, message, folder):
    (folder / name).write_text(text)
    with pytest.raises(InputError, match=f"^{name}: {message}") as refused:
        mass_properties_of_model(folder / name)
    assert len(str(refused.value).splitlines()) == 1


def test_two_that_include_each_other(folder):
    (folder / "a.sdf").write_text(including("b.sdf"))
    (folder / "b.sdf").write_text(including("a.sdf"))
    with pytest.raises(InputError, match=r"a.sdf: must not include itself, got a.sdf"):
        mass_properties_of_model(folder / "a.sdf")


def test_a_parser_that_ends_or_never_does(folder, monkeypatch, tmp_path):
    """Whatever ends the process is a line for the user, not the end of the caller's."""
    python = tmp_path / "python"
    for script, message in (
        ("kill -SEGV $$", "Drake's parser ended: SIGSEGV"),
        ("echo out of memory >&2; exit 1", "Drake's parser ended: out of memory"),
        ("sleep 60", "takes more than 1 s to read"),
    ):
        python.write_text(f"#!/bin/bash\nexec 2>&2\n{script}\n")
        python.chmod(0o755)
        monkeypatch.setattr(model_reader.sys, "executable", str(python))
        monkeypatch.setattr(model_reader, "_SECONDS", 1)
        model = folder / f"{len(script)}.sdf"
        shutil.copy(folder / "ok.sdf", model)
        with pytest.raises(InputError, match=message):
            mass_properties_of_model(model)
