"""Bodies that leave in any direction, by closed forms and by turning the axes."""

import dataclasses
import math

import numpy as np
import pytest
from command_line import run as run_command
from scipy.spatial.transform import Rotation
from separations import FREE, GENERIC, generic_pair
from trade import JOINT, SPEED, symmetric_design

import drakesep
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.case_file.case import Case
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.separation import InitialMotion, Pair, Separation
from drakesep.systems.simulation.simulation import Simulation


NONE = (math.inf,) * 3
MIRRORED = {
    "lv": {
        "mass_kg": 2000.0,
        "cg_mm": [1200.0, 0.0, 0.0],
        "inertia_kg_m2": {"xx": 1500.0, "yy": 2500.0, "zz": 2500.0},
    },
    "sc": {
        "mass_kg": 500.0,
        "cg_mm": [-600.0, 0.0, 0.0],
        "inertia_kg_m2": {"xx": 180.0, "yy": 120.0, "zz": 120.0},
    },
}


def one_spring(direction, axis, **changes) -> Case:
    """One spring of 20 J on the axis: sqrt(2 E / mu) = 0.316228 m/s."""
    spring = {"name": "s", "law": "displacement", "force_max_N": 500.0}
    return symmetric_design(
        bodies=MIRRORED,
        pair={"A": "lv", "B": "sc", "direction": direction},
        attachments={
            "a": {
                "A": "lv",
                "B": "sc",
                "position_mm": [0.0, 0.0, 0.0],
                "joint": JOINT,
                "spring": spring | {"stroke_mm": 80.0, "axis": axis},
                "release_time_s": 0.0,
            }
        },
        run={"duration_s": 2.0, "accuracy": 1e-9},
        **changes,
    )


BACK, FORTH = [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]
OF_ONE = math.sqrt(2.0 * 20.0 / 400.0)


@pytest.mark.parametrize(
    ("direction", "axis", "speed", "said"),
    [
        (BACK, BACK, OF_ONE, None),
        (FORTH, BACK, -OF_ONE, "sc moves against its direction [1, 0, 0], at -0.316"),
        (FORTH, FORTH, OF_ONE, "sc moves in its direction [1, 0, 0] and stands behind"),
    ],
)
def test_release_towards_minus_x(direction, axis, speed, said):
    """Away behind; the direction forgotten; and pushed through the launcher."""
    case = one_spring(direction, axis)
    simulated = drakesep.simulate(case)
    told = [simulated.labelled.metrics]
    told.append(Batch(case.separation, ["sc.mass"]).run([[500.0]]).metrics.iloc[0])
    for metrics in told:
        # Ten times the accuracies, 1e-9 and 1e-7.
        after = metrics["longitudinal_speed_after_separation"]
        assert after == pytest.approx(speed, abs=1e-6)
        assert metrics["G_PM"] == pytest.approx(-max(speed, 0.0), abs=1e-6)
    # The x component of the velocity is what it was.
    along_x = simulated.run.motion.relative_velocity[-1, 0]
    assert along_x == pytest.approx(math.copysign(OF_ONE, axis[0]), abs=1e-8)
    assert [said in each.text for each in simulated.remarks] == [True] * bool(said)


def test_the_command_line_says_so(capsys, monkeypatch, tmp_path):
    file = tmp_path / "case.yaml"
    data = one_spring(FORTH, BACK).model_dump_json(exclude_none=True)
    file.write_text(data, encoding="utf-8")
    code, out, _ = run_command(
        capsys, monkeypatch, "simulate", file, "-o", tmp_path / "out"
    )
    assert code == 0
    assert "Note: sc moves against its direction" in " ".join(out.split())
    table = drakesep.read_results(tmp_path / "out").table("remarks.csv")
    assert table[["about", "run"]].to_numpy().tolist() == [["sc", "nominal"]]


def espa(direction=(0.0, 1.0, 0.0), **changes) -> Case:
    """Three payloads of 180 kg on radial ports of a ring, each pushed outward."""
    ports = [(0.0, 800.0, 0.0), (0.0, -400.0, 692.820323028)]
    ports.append((0.0, -400.0, -692.820323028))
    attitudes = [(0.0, 180.0, 90.0), (0.0, 60.0, 90.0), (0.0, -60.0, 90.0)]
    bodies: dict[str, object] = {
        "ring": {
            "mass_kg": 1500.0,
            "cg_mm": [0.0, 0.0, 0.0],
            "inertia_kg_m2": {"xx": 600.0, "yy": 500.0, "zz": 500.0},
            "geometry": {"drum": {"cylinder": {"radius_mm": 700, "length_mm": 600}}},
        }
    }
    for i, (port, attitude) in enumerate(zip(ports, attitudes, strict=True)):
        bodies[f"sat{i}"] = {
            "mass_kg": 180.0,
            "cg_mm": [-400.0, 0.0, 0.0],
            "inertia_kg_m2": {"xx": 20.0, "yy": 25.0, "zz": 25.0},
            "mated": {"position_mm": list(port), "attitude_deg": list(attitude)},
        }
    bodies["sat0"]["geometry"] = {
        "box0": {"box": {"size_mm": [600, 500, 500]}, "position_mm": [-400, 0, 0]}
    }
    attachments = {
        f"p{i}": {
            "A": f"sat{i}",
            "B": "ring",
            "position_mm": [0.0, 0.0, 0.0],
            "joint": JOINT,
            "spring": {
                "name": f"s{i}",
                "law": "displacement",
                "force_max_N": 1500.0,
                "stroke_mm": 60.0,
            },
            "release_time_s": 0.5 * i,
        }
        for i in range(3)
    }
    return symmetric_design(
        pair={"A": "ring", "B": "sat0", "direction": list(direction)},
        bodies=bodies,
        attachments=attachments,
        run={"duration_s": 3.0, "accuracy": 1e-8},
        **changes,
    )


def test_payload_on_a_radial_port():
    """45 J between 180 and 1860 kg: 0.740532 m/s until the next one leaves."""
    simulated = drakesep.simulate(espa())
    run = simulated.run
    told = metrics_of_run(run, NONE, ["longitudinal_speed_at_0.45_s"])
    expected = math.sqrt(2.0 * 45.0 * (1.0 / 180.0 + 1.0 / 1860.0))
    # The joints of the others give: they take F^2 / 2 K, 1.1 J, at most.
    slowest = expected * math.sqrt(1.0 - 1500.0**2 / (2.0 * 1e6) / 45.0)
    assert slowest < told["longitudinal_speed_at_0.45_s"] < expected
    # As the others leave: to the two digits that are known.
    assert 0.655 < told["longitudinal_speed_after_separation"] < 0.745
    # As it was mated is no deviation, however it was.
    assert told["deviation_at_separation_yaw"] == pytest.approx(0.0, abs=1e-6)
    assert simulated.remarks == []


def test_a_direction_that_is_forgotten():
    """Pushed along y; by default it is to leave along x, where it does not move."""
    study = drakesep.simulate(espa(direction=FORTH))
    [remark] = study.remarks
    assert remark.about == ("sat0",)
    assert "sat0 leaves across its direction [1, 0, 0]: at 0.7" in remark.text
    assert ", 0 m/s of it in that direction" in remark.text


def test_one_that_tumbles_is_told_of_as_it_leaves():
    """Later, in axes that turn with A, it goes in circles."""
    case = one_spring(FORTH, FORTH, before_separation={"rate_deg_s": [0, 0, 20]})
    study = drakesep.simulate(case)
    assert study.run.motion.relative_velocity[-1, 0] < -0.1
    assert not any("against" in each.text for each in study.remarks)


@pytest.mark.parametrize(("until", "verdict"), [(500, "met"), (5000, "not looked at")])
def test_window_of_clearance_of_a_side_release(until, verdict):
    """200 mm while mated, more from then on; in 3 s it moves 1.7 m."""
    required = {"quantity": "clearance_mm", "at_least": 50}
    case = espa(requirements=[required | {"until_separation_mm": until}])
    study = drakesep.verify(case, workers=1)
    [row] = study.requirements.to_dict("records")
    assert row["verdict"] == verdict
    assert study.passed == (verdict == "met")
    if study.passed:
        assert row["worst"] == pytest.approx(200.0, abs=0.1)  # what joints give
    [moved] = drakesep.clearance(case).separations.values()
    assert 1.6 < moved[-1] < 2.3


def turned(separation: Separation, Q: Rotation) -> Separation:
    """The same bodies, where A's axes are others: what was x is now along Q x."""
    lower, upper = separation.bodies
    xx, yy, zz, xy, xz, yz = lower.I_BBcm_B
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    M = Q.as_matrix() @ inertia @ Q.as_matrix().T
    entries = (M[0, 0], M[1, 1], M[2, 2], M[0, 1], M[0, 2], M[1, 2])

    def to(vector):
        return tuple(Q.apply(vector).tolist())

    lower = dataclasses.replace(
        lower,
        p_BoBcm_B=to(lower.p_BoBcm_B),
        I_BBcm_B=tuple(map(float, entries)),
    )
    rpy_AB = tuple(Q.as_euler("xyz").tolist())
    upper = dataclasses.replace(upper, rpy_AB=rpy_AB)
    attachments = tuple(
        dataclasses.replace(
            a,
            p_AoPad_A=to(a.p_AoPad_A),
            spring=dataclasses.replace(a.spring, axis_A=to((1.0, 0.0, 0.0))),
        )
        for a in separation.attachments
    )
    initial = separation.initial
    R_WA = Rotation.from_euler("xyz", initial.rpy_WA) * Q.inv()
    return dataclasses.replace(
        separation,
        bodies=(lower, upper),
        attachments=attachments,
        direction=to((1.0, 0.0, 0.0)),
        initial=InitialMotion(
            rpy_WA=tuple(R_WA.as_euler("xyz").tolist()), w_WA_A=to(initial.w_WA_A)
        ),
    )


@pytest.mark.parametrize(
    "Q",
    [
        Rotation.from_euler("z", 90.0, degrees=True),
        Rotation.from_euler("z", 180.0, degrees=True),
        Rotation.from_euler("xyz", [0.3, -0.8, 2.0]),
    ],
    ids=["sideways", "backwards", "aslant"],
)
def test_as_seen_from_other_axes_nothing_changes(Q):
    """Both engines; all of B's rates, and all that is along the direction."""
    given = generic_pair(
        release_times=(0.05, 0.02, 0.09, 0.03), joint=FREE, initial=GENERIC
    )
    names = [
        *("G_L1", "G_PM", "rate_after_separation_y", "final_rate_z", "separation_end"),
        *("longitudinal_speed_after_separation", "longitudinal_speed_max"),
    ]
    integration = Integration(accuracy=1e-10)
    other = turned(given, Q)
    expected = metrics_of_run(Simulation(given, integration).run(), NONE)
    flown = metrics_of_run(Simulation(other, integration).run(), NONE)
    batch = Batch(other, ["upper.mass"], tolerance=1e-9).run([[1200.0]]).metrics.iloc[0]
    for name in names:
        assert flown[name] == pytest.approx(expected[name], rel=1e-8, abs=1e-9), name
        assert batch[name] == pytest.approx(expected[name], rel=1e-7, abs=1e-8), name


def test_fairing_halves_leave_sideways():
    """By the energy of springs and thrust, on ideal hinges; not along x.

    About the CG of all bodies a half at rest gains what its springs store and what the
    thrust does as the stage moves there; its CG is rho from the hinge, which lets go at
    45 deg. The springs' axes turn with the left half: the halves share unevenly, but
    together they have the speeds of two that are alike.
    """
    case = drakesep.load_case("fairing")
    stage, half = 3000.0, 270.0
    springs, thrust = 2 * 0.5 * 1200.0 * 0.2, 6000.0
    along, inward, I_zz = 3.4, 1.3 - 0.8276, 1083.62
    rho, before = math.hypot(along, inward), math.atan2(inward, along)
    at = math.radians(45.0) - before
    share = half / (stage + 2.0 * half)
    work = thrust * 2.0 * share * rho * (math.cos(before) - math.cos(at))
    inertia = I_zz + half * rho**2 * (1.0 - 2.0 * share * math.sin(at) ** 2)
    expected = rho * math.cos(at) * math.sqrt((springs + work) / inertia)
    names = [
        f"{body}{quantity}"
        for body in ("", "half_right.")
        for quantity in ("longitudinal_speed_at_separation", "longitudinal_speed_max")
    ]
    told = metrics_of_run(drakesep.simulate(case).run, NONE, names)
    left, largest, right, _ = (told[name] for name in names)
    # Joints give by a few parts in 1e4 of a radian (as against Drake's own hinges).
    assert 0.5 * (left + right) == pytest.approx(expected, rel=1e-3)
    assert left == pytest.approx(expected, rel=0.01)
    # As it was reported, to its digits, beside 0.0996 and -4.84 along x; and as above.
    assert largest == pytest.approx(1.256, abs=5e-4 + 1e-3 * expected)


@pytest.mark.parametrize(
    ("direction", "message"),
    [
        ((0.0, 0.0, 0.0), "pair: upper: direction must be of length 1"),
        ((1.0, 1.0, 0.0), "pair: upper: direction must be of length 1"),
    ],
)
def test_direction_is_a_unit_vector(direction, message):
    with pytest.raises(ValueError, match=message):
        Pair(A="lower", B="upper", direction=direction)
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(generic_pair(), direction=direction)


def test_symmetric_design_is_as_it_was():
    metrics = drakesep.simulate(symmetric_design()).labelled.metrics
    speed = metrics["longitudinal_speed_max_after_separation"]
    assert speed == pytest.approx(SPEED, abs=1e-6)
