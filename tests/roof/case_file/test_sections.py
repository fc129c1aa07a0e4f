"""Joints, springs, loads and bodies in case files."""

import copy
import math

import pytest
import trimesh
from ruamel.yaml import YAML

from drakesep.case_file.reader import builtin_cases, load_case
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.loads import Load, thruster
from drakesep.systems.model.springs import DisplacementSpring


VEGA = YAML(typ="safe").load(builtin_cases()["vega"])
GAINS = {
    "stiffness_N_m": 1e6,
    "damping_N_s_m": [1e3, 2e3, 3e3],
    "angular_stiffness_N_m_rad": 1e5,
    "angular_damping_N_m_s_rad": 0,
}


@pytest.fixture
def load(tmp_path):
    """Loads VEGA with a section changed, from a file beside meshes and models."""

    def load(change):
        data = copy.deepcopy(VEGA)
        del data["dispersions"], data["published"]
        del data["requirements"][-1]  # on the geometry, which goes with its body
        change(data)
        path = tmp_path / "case.yaml"
        with path.open("w") as file:
            YAML(typ="safe").dump(data, file)
        return load_case(path)

    return load


def joint(**keys):
    def change(data):
        data["attachments"]["attachment_1"]["joint"] = GAINS | keys

    return change


def attachment(**keys):
    def change(data):
        data["attachments"]["attachment_1"] |= keys

    return change


def spring(**keys):
    return attachment(spring={"name": "spring_1"} | keys)


def burn(**keys):
    def change(data):
        data["loads"] = {"burn": {"body": "launch_vehicle"} | keys}

    return change


def payload(**keys):
    def change(data):
        data["bodies"]["payload"] = keys

    return change


def test_joint_with_a_frame_and_gains_of_each_axis(load):
    axes = {"x": [0, 0, 1], "y": [1, 0, 0]}
    case = load(joint(type="revolute", axes=axes))
    assert case.separation.attachments[0].joint == Joint(
        type="revolute",
        K_F=1e6,
        D_F=(1e3, 2e3, 3e3),
        K_T=1e5,
        D_T=0.0,
        x_axis_A=(0.0, 0.0, 1.0),
        y_axis_A=(1.0, 0.0, 0.0),
    )


def test_release_at_an_angle_needs_no_time(load):
    def change(data):
        joint(type="revolute")(data)
        attachment(release_angle_deg=60)(data)
        del data["attachments"]["attachment_1"]["release_time_s"]

    case = load(change)
    released = case.separation.attachments[0]
    assert (released.release_time, released.release_angle) == (
        math.inf,
        pytest.approx(math.pi / 3),
    )
    name = "attachment_1.release_angle_deg"
    assert case.values_in_si({name: 90})["attachment_1.release_angle"] == math.pi / 2


def test_force_stroke_table(load):
    case = load(
        spring(
            law="table",
            displacements_mm=[0, 50, 121],
            forces_N=[1400, 900, 100],
            damping_N_s_m=5,
        )
    )
    assert case.separation.springs[0] == DisplacementSpring.from_table(
        name="spring_1",
        displacements=(0.0, 0.05, 0.121),
        forces=(1400.0, 900.0, 100.0),
        damping=5.0,
    )


def test_thruster_and_disturbance(load):
    def change(data):
        burn(
            direction=[-1, 0, 0],
            position_mm=[-1700, 0, 0],
            times_s=[0, 1],
            thrusts_N=[500, 300],
            after="attachment_1",
            start_s=0.5,
        )(data)
        data["loads"]["gust"] = {
            "body": "payload",
            "axes": "world",
            "times_s": [0, 1],
            "torques_N_m": [[0, 1, 0], [0, 2, 0]],
        }

    assert load(change).separation.loads == (
        thruster(
            name="burn",
            body="launch_vehicle",
            p_BoQ_B=(-1.7, 0.0, 0.0),
            direction_B=(-1.0, 0.0, 0.0),
            times=(0.0, 1.0),
            thrusts=(500.0, 300.0),
            start=0.5,
            after="attachment_1",
        ),
        Load(
            name="gust",
            body="payload",
            axes="world",
            times=(0.0, 1.0),
            torques=((0.0, 1.0, 0.0), (0.0, 2.0, 0.0)),
        ),
    )


@pytest.mark.parametrize(
    ("solid", "moment"),
    [
        ({"box": {"size_mm": [1000, 2000, 3000]}}, 13 / 12),
        ({"cylinder": {"radius_mm": 1000, "length_mm": 3000}}, 0.5),
        ({"sphere": {"radius_mm": 1000}}, 0.4),
        ({"ellipsoid": {"semi_axes_mm": [500, 1000, 1000]}}, 0.4),
        ({"capsule": {"radius_mm": 1000, "length_mm": 0.001}}, 0.4),
    ],
)
def test_body_of_a_solid(load, solid, moment):
    case = load(payload(solid={**solid, "mass_kg": 500, "position_mm": [900, 0, 0]}))
    body = case.separation.body("payload")
    assert body.mass == pytest.approx(500.0)
    assert body.p_BoBcm_B == (0.9, 0.0, 0.0)
    assert body.I_BBcm_B[0] == pytest.approx(500 * moment, rel=1e-5)


def test_body_of_a_mesh_beside_the_case(load, tmp_path):
    trimesh.creation.box((1000, 2000, 3000)).export(tmp_path / "box.stl")
    solid = {"mesh": {"file": "box.stl", "scale": 0.001}, "density_kg_m3": 100}
    body = load(payload(solid=solid)).separation.body("payload")
    assert body.mass == pytest.approx(600.0)


MODEL = """<robot name="p"><link name="bus"><inertial><mass value="8"/>
<inertia ixx="1" iyy="2" izz="2.5" ixy="0" ixz="0" iyz="0"/></inertial></link>
</robot>"""


def test_body_of_a_model_beside_the_case(load, tmp_path):
    (tmp_path / "bus.urdf").write_text(MODEL)
    case = load(payload(model={"file": "bus.urdf"}))
    assert case.separation.body("payload").I_BBcm_B[:3] == (1.0, 2.0, 2.5)


BAD = {
    "joint type": (joint(type="hinge"), "attachment_1.joint.type: must be 'fixed', "),
    "negative gain": (
        joint(stiffness_N_m=-1),
        "joint.stiffness_N_m: must be >= 0, got -1",
    ),
    "two gains": (
        joint(stiffness_N_m=[1, 2]),
        "joint.stiffness_N_m: must be 3 numbers, got",
    ),
    "axis not of length one": (
        joint(axes={"x": [1, 1, 0], "y": [0, 0, 1]}),
        "attachment_1: joint x axis must be of length 1, got .* of length 1.41421356",
    ),
    "axes not at a right angle": (
        joint(axes={"x": [1, 0, 0], "y": [0.6, 0.8, 0]}),
        "attachment_1: joint axes x and y must be at a right angle, got 53.13.* deg",
    ),
    "body attached to itself": (
        attachment(B="launch_vehicle"),
        "attachment_1: must join two different bodies, got 'launch_vehicle' twice",
    ),
    "angle of a fixed joint": (
        attachment(release_angle_deg=30),
        "release angle needs a joint that turns about its x axis alone, got fixed",
    ),
    "table without forces": (
        spring(law="table", displacements_mm=[0, 1]),
        "spring: forces_N: missing; law: table needs it",
    ),
    "table that does not begin at zero": (
        spring(law="table", displacements_mm=[5, 10], forces_N=[1, 0]),
        "spring_1: displacements must increase from 0, got 0.005, 0.01 m",
    ),
    "thrust without direction": (
        burn(times_s=[0, 1], thrusts_N=[1, 1]),
        "loads.burn: thrusts_N and direction: one needs the other",
    ),
    "axes of a thruster": (
        burn(times_s=[0, 1], thrusts_N=[1, 1], direction=[1, 0, 0], axes="world"),
        "loads.burn: axes: a thruster has none",
    ),
    "load without anything": (
        burn(times_s=[0, 1]),
        "thrusts_N, or forces_N .*got none",
    ),
    "load on nothing": (
        burn(body="lunch_vehicle", times_s=[0, 1], forces_N=[[1, 0, 0], [1, 0, 0]]),
        "burn: unknown body 'lunch_vehicle'; did you mean 'launch_vehicle'",
    ),
    "two shapes": (
        payload(
            solid={
                "box": {"size_mm": [1, 1, 1]},
                "sphere": {"radius_mm": 1},
                "mass_kg": 1,
            }
        ),
        "solid: must have one of .*, got box and sphere",
    ),
    "no mass": (
        payload(solid={"sphere": {"radius_mm": 1}}),
        "solid: must have one of mass_kg, density_kg_m3, got none",
    ),
    "mass and solid": (
        payload(mass_kg=3, solid={"sphere": {"radius_mm": 1}, "mass_kg": 3}),
        "bodies.payload: must have mass_kg, cg_mm, inertia_kg_m2, or a solid or model",
    ),
    "missing mesh": (
        payload(solid={"mesh": {"file": "none.stl"}, "mass_kg": 1}),
        "payload: mesh file must exist, got '.*none.stl'",
    ),
    "missing model": (
        payload(model={"file": "none.urdf"}),
        "payload: model file must exist, got '.*none.urdf'",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_sections_are_refused_in_one_line(name, load):
    change, message = BAD[name]
    with pytest.raises(ValueError, match=message) as error:
        load(change)
    assert "\n" not in str(error.value)


def test_open_mesh_is_refused(load, tmp_path):
    box = trimesh.creation.box((1, 1, 1))
    box.update_faces([True] * 10 + [False] * 2)
    box.export(tmp_path / "open.stl")
    solid = {"mesh": {"file": "open.stl"}, "mass_kg": 1}
    with pytest.raises(ValueError, match=r"payload: open.stl: mesh must be closed"):
        load(payload(solid=solid))
