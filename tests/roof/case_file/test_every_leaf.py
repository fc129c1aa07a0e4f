"""Every leaf of a case file arrives in its field, in SI, and is flown.

Three cases hold among them every key that there is, each number unlike all others and
unlike its default. What is wanted is written by hand, as the same model in Python:
nothing that reads case files or knows units is asked.
"""

import dataclasses
import itertools
import math
from collections.abc import Mapping

import numpy as np
import pytest
from every_leaf import MAIN, SOLIDS, STATE, TAKEN, write_models
from ruamel.yaml import YAML
from scipy.spatial.transform import Rotation

from drakesep.analysis.analysis_case import (
    AnalysisCase,
    ClearancePairs,
    PrintedResult,
    PublishedCase,
)
from drakesep.analysis.failure_cases import FailureCase
from drakesep.analysis.metrics.registry import registered_metrics
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.analysis.tolerances.correlations import RankCorrelation
from drakesep.analysis.tolerances.distributions import (
    Discrete,
    Lognormal,
    Normal,
    Table,
    Triangular,
    TruncatedNormal,
    Uniform,
)
from drakesep.analysis.tolerances.ellipsoid import Ellipsoid
from drakesep.analysis.tolerances.sides import Sides
from drakesep.case_file.attachments import SpringSection
from drakesep.case_file.case import Case
from drakesep.case_file.reader import load_case
from drakesep.case_file.section import Section
from drakesep.systems.checks import InputError
from drakesep.systems.equations.springs import PUSHERS
from drakesep.systems.model.connectors import Connector, Guide
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.loads import Load
from drakesep.systems.model.orbit import Orbit
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.parts import Box, Capsule, Cone, Mesh, Part, Sphere
from drakesep.systems.model.recontact import Recontact
from drakesep.systems.model.separation import (
    Attachment,
    Body,
    InitialMotion,
    Separation,
)
from drakesep.systems.model.springs import DisplacementSpring, Spring
from drakesep.systems.simulation.simulation import Simulation


DEG = math.pi / 180.0
ROUND_OFF = 4 * np.finfo(float).eps
"""Of a conversion, and of the decimals beside it; an angle takes two."""


def separation_of_main(folder) -> Separation:
    mm = 1e-3
    slack = Joint(K_F=0.0, D_F=0.0, K_T=0.0, D_T=0.0)
    plate = Part(
        name="plate",
        shape=Box(size=(0.211, 1.213, 1.411)),
        p_BoGo_B=(-1.901, 0.061, -0.071),
        rpy_BG=(1.25 * DEG, -2.25 * DEG, 3.25 * DEG),
        role="a plate",
    )
    ball = Part(
        name="ball", shape=Sphere(radius=0.151), p_BoGo_B=(-1.301, 0.901, 0.081)
    )
    rod = Part(
        name="rod",
        shape=Capsule(radius=0.053, length=0.257),
        p_BoGo_B=(-1.303, -0.903, 0.083),
        rpy_BG=(4.25 * DEG, 5.25 * DEG, -6.25 * DEG),
        role="antenna",
    )
    skirt = Part(
        name="skirt",
        shape=Cone(radius_aft=0.307, radius_fore=0.307, length=0.311, thickness=0.013),
        p_BoGo_B=(0.409, 0.017, -0.019),
        rpy_BG=(-1.75 * DEG, 2.75 * DEG, -3.75 * DEG),
    )
    nose = Part(
        name="nose",
        shape=Cone(radius_aft=0.317, radius_fore=0.109, length=0.503, thickness=0.003),
        p_BoGo_B=(1.709, 0.027, -0.029),
        role="nose",
    )
    block = Part(
        name="block",
        shape=Mesh(file=folder / "block.stl", scale=0.0023),
        p_BoGo_B=(2.309, 0.037, -0.039),
        rpy_BG=(-4.75 * DEG, 5.75 * DEG, 6.875 * DEG),
    )
    carrier = Body(
        name="carrier",
        mass=711.5,
        p_BoBcm_B=(-0.8015, 0.0515, -0.0315),
        I_BBcm_B=(301.5, 421.5, 381.5, 12.5, -15.5, 8.5),
        parts=(plate, ball, rod),
    )
    craft = Body(
        name="craft",
        mass=1213.5,
        p_BoBcm_B=(1.1015, -0.02075, 0.0415),
        I_BBcm_B=(501.5, 821.5, 781.5, -22.5, 25.5, 18.5),
        p_ABo=(11 * mm, -7 * mm, 5 * mm),
        rpy_AB=(7.25 * DEG, -8.25 * DEG, 9.25 * DEG),
        parts=(skirt, nose, block),
    )
    tail = Body(
        name="tail",
        mass=93.5,
        p_BoBcm_B=(-0.0135, 0.0035, 0.0025),
        I_BBcm_B=(9.625, 10.5, 11.5, 0.0, 0.0, 0.0),
        p_ABo=(-2.011, 0.207, -0.105),
    )
    hinge = Attachment(
        name="hinge",
        A="carrier",
        B="craft",
        p_AoPad_A=(0.023, 0.431, 0.2115),
        joint=Joint(
            type="cylindrical",
            K_F=(200001.0, 210001.0, 220001.0),
            D_F=(2001.0, 2101.0, 2201.0),
            K_T=(30001.0, 31001.0, 32001.0),
            D_T=(401.0, 411.0, 421.0),
            x_axis_A=(0.0, 0.28, 0.96),
            y_axis_A=(0.8, 0.576, -0.168),
        ),
        release_time=0.0625,
        release_angle=37.5 * DEG,
        release_travel=0.4185,
    )
    bolt = Attachment(
        name="bolt",
        A="carrier",
        B="craft",
        p_AoPad_A=(0.03, -0.433, 0.213),
        joint=Joint(type="spherical", K_F=230001.0, D_F=2301.0, K_T=33001.0, D_T=441.0),
        spring=Spring(
            name="timed",
            axis_A=(0.1234, 0.2345, 0.964252),
            force_max=1201.5,
            stroke=0.097,
            design_mass=107.5,
            tilt_y=1.625 * DEG,
            tilt_z=-2.625 * DEG,
            lost_stroke=0.0725,
        ),
        release_time=0.03125,
    )
    latch = Attachment(
        name="latch",
        A="carrier",
        B="craft",
        p_AoPad_A=(0.031, 0.0075, -0.439),
        joint=slack,
        spring=DisplacementSpring(
            name="wound",
            axis_A=(-0.3456, 0.4567, 0.819747),
            force_max=1303.5,
            stroke=0.089,
            damping=43.0,
            tilt_y=-3.625 * DEG,
            tilt_z=4.625 * DEG,
            lost_stroke=0.0825,
        ),
    )
    strap = Attachment(
        name="strap",
        A="tail",
        B="carrier",
        p_AoPad_A=(0.047, -0.0095, 0.103),
        joint=slack,
        spring=DisplacementSpring(
            name="measured",
            axis_A=(0.5678, -0.6789, 0.465508),
            force_max=411.5,
            stroke=0.059,
            damping=19.5,
            tilt_y=5.625 * DEG,
            tilt_z=-6.625 * DEG,
            lost_stroke=0.0925,
            profile=(
                (0.0, 307.5 / 411.5),
                (20.5 / 59.0, 1.0),
                (1.0, 101.75 / 411.5),
            ),
        ),
    )
    plug = Attachment(
        name="plug",
        A="carrier",
        B="craft",
        p_AoPad_A=(0.041, 0.0815, 0.305),
        joint=slack,
        spring=Connector(
            name="pin",
            axis_A=(0.6788, -0.1233, 0.723898),
            force_max=61.75,
            travel=0.0065,
            tilt_y=0.725 * DEG,
            tilt_z=-0.825 * DEG,
        ),
    )
    socket = Attachment(
        name="socket",
        A="carrier",
        B="craft",
        p_AoPad_A=(0.0465, 0.0835, 0.315),
        joint=slack,
        spring=Connector(
            name="seal",
            axis_A=(0.7895, -0.2346, 0.567144),
            force_max=71.25,
            travel=0.008875,
            profile=((0.0, 1.0), (3.4375 / 8.875, 31.25 / 71.25), (1.0, 11.25 / 71.25)),
            tilt_y=0.925 * DEG,
            tilt_z=-1.025 * DEG,
        ),
    )
    runner = Attachment(
        name="runner",
        A="carrier",
        B="craft",
        p_AoPad_A=(0.0485, 0.0855, 0.325),
        joint=slack,
        spring=Guide(
            name="rub",
            axis_A=(0.5555, -0.4444, 0.702769),
            force_max=17.375,
            travel=0.01925,
            tilt_y=1.375 * DEG,
            tilt_z=-1.4375 * DEG,
        ),
    )
    jet = Load(
        name="jet",
        body="craft",
        p_BoQ_B=(0.1035, 0.2075, -0.3095),
        times=(0.015, 0.215),
        forces=(
            (0.48 * 503.5, -0.6 * 503.5, 0.64 * 503.5),
            (0.48 * 907.5, -0.6 * 907.5, 0.64 * 907.5),
        ),
        start=0.045,
        after="latch",
    )
    gust = Load(
        name="gust",
        body="carrier",
        p_BoQ_B=(-0.1115, 0.2225, 0.3335),
        axes="world",
        times=(0.025, 0.325, 0.425),
        forces=((11.2, -12.2, 13.2), (14.2, 15.2, -16.2), (-17.2, 18.2, 19.2)),
        torques=((1.2, 2.2, -3.2), (-4.2, 5.2, 6.2), (7.2, -8.2, 9.2)),
        start=0.055,
    )
    return Separation(
        bodies=(carrier, craft, tail),
        attachments=(hinge, bolt, latch, strap, plug, socket, runner),
        A="carrier",
        B="craft",
        direction=(0.7891, 0.5123, 0.338925),
        loads=(jet, gust),
        initial=InitialMotion(
            rpy_WA=(21.5 * DEG, -30.5 * DEG, 40.5 * DEG),
            w_WA_A=(3.125 * DEG, -4.125 * DEG, 5.125 * DEG),
        ),
        orbit=Orbit(
            radius=6378137.0 + 613000.0,
            axes=local_axes(51.6875, 217.0625, 133.8125),
            frame="GCRF",
            epoch="2027-02-03T04:05:06.25",
            time_system="TAI",
        ),
        recontact=Recontact(
            stiffness=70001.0,
            face_stiffness=810001.0,
            dissipation=0.7125,
            friction=0.2125,
            without=(("rod", "block"), ("plate", "nose")),
        ),
        duration=0.59,
    )


def record_of_main(folder) -> AnalysisCase:
    return AnalysisCase(
        name="every_leaf",
        separation=separation_of_main(folder),
        integration=Integration(
            scheme="bogacki_shampine3",
            accuracy=3e-4,
            max_step=0.0175,
            time_limit=877.5,
        ),
        tolerances={
            "craft.mass": 33.25,
            "craft.cg_x": 0.00675,
            "craft.inertia_xy": 1.125,
            "timed.tilt_z": 0.375 * DEG,
            "hinge.release_angle": 0.875 * DEG,
            "before_separation.rate_y": 0.625 * DEG,
            "bolt.release_time": 0.0085,
            "jet.factor": 0.095,
            "craft.cg_y": Sides(minus=0.1023125, plus=0.2771875),
            "craft.cg_z": Sides(minus=0.002875, plus=0.007625),
            "carrier.mass": Normal(sigma=4.3125 / 2.375, within=4.3125),
            "carrier.cg_x": Uniform(
                extent=Sides(minus=0.811375 - 0.8015, plus=0.8015 - 0.790875),
                within=0.00196875,
            ),
            "carrier.cg_y": Triangular(extent=Sides(minus=0.00121875, plus=0.00246875)),
            "carrier.cg_z": Normal(sigma=0.00034375),
            "tail.mass": TruncatedNormal(sigma=1.03125, extent=2.09375),
            "wound.force_max": Lognormal(sigma=6.53125),
            "timed.force_max": Table(
                values=(1190.25, 1205.25, 1215.75), weights=(1.15625, 2.28125, 0.84375)
            ),
            "measured.force_max": Discrete(
                values=(405.125, 411.625), probabilities=(0.28125, 0.71875)
            ),
        },
        ellipsoids=(
            Ellipsoid(
                names=("craft.mass", "craft.cg_x", "jet.factor"),
                correlation=((1.0, 0.31, -0.21), (0.31, 1.0, 0.11), (-0.21, 0.11, 1.0)),
            ),
        ),
        correlations=(
            RankCorrelation(names=("wound.force_max", "timed.force_max"), rank=0.4375),
        ),
        requirements=(
            Requirement(metric="clearance_until_0.0875_m", sense=">=", limit=0.002125),
            *(
                Requirement(
                    metric=f"rate_after_separation_{axis}",
                    sense="<=",
                    limit=limit * DEG,
                )
                for axis, limit in zip("xyz", (64, 65, 66), strict=True)
            ),
            *(
                Requirement(
                    metric=f"deviation_at_separation_{axis}",
                    sense=">=",
                    limit=limit * DEG,
                )
                for axis, limit in (("roll", 0.165), ("pitch", 0.175), ("yaw", 0.185))
            ),
            *(
                Requirement(
                    metric=f"rate_at_0.4125_s_{axis}",
                    sense="<=",
                    limit=limit * DEG,
                    id="UM-1",
                    source="guide",
                )
                for axis, limit in (("x", 67), ("z", 68))
            ),
            Requirement(
                metric="rate_from_0.1725_to_0.5525_s_y", sense="<=", limit=69 * DEG
            ),
            Requirement(
                metric="bolt.joint_force",
                sense="<=",
                limit=90001.0,
                share=0.9825,
                confidence=0.8125,
                sides="two",
            ),
            Requirement(
                metric="clearance_to_carrier_until_0.0975_m", sense=">=", limit=0.003375
            ),
            Requirement(
                metric="clearance_of_ball+skirt_until_0.10625_m", sense=">", limit=0.0
            ),
            Requirement(
                metric="clearance_of_rod+nose_until_0.10625_m", sense=">", limit=0.0
            ),
        ),
        objectives="paper",
        clearance=ClearancePairs(
            pairs=(("plate", "skirt"), ("ball", "nose")),
            touching=(("rod", "block"), ("plate", "nose")),
        ),
        published=(
            PublishedCase(
                label="theirs",
                objectives=("L2", "PM"),
                values={
                    "craft.mass": 1213.5 + 33.25,
                    "craft.cg_x": 1.1015 - 0.00675,
                    "carrier.mass": 733.5,
                },
                printed=PrintedResult(
                    rate=(0.515 * DEG, 0.525 * DEG, 0.535 * DEG),
                    deviation_within_limits_until=0.305,
                    longitudinal_speed=0.405,
                    iterations=18,
                ),
            ),
        ),
        failure_cases=(
            FailureCase(
                name="worn",
                values={"craft.mass": 1213.5 + 33.25, "carrier.mass": 722.5},
            ),
        ),
        failure_probabilities={"worn": 0.015625},
    )


def local_axes(inclination, node, latitude):
    """Along the motion, against the angular momentum, and down, by rotations."""
    angles = [node, inclination, latitude]
    up, ahead, normal = Rotation.from_euler("ZXZ", angles, degrees=True).as_matrix().T
    return tuple(tuple(axis.tolist()) for axis in (ahead, -normal, -up))


def solids():
    """Mass, CG in m and moments of the bodies above, by the textbook."""

    def box(m, x, y, z):
        return [
            m * (y * y + z * z) / 12,
            m * (x * x + z * z) / 12,
            m * (x * x + y * y) / 12,
        ]

    # In the axes of arm, hull's origin is at (0, 0.5, 0) and hull is turned back by
    # 90 deg: its x moment is about y there. The CG divides the distance 3 to 1.
    both = 30.0 * 10.0 / 40.0 * 0.5**2
    yield (
        "base",
        40.0,
        (0.0, 0.375, 0.0),
        [1.0 + 4.0 + both, 1.5 + 3.0, 2.0 + 5.0 + both],
    )
    yield "brick", 210.0, (0.901, 0.031, -0.041), box(210.0, 1.3, 1.1, 1.7)
    m = 55.0 * math.pi * 0.45**2 * 2.1
    across = m * (3 * 0.45**2 + 2.1**2) / 12
    yield "drum", m, (0.003, 0.005, 0.007), [0.5 * m * 0.45**2, across, across]
    yield "orb", 65.0, (0.013, 0.017, 0.019), [0.4 * 65.0 * 0.35**2] * 3
    # turned by 90 deg about x: its z axis along -y
    a, b, c = 0.61**2, 0.42**2, 0.53**2
    egg = [15.0 * (b + c), 15.0 * (a + b), 15.0 * (a + c)]  # m / 5 = 15 kg
    yield "egg", 75.0, (0.023, 0.029, 0.037), egg
    r, length = 0.24, 0.92
    tube, ball = math.pi * r**2 * length, 4.0 / 3.0 * math.pi * r**3
    tube, ball = 85.0 * tube / (tube + ball), 85.0 * ball / (tube + ball)
    along = 0.5 * tube * r**2 + 0.4 * ball * r**2
    # Of a half ball the CG is 3 r / 8 from its flat side.
    across = tube * (3 * r**2 + length**2) / 12 + ball * (
        0.4 * r**2 + 0.25 * length**2 + 3.0 / 8.0 * r * length
    )
    yield "pill", 85.0, (0.043, 0.047, 0.053), [along, across, across]
    x, y, z = 0.0023 * 200, 0.0023 * 300, 0.0023 * 500
    m = 131.0 * x * y * z
    yield "slab", m, (0.059, 0.061, 0.067), box(m, z, y, x)  # z along x


@pytest.fixture
def folder(tmp_path):
    write_models(tmp_path)
    return tmp_path


def read(folder, text) -> Case:
    (folder / "case.yaml").write_text(text)
    return load_case(folder / "case.yaml")


def leaves(value, path=""):
    """Paths and leaves of records, mappings and sequences."""
    if dataclasses.is_dataclass(value):
        fields = [f.name for f in dataclasses.fields(value) if f.init]
        value = {name: getattr(value, name) for name in fields}
    if isinstance(value, Mapping):
        for key, entry in value.items():
            yield from leaves(entry, f"{path}.{key}")
    elif isinstance(value, (list, tuple)):
        yield f"{path}:length", len(value)
        for i, entry in enumerate(value):
            yield from leaves(entry, f"{path}[{i}]")
    else:
        yield path, value


def assert_same(got, expected):
    got, expected = dict(leaves(got)), dict(leaves(expected))
    assert got.keys() == expected.keys()
    for path, value in expected.items():
        if isinstance(value, float):
            absolute = ROUND_OFF if ".axes" in path else 0.0  # parts of unit vectors
            value = pytest.approx(value, rel=ROUND_OFF, abs=absolute)
        assert got[path] == value, path


_ALIASED = ("strap", "plug", "socket", "runner")
"""Attachments whose joint is that of another."""


def test_numbers_differ():
    """Else one that arrives in the place of another would not be seen."""
    data = YAML(typ="safe").load(MAIN)
    numbers = [
        abs(leaf)
        for path, leaf in leaves(data)
        if isinstance(leaf, int | float)
        and not path.endswith(":length")
        and ".ellipsoids" not in path  # a symmetric matrix
        # aliases
        and not any(f".{name}.joint" in path for name in _ALIASED)
        and leaf != 0
    ]
    assert len(numbers) > 200
    assert len(numbers) == len(set(numbers))


def test_every_number_arrives_in_si(folder):
    assert_same(read(folder, MAIN).in_si(), record_of_main(folder))


def test_the_model_built_in_python_flies_alike(folder):
    """Through everything that reads the records: what is not compared above is here."""
    got, expected = (
        # Contacts of all parts at every step take most of the time.
        Simulation(dataclasses.replace(c.separation, recontact=None), c.integration)
        for c in (read(folder, MAIN).in_si(), record_of_main(folder))
    )
    got, expected = got.run(), expected.run()
    assert expected.steps == got.steps > 50
    for field in dataclasses.fields(expected.motion):
        reference = getattr(expected.motion, field.name)
        # Round-off of the numbers above, which grows over the steps.
        assert getattr(got.motion, field.name) == pytest.approx(
            reference, rel=0.0, abs=1e-10 * max(1.0, np.abs(reference).max())
        )


def test_computed_bodies(folder):
    separation = read(folder, SOLIDS).separation
    wanted = list(solids())
    assert [name for name, *_ in wanted] == [body.name for body in separation.bodies]
    for name, mass, cg, moments in wanted:
        body = separation.body(name)
        # Angles of 90 deg, and the URDF's, are right to 1e-16 rad; STL has floats.
        assert body.mass == pytest.approx(mass, rel=1e-6), name
        assert body.p_BoBcm_B == pytest.approx(cg, rel=1e-6, abs=1e-9), name
        assert body.I_BBcm_B[:3] == pytest.approx(moments, rel=1e-6), name
        assert body.I_BBcm_B[3:] == pytest.approx([0.0] * 3, abs=1e-9), name


def test_orbits_by_their_ends_and_by_a_state(folder):
    """A quarter of the way up, the radius is the semi-latus rectum, p."""
    orbit = read(folder, SOLIDS).separation.orbit
    low, high = 6378137.0 + 211e3, 6378137.0 + 1013e3
    p, e = 2.0 * low * high / (low + high), (high - low) / (high + low)
    speed = math.sqrt(3.986004418e14 / p)
    assert orbit.radius == pytest.approx(p, rel=1e-14)
    assert orbit.horizontal_speed == pytest.approx(speed, rel=1e-14)
    assert orbit.climb_rate == pytest.approx(e * speed, rel=1e-13)
    assert_same(
        read(folder, STATE).separation.orbit,
        Orbit(
            radius=7e6,
            horizontal_speed=7500.0,
            climb_rate=1250.0,
            axes=((1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0)),
            frame="ICRF",
            epoch="2027-02-03T04:05:07.125",
        ),
    )


def test_a_state_from_a_table(folder):
    """The body's axes are the frame's; W's x axis is ahead, along the frame's y."""
    separation = read(folder, TAKEN).separation
    initial, orbit = separation.initial, separation.orbit
    assert initial.w_WA_A == pytest.approx((0.01, 0.02, 0.03), rel=ROUND_OFF)
    assert (orbit.frame, orbit.epoch) == ("ICRF", "2027-02-03T04:05:08.5")
    assert orbit.time_system == "TT"
    # The brick's CG is at (0.901, 0.031, -0.041) m in A, A's own at (0, 0.375, 0).
    origin = np.array([7.1e6 - 0.901, -0.031, 0.041])
    assert orbit.radius == pytest.approx(np.linalg.norm(origin), rel=ROUND_OFF)
    turning = np.cross([0.01, 0.02, 0.03], [0.901, 0.031 - 0.375, -0.041])
    speed = np.linalg.norm([0.0, 7.3e3, 0.0] - turning)
    assert orbit.speed == pytest.approx(speed, rel=1e-12)
    R_WA = Rotation.from_euler("xyz", initial.rpy_WA)
    # W's axes are beside the frame's by the slant of so short a way, 1e-6 rad.
    assert R_WA.apply([0.0, 1.0, 0.0]) == pytest.approx([1.0, 0.0, 0.0], abs=1e-5)
    assert R_WA.apply([1.0, 0.0, 0.0]) == pytest.approx([0.0, 0.0, -1.0], abs=1e-5)


def sections(base=Section):
    for section in base.__subclasses__():
        yield section
        yield from sections(section)


def keys_there_are():
    for section in sections():
        if not section.__module__.startswith("drakesep"):
            continue
        law = (
            section.model_fields["law"].default
            if issubclass(section, SpringSection)
            else ""
        )
        if issubclass(section, SpringSection) and (
            section is SpringSection or law not in PUSHERS
        ):
            continue  # the base of all, or a toy of another test
        for key in section.model_fields:
            yield section.__name__, law, key


def test_rigid_joint(folder):
    separation = read(folder, SOLIDS).separation
    assert [a.joint.rigid for a in separation.attachments] == [False] * 5 + [True]
    spins = {body.name: body.spin for body in separation.bodies if body.spin}
    assert spins == {"slab": pytest.approx(-7.25 * DEG, rel=ROUND_OFF)}


@pytest.mark.parametrize("gain", ["stiffness_N_m", "angular_damping_N_m_s_rad"])
def test_a_rigid_joint_has_no_gains_and_another_has_all(folder, gain):
    given = SOLIDS.replace("rigid: true}", f"rigid: true, {gain}: 0}}")
    with pytest.raises(InputError, match=f"{gain}: a rigid joint has none"):
        read(folder, given)
    missing = SOLIDS.replace(f"      {gain}: 0\n", "")
    with pytest.raises(InputError, match=f"{gain}: missing; a joint that is not rigid"):
        read(folder, missing)


def keys_used(section):
    """Keys of a section and those in it that stand there with a value of their own."""
    law = section.law if isinstance(section, SpringSection) else ""
    for key, field in type(section).model_fields.items():
        value = getattr(section, key)
        if value is None or (value == field.default and key != "law"):
            continue
        yield type(section).__name__, law, key
        entries = [value]
        if isinstance(value, dict):
            entries = list(value.values())
        elif isinstance(value, (list, tuple)):
            entries = list(value)
        for entry in entries:
            if isinstance(entry, Section):
                yield from keys_used(entry)


def test_no_key_is_left_out(folder):
    """A new key has to be given a value here, and what comes of it."""
    used = set()
    for text in (MAIN, SOLIDS, STATE, TAKEN):
        used |= set(keys_used(read(folder, text)))
    assert set(keys_there_are()) - used == set()


UNITS = {"mass": ("kg", 1.0), "cg": ("mm", 1e-3), "inertia": ("kg_m2", 1.0)}
UNITS |= {"position": ("mm", 1e-3), "release_time": ("s", 1.0)}
UNITS |= {"release_travel": ("mm", 1e-3), "release_angle": ("deg", DEG)}
UNITS |= {"force_max": ("N", 1.0)}
UNITS |= {"stroke": ("mm", 1e-3), "tilt": ("deg", DEG), "design_mass": ("kg", 1.0)}
UNITS |= {"damping": ("N_s_m", 1.0), "start": ("s", 1.0), "factor": ("", 1.0)}
UNITS |= {
    "lost_stroke": ("", 1.0),
    "travel": ("mm", 1e-3),
    "attitude": ("deg", DEG),
    "rate": ("deg_s", DEG),
}
UNITS |= {"mated_offset": ("mm", 1e-3), "mated_misalignment": ("deg", DEG)}
BODY = [
    ("mass", [""]),
    ("cg", "xyz"),
    ("inertia", ["xx", "yy", "zz", "xy", "xz", "yz"]),
]
SITTING = [("mated_offset", "xyz"), ("mated_misalignment", ["roll", "pitch", "yaw"])]
TILTS, LOST = ("tilt", "yz"), ("lost_stroke", [""])
TIMED = [("position", "xyz"), ("release_time", [""])]
LOAD = [("position", "xyz"), ("start", [""]), ("factor", [""])]
PART = [("position", "xyz"), ("attitude", ["roll", "pitch", "yaw"])]
WOUND = [("force_max", [""]), ("stroke", [""]), ("damping", [""]), TILTS, LOST]
RESISTING = [("force_max", [""]), ("travel", [""]), TILTS]
PARAMETERS = {
    "carrier": BODY,  # in whose frame the stack is placed
    **dict.fromkeys(("craft", "tail"), BODY + SITTING),
    "hinge": [
        ("position", "xyz"),
        ("release_time", [""]),
        ("release_angle", [""]),
        ("release_travel", [""]),
    ],
    **dict.fromkeys(("bolt", "latch", "strap"), TIMED),
    **dict.fromkeys(("plug", "socket", "runner"), TIMED),
    **dict.fromkeys(("pin", "seal", "rub"), RESISTING),
    "timed": [
        ("force_max", [""]),
        ("stroke", [""]),
        TILTS,
        ("design_mass", [""]),
        LOST,
    ],
    **dict.fromkeys(("wound", "measured"), WOUND),
    **dict.fromkeys(("jet", "gust"), LOAD),
    **dict.fromkeys(("plate", "ball", "rod", "skirt", "nose", "block"), PART),
    "before_separation": [("attitude", ["roll", "pitch", "yaw"]), ("rate", "xyz")],
}
"""Of each owner in MAIN, what may be set and dispersed."""


def test_every_parameter_by_its_name_with_unit(folder):
    """As --set, dispersions and tables have them."""
    case = read(folder, MAIN)
    given, expected = {}, {}
    number = itertools.count(1)
    for owner, quantities in PARAMETERS.items():
        for stem, axes in quantities:
            unit, si = UNITS[stem]
            for axis in axes:
                name = "_".join(filter(None, [f"{owner}.{stem}", axis]))
                value = 1.0 + next(number)
                given["_".join(filter(None, [name, unit]))] = value
                expected[name] = si * value
    assert set(expected) == set(parameters(case.separation))
    assert case.values_in_si(given) == pytest.approx(expected, rel=ROUND_OFF)


LIMITED = {
    "rate_after_separation_deg_s": ("xyz", DEG),
    "deviation_at_separation_deg": (("roll", "pitch", "yaw"), DEG),
    "longitudinal_speed_after_separation_m_s": ("", 1.0),
    "clearance_mm": ("", 1e-3),
    "G_L1_deg": ("", DEG),
    "G_L2_deg_per_sqrt_s": ("", DEG),
    "G_Linf_deg_s": ("", DEG),
    "G_PM_m_s": ("", 1.0),
    "final_rate_deg_s": ("xyz", DEG),
    "rate_min_after_separation_deg_s": ("xyz", DEG),
    "rate_max_after_separation_deg_s": ("xyz", DEG),
    "rate_magnitude_min_after_separation_deg_s": ("xyz", DEG),
    "angle_at_separation_deg": (("roll", "pitch", "yaw"), DEG),
    "deviation_within_limits_until_s": ("", 1.0),
    "longitudinal_speed_max_m_s": ("", 1.0),
    "longitudinal_speed_max_after_separation_m_s": ("", 1.0),
    "separation_end_s": ("", 1.0),
}
"""What a requirement may be on: its axes, and its unit in SI."""


@pytest.mark.parametrize(("key", "sense"), [("at_most", "<="), ("at_least", ">=")])
def test_every_quantity_of_a_requirement(folder, key, sense):
    number = itertools.count(2)
    sections, expected = [], []
    for quantity, (axes, si) in LIMITED.items():
        if quantity == "clearance_mm" and key == "at_most":
            continue  # no clearance is too large
        values = [float(next(number)) for _ in axes or [""]]
        sections.append({"quantity": quantity, key: values if axes else values[0]})
        stem = quantity
        for suffix in ("_deg_per_sqrt_s", "_deg_s", "_deg", "_m_s", "_mm", "_s"):
            if quantity.endswith(suffix):
                stem = quantity.removesuffix(suffix)
                break
        names = [f"{stem}_{axis}" for axis in axes] or [stem]
        expected += [(n, sense, si * v) for n, v in zip(names, values, strict=True)]
    # Time within limits needs some, which come last.
    within = {"quantity": "deviation_at_separation_deg", "at_most": [1.0, 1.0, 1.0]}
    limited = [*sections, within | {"id": "needed"}]
    limits = read(folder, MAIN).replaced(requirements=limited).limits[:-3]
    got = [(r.metric, r.sense, pytest.approx(r.limit, rel=ROUND_OFF)) for r in limits]
    assert got == expected
    stems = {m.stem for m in registered_metrics()}
    assert len(LIMITED) == len(stems)
