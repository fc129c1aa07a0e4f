"""The paper's case: what it prints, and what it missed.

Simplicio and Bennani, "Worst-case Launch Vehicle Stage Separation Analysis", Table 4.
The numbers stand here as they are printed there.
"""

import csv
import math

import numpy as np
import pytest

from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.systems.model.parameters import parameters
from drakesep.systems.simulation.simulation import Simulation


PRINTED = {
    # rates (deg/s), within limits until (s), longitudinal speed (m/s)
    "paper_L1_Linf": ((0.58, 0.02, 0.49), 1.1, 1.16),
    "paper_L2": ((0.58, 0.02, 0.33), 1.6, 1.16),
    "paper_PM": ((0.58, 0.24, 0.33), 1.6, 1.14),
}
# The paper's times as an independent simulation gives them: the first of its samples,
# 10 ms apart, that is beyond a limit.
SAMPLED_TIMES = {"paper_L1_Linf": 1.11, "paper_L2": 1.60, "paper_PM": 1.59}

LOWEST = "lowest_clearance_until_0.5_m"
RATES = [f"final_rate_{axis}_deg_s" for axis in "xyz"]


@pytest.fixture(scope="module")
def table(vega_verification):
    return vega_verification.table.set_index("label")


def test_nominal(table):
    nominal = table.loc["nominal"]
    assert [f"{nominal[rate]:.4f}" for rate in RATES] == ["0.5752", "0.2440", "0.3325"]
    assert f"{nominal['longitudinal_speed_max_m_s']:.4f}" == "1.1597"


def test_nominal_after_separation(table):
    """Not before it: the y rate falls from Table 3's 0.327 deg/s during the push."""
    nominal = table.loc["nominal"]
    assert nominal["rate_after_separation_y_deg_s"] == pytest.approx(0.2440, abs=5e-5)
    # 0.3376 at the end of the push, then less
    assert nominal["rate_after_separation_z_deg_s"] == pytest.approx(0.3376, abs=5e-5)
    assert nominal["separation_end_s"] == pytest.approx(0.1639, abs=5e-5)


@pytest.mark.parametrize("label", PRINTED)
def test_published_worst_cases(table, label):
    """Every number within 0.01, a last printed digit."""
    rates, until, speed = PRINTED[label]
    row = table.loc[label]
    assert row[RATES].tolist() == pytest.approx(rates, abs=0.01)
    assert row["longitudinal_speed_max_m_s"] == pytest.approx(speed, abs=0.01)
    within = row["deviation_within_limits_until_s"]
    assert within == pytest.approx(until, abs=0.02)  # printed to 0.1 s, from samples
    assert 0.0 <= SAMPLED_TIMES[label] - within <= 0.01


def test_published_vectors_are_those_of_table_4(table):
    """Spot checks: masses at their maximum, springs low and high in pairs."""
    assert (table.loc[list(PRINTED), "payload.mass_kg"] == 1880.0).all()
    springs = [f"spring_{i}.force_max_N" for i in (1, 2, 3, 4)]
    assert table.loc["paper_L2", springs].tolist() == [1470, 1470, 1500, 1500]
    assert table.loc["paper_PM", springs].tolist() == [1470, 1470, 1470, 1470]
    assert table.loc["paper_L2", "payload.cg_y_mm"] == 1.0
    assert table.loc["paper_L1_Linf", "payload.inertia_zz_kg_m2"] == 2935.0


@pytest.mark.parametrize(
    ("objective", "published", "at_least"),
    [
        ("G_L1_deg", "paper_L1_Linf", 1.17),
        ("G_Linf_deg_s", "paper_L1_Linf", 1.20),
        ("G_L2_deg_per_sqrt_s", "paper_L2", 1.08),
    ],
)
def test_worst_cases_are_worse_than_the_published(
    table, objective, published, at_least
):
    name = objective.split("_")[1]
    ours = table.loc[f"worst_{name}", objective]
    assert ours > at_least * table.loc[published, objective]
    assert table.loc[f"worst_{name}", "status"] == "confirmed"
    assert table.loc[f"sqp_{name}", "status"] == "converged"


def test_slowest_separation_is_the_published_one(table):
    """G_PM is nearly linear: heavy payload and weak springs, the rest to 2e-5 m/s."""
    ours, published = table.loc[["worst_PM", "paper_PM"], "G_PM_m_s"]
    assert ours >= published
    assert ours == pytest.approx(published, abs=2e-5)
    assert table.loc["sqp_PM", "iterations"] <= 5


def test_worst_cases_lie_within_the_tolerances(vega_verification):
    box = vega_verification.case.box
    for one in vega_verification.runs:
        values = parameters(one.run.separation)
        u = box.scaled({name: values[name] for name in box.names})
        assert np.abs(u).max() <= 1.0 + 1e-12


def test_requirements_of_table_1_are_met(vega_verification):
    """As the paper finds, with the margins that are left."""
    requirements = vega_verification.requirements
    assert vega_verification.passed
    assert (requirements["verdict"] == "met").all()
    of_paper = requirements[requirements["unit"] != "mm"]
    assert of_paper["limit"].tolist() == pytest.approx(
        [1.5, 1.5, 1.5, 1.5, 1.0, 1.0, 0.5]
    )
    assert (of_paper["margin"] > 0.4).all()


def test_table_4_in_its_own_form(vega_verification):
    table = vega_verification.table_4.set_index("condition or property")
    assert table.loc["rate z (deg/s)", "paper_L2"] == "0.34 (0.33)"
    assert table.loc["payload cg x y z (mm)", "paper_L2"] == "M Nom M"
    assert (
        table.loc["payload inertia moments xx yy zz (kg m²)", "paper_L1_Linf"]
        == "M m m"
    )
    assert (
        table.loc["payload inertia products xy xz yz (kg m²)", "paper_PM"]
        == "Nom Nom Nom"
    )
    assert table.loc["spring 1 ... spring 4 stroke (mm)", "worst_PM"] == "m m m m"
    assert table.loc["solver iterations", "paper_L1_Linf"] == "(8)"
    assert len(table.columns) == 1 + 3 + 4 + 4  # nominal, published, SQP, worst
    assert (
        "Nom" not in table.loc["payload inertia products xy xz yz (kg m²)", "worst_L1"]
    )


def test_comparison_says_by_how_much(vega_verification):
    comparison = vega_verification.comparison.set_index("objective")
    row = comparison.loc["G_L1"]
    for other in ("nominal", "published"):
        above = 100.0 * (row["worst"] / row[other] - 1.0)
        assert row[f"above_{other}_percent"] == pytest.approx(above)


def test_tables_on_disk_read_back_exactly(vega_verification, vega_folder):
    for name, frame in {
        "worst_cases": vega_verification.table,
        "iterates": vega_verification.iterates,
        "requirements": vega_verification.requirements,
        "motion_worst_L1": vega_verification.motions["worst_L1"],
    }.items():
        with (vega_folder / f"{name}.csv").open(newline="") as file:
            header, *rows = csv.reader(file)
        assert header == list(frame.columns)
        for column in frame.select_dtypes("float"):
            i = header.index(column)
            read = [float(row[i] or math.nan) for row in rows]
            np.testing.assert_array_equal(read, frame[column], err_msg=column)


def test_nothing_found_beats_the_worst(vega_verification):
    """No vertex, no random sample, no start; and Drake has the same values.

    Sweeps leave out the clearance; see benchmarks/worst_clearance.py.

    Drake at its default accuracy, 1e-6, is within 1e-7 deg/s of itself at a hundredth,
    and within 3e-5 of the relative rates' sums.
    """
    evidence = vega_verification.evidence.set_index("objective")
    for name, row in evidence.iterrows():
        side = -1.0 if str(name).endswith("_down") or "lowest" in str(name) else 1.0
        swept = () if name == LOWEST else ("vertices", "samples")
        for search in ("sqp", "multistart", *swept):
            slack = 1e-12 * abs(row["worst"])
            assert side * row[search] <= side * row["worst"] + slack, (name, search)
        assert abs(row["difference"]) < 1e-6 * max(abs(row["worst"]), 0.1)
    fractions = evidence["fraction_beyond_at_95_percent"]
    assert (fractions.drop(LOWEST) < 6e-5).all()
    assert fractions[LOWEST] == 1.0


def test_worst_cases_are_maxima_of_first_order(vega_verification):
    """All in corners, but where there are kinks.

    The end of separation has one at equal push times, a clearance where other parts of
    round walls, which are polygons, come nearest.
    """
    evidence = vega_verification.evidence.set_index("objective")
    kinked = evidence["at_bounds"] < 18
    smooth = evidence[~kinked]
    assert (smooth["optimality_residual"] < 1e-9).all()
    assert set(evidence.index[kinked]) <= {
        "deviation_at_separation_roll_down",
        LOWEST,
    }


def test_each_requirement_has_its_worst_case(vega_verification):
    """The run with the worst value of a requirement is that of its own search."""
    requirements = vega_verification.requirements.set_index(["requirement", "axis"])
    for axis in "xyz":
        row = requirements.loc[("rate after separation", axis)]
        assert row["which_run"] == f"worst_rate_after_separation_{axis}_up"
    # by hand, before there was a search of it: 0.597, 0.447 and 0.541 deg/s
    worst = requirements.loc["rate after separation", "worst"]
    assert worst.tolist() == pytest.approx([0.6919, 0.4602, 0.5591], abs=1e-4)


def test_tolerances_may_grow(vega_verification):
    """Rates are violated first; a factor is a violation that Drake confirms."""
    requirements = vega_verification.requirements
    rates = requirements["growth_factor"].iloc[:3]
    assert rates.tolist() == pytest.approx([2.31, 2.95, 2.85], abs=0.02)
    assert (requirements["growth_factor"].iloc[:7] > 1.0).all()
    assert requirements["growth_by"].tolist() == ["search"] * 7 + ["ray"]
    simulation = Simulation(vega_verification.case.separation)
    # A clearance, along the ray to its worst case: there it is at its limit, to 50 um,
    # and less what a hundredth of growth takes, twice a hundredth of 4.9 mm.
    clearance, growth = vega_verification.growths[7]
    assert 1.0 < requirements["growth_factor"].iloc[7] == growth.factor
    objective = vega_verification.case.lowest_clearance(clearance.metric)
    left = -objective(simulation.run(growth.values)) - clearance.limit
    assert -1.5e-4 < left < 5e-5
    for requirement, growth in vega_verification.growths[:3]:
        run = simulation.run(growth.values)
        value = metrics_of_run(run, (math.inf,) * 3)[requirement.metric]
        assert value == pytest.approx(requirement.limit, rel=1e-4)


def test_share_of_the_tolerances_that_is_unphysical(vega_verification):
    """Of 100 000 samples; four standard deviations."""
    assert vega_verification.share_unphysical == pytest.approx(0.023, abs=0.002)
