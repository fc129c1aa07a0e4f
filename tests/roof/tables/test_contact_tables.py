"""Contacts from the forces of steps, by hand."""

import dataclasses

import numpy as np
import pytest
from runs import made_up_run

from drakesep.systems.model.run import ContactForces
from drakesep.tables.contact_tables import contact_forces_table, contacts_table


def contact(first, second, rows):
    time, x, y = np.array(rows, dtype=float).T
    force = np.stack([x, y, 0.0 * x], axis=1)
    return ContactForces(first=first, second=second, time=time, force=force)


@pytest.fixture
def run():
    """One pair touches twice, another in between; each from no force to none."""
    twice = contact(
        "rim",
        "lug",
        [
            *((0.1, 0, 0), (0.2, 30, 40), (0.4, 60, 80), (0.5, 0, 0)),
            *((0.9, 0, 0), (1.0, -6, 8), (1.1, 0, 0)),
        ],
    )
    between = contact("rim", "mast", [(0.6, 0, 0), (0.7, 5, 12), (0.9, 0, 0)])
    return dataclasses.replace(made_up_run(), contacts=(twice, between))


def test_contacts(run):
    """Impulses are areas under the components, the rise and the fall among them."""
    frame = contacts_table(run)
    assert frame.values.tolist() == [
        # 50 N at 0.2 s and 100 N at 0.4 s along (3, 4): 2.5 + 15 + 5 N s
        ["rim", "lug", 0.2, 0.5, 100.0, pytest.approx(22.5)],
        # 13 N: 0.65 + 1.3
        ["rim", "mast", 0.7, 0.9, 13.0, pytest.approx(1.95)],
        ["rim", "lug", 1.0, 1.1, 10.0, pytest.approx(1.0)],
    ]
    assert frame.columns.tolist() == [
        *("first", "second", "contact_time_s", "contact_end_s", "force_max_N"),
        "impulse_N_s",
    ]


def test_forces(run):
    frame = contact_forces_table(run)
    assert len(frame) == 7 + 3
    row = frame.iloc[2]
    assert row["time_s"] == 0.4
    assert (row["first"], row["second"]) == ("rim", "lug")
    forces = [row[f"force_{axis}_N"] for axis in "xyz"]
    assert [row["force_N"], *forces] == [100.0, 60.0, 80.0, 0.0]


def test_none():
    """Columns are there, rows are not."""
    run = made_up_run()
    assert contacts_table(run).empty
    assert contact_forces_table(run).empty
    assert "impulse_N_s" in contacts_table(run)
    assert "force_x_N" in contact_forces_table(run)
