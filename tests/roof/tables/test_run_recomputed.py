"""The tables of one run, column by column, computed anew from poses of its bodies.

Rotations are scipy's, distances between a ball, a rod and boxes have closed forms.
"""

import numpy as np
import pandas as pd
import pytest
from recomputed import ANGLES, DEG, MM, XYZ, metrics
from scipy.integrate import cumulative_trapezoid
from scipy.spatial.transform import Rotation
from small_case import small_case, write_case

import drakesep
from drakesep.tables.run_tables import metrics_table


CG = {"lower": (-0.8, 0.05, -0.03), "upper": (1.1, -0.02, 0.04)}
PADS = {"s1": (0.0, 0.5, 0.0), "s2": (0.0, -0.4, 0.3)}
PUSH = {"s1": (1200.0, 0.1), "s2": (1300.0, 0.11)}
"""Largest force, N, and stroke, m."""
DESIGN_MASS = 110.0
POST = ((0.42, 0.4, 0.03), (0.1, 0.1, 0.9))
NEARER = ((0.42, 0.32, 0.03), POST[1])
DECK = ((-0.15, -0.1, 0.05), (0.1, 0.5, 0.5))
BALL = ((0.25, 0.2, -0.08), 0.1)
MAST = ((0.32, -0.3, 0.2), (0.0, 20.0, 10.0), 0.03, 0.4)
"""Boxes by place and size; a ball by place and radius; a rod by place, roll, pitch and
yaw in deg, radius and length. All in m, in their bodies."""


class Poses:
    """Of both bodies, from the run's trajectory."""

    def __init__(self, run):
        self.time = run.trajectory.time
        self.R, self.p, self.w, self.v = {}, {}, {}, {}
        for name in ("lower", "upper"):
            states = run.trajectory.of(name)
            self.R[name] = Rotation.from_quat(states[:, :4], scalar_first=True)
            self.p[name], self.w[name] = states[:, 4:7], states[:, 7:10]
            self.v[name] = states[:, 10:13]

    def point(self, body, at):
        """(n, 3) place and velocity in W of a point of a body."""
        arm = self.R[body].apply(at)
        return self.p[body] + arm, self.v[body] + np.cross(self.w[body], arm)

    def in_A(self, at):
        """(n, 3) places in A of a point of B."""
        place, _ = self.point("upper", at)
        return self.R["lower"].apply(place - self.p["lower"], inverse=True)


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    folder = tmp_path_factory.mktemp("simulated")
    data = small_case()
    data["run"]["accuracy"] = 1e-9
    study = drakesep.simulate(
        write_case(folder, data), {"upper.mass_kg": 1210.0, "two.position_y_mm": -390.0}
    )
    study.save(folder)
    return study, folder


def test_motion(simulated):
    study, folder = simulated
    frame, poses = pd.read_csv(folder / "motion.csv"), Poses(study.run)
    t, R = poses.time, poses.R
    _, v_A = poses.point("lower", CG["lower"])
    cg_B, v_B = poses.point("upper", CG["upper"])
    in_A, in_B = R["lower"].inv(), R["upper"].inv()
    apart = cg_B - poses.p["lower"]
    v_origin_A = poses.v["lower"]
    relative = v_B - v_origin_A - np.cross(poses.w["lower"], apart)

    force, torque = np.zeros((2, len(t), 3))
    pads = PADS | {"s2": (0.0, -0.39, 0.3)}
    for name, pad in pads.items():
        F, L = PUSH[name]
        w = np.sqrt(F / (DESIGN_MASS * L))
        push = np.where(w * t < 0.5 * np.pi, F * np.cos(w * t), 0.0)  # Eq. 5
        along = in_B.apply(R["lower"].apply(push[:, None] * np.array([1.0, 0.0, 0.0])))
        force += along
        torque += np.cross(np.subtract(pad, CG["upper"]), along)

    def integral(rate):
        steps = 0.5 * np.diff(t)[:, None] * (rate[1:] + rate[:-1])
        return np.vstack([np.zeros(3), np.cumsum(steps, axis=0)])

    expected = {
        ("rate", "deg_s"): DEG * in_B.apply(poses.w["upper"]),
        ("relative_rate", "deg_s"): DEG
        * in_B.apply(poses.w["upper"] - poses.w["lower"]),
        ("angle", "deg"): DEG * R["upper"].as_euler("xyz"),
        ("relative_position", "m"): in_A.apply(apart) - CG["upper"],
        ("relative_velocity", "m_s"): in_A.apply(relative),
        ("acceleration", "m_s2"): np.gradient(v_B, t, axis=0),
        ("linear_momentum_change", "N_s"): integral(force),
        ("angular_momentum_change", "N_m_s"): integral(torque),
    }
    # By trapezoids of 64 samples a push, and differences of samples, beside kinks.
    room = {"acceleration": 0.03, "linear": 0.03, "angular": 0.02}
    assert frame.columns.tolist() == [
        "time_s",
        *(
            f"{name}_{axis}_{unit}"
            for name, unit in expected
            for axis in (ANGLES if name == "angle" else XYZ)
        ),
        *(f"rotation_{axis}_deg" for axis in XYZ),
        "total_rotation_deg",
    ]
    assert frame["time_s"].to_numpy() == pytest.approx(t, abs=0.0)
    kinks = np.abs(t[:, None] - study.run.breaks).min(axis=1) < 0.01
    for (name, unit), values in expected.items():
        for i, axis in enumerate(ANGLES if name == "angle" else XYZ):
            got = frame[f"{name}_{axis}_{unit}"].to_numpy()
            allowed = room.get(name.partition("_")[0], 1e-9)
            smooth = ~kinks if name == "acceleration" else slice(None)
            apart_by = np.abs(got - values[:, i])[smooth].max()
            assert apart_by <= allowed, (name, axis, apart_by)
    rate = in_B.apply(poses.w["upper"])
    modulus = np.linalg.norm(rate, axis=1)
    for name, turned in (
        *((f"rotation_{axis}_deg", rate[:, i]) for i, axis in enumerate(XYZ)),
        ("total_rotation_deg", modulus),
    ):  # by trapezoids, again
        expected = DEG * cumulative_trapezoid(turned, t, initial=0.0)
        assert frame[name].to_numpy() == pytest.approx(expected, abs=1e-3)
    # Nothing but springs acts: what B has gained is its momentum.
    gained = 1210.0 * np.linalg.norm(v_B[-1] - v_B[0])
    columns = [f"linear_momentum_change_{axis}_N_s" for axis in XYZ]
    assert np.linalg.norm(frame[columns].iloc[-1]) == pytest.approx(gained, rel=1e-3)
    both = 700.0 * v_A + 1210.0 * v_B
    assert both == pytest.approx(np.tile(both[0], (len(t), 1)), abs=1e-6)


def test_summary(simulated):
    study, folder = simulated
    [row] = pd.read_csv(folder / "summary.csv").to_dict("records")
    told = metrics(study.run, np.radians([2.1, 2.87, 4.0]))
    assert list(row) == [
        *("label", "role", "s1.force_max_N", "upper.cg_y_mm", "upper.mass_kg"),
        "two.position_y_mm",
        *(name for name in row if name in told),
        *("iterations", "evaluations", "status"),
    ]
    assert set(told) <= set(row)
    for name, value in told.items():
        room = 2e-4 if name.endswith("until_s") else 1e-6
        assert row[name] == pytest.approx(value, rel=room, abs=1e-6), name
    given = [row[name] for name in ("s1.force_max_N", "upper.cg_y_mm", "upper.mass_kg")]
    assert given == pytest.approx([1200.0, -20.0, 1210.0])
    assert row["two.position_y_mm"] == pytest.approx(-390.0)
    assert (row["label"], row["role"]) == ("run", "changed")
    assert (row["evaluations"], row["status"]) == (1, "completed")
    assert np.isnan(row["iterations"])


def test_requirements_of_the_run(simulated):
    study, folder = simulated
    told = metrics(study.run, np.radians([2.1, 2.87, 4.0]))
    rows = pd.read_csv(folder / "requirements_of_run.csv").to_dict("records")
    limits = [
        ("longitudinal_speed_after_separation_m_s", "m/s", ">=", 0.49),
        *(
            (f"rate_after_separation_{axis}_deg_s", "deg/s", "<=", limit)
            for axis, limit in zip(XYZ, (0.66, 1.72, 1.25), strict=True)
        ),
        *(
            (f"deviation_at_separation_{axis}_deg", "deg", "<=", limit)
            for axis, limit in zip(ANGLES, (2.1, 2.87, 4.0), strict=True)
        ),
    ]
    assert len(rows) == len(limits)
    for row, (name, unit, sense, limit) in zip(rows, limits, strict=True):
        assert (row["unit"], row["sense"], row["limit"]) == (unit, sense, limit)
        assert row["value"] == pytest.approx(told[name], rel=1e-6, abs=1e-6)
        margin = limit - told[name] if sense == "<=" else told[name] - limit
        assert row["margin"] == pytest.approx(margin, abs=2e-6)
        assert row["verdict"] == ("met" if margin >= 0.0 else "not met")
        assert row["pair"] == "upper"


def test_printed_metrics(simulated):
    """As `simulate` prints them."""
    study, _ = simulated
    frame = metrics_table(study.labelled.metrics)
    told = metrics(study.run, np.radians([2.1, 2.87, 4.0]))
    assert len(frame) == len(told)
    for _, row in frame.iterrows():
        unit = row["unit"].replace("/√", "_per_sqrt_").replace("/", "_")
        expected = told[f"{row['metric']}_{unit}"]
        room = 2e-4 if unit == "s" else 1e-6
        assert row["value"] == pytest.approx(expected, rel=room, abs=1e-6)


# Distances.


def to_box(points, box):
    """(n,) from points in A to a box of A."""
    place, size = box
    beyond = np.abs(points - np.array(place)) - 0.5 * np.array(size)
    return np.linalg.norm(np.maximum(beyond, 0.0), axis=-1)


def distances(poses, post):
    """(n,) of each pair, in the order of their names, over the samples, m."""
    place, radius = BALL
    ball = poses.in_A(place)
    at, rpy, r, length = MAST
    axis = Rotation.from_euler("xyz", rpy, degrees=True).apply([1.0, 0.0, 0.0])
    rod = np.array(
        [
            poses.in_A(np.array(at) + s * length * axis)
            for s in np.linspace(-0.5, 0.5, 801)
        ]
    )
    return {
        (name, other): to_box(points, box).min(axis=0) - size
        for name, box in (("deck", DECK), ("post", post))
        for other, points, size in (("ball", ball[None], radius), ("mast", rod, r))
    }


@pytest.fixture(scope="module", params=["clear", "contact"])
def measured(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp(request.param)
    data = small_case()
    if request.param == "contact":
        data["bodies"]["lower"]["geometry"]["post"]["position_mm"][1] = 320.0
    study = drakesep.clearance(write_case(folder, data))
    study.save(folder)
    return study, folder, NEARER if request.param == "contact" else POST


def test_clearances(measured):
    study, folder, post = measured
    poses = Poses(study.run)
    truth = distances(poses, post)
    moved = poses.in_A((0.0, 0.0, 0.0))[:, 0]
    over_time = pd.read_csv(folder / "clearance.csv")
    assert over_time.columns.tolist() == [
        *("time_s", "separation_mm"),
        *(f"{a}_to_{b}_mm" for a, b in truth),
    ]
    assert over_time["time_s"].to_numpy() == pytest.approx(poses.time, abs=0.0)
    assert over_time["separation_mm"].to_numpy() == pytest.approx(MM * moved, abs=1e-9)
    for (a, b), values in truth.items():
        apart = values > 1e-6
        got = over_time[f"{a}_to_{b}_mm"].to_numpy()
        # Drake's distance errs by micrometres, a rod's by its 801 points.
        assert got[apart] == pytest.approx(MM * values[apart], abs=0.01)
        assert (got[~apart] <= 0.01).all()

    summary = pd.read_csv(folder / "clearance_summary.csv")
    assert sorted(zip(summary["first"], summary["second"], strict=True)) == sorted(
        truth
    )
    assert summary["clearance_mm"].is_monotonic_increasing
    roles = {"post": "guide", "deck": np.nan, "ball": np.nan, "mast": "antenna"}
    for _, row in summary.iterrows():
        values = truth[row["first"], row["second"]]
        assert (row["first_body"], row["second_body"]) == ("lower", "upper")
        for side in ("first", "second"):
            assert row[f"{side}_role"] in (roles[row[side]],) or (
                pd.isna(row[f"{side}_role"]) and pd.isna(roles[row[side]])
            )
        touches = values.min() <= 1e-6
        assert row["status"] == ("contact" if touches else "clear")
        # Between samples it comes nearer by what curves in 3 ms.
        assert row["clearance_mm"] == pytest.approx(
            MM * max(values.min(), 0.0), abs=0.06
        )
        when = np.interp(row["time_s"], poses.time, values)
        assert MM * max(when, 0.0) == pytest.approx(row["clearance_mm"], abs=0.06)
        assert row["separation_mm"] == pytest.approx(
            MM * np.interp(row["time_s"], poses.time, moved), abs=0.01
        )
        first, second = (
            np.array([row[f"{side}_position_{axis}_mm"] for axis in XYZ]) / MM
            for side in ("first", "second")
        )
        second_A = np.array(
            [np.interp(row["time_s"], poses.time, c) for c in poses.in_A(second).T]
        )
        assert MM * np.linalg.norm(second_A - first) == pytest.approx(
            row["clearance_mm"], abs=0.1
        )
        box = {"post": post, "deck": DECK}[row["first"]]
        on_its_surface = np.abs(first - np.array(box[0])) - 0.5 * np.array(box[1])
        assert on_its_surface.max() == pytest.approx(0.0, abs=1e-4)
        if row["second"] == "ball":
            from_centre = np.linalg.norm(second - np.array(BALL[0]))
            assert from_centre == pytest.approx(BALL[1], abs=1e-4)
        if not touches:
            assert pd.isna(row["contact_time_s"])
            assert pd.isna(row["closing_speed_m_s"])
            continue
        k = int(np.argmax(values <= 1e-6))
        assert poses.time[k - 1] < row["contact_time_s"] <= poses.time[k]
        assert row["contact_time_s"] == row["time_s"]
        closing = (values[k - 2] - values[k - 1]) / (
            poses.time[k - 1] - poses.time[k - 2]
        )
        assert row["closing_speed_m_s"] == pytest.approx(closing, rel=0.05)


def test_contacts(tmp_path):
    """A blow's impulse is what the momentum of B changes by."""
    data = small_case(
        recontact={"stiffness_N_m": 2.0e5, "dissipation_s_m": 0.1, "friction": 0.2}
    )
    data["bodies"]["lower"]["geometry"]["post"]["position_mm"][1] = 320.0
    data["run"]["accuracy"] = 1e-7
    study = drakesep.simulate(write_case(tmp_path, data))
    study.save(tmp_path)
    contacts = pd.read_csv(tmp_path / "contacts.csv")
    forces = pd.read_csv(tmp_path / "contact_forces.csv")
    assert forces.columns.tolist() == [
        *("time_s", "first", "second", "force_N"),
        *(f"force_{axis}_N" for axis in XYZ),
    ]
    components = forces[[f"force_{axis}_N" for axis in XYZ]].to_numpy()
    assert forces["force_N"].to_numpy() == pytest.approx(
        np.linalg.norm(components, axis=1), rel=1e-12
    )
    assert {*zip(forces["first"], forces["second"], strict=True)} == {("post", "ball")}
    assert contacts.columns.tolist() == [
        *("first", "second", "contact_time_s", "contact_end_s", "force_max_N"),
        "impulse_N_s",
    ]
    assert len(contacts) >= 1
    poses = Poses(study.run)
    _, v_B = poses.point("upper", CG["upper"])
    for _, row in contacts.iterrows():
        begin, end = row["contact_time_s"], row["contact_end_s"]
        mine = forces["time_s"].between(begin, end)
        assert row["force_max_N"] == forces.loc[mine, "force_N"].max()
        # From the sample before to the one after.
        i = int(np.searchsorted(poses.time, begin)) - 1
        j = int(np.searchsorted(poses.time, end))
        change = 1200.0 * np.linalg.norm(v_B[min(j, len(v_B) - 1)] - v_B[i])
        # Of a trapezoid over the steps of a contact.
        assert row["impulse_N_s"] == pytest.approx(change, rel=0.03)
