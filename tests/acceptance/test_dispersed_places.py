"""Places and attitudes of geometry and of bodies, with tolerances, end to end."""

import math

import pytest
from trade import BODIES, symmetric_design

import drakesep


GAP = 150.0
"""Between the neighbour and what passes it, mm: both are boxes, and nothing turns."""
SOLVER = 1e-3
"""Of Drake's iteration between boxes, mm."""
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
