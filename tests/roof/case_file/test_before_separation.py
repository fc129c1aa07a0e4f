"""The stack's motion and orbit, taken from files of a trajectory simulation.

What is wanted is computed by hand, by scipy's rotations, or is what was handed out.
"""

import math
import os

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation
from small_case import small_case, write_case

import drakesep
from drakesep.exchange.aem import attitudes_of
from drakesep.exchange.kvn import read_message
from drakesep.exchange.oem import ephemeris_of


AT = "2026-03-01T12:00:10.5"
Q = np.array([0.36, 0.48, -0.64, 0.48])
"""Of A in EME2000, w first."""
RATE = [0.5, -0.4, 0.3]
"""deg/s, in A."""
POSITION = [-6045.0, -3490.0, 2500.0]
"""km."""
VELOCITY = [-3.457, 6.618, 2.533]
"""km/s."""
OEM = """CCSDS_OEM_VERS = 2.0
COMMENT by hand
CREATION_DATE = 2026-01-01T00:00:00
ORIGINATOR = TRAJ

META_START
OBJECT_NAME = STACK
OBJECT_ID = 2026-001A
CENTER_NAME = EARTH
REF_FRAME = EME2000
TIME_SYSTEM = UTC
START_TIME = 2026-03-01T12:00:00.5
STOP_TIME = 2026-03-01T12:00:20.5
META_STOP
2026-03-01T12:00:00.5 -6010.3 -3556.1 2474.6 -3.49 6.6 2.55
2026-03-01T12:00:10.500 -6045.0 -3490.0 2500.0 -3.457 6.618 2.533 0.001 0.002 0.003
2026-060T12:00:20.5Z -6079.4 -3423.7 2525.2 -3.42 6.64 2.51
COVARIANCE_START
EPOCH = 2026-03-01T12:00:10.5
1.0
COVARIANCE_STOP
"""
AEM = """CCSDS_AEM_VERS = 2.0
CREATION_DATE = 2026-01-01T00:00:00
ORIGINATOR = TRAJ
META_START
COMMENT by hand
OBJECT_NAME = STACK
OBJECT_ID = 2026-001A
REF_FRAME_A = EME2000
REF_FRAME_B = SC_BODY_1
TIME_SYSTEM = UTC
START_TIME = 2026-03-01T12:00:00.5
STOP_TIME = 2026-03-01T12:00:10.5
ATTITUDE_TYPE = QUATERNION/ANGVEL
ANGVEL_FRAME = SC_BODY_1
META_STOP
DATA_START
2026-03-01T12:00:00.5 0 0 0 1 0 0 0
2026-03-01T12:00:10.5 0.48 -0.64 0.48 0.36 0.5 -0.4 0.3
DATA_STOP
"""
PLANE = {
    "altitude_km": 700.0,
    "inclination_deg": 98.0,
    "ascending_node_deg": 40.0,
    "argument_of_latitude_deg": 75.0,
    "frame": "EME2000",
    "epoch": AT,
}


@pytest.fixture
def files(tmp_path):
    (tmp_path / "traj.oem").write_text(OEM)
    (tmp_path / "traj.aem").write_text(AEM)
    return tmp_path


def case_from(folder, *names, orbit=None, **more):
    before = {"from": [*names] if len(names) > 1 else names[0], "at": AT, **more}
    data = small_case(before_separation=before, orbit=orbit, published=None)
    return drakesep.load_case(write_case(folder, data))


def state_of(separation, point):
    """Of a point fixed in the stack, and its attitude, in the frame at t = 0."""
    orbit, initial = separation.orbit, separation.initial
    R_FW = np.array(orbit.axes).T
    R_WA = Rotation.from_euler("xyz", initial.rpy_WA)
    p_AcmPoint = np.subtract(point, separation.body("lower").p_BoBcm_B)
    _, r, across, climb = orbit.start
    turning = np.cross(initial.w_WA_A, p_AcmPoint)
    in_W = np.add([0.0, 0.0, -r], R_WA.apply(point))
    moving = np.add([across, 0.0, -climb], R_WA.apply(turning))
    return R_FW @ in_W, R_FW @ moving, Rotation.from_matrix(R_FW) * R_WA


def stack_cg(separation):
    bodies = separation.bodies
    return np.average(
        [body.p_BoBcm_B for body in bodies], axis=0, weights=[b.mass for b in bodies]
    )


@pytest.mark.parametrize("of", [None, "lower", "upper"])
def test_orbit_and_attitude(of, files):
    """The state is that of the stack's CG, or of a body's, to 1e-12."""
    names = ["traj.aem", "traj.oem"]
    case = case_from(files, *names, **({} if of is None else {"of": of}))
    separation = case.separation
    point = stack_cg(separation) if of is None else separation.body(of).p_BoBcm_B
    r, v, R_FA = state_of(separation, point)
    assert np.linalg.norm(r - 1e3 * np.array(POSITION)) <= 1e-12 * 7.4e6
    assert np.linalg.norm(v - 1e3 * np.array(VELOCITY)) <= 1e-12 * 7.9e3
    assert (R_FA * Rotation.from_quat(Q, scalar_first=True).inv()).magnitude() < 1e-14
    assert separation.initial.w_WA_A == pytest.approx(np.radians(RATE), rel=4e-16)
    orbit = separation.orbit
    assert (orbit.frame, orbit.time_system, orbit.epoch) == ("EME2000", "UTC", AT)
    assert {file.name for file in case.files} == set(names)


def test_attitude_on_an_orbit_of_the_case(files):
    case = case_from(files, "traj.aem", orbit=PLANE)
    R_FW = np.array(case.separation.orbit.axes).T
    R_FA = Rotation.from_quat(Q, scalar_first=True).as_matrix()
    wanted = Rotation.from_matrix(R_FW.T @ R_FA).as_euler("ZYX")[::-1]
    assert case.separation.initial.rpy_WA == pytest.approx(wanted, abs=1e-14)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_attitudes_on_end(axis, files):
    """A's x axis along W's z, where roll and yaw are one."""
    R_FW = np.array(case_from(files, "traj.aem", orbit=PLANE).separation.orbit.axes).T
    on_end = Rotation.from_euler("ZYX", [20.0, -90.0, 0.0], degrees=True)
    if axis == "y":
        on_end = Rotation.from_euler("ZYX", [20.0, 90.0 - 1e-7, 30.0], degrees=True)
    x, y, z, w = (Rotation.from_matrix(R_FW) * on_end).as_quat()
    line = f"{AT} {x!r} {y!r} {z!r} {w!r} 0.5 -0.4 0.3".replace("np.float64", "")
    line = line.replace("(", "").replace(")", "")
    text = AEM.replace(AEM.splitlines()[-2], line)
    (files / "traj.aem").write_text(text)
    rpy = case_from(files, "traj.aem", orbit=PLANE).separation.initial.rpy_WA
    off = Rotation.from_euler("xyz", rpy) * on_end.inv()
    # Round-off over the cosine of the pitch, 2e-9, of the last.
    assert off.magnitude() <= 1e-7


def test_quaternions_of_the_first_version(files):
    """A2B or B2A, scalar first or last, without a rate: that is given then."""
    base = AEM.replace("VERS = 2.0", "VERS = 1.0").replace("/ANGVEL", "")
    base = base.replace("ANGVEL_FRAME = SC_BODY_1", "ATTITUDE_DIR = A2B\nTYPE")
    wanted = case_from(files, "traj.aem", orbit=PLANE).separation.initial
    for direction, kind, numbers in (
        ("A2B", "LAST", "0.48 -0.64 0.48 0.36"),
        ("A2B", "FIRST", "0.36 0.48 -0.64 0.48"),
        ("B2A", "LAST", "-0.48 0.64 -0.48 0.36"),
        ("B2A", "FIRST", "0.36 -0.48 0.64 -0.48"),
    ):
        text = base.replace("A2B", direction).replace(
            "TYPE\n", f"QUATERNION_TYPE = {kind}\n"
        )
        text = text.replace("0.48 -0.64 0.48 0.36 0.5 -0.4 0.3", numbers)
        text = text.replace("0 0 0 1 0 0 0", "0 0 0 1" if kind == "LAST" else "1 0 0 0")
        (files / "traj.aem").write_text(text)
        got = case_from(files, "traj.aem", orbit=PLANE, rate_deg_s=RATE)
        assert got.separation.initial.rpy_WA == pytest.approx(wanted.rpy_WA, abs=1e-15)
        assert got.separation.initial.w_WA_A == wanted.w_WA_A


def test_rates_in_the_inertial_frame(files):
    in_F = Rotation.from_quat(Q, scalar_first=True).apply(RATE)
    text = AEM.replace("ANGVEL_FRAME = SC_BODY_1", "ANGVEL_FRAME = EME2000")
    numbers = " ".join(f"{x:.17g}" for x in in_F)
    (files / "traj.aem").write_text(text.replace("0.5 -0.4 0.3", numbers))
    got = case_from(files, "traj.aem", orbit=PLANE).separation.initial.w_WA_A
    assert got == pytest.approx(np.radians(RATE), rel=1e-14)


def test_out_and_in_again(files, tmp_path, monkeypatch):
    """What is handed over at t = 0 is what was taken: a round trip, to 1e-12."""
    monkeypatch.setattr("drakesep.plots.motion.save_motion", lambda *_, **__: None)
    case = case_from(files, "traj.aem", "traj.oem", of="lower")
    drakesep.simulate(case, output=tmp_path / "out")
    drakesep.export(tmp_path / "out", "oem", output=tmp_path / "handed")
    drakesep.export(tmp_path / "out", "aem", output=tmp_path / "handed")
    orbit = ephemeris_of(read_message(tmp_path / "handed" / "nominal_lower.oem"))
    off = orbit.position[0] - 1e3 * np.array(POSITION)
    assert np.linalg.norm(off) <= 1e-12 * 7.4e6
    off = orbit.velocity[0] - 1e3 * np.array(VELOCITY)
    assert np.linalg.norm(off) <= 1e-12 * 7.9e3
    turned = attitudes_of(read_message(tmp_path / "handed" / "nominal_lower.aem"))
    assert abs(turned.orientation[0] @ Q) == pytest.approx(1.0, abs=1e-15)
    assert turned.rate[0] == pytest.approx(np.radians(RATE), rel=1e-14)


def test_a_stage_goes_on_from_a_handover(files, tmp_path, monkeypatch):
    """One separation hands over to the next: the body is the stack now."""
    monkeypatch.setattr("drakesep.plots.motion.save_motion", lambda *_, **__: None)
    drakesep.simulate(
        case_from(files, "traj.aem", "traj.oem"), output=tmp_path / "first"
    )
    drakesep.export(tmp_path / "first", "csv", output=tmp_path)
    table = pd.read_csv(tmp_path / "handover.csv").set_index("body")
    lower = table.loc["lower"]
    before = {
        **{"from": "handover.csv", "at": lower["epoch"], "of": "lower"},
        **{"run": "nominal", "body": "lower"},
    }
    data = small_case(before_separation=before, published=None)
    separation = drakesep.load_case(write_case(tmp_path, data)).separation
    r, v, R_FA = state_of(separation, separation.body("lower").p_BoBcm_B)
    position = lower[[f"position_{a}_m" for a in "xyz"]].to_numpy(float)
    velocity = lower[[f"velocity_{a}_m_s" for a in "xyz"]].to_numpy(float)
    assert np.linalg.norm(r - position) <= 1e-12 * 7.4e6
    assert np.linalg.norm(v - velocity) <= 1e-12 * 7.9e3
    q = lower[[f"orientation_{x}" for x in "wxyz"]].to_numpy(float)
    assert (R_FA * Rotation.from_quat(q, scalar_first=True).inv()).magnitude() < 1e-14
    del before["body"]
    data = small_case(before_separation=before, published=None)
    with pytest.raises(drakesep.InputError, match="run and body must choose one row"):
        drakesep.load_case(write_case(tmp_path, data))


def test_a_study_knows_what_its_case_was_taken_from(files, tmp_path, monkeypatch):
    """By hashes; and the case as a text is read again."""
    monkeypatch.setattr("drakesep.plots.motion.save_motion", lambda *_, **__: None)
    case = case_from(files, "traj.aem", "traj.oem")
    again = case.replaced(description="changed in Python")
    assert "from_" not in again.text
    assert "from:" in again.text
    (tmp_path / "again.yaml").write_text(again.text)
    read = drakesep.load_case(tmp_path / "again.yaml")
    assert read.separation == case.separation
    drakesep.simulate(case, output=tmp_path / "out")
    record = drakesep.read_results(tmp_path / "out").record
    assert set(record.named_files) == {str(files / f"traj.{x}") for x in ("aem", "oem")}
    assert drakesep.read_results(tmp_path / "out").case.separation == case.separation


OTHERS = [
    (["traj.oem"], {}, {}, "from: must have an attitude, got .*traj.oem"),
    (["traj.aem"], {}, {}, "orbit: must say how it lies in the frame of the files"),
    (["traj.aem", "traj.oem"], {"orbit": PLANE}, {}, "orbit: must be left out"),
    (["traj.aem", "traj.aem"], {}, {}, "from: one file must have the orientation"),
    (["none.aem"], {}, {}, "none.aem: must be an OEM or an AEM, got: No such file"),
    (["traj.aem", "traj.oem"], {}, {"of": "midle"}, "of: unknown body 'midle'"),
    (["traj.aem"], {"orbit": PLANE}, {"run": "nominal"}, "must stand with a CSV file"),
    (
        ["traj.aem"],
        {"orbit": PLANE},
        {"rate_deg_s": RATE},
        "must not stand",
    ),
    (
        ["traj.aem"],
        {"orbit": PLANE},
        {"attitude_deg": [0.0, 0.0, 0.0]},
        "attitude_deg must not stand with 'from'",
    ),
    (
        ["traj.aem", "traj.oem"],
        {},
        {"at": "2026-03-01T12:00:10.4"},
        r"at: must be an epoch of .*traj.aem, of which the nearest is 2026-03-01T",
    ),
    (
        ["traj.aem"],
        {"orbit": PLANE | {"frame": "GCRF"}},
        {},
        "orbit: must be in EME2000 at 2026-03-01T12:00:10.5 UTC, as the files are",
    ),
    (
        ["traj.aem"],
        {"orbit": PLANE | {"epoch": "2026-03-01T12:00:00"}},
        {},
        "orbit: must be in EME2000 at 2026-03-01T12:00:10.5 UTC, as the files are",
    ),
]


@pytest.mark.parametrize(("names", "orbit", "more", "message"), OTHERS)
def test_what_does_not_fit(names, orbit, more, message, files):
    with pytest.raises(drakesep.InputError, match=message) as caught:
        case_from(files, *names, **orbit, **more)
    assert "before_separation: " in str(caught.value)


@pytest.mark.parametrize(
    ("file", "old", "new", "message"),
    [
        ("oem", "EME2000", "ITRF2000", "REF_FRAME must be an inertial frame"),
        ("oem", "= EARTH", "= MOON", "CENTER_NAME must be EARTH, got MOON"),
        (
            "oem",
            "= UTC",
            "= TAI",
            "from: files must have one time_system, got UTC and TAI",
        ),
        ("oem", "= UTC", "= UT1", "TIME_SYSTEM must be one of UTC, TAI, .*got 'UT1'"),
        ("aem", "= UTC", "= SCLK", "TIME_SYSTEM must be one of UTC, TAI"),
        ("oem", "COVARIANCE_STOP\n", "", "COVARIANCE_STOP, got the end of the message"),
        ("oem", "COVARIANCE_START\n", "", "COVARIANCE_STOP must follow its START"),
        ("oem", "META_STOP\n", "", "a line of metadata must be a key, = and its"),
        (
            "aem",
            "META_STOP\n",
            "",
            "META_START must be followed by META_STOP, got",
        ),
        ("aem", "DATA_STOP\n", "", "DATA_STOP, got the end of the message"),
        ("oem", "12:00:00.5 ", "23:59:60.0 ", "must not be within a leap second"),
        ("oem", "6.618 2.533", "", "a line of data must be an epoch and 6 numbers"),
        ("oem", "6.618", "six", "a line of data must be an epoch and 6 numbers"),
        ("oem", "6.618", "nan", "an epoch and 6 numbers, all finite"),
        ("oem", "-3.457 6.618 2.533", "1e300 0 0", "orbit: must be an ellipse"),
        ("aem", "0.5 -0.4 0.3", "0.5 -0.4 inf", "an epoch and 7 numbers, all finite"),
        ("aem", "ATTITUDE_TYPE", "ATTITUDE_DIR = A TO B\nATTITUDE_TYPE", "DIR must be"),
        ("aem", "ATTITUDE_TYPE", "QUATERNION_TYPE = W\nATTITUDE_TYPE", "must be LAST"),
        ("oem", "CCSDS_OEM_VERS = 2.0", "", "must begin with CCSDS_OEM_VERS or"),
        ("oem", "CCSDS_OEM", "CCSDS_TDM", "must be an OEM or an AEM, got TDM"),
        ("oem", "REF_FRAME = EME2000\n", "", "REF_FRAME must be one, got None"),
        ("oem", "12:00:00.5 ", "12:00:00,5 ", "an epoch must be an epoch such as"),
        ("oem", "-3.457 6.618 2.533", "0 0 0", "orbit: must be an ellipse"),
        ("oem", "-3.457 6.618 2.533", "-9 9 9", "orbit: must be an ellipse"),
        ("aem", "0.48 0.36 0.5", "0.48 0.30 0.5", "quaternions must be of length 1"),
        ("aem", "/ANGVEL", "/DERIVATIVE", "ATTITUDE_TYPE must be QUATERNION or"),
        ("aem", "ANGVEL_FRAME = SC_BODY_1", "ANGVEL_FRAME = LVLH", "ANGVEL_FRAME must"),
        (
            "aem",
            "REF_FRAME_A = EME2000",
            "REF_FRAME_A = LVLH",
            "REF_FRAME_A must be an",
        ),
    ],
)
def test_faulty_files(file, old, new, message, files):
    path = files / f"traj.{file}"
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(drakesep.InputError, match=message):
        case_from(files, "traj.aem", "traj.oem")


def test_a_manoeuvre_between_segments_is_not_chosen_from(files):
    """Both have its epoch: the state before it, and the one after it."""
    segment = OEM[OEM.index("META_START") :]
    path = files / "traj.oem"
    path.write_text(OEM + segment)
    assert case_from(files, "traj.aem", "traj.oem").separation.orbit is not None
    path.write_text(OEM + segment.replace("6.618", "6.619"))
    with pytest.raises(drakesep.InputError, match=r"must have one state at .*, got 2"):
        case_from(files, "traj.aem", "traj.oem")


def test_an_attitude_is_the_same_by_both_of_its_quaternions(files):
    segment = AEM[AEM.index("META_START") :]
    row = "0.48 -0.64 0.48 0.36 0.5"
    assert row in segment
    other = segment.replace(row, "-0.48 0.64 -0.48 -0.36 0.5")
    expected = case_from(files, "traj.aem", "traj.oem").separation.initial
    (files / "traj.aem").write_text(AEM + other)
    initial = case_from(files, "traj.aem", "traj.oem").separation.initial
    np.testing.assert_allclose(initial.rpy_WA, expected.rpy_WA, atol=1e-14)  # round-off


@pytest.mark.parametrize(
    ("column", "value", "message"),
    [
        ("orientation_w", "", "orientation_w must be a finite number, got ''"),
        ("orientation_w", "3", "quaternions must be of length 1"),
        ("position_x_m", "inf", "position_x_m must be a finite number, got 'inf'"),
        ("rate_z_rad_s", "slow", "rate_z_rad_s must be a finite number, got 'slow'"),
        ("time_system", "", "time_system must be one of UTC, TAI, TT, GPS, TDB"),
        ("time_system", "LOCAL", "time_system must be one of UTC, .*got 'LOCAL'"),
    ],
)
def test_faulty_tables(column, value, message, tmp_path):
    row = {
        **{"label": "1", "body": "NA", "epoch": AT},
        **{"time_system": "UTC", "frame": "EME2000"},
        **{f"position_{x}_m": 7e6 if x == "x" else 0 for x in "xyz"},
        **{f"velocity_{x}_m_s": 7500 if x == "y" else 0 for x in "xyz"},
        **{f"orientation_{q}": 1 if q == "w" else 0 for q in "wxyz"},
        **{f"rate_{x}_rad_s": 0 for x in "xyz"},
    }
    assert column in row
    labels = {"run": "1", "body": "NA"}
    table = tmp_path / "handover.csv"
    pd.DataFrame([row]).to_csv(table, index=False)
    assert case_from(tmp_path, "handover.csv", **labels).separation.orbit
    pd.DataFrame([row | {column: value}]).to_csv(table, index=False)
    with pytest.raises(drakesep.InputError, match=message):
        case_from(tmp_path, "handover.csv", **labels)


@pytest.mark.parametrize("at", ["9999-12-31T23:59:59", "0001-01-01T00:00:00"])
def test_epochs_beyond_all_dates(at, files):
    with pytest.raises(drakesep.InputError, match="at must be an epoch such as"):
        case_from(files, "traj.aem", "traj.oem", at=at)


@pytest.mark.parametrize("name", ["pipe", "pipe.csv", "folder", "/dev/zero"])
def test_what_does_not_end_is_not_read(name, tmp_path):
    """A pipe waits for a writer that never comes; a device has no end."""
    if name.startswith("pipe"):
        os.mkfifo(tmp_path / name)
    elif name == "folder":
        (tmp_path / name).mkdir()
    with pytest.raises(drakesep.InputError, match=r"must be a file, got a folder, a p"):
        case_from(tmp_path, name)


@pytest.mark.parametrize("name", ["large.oem", "large.csv"])
def test_what_is_far_too_large_is_not_read(name, tmp_path):
    with (tmp_path / name).open("wb") as file:
        file.truncate(100_000_001)  # with no byte on the disk
    with pytest.raises(drakesep.InputError, match="must be at most 100 MB"):
        case_from(tmp_path, name)


def test_no_file_at_all(tmp_path):
    data = small_case(before_separation={"from": [], "at": AT}, published=None)
    with pytest.raises(drakesep.InputError, match="at least 1 item"):
        drakesep.load_case(write_case(tmp_path, data))


@pytest.mark.parametrize(
    ("orbit", "message"),
    [
        ({}, "must have one of altitude_km, perigee_altitude_km, position_km"),
        ({"perigee_altitude_km": 200.0}, "apogee_altitude_km must stand together"),
        (
            {"perigee_altitude_km": 300.0, "apogee_altitude_km": 200.0},
            "perigee_altitude_km must not be above apogee_altitude_km",
        ),
        (
            {"perigee_altitude_km": -6400.0, "apogee_altitude_km": 200.0},
            "nor below the centre of the Earth",
        ),
        (
            {"altitude_km": 700.0, "true_anomaly_deg": 3.0},
            "must stand with perigee",
        ),
        ({"altitude_km": 700.0, "inclination_deg": 3.0}, "must stand together"),
        ({"altitude_km": 700.0, "frame": "EME2000"}, "frame must stand with"),
        (PLANE | {"frame": None}, "must have 'frame'"),
        (PLANE | {"epoch": None}, "must have 'epoch'"),
        (PLANE | {"epoch": "noon"}, "epoch must be an epoch such as"),
        (PLANE | {"time_system": "GMT"}, "orbit.time_system: must be"),
        ({"position_km": POSITION}, "velocity_km_s must stand together"),
    ],
)
def test_faulty_orbits(orbit, message, tmp_path):
    given = {key: value for key, value in orbit.items() if value is not None}
    with pytest.raises(drakesep.InputError, match=message):
        drakesep.load_case(write_case(tmp_path, small_case(orbit=given)))


def test_perigee_and_apogee(tmp_path):
    """By vis viva, and from the perigee to the apogee in half a period."""
    ends = {"perigee_altitude_km": 200.0, "apogee_altitude_km": 35_786.0}
    earth, mu = 6378137.0, 3.986004418e14
    low, high = earth + 200e3, earth + 35_786e3
    for anomaly, radius in ((0.0, low), (180.0, high)):
        given = {"true_anomaly_deg": anomaly, **ends}
        data = small_case(orbit=given, published=None)
        orbit = drakesep.load_case(write_case(tmp_path, data)).separation.orbit
        assert orbit.radius == pytest.approx(radius, rel=1e-14)
        speed = math.sqrt(mu * (2.0 / radius - 2.0 / (low + high)))
        assert orbit.speed == pytest.approx(speed, rel=1e-14)
        assert abs(orbit.climb_rate) < 1e-9
        assert orbit.eccentricity == pytest.approx(
            (high - low) / (high + low), rel=1e-12
        )
