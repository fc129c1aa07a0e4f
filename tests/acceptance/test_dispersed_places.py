"""Places and attitudes of geometry and of bodies, with tolerances, end to end."""

import math

import pytest
from trade import BODIES, symmetric_design

import drakesep


GAP = 150.0
"""Between the neighbour and what passes it, mm: both are boxes, and nothing turns."""
SOLVER = 5e-3
"""Up to which a distance between boxes is taken for certain, mm."""
EFFORT = {"samples": 50, "starts": 2, "growth": False}
NEIGHBOUR = {"box": {"size_mm": [400, 300, 200]}, "position_mm": [300, 600, 0]}
BUS = {"box": {"size_mm": [800, 600, 500]}, "position_mm": [400, 0, 0]}


def passing(neighbour=NEIGHBOUR, **changes):
    """Springs push along x; the bus passes the neighbour, which stands toward +y."""
    bodies = {
        "lv": BODIES["lv"] | {"geometry": {"neighbour": neighbour}},
        "sc": BODIES["sc"] | {"geometry": {"bus": BUS}},
    }
    return symmetric_design(bodies=bodies, **changes)


def smallest(case, values=None):
    return drakesep.clearance(case, values).summary["clearance_mm"].min()


def test_neighbours_place_and_attitude():
    case = passing()
    assert smallest(case) == pytest.approx(GAP, abs=SOLVER)
    for d in (-20.0, 35.0):
        found = smallest(case, {"neighbour.position_y_mm": 600.0 + d})
        assert found == pytest.approx(GAP + d, abs=SOLVER)
    # Rolled about its centre, a corner of 150 by 100 comes nearer.
    roll = math.radians(5.0)
    corner = 150.0 * math.cos(roll) + 100.0 * math.sin(roll)
    found = smallest(case, {"neighbour.attitude_roll_deg": 5.0})
    assert found == pytest.approx(600.0 - corner - 300.0, abs=SOLVER)


def test_as_a_case_file_that_has_it_there():
    values = {
        "neighbour.position_x_mm": 290.0,
        "neighbour.position_y_mm": 612.0,
        "neighbour.attitude_roll_deg": 3.0,
        "neighbour.attitude_yaw_deg": -2.0,
    }
    there = NEIGHBOUR | {
        "position_mm": [290.0, 612.0, 0.0],
        "attitude_deg": [3.0, 0.0, -2.0],
    }
    varied = drakesep.clearance(passing(), values)
    written = drakesep.clearance(passing(there))
    assert varied.run.separation == written.run.separation
    assert (varied.run.trajectory.states == written.run.trajectory.states).all()
    columns = ["clearance_mm", "first_position_y_mm", "second_position_y_mm"]
    for got, expected in zip(
        varied.summary[columns].to_numpy(),
        written.summary[columns].to_numpy(),
        strict=True,
    ):
        assert got == pytest.approx(expected, abs=SOLVER)


@pytest.mark.slow
def test_worst_clearance_over_the_neighbours_place():
    """Searched with runs of the batch engine, and flown in Drake."""
    case = passing(
        dispersions={
            "neighbour.position_y_mm": {"lower": 590, "upper": 640},
            "neighbour.position_z_mm": 5,
        },
        requirements=[{"quantity": "clearance_mm", "at_least": 139}],
    )
    study = drakesep.verify(case, **EFFORT)
    [row] = study.requirements.to_dict("records")
    # To the accuracy of a clearance.
    assert row["worst"] == pytest.approx(GAP - 10.0, abs=0.05)
    assert row["verdict"] == "met"
    points = study.worst_points.set_index("parameter")["lowest_clearance"]
    assert points["neighbour.position_y_mm"] == "m"


def test_a_place_that_nothing_is_measured_to_is_refused():
    geometry = {"neighbour": NEIGHBOUR}
    bodies = BODIES | {"lv": BODIES["lv"] | {"geometry": geometry}}
    message = (
        r"neighbour\.position_y: must be of a part that is measured to one of anoth"
    )
    with pytest.raises(ValueError, match=message):
        symmetric_design(bodies=bodies, dispersions={"neighbour.position_y_mm": 5})


def test_a_place_of_what_pushes_is_refused():
    with pytest.raises(
        ValueError, match=r"neighbour\.position_y_mm ± 5: .* a recontact"
    ):
        passing(
            recontact={"stiffness_N_m": 1e6},
            dispersions={"neighbour.position_y_mm": 5},
        )


def test_mated_offset_carries_the_body_along():
    """The bus stands as much nearer at first; springs then push off its centre."""
    for d in (-20.0, 35.0):
        study = drakesep.clearance(passing(), {"sc.mated_offset_y_mm": d})
        assert 1e3 * study.distances[0, 0] == pytest.approx(GAP - d, abs=SOLVER)
    # What stays are the pads in A: those of equal springs push beside the CG.
    run = drakesep.simulate(passing(), {"sc.mated_offset_y_mm": 35.0}).run
    rate = run.motion.rate[-1]
    # 2 springs toward +y, 2 toward -y: the torque is -35 mm times all of their force
    # about z, and the moment of inertia of sc and of what it pushes from is positive.
    assert rate[2] > 0.0
    assert rate[:2] == pytest.approx([0.0, 0.0], abs=1e-9)


def test_mated_place_as_a_case_file_that_has_it_there():
    """Bit for bit."""
    values = {"sc.mated_offset_y_mm": 12.0, "sc.mated_misalignment_roll_deg": 2.0}
    mated = {"position_mm": [0.0, 12.0, 0.0], "attitude_deg": [2.0, 0.0, 0.0]}
    bodies = {"lv": BODIES["lv"], "sc": BODIES["sc"] | {"mated": mated}}
    varied = drakesep.simulate(symmetric_design(), values).run
    written = drakesep.simulate(symmetric_design(bodies=bodies)).run
    assert (varied.trajectory.states == written.trajectory.states).all()
    assert (varied.motion.relative_position == written.motion.relative_position).all()


def test_misalignment_counts_from_the_nominal_stack():
    """At release nothing has moved: the tip-off angle is the misalignment."""
    case = symmetric_design(
        dispersions={"sc.mated_misalignment_yaw_deg": {"minus": 0.5, "plus": 1.0}},
        requirements=[
            {"quantity": "tip_off_angle_deg", "when": "at_release", "at_most": 0.8}
        ],
    )
    study = drakesep.verify(case, **EFFORT)
    [row] = study.requirements.to_dict("records")
    assert row["nominal"] == pytest.approx(0.0, abs=1e-9)
    # An angle whose square is added up: to half of the digits of 1 deg.
    assert row["worst"] == pytest.approx(1.0, abs=1e-6)
    assert row["verdict"] == "not met"


def test_what_hangs_on_a_displaced_body_is_flown_with_it():
    """An adapter between: displaced, with what it carries; and both as written."""
    bodies = {
        "lv": BODIES["lv"],
        "adapter": {
            "mass_kg": 60.0,
            "cg_mm": [50.0, 0.0, 0.0],
            "inertia_kg_m2": {"xx": 9.0, "yy": 5.0, "zz": 5.0},
        },
        "sc": BODIES["sc"] | {"mated": {"position_mm": [100.0, 0.0, 0.0]}},
    }
    plain = symmetric_design().model_dump(mode="json", exclude_none=True)["attachments"]
    attachments = {
        "bolt": plain["a1"] | {"B": "adapter", "spring": None, "release_time_s": 0.5},
        **{
            name: a | {"A": "adapter", "position_mm": [100.0, *a["position_mm"][1:]]}
            for name, a in plain.items()
        },
    }
    del attachments["bolt"]["spring"]
    case = symmetric_design(
        bodies=bodies, attachments=attachments, pair={"A": "lv", "B": "sc"}
    )
    d = 20.0
    there = bodies | {
        "adapter": bodies["adapter"] | {"mated": {"position_mm": [0.0, d, 0.0]}},
        "sc": BODIES["sc"] | {"mated": {"position_mm": [100.0, d, 0.0]}},
    }
    written = symmetric_design(bodies=there, attachments=attachments)
    values = {"adapter.mated_offset_y_mm": d}
    varied = drakesep.simulate(case, values).run
    other = drakesep.simulate(written).run
    start, expected = (run.trajectory.states[0] for run in (varied, other))
    assert start == pytest.approx(expected, abs=1e-15)
    # Round-off of the places above, which steps of a second do not enlarge by more.
    assert varied.trajectory.states[-1] == pytest.approx(
        other.trajectory.states[-1], abs=1e-10
    )
