"""Models as they are found: with looks, sensors, contact, meshes that are missing."""

import math

import numpy as np
import pytest
from trade import BODIES, JOINT

import drakesep
from drakesep.case_file.case import Case
from drakesep.systems.checks import InputError
from drakesep.systems.design.mass_properties import mass_properties_of_model


MJCF = """<mujoco>
  <compiler angle="degree" autolimits="true" texturedir="t" discardvisual="false"/>
  <option gravity="0 0 0" timestep="0.01"><flag contact="disable"/></option>
  <visual><global offwidth="1280"/></visual>
  <statistic extent="4"/>
  <asset>
    <texture name="sky" type="skybox" builtin="gradient" width="8" height="8"/>
    <texture name="foil" type="2d" file="missing.png"/>
    <material name="foil" texture="foil" reflectance="0.3"/>
    <mesh name="dish" file="missing.stl" scale="0.001 0.001 0.001"/>
  </asset>
  <default>
    <site size="0.01"/>
    <default class="panel">
      <geom type="box" size="1 0.05 0.5" density="100" material="foil" contype="1"/>
      <joint armature="0.1"/>
    </default>
  </default>
  <worldbody>
    <light pos="0 0 3"/>
    <geom name="floor" type="plane" size="1 1 1" material="foil"/>
    <geom name="stand" type="box" size="1 1 1"/>
    <frame pos="9 0 0">
      <body name="bus">
        <freejoint/>
        <geom type="box" size="0.5 0.5 0.5" density="200" conaffinity="2" margin="1"
              rgba="1 0 0 1" friction="1 0.1 0.1" solref="0.02 1"/>
        <camera name="star_tracker" pos="0 0 1"/>
        <site name="thruster" pos="0 0 -0.5"/>
        <body name="wing" childclass="panel" pos="1.5 0 0">
          <joint name="deploy" axis="0 1 0" range="0 90"/>
          <geom/>
        </body>
        <frame pos="0 0 0.5">
          <body name="antenna">
            <inertial pos="0 0 0.1" mass="4" diaginertia="0.2 0.2 0.3"/>
            <geom type="mesh" mesh="dish" mass="77"/>
          </body>
        </frame>
      </body>
    </frame>
  </worldbody>
  <contact><exclude body1="bus" body2="wing"/></contact>
  <actuator><motor joint="deploy"/></actuator>
  <sensor><gyro site="thruster"/></sensor>
  <keyframe><key qpos="0 0 0 1 0 0 0 0.3"/></keyframe>
</mujoco>"""


def composite(*parts):
    """Mass, CG and inertia about it of boxes and others, (mass, place, diagonal)."""
    mass = sum(m for m, _, _ in parts)
    cg = sum(m * np.array(p, float) for m, p, _ in parts) / mass
    inertia = np.zeros((3, 3))
    for m, p, diagonal in parts:
        d = np.array(p) - cg
        inertia += np.diag(diagonal) + m * (d @ d * np.eye(3) - np.outer(d, d))
    return mass, cg, inertia


def box(mass, x, y, z):
    return mass / 12.0 * np.array([y**2 + z**2, x**2 + z**2, x**2 + y**2])


def check(file, expected, **options):
    got = mass_properties_of_model(file, **options)
    mass, cg, inertia = expected
    assert got.mass == pytest.approx(mass, rel=1e-12)
    assert got.p_BoBcm_B == pytest.approx(cg, abs=1e-12)
    xx, yy, zz, xy, xz, yz = got.I_BBcm_B
    matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    assert matrix == pytest.approx(inertia, abs=1e-9)


def test_mjcf_with_all_that_spacecraft_have(tmp_path):
    """By hand: 200 kg/m3 in 1 m3, 100 in 0.2 m3, and an antenna with its inertia."""
    file = tmp_path / "satellite.xml"
    file.write_text(MJCF)
    expected = composite(
        (200.0, (0.0, 0.0, 0.0), box(200.0, 1.0, 1.0, 1.0)),
        (20.0, (1.5, 0.0, 0.0), box(20.0, 2.0, 0.1, 1.0)),
        (4.0, (0.0, 0.0, 0.6), (0.2, 0.2, 0.3)),
    )
    check(file, expected)
    mass, cg, inertia = expected
    check(file, (mass, cg - [1.5, 0.0, 0.0], inertia), frame="wing")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('autolimits="true"', 'settotalmass="7"', "else of mass .*got settotalmass"),
        ("<camera", '<flexcomp name="x"/><camera', "bodies must be .*got flexcomp"),
        ("<camera", '<replicate count="3"/><camera', "bodies must be .*got replicate"),
        ("<camera", "<composite/><camera", "bodies must be .*got composite"),
        ('autolimits="true"', 'boundmass="7"', "else of mass .*got boundmass"),
        ('mass="77"', 'mass="77" shellinertia="true"', None),
        ('pos="0 0 0.1" mass="4"', 'mass="4"', None),
    ],
)
def test_what_bears_on_mass_and_is_not_known_is_refused(tmp_path, old, new, message):
    file = tmp_path / "satellite.xml"
    file.write_text(MJCF.replace(old, new))
    if message is None:  # of a geom that weighs nothing; and a default
        assert mass_properties_of_model(file).mass == pytest.approx(224.0)
    else:
        with pytest.raises(InputError, match=f"satellite.xml: .*{message}"):
            mass_properties_of_model(file)


@pytest.mark.parametrize(
    ("defaults", "geom"),
    [
        ("", '<geom type="mesh" mesh="dish" mass="0"/>'),
        ("", '<geom type="mesh" mesh="dish" density="0.0"/>'),
        ('<default class="seen"><geom mass="0"/></default>', '<geom class="seen" {}/>'),
        ('<geom density="0"/>', "<geom {}/>"),
        ('<geom mass="0"/><default class="seen"/>', '<geom class="seen" {}/>'),
    ],
)
def test_a_mesh_that_is_drawn_alone_may_be_missing(tmp_path, defaults, geom):
    """A cube of 1 m of 30 kg, and a dish of no mass."""
    file = tmp_path / "satellite.xml"
    file.write_text(
        f"<mujoco><default>{defaults}</default><asset><mesh name='dish' file='no.stl'/>"
        '</asset><worldbody><body><geom type="box" size="0.5 0.5 0.5" mass="30"/>'
        + geom.format('type="mesh" mesh="dish"')
        + "</body></worldbody></mujoco>"
    )
    check(file, composite((30.0, (0.0, 0.0, 0.0), box(30.0, 1.0, 1.0, 1.0))))
    file.write_text(file.read_text().replace('="0"', '="2"').replace('"0.0"', '"2"'))
    with pytest.raises(InputError, match=r"satellite.xml: .*no.stl"):
        mass_properties_of_model(file)


def test_a_mesh_that_bodies_are_weighed_by_must_be_there(tmp_path):
    file = tmp_path / "satellite.xml"
    start = MJCF.index("<inertial")
    end = MJCF.index("<geom", start)
    file.write_text(MJCF[:start] + MJCF[end:])
    with pytest.raises(InputError, match=r"satellite.xml: .*missing.stl"):
        mass_properties_of_model(file)


URDF = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <material name="foil"><color rgba="1 1 0 1"/></material>
  <link name="bus">
    <inertial><mass value="200"/><inertia ixx="10" iyy="20" izz="25"/></inertial>
    <visual><geometry><mesh filename="package://none/bus.dae"/></geometry>
      <material name="foil"/></visual>
    <collision><geometry><mesh filename="bus.stl"/></geometry></collision>
    <sensor name="imu" type="imu"/>
  </link>
  <link name="wing">
    <inertial><origin xyz="0.5 0 0"/><mass value="20"/>
      <inertia ixx="1" iyy="2" izz="2.5"/></inertial>
  </link>
  <joint name="deploy" type="revolute">
    <parent link="bus"/><child link="wing"/><origin xyz="1 0 0"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="1" effort="1" velocity="1"/>
    <dynamics damping="0.1" friction="0.2"/>
    <mimic joint="other" multiplier="2"/>
    <safety_controller k_velocity="1"/>
  </joint>
  <transmission name="t"><type>simple</type></transmission>
  <gazebo reference="bus"><kp>1e6</kp></gazebo>
  <ros2_control name="x" type="system"/>
</robot>"""
INCLUDED = """<sdf version="1.9"><model><link name="bus">
  <inertial><mass>200</mass><inertia><ixx>10</ixx><iyy>20</iyy><izz>25</izz></inertia>
  </inertial>
  <visual name="v"><geometry><mesh><uri>model://none/bus.dae</uri></mesh></geometry>
  </visual>
  <collision name="c"><geometry><mesh><uri>bus.dae</uri></mesh></geometry></collision>
  <sensor name="s" type="imu"/><velocity_decay/></link></model></sdf>"""
SDF = """<sdf version="1.9"><world name="orbit">
  <physics type="ode"/><light name="sun" type="directional"/><plugin name="p"
  filename="libp.so"/><scene/>
  <model name="satellite"><self_collide>0</self_collide>
    <include><uri>bus.sdf</uri><name>bus</name><plugin name="p" filename="q"/></include>
    <link name="wing"><pose>1 0 0 0 0 0</pose><inertial><pose>0.5 0 0 0 0 0</pose>
      <mass>20</mass><inertia><ixx>1</ixx><iyy>2</iyy><izz>2.5</izz></inertia>
    </inertial><visual name="v"/></link>
    <joint name="deploy" type="revolute"><parent>bus::bus</parent><child>wing</child>
      <axis><xyz>0 1 0</xyz><dynamics><damping>1</damping></dynamics></axis></joint>
    <plugin name="control" filename="libc.so"/>
  </model></world></sdf>"""
WEIGHED = composite(
    (200.0, (0.0, 0.0, 0.0), (10.0, 20.0, 25.0)),
    (20.0, (1.5, 0.0, 0.0), (1.0, 2.0, 2.5)),
)


def test_urdf_with_all_that_robots_have(tmp_path):
    file = tmp_path / "satellite.urdf"
    file.write_text(URDF)
    check(file, WEIGHED)


def test_sdf_with_all_that_worlds_have(tmp_path):
    file = tmp_path / "satellite.sdf"
    file.write_text(SDF)
    (tmp_path / "bus.sdf").write_text(INCLUDED)
    check(file, WEIGHED)


def test_an_sdf_whose_inertia_follows_from_its_shapes(tmp_path):
    """Of 10 kg/m3, in 1 m by 2 m by 3 m, beside one that says its own."""
    file = tmp_path / "satellite.sdf"
    file.write_text(
        '<sdf version="1.11"><model name="m"><link name="bus"><inertial auto="true">'
        '<density>10</density></inertial><collision name="c"><pose>1 0 0 0 0 0</pose>'
        "<geometry><box><size>1 2 3</size></box></geometry><surface/>"
        '</collision></link><link name="wing"><inertial><mass>20</mass></inertial>'
        '<collision name="c"><geometry><mesh><uri>no.dae</uri></mesh></geometry>'
        "</collision></link></model></sdf>"
    )
    # That SDF takes for 1 kg m2 each what is left out.
    wing = (20.0, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    check(file, composite((60.0, (1.0, 0.0, 0.0), box(60.0, 1.0, 2.0, 3.0)), wing))


def test_what_the_parser_says_is_told_whole(tmp_path):
    file = tmp_path / "satellite.urdf"
    file.write_text(URDF.replace('izz="25"', 'izz="40"'))
    with pytest.raises(InputError, match="do not satisfy the triangle inequality"):
        mass_properties_of_model(file)


def test_a_body_of_a_mujoco_model_flies(tmp_path):
    """100 kg of a cube of 1 m, by MuJoCo; 20 J of a spring on it and on 2000 kg."""
    file = tmp_path / "sat.xml"
    file.write_text(
        '<mujoco><worldbody><body name="bus"><freejoint/>'
        '<geom type="box" size="0.5 0.5 0.5" density="100"/>'
        "</body></worldbody></mujoco>"
    )
    spring = {"name": "s", "law": "displacement", "force_max_N": 500, "stroke_mm": 80}
    attachment = {"A": "lv", "B": "sc", "position_mm": [0, 0, 0], "joint": JOINT}
    case = Case.model_validate(
        {
            "name": "satellite",
            "pair": {"A": "lv", "B": "sc"},
            "bodies": {
                "lv": BODIES["lv"],
                "sc": {
                    "model": {"file": str(file)},
                    "mated": {"position_mm": [1000, 0, 0]},
                },
            },
            "attachments": {"a": attachment | {"spring": spring, "release_time_s": 0}},
            "run": {"duration_s": 1, "accuracy": 1e-6},
        }
    )
    sc = case.separation.body("sc")
    assert sc.mass == pytest.approx(100.0, rel=1e-12)
    assert sc.I_BBcm_B[:3] == pytest.approx([100.0 / 6.0] * 3, rel=1e-12)
    speed = drakesep.simulate(case).motion["relative_velocity_x_m_s"].iloc[-1]
    # Of a run at 1e-6.
    assert speed == pytest.approx(math.sqrt(40.0 * (1 / 100 + 1 / 2000)), abs=1e-6)
