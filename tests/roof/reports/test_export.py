"""What is handed over is what was flown: read back by other programs' libraries.

The orbit is added by hand, from a two-body integration, and attitudes by scipy.
"""

import hashlib
import json
import math
import sys
from decimal import Decimal

import ccsds_ndm
import numpy as np
import pandas as pd
import pytest
import scipy.io
from command_line import run
from scipy.spatial.transform import Rotation
from small_case import small_case, write_case
from two_bodies import two_bodies

import drakesep
from drakesep.exchange.epochs import epoch_text, parse_epoch
from drakesep.results.campaign_files import DRAWS


EPOCH = "2026-02-28T23:59:59.75"
ORBIT = {
    "perigee_altitude_km": 300.0,
    "apogee_altitude_km": 2500.0,
    "true_anomaly_deg": 100.0,
    "inclination_deg": 51.6,
    "ascending_node_deg": 250.0,
    "argument_of_latitude_deg": 140.0,
    "frame": "EME2000",
    "epoch": EPOCH,
    "time_system": "TAI",
}


@pytest.fixture(autouse=True, scope="module")
def nothing_drawn():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("drakesep.plots.motion.save_motion", lambda *_, **__: None)
        yield


def flown_in(home, orbit):
    data = small_case(orbit=orbit, published=None)
    drakesep.simulate(write_case(home, data), output=home / "out")
    return home / "out"


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """The small case on an ellipse."""
    return flown_in(tmp_path_factory.mktemp("flown"), ORBIT)


@pytest.fixture(scope="module")
def without_plane(tmp_path_factory):
    """On a circle of which nobody knows how it lies."""
    return flown_in(tmp_path_factory.mktemp("circle"), {"altitude_km": 622.0})


@pytest.fixture(scope="module")
def wanted(flown):
    """Time, and of each body position, velocity, orientation and rate.

    From the motion in W and the orbit's elements, by the textbook.
    """
    results = drakesep.read_results(flown)
    trajectory = results.run("nominal").run.completed_trajectory
    mu, earth = 3.986004418e14, 6378137.0
    low, high = (earth + 1e3 * ORBIT[f"{n}_altitude_km"] for n in ("perigee", "apogee"))
    e, anomaly = (high - low) / (high + low), math.radians(100.0)
    p = low * (1.0 + e)
    turn = Rotation.from_euler("ZXZ", [250.0, 51.6, 140.0 - 100.0], degrees=True)
    r = p / (1.0 + e * math.cos(anomaly))
    r_F = turn.apply([r * math.cos(anomaly), r * math.sin(anomaly), 0.0])
    v = math.sqrt(mu / p)
    v_F = turn.apply([-v * math.sin(anomaly), v * (e + math.cos(anomaly)), 0.0])
    fallen = two_bodies(np.concatenate([r_F, v_F]), trajectory.time)
    # Local vertical, local horizontal: z down, y against the angular momentum.
    z = -r_F / np.linalg.norm(r_F)
    y = -np.cross(r_F, v_F)
    y /= np.linalg.norm(y)
    R_FW = Rotation.from_matrix(np.stack([np.cross(y, z), y, z], axis=1))
    bodies = {}
    for body in results.case.separation.bodies:
        state = trajectory.of(body.name)
        R_WB = Rotation.from_quat(state[:, :4], scalar_first=True)
        cg = R_WB.apply(body.p_BoBcm_B)
        moving = state[:, 10:] + np.cross(state[:, 7:10], cg)
        bodies[body.name] = (
            fallen[:, :3] + R_FW.apply(state[:, 4:7] + cg),
            fallen[:, 3:] + R_FW.apply(moving),
            R_FW * R_WB,
            R_WB.inv().apply(state[:, 7:10]),
        )
    return trajectory.time, bodies


def check_epochs(got, time):
    """To 1e-12 s, by whole calendar days."""
    start = parse_epoch("epoch", EPOCH)
    off = [
        parse_epoch("", t) - start - Decimal(x) for t, x in zip(got, time, strict=True)
    ]
    assert max(map(abs, off)) <= Decimal("1e-12")
    assert got[-1].startswith("2026-03-01T00:00:00.55")


def check_rotations(got, wanted):
    """Beyond the sign that every attitude has two of."""
    assert (got * wanted.inv()).magnitude().max() <= 1e-14


def test_orbits_by_a_second_library(flown, wanted, tmp_path):
    time, bodies = wanted
    *files, last, _ = drakesep.export(flown, "oem", output=tmp_path)
    assert last.name == "handover.csv"
    assert [file.name for file in files] == ["nominal_lower.oem", "nominal_upper.oem"]
    for file, (body, state) in zip(files, bodies.items(), strict=True):
        message = ccsds_ndm.Oem.from_file(str(file))
        message.validate()
        [segment] = message.segments
        meta, data = segment.metadata, segment.data
        assert (meta.object_name, meta.center_name) == (body.upper(), "EARTH")
        assert (meta.ref_frame, meta.time_system) == ("EME2000", "TAI")
        assert "centre of mass" in " ".join(meta.comment)
        check_epochs(data.state_vector_epochs, time)
        states = 1e3 * data.state_vector_numpy[:, :6]
        # 1e-9 relative is asked for; two bodies are integrated to 1e-12.
        assert np.abs(states[:, :3] - state[0]).max() <= 1e-12 * 8e6
        assert np.abs(states[:, 3:] - state[1]).max() <= 1e-12 * 8e3


def test_attitudes_by_a_second_library(flown, wanted, tmp_path):
    time, bodies = wanted
    *files, _, _ = drakesep.export(flown, "aem", output=tmp_path)
    for file, (body, state) in zip(files, bodies.items(), strict=True):
        message = ccsds_ndm.Aem.from_file(str(file))
        message.validate()
        [segment] = message.segments
        meta, data = segment.metadata, segment.data
        assert (meta.object_name, meta.ref_frame_a) == (body.upper(), "EME2000")
        assert (meta.ref_frame_b, meta.angvel_frame) == ("SC_BODY_1", "SC_BODY_1")
        check_epochs(data.attitude_states_epochs, time)
        numbers = data.attitude_states_numpy
        check_rotations(Rotation.from_quat(numbers[:, :4]), state[2])
        assert np.abs(np.radians(numbers[:, 4:]) - state[3]).max() <= 1e-14


def test_the_quaternion_is_that_of_the_standard():
    """504.0-B-2, annex F2.2: B is turned from A by 90 deg about z.

    Q1 Q2 Q3 QC are 0, 0, 0.7071, 0.7071, and its x axis has coordinates 0, 1, 0 in A.
    """
    q = [0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)]
    assert Rotation.from_quat(q).apply([1.0, 0.0, 0.0]) == pytest.approx([0, 1, 0])


def test_arrays_of_other_programs(flown, wanted, tmp_path):
    """A MAT-file and JSON hold the same numbers, to the last digit."""
    time, bodies = wanted
    for kind in ("mat", "json"):
        [file, *_] = drakesep.export(flown, kind, output=tmp_path)
        assert file == tmp_path / f"nominal.{kind}"
    told = json.loads((tmp_path / "nominal.json").read_text())
    mat = scipy.io.loadmat(tmp_path / "nominal.mat", simplify_cells=True)
    notes = told["notes"]
    assert mat["notes"] == notes
    assert (notes["frame"], notes["epoch"], notes["time_system"]) == (
        *("EME2000", EPOCH, "TAI"),
    )
    for column in (told["time"], mat["time"]):
        assert np.asarray(column).tolist() == time.tolist()
    trajectory = drakesep.read_results(flown).run("nominal").run.completed_trajectory
    for body, state in bodies.items():
        arrays = {k: np.array(x) for k, x in told["bodies"][body].items()}
        assert mat["bodies"][body].pop("name") == body
        for name, array in mat["bodies"][body].items():
            assert array.tolist() == arrays[name].tolist(), name
        assert np.abs(arrays["position"] - state[0]).max() <= 1e-12 * 8e6
        assert np.abs(arrays["velocity"] - state[1]).max() <= 1e-12 * 8e3
        q = Rotation.from_quat(arrays["orientation"], scalar_first=True)
        check_rotations(q, state[2])
        assert np.abs(arrays["rate"] - state[3]).max() <= 1e-14
        # In W nothing is lost: metres keep the digits that the orbit would take.
        q_WB = trajectory.of(body)[:, :4]
        in_W = Rotation.from_quat(arrays["orientation_in_W"], scalar_first=True)
        check_rotations(in_W, Rotation.from_quat(q_WB, scalar_first=True))
        assert np.abs(arrays["position_in_W"]).max() < 2.0


def test_parquet(flown, tmp_path):
    """The numbers of the JSON file, to the last digit; where pyarrow is installed."""
    parquet = pytest.importorskip("pyarrow.parquet")
    for kind in ("json", "parquet"):
        drakesep.export(flown, kind, output=tmp_path)
    told = json.loads((tmp_path / "nominal.json").read_text())
    table = parquet.read_table(tmp_path / "nominal.parquet")
    notes = {k.decode(): v.decode() for k, v in table.schema.metadata.items()}
    assert notes == told["notes"]
    flat = {name: table[name].to_pylist() for name in table.column_names}
    assert flat.pop("time_s") == told["time"]
    axes = {"orientation": "wxyz"}
    units = {"position": "_m", "velocity": "_m_s", "rate": "_rad_s"}
    for body, arrays in told["bodies"].items():
        for name, rows in arrays.items():
            quantity = name.removesuffix("_in_W")
            place = "in_W_" if name != quantity else ""
            for axis, column in zip(
                axes.get(quantity, "xyz"), np.transpose(rows).tolist(), strict=True
            ):
                unit = units.get(quantity, "")
                assert flat.pop(f"{body}.{place}{quantity}_{axis}{unit}") == column
    assert not flat


def test_parquet_needs_a_package(flown, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(drakesep.InputError, match=r"pip install 'drakesep\[parquet\]'"):
        drakesep.export(flown, "parquet", output=tmp_path)


def test_states_after_separation(flown, wanted, tmp_path):
    """A row for each run and body: at the sample when the last spring has ended."""
    time, bodies = wanted
    [file, _] = drakesep.export(flown, "csv", output=tmp_path)
    table = pd.read_csv(file)
    assert table["label"].tolist() == ["nominal", "nominal"]
    ends = drakesep.read_results(flown).run("nominal").run.stroke_ends
    for (_, row), (body, state) in zip(table.iterrows(), bodies.items(), strict=True):
        assert (row["body"], row["frame"]) == (body, "EME2000")
        assert row["time_s"] == max(ends.values())
        i = time.tolist().index(row["time_s"])
        check_epochs([row["epoch"], "2026-03-01T00:00:00.55"], [time[i], 0.8])
        position = row[[f"position_{a}_m" for a in "xyz"]].to_numpy(float)
        assert np.abs(position - state[0][i]).max() <= 1e-12 * 8e6
        rate = row[[f"rate_{a}_rad_s" for a in "xyz"]].to_numpy(float)
        assert np.abs(rate - state[3][i]).max() <= 1e-14


def test_worst_vectors_stand_beside_the_nominal(tmp_path):
    """Of a study that keeps several runs: what each varies, in its unit."""
    data = small_case(dispersions={"upper.mass_kg": 50.0, "upper.cg_y_mm": 8.0})
    data["published"][0]["values"] = {"upper.mass_kg": "M"}
    case = write_case(tmp_path, data)
    drakesep.worst_case(
        case, ["PM"], searches=["drake"], workers=1, output=tmp_path / "out"
    )
    drakesep.export(tmp_path / "out", "csv", output=tmp_path)
    table = pd.read_csv(tmp_path / "handover.csv").set_index(["label", "body"])
    worst = pd.read_csv(tmp_path / "out" / "worst_cases.csv").set_index("label")
    assert set(table.index.get_level_values(0)) == set(worst.index)
    for (label, _), row in table.iterrows():
        for name in ("upper.mass_kg", "upper.cg_y_mm"):
            assert row[name] == worst.loc[label, name]
    assert "frame" not in table  # there is no orbit


def test_a_report_tells_of_the_ellipse(flown, tmp_path):
    """Its numbers are those of the folder, as the report's own tests hold all."""
    told = drakesep.report(flown, output=tmp_path / "page.html").read_text()
    for words in (
        "radius of the reference orbit at the start",
        "climb rate",
        "EME2000",
    ):
        assert words in told
    assert "circular" not in told


def test_what_the_case_does_not_say_is_given(without_plane, tmp_path):
    """Epoch, frame and how the orbit lies; the elements come out by the textbook."""
    given = {
        "epoch": "2026-060T12:00:00Z",
        "frame": "GCRF",
        "plane": [97.5, 10.0, 30.0],
    }
    [file, *_] = drakesep.export(without_plane, "oem", output=tmp_path, **given)
    [segment] = ccsds_ndm.Oem.from_file(str(file)).segments
    assert segment.metadata.time_system == "UTC"
    assert segment.data.state_vector_epochs[0] == "2026-03-01T12:00:00"
    x, y, z, *velocity = segment.data.state_vector_numpy[0, :6]
    h = np.cross([x, y, z], velocity)
    inclination = math.degrees(math.acos(h[2] / np.linalg.norm(h)))
    node = math.degrees(math.atan2(h[0], -h[1]))
    # The CG is 0.8 m from W's origin: 1e-7 rad.
    assert (inclination, node) == pytest.approx((97.5, 10.0), abs=1e-5)
    assert z == pytest.approx(
        7000.137
        * math.sin(math.radians(30.0))
        * h[0]
        / (np.linalg.norm(h) * math.sin(math.radians(10.0))),
        abs=1e-3,
    )


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "epoch, frame and plane: must be given, where the case has none"),
        ({"frame": "EME2000", "plane": [1, 2, 3]}, "epoch: must be given"),
        ({"epoch": EPOCH, "plane": [1, 2, 3]}, "frame: must be given"),
        ({"epoch": EPOCH, "frame": "EME2000"}, "plane: must be given"),
        (
            {"epoch": EPOCH, "frame": "ITRF2000", "plane": [1, 2, 3]},
            "must be an inertial frame",
        ),
        (
            {"epoch": "noon", "frame": "EME2000", "plane": [1, 2, 3]},
            "epoch must be an epoch such as",
        ),
        ({"plane": [1, 2]}, "plane must have 3 entries"),
        (
            {
                **{"epoch": EPOCH, "frame": "EME2000", "plane": [1, 2, 3]},
                **{"time_system": "UT1"},
            },
            "time_system must be one of UTC, TAI, TT, GPS, TDB, got 'UT1'",
        ),
    ],
)
def test_what_is_missing(given, message, without_plane, tmp_path):
    with pytest.raises(drakesep.InputError, match=message):
        drakesep.export(without_plane, "oem", output=tmp_path / "out", **given)
    assert not (tmp_path / "out").exists() or not [*(tmp_path / "out").iterdir()]


def test_what_is_given_at_the_export_stands_in_what_is_exported(
    without_plane, flown, tmp_path
):
    """In messages, in notes of arrays, and in the provenance; else nothing is said."""
    given = {"epoch": EPOCH, "frame": "GCRF", "plane": [97.5, 10.0, 30.0]}
    for format in ("oem", "json"):
        drakesep.export(without_plane, format, output=tmp_path, **given)
        drakesep.export(flown, format, output=tmp_path / "whole")
    message = " ".join((tmp_path / "nominal_lower.oem").read_text().split())
    notes = json.loads((tmp_path / "nominal.json").read_text())["notes"]
    for words in (
        f"epoch {EPOCH}",
        "frame GCRF",
        "time_system UTC",
        "97.5, 10, 30 deg",
    ):
        assert words in message.replace(" COMMENT ", " ")
        assert words in notes["given_at_the_export"]
    told = json.loads((tmp_path / "nominal_oem_provenance.json").read_text())
    plane = {"plane": "97.5, 10, 30", "time_system": "UTC"}
    assert told["given"] == {**given, **plane}
    record = drakesep.read_results(without_plane).record
    assert told["case_sha256"] == record.case["sha256"]
    for name, digest in told["files"].items():
        assert hashlib.sha256((tmp_path / name).read_bytes()).hexdigest() == digest
    assert "nominal_lower.oem" in told["files"]
    whole = tmp_path / "whole"
    assert "given" not in (whole / "nominal_lower.oem").read_text()
    assert "given" not in (whole / "nominal.json").read_text()
    told = json.loads((whole / "nominal_oem_provenance.json").read_text())
    assert told["given"] == {}


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"frame": "ICRF"}, "frame: must be EME2000, as the case says, got ICRF"),
        ({"epoch": "2026-01-01T00:00:00"}, f"epoch: must be {EPOCH}, as the case says"),
        ({"time_system": "UTC"}, "time_system: must be TAI, as the case says"),
        ({"plane": [1, 2, 3]}, "plane: must not be given"),
        ({"run": "worst_L1"}, "run: unknown run 'worst_L1'"),
    ],
)
def test_what_contradicts_the_folder(given, message, flown, tmp_path):
    with pytest.raises(drakesep.InputError, match=message):
        drakesep.export(flown, "oem", output=tmp_path, **given)


def test_command(without_plane, tmp_path, capsys, monkeypatch):
    """It does what the function does; and the same bytes where time stands still."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1772366400")
    given = {"epoch": EPOCH, "frame": "EME2000", "plane": [51.6, 20.0, 30.0]}
    drakesep.export(
        without_plane, "aem", output=tmp_path / "called", time_system="TT", **given
    )
    words = ["export", without_plane, "--format", "aem", "--epoch", EPOCH]
    words += ["--frame", "EME2000", "--plane", "51.6,20,30", "--time-system", "TT"]
    code, out, _ = run(
        *(capsys, monkeypatch, *words, "--run", "nominal", "-o", tmp_path / "typed")
    )
    assert code == 0
    assert "nominal_upper.aem" in out
    files = [file.name for file in sorted((tmp_path / "called").iterdir())]
    messages = ["nominal_lower.aem", "nominal_upper.aem"]
    told = "nominal_aem_provenance.json"
    assert files == ["handover.csv", told, *messages]
    for name in files:
        called, typed = ((tmp_path / x / name).read_text() for x in ("called", "typed"))
        assert called == typed
    assert "CREATION_DATE = 2026-03-01T12:00:00\n" in typed
    code, _, err = run(capsys, monkeypatch, *words[:3], "ome")
    assert code == 2
    assert "format" in err
    code, _, err = run(capsys, monkeypatch, *words[:4], "--plane", "1,2")
    assert code == 2
    assert "--plane: must be three angles" in err
    # Beside the folder, if nothing else is said.
    code, _, _ = run(capsys, monkeypatch, "export", without_plane, "--format", "csv")
    assert code == 0
    assert (without_plane.parent / "out_handover" / "handover.csv").exists()


def test_mean_and_covariance_of_a_campaign(tmp_path):
    """Against numpy's, of draws that are made by hand; one has failed."""
    rng = np.random.default_rng(0)
    mix = np.array([[1.0, 0.2, 0.0], [0.0, 0.5, 0.1], [0.3, 0.0, 2.0]])
    metrics = rng.normal(size=(50, 3)) @ mix
    metrics[7, 1] = np.nan
    names = ["final_rate_x", "longitudinal_speed_max", "G_L1"]
    record = {
        **{"format": 1, "study": "campaign", "ended": "completed", "again": None},
        **{"begun": "", "seconds": 0.0, "process": 1, "versions": {}, "case": {}},
    }
    (tmp_path / "study.json").write_text(json.dumps(record))
    np.savez(tmp_path / DRAWS, metrics=metrics, metric_names=np.array(names))
    [file, _] = drakesep.export(tmp_path, "csv", output=tmp_path / "out")
    table = pd.read_csv(file)
    columns = table["metric"].tolist()
    assert columns == ["final_rate_x_deg_s", "longitudinal_speed_max_m_s", "G_L1_deg"]
    assert set(table["draws"]) == {49}
    assert set(table["left_out"]) == {1}
    told = np.delete(metrics, 7, axis=0) * [math.degrees(1), 1.0, math.degrees(1)]
    assert table["mean"].to_numpy() == pytest.approx(told.sum(axis=0) / 49, rel=1e-13)
    off = told - told.mean(axis=0)
    covariance = table[[f"covariance_with_{c}" for c in columns]].to_numpy()
    assert covariance == pytest.approx(off.T @ off / 48, rel=1e-12, abs=1e-14)
    with pytest.raises(drakesep.InputError, match="format: must be csv of a campaign"):
        drakesep.export(tmp_path, "oem", output=tmp_path / "out")
    (tmp_path / DRAWS).write_bytes(b"PK")
    with pytest.raises(drakesep.InputError, match="must be the draws of a campaign"):
        drakesep.export(tmp_path, "csv", output=tmp_path / "out")


@pytest.mark.parametrize(
    "text",
    [
        *("2026-03-01T12:00:00.123456789012", "1999-12-31T23:59:59.999999999999"),
        *("2026-12-31T00:00:00", "2024-02-29T01:02:03.5"),
    ],
)
def test_epochs_keep_their_digits(text):
    assert epoch_text(parse_epoch("epoch", text)) == text


@pytest.mark.parametrize(
    "text",
    [
        *("2026-13-01T00:00:00", "2026-02-30T00:00:00", "2026-366T00:00:00"),
        *("2026-000T00:00:00", "2026-03-01T24:00:00", "2026-03-01T00:60:00"),
        *("2026-03-01T00:00:61", "2026-03-01 00:00:00", "2026-03-01", "", "nan"),
        *("2026-03-01T00:00:60", "2026-03-01T23:58:60"),
    ],
)
def test_what_is_no_epoch(text):
    with pytest.raises(ValueError, match="epoch must be an epoch such as"):
        parse_epoch("epoch", text)


@pytest.mark.parametrize("text", ["2016-12-31T23:59:60", "2016-366T23:59:60.999Z"])
def test_a_leap_second_is_refused_by_its_name(text):
    """As the next day it would be another epoch."""
    with pytest.raises(ValueError, match="epoch must not be within a leap second"):
        parse_epoch("epoch", text)
