"""Every column that a command writes is in the catalogue."""

import json
import shutil

import pandas as pd
import pytest
from batches import compiled_once
from one_pair import one_pair

import drakesep
from drakesep.case_file.reader import builtin_cases
from drakesep.results.catalogue.files import FILES
from drakesep.results.catalogue.names import STUDIES
from drakesep.results.listing import described
from drakesep.units import split_unit


def studies(case, two, folder):
    """Each study of a case, in a folder of its own; `two` of its parameters vary."""
    quick = {"searches": ["drake"], "workers": 1}
    drakesep.simulate(case, output=folder / "simulate")
    drakesep.clearance(case, output=folder / "clearance")
    how = {"growth": True, "corners": 1, "campaign": 100, "prove": True}
    drakesep.verify(case, output=folder / "verify", **how, **quick)
    drakesep.sweep(case, {"payload.mass_kg": [1880]}, output=folder / "sweep")
    drakesep.campaign(case, 100, output=folder / "campaign", workers=1)
    drakesep.prove(case, output=folder / "prove")
    few = {"base": 2, "replicates": 2}
    drakesep.sensitivity(two, output=folder / "sensitivity", **few)
    few = {"per_level": 20, "replicates": 2, "least": 0.1}
    drakesep.rare_events(case, output=folder / "rare-events", **few)
    chosen = ["PM", "lowest_clearance"]
    drakesep.worst_case(case, chosen, output=folder / "worst-case", **quick)


def undescribed(folder):
    said = json.loads((folder / "study.json").read_text(encoding="utf-8"))
    files = {file["name"]: file for file in said["files"]}
    there = {str(f.relative_to(folder)) for f in folder.rglob("*") if f.is_file()}
    assert there == set(files)
    for name, file in files.items():
        assert file["what"]
        if not name.endswith(".csv"):
            continue
        assert file["row"]
        columns = list(pd.read_csv(folder / name, nrows=0))
        assert [column["name"] for column in file["columns"]] == columns
        for column in file["columns"]:
            if not column["what"]:
                yield name, column["name"]


def test_every_column_of_every_command_is_described(tmp_path, monkeypatch):
    compiled_once(monkeypatch, "drakesep.analysis.campaigns.flights")
    required = {"requirements": drakesep.load_case("vega").requirements[:1]}
    varying = {"payload.mass_kg": 20}
    case = one_pair(dispersions=varying, published=[], **required)
    varying["payload.cg_y_mm"] = 13
    two = one_pair(dispersions=varying, published=[], **required)
    studies(case, two, tmp_path)
    assert {folder.name for folder in tmp_path.iterdir()} == set(STUDIES)
    for folder in [*tmp_path.iterdir()]:
        assert list(undescribed(folder)) == []
        copy = shutil.copytree(folder, tmp_path / f"copy_of_{folder.name}")
        assert drakesep.compare(folder, copy, tolerance=0.0).table.empty


def test_keys_are_columns():
    for kind in FILES:
        assert bool(kind.row) == bool(kind.key)
        for name in kind.key:
            assert described(kind, name), (kind.name, name)


@pytest.mark.parametrize("name", sorted(set(builtin_cases()) - {"vega", "rideshare"}))
def test_columns_of_other_vehicles_are_described(name, tmp_path):
    drakesep.simulate(name, output=tmp_path)
    assert list(undescribed(tmp_path)) == []


@pytest.mark.parametrize(
    ("file", "column", "unit", "what"),
    [
        ("summary.csv", "payload.cg_x_mm", "mm", "CG, x of payload."),
        ("summary.csv", "spring_2.force_max_N", "N", "Maximum force of spring_2."),
        ("summary.csv", "separation_end_s", "s", "Time at separation."),
        ("motion.csv", "rate_x_deg_s", "deg/s", "Angular velocity of B in W"),
        ("runs/{label}.csv.gz", "payload.velocity_z_m_s", "m/s", "origin in W"),
        ("runs/{label}.csv.gz", "attachment_1.torque_x_N_m", "N m", "Of the joint"),
        ("clearance.csv", "bus_to_ring_mm", "mm", "Distance of the two parts."),
        ("evidence.csv", "multistart", "as `unit` says", "The worst that this search"),
    ],
)
def test_meaning_and_unit(file, column, unit, what):
    [kind] = [kind for kind in FILES if kind.name == file]
    told = described(kind, column)
    assert told.unit == unit
    assert what in told.what


@pytest.mark.parametrize("column", ["rate_x", "rate_q_deg_s", "payload.mas_kg", "x"])
def test_what_is_no_column_is_not_described(column):
    for name in ("motion.csv", "summary.csv", "clearance.csv"):
        [kind] = [kind for kind in FILES if kind.name == name]
        assert described(kind, column) is None


@pytest.mark.parametrize(
    ("name", "stem", "suffix"),
    [
        ("rate_x_deg_s", "rate_x", "deg_s"),
        ("G_L2_deg_per_sqrt_s", "G_L2", "deg_per_sqrt_s"),
        ("damping_N_s_m", "damping", "N_s_m"),
        ("first_position_x_mm", "first_position_x", "mm"),
        ("factor", "factor", ""),
        ("evaluations", "evaluations", ""),
    ],
)
def test_unit_is_the_longest_suffix(name, stem, suffix):
    found, unit = split_unit(name)
    assert (found, unit.suffix) == (stem, suffix)
