"""Sobol' indices and far probabilities over the distributions of a case.

Of functions of the values, whose answers are closed forms; nothing is flown.
"""

import dataclasses
import math

import numpy as np
import pytest
from scipy.stats import norm
from trade import symmetric_design

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.campaigns.of_case import (
    dependences,
    probability_beyond,
    sobol_indices_of,
)
from drakesep.analysis.tolerances.correlations import RankCorrelation
from drakesep.analysis.tolerances.distributions import Normal, Uniform
from drakesep.analysis.tolerances.ellipsoid import Ellipsoid
from drakesep.systems.checks import InputError


FORCES = {
    "s1.force_max": Normal(sigma=10.0),
    "s2.force_max": Uniform(extent=30.0),
    "s3.force_max": Normal(sigma=5.0),
}


def case(**changes) -> AnalysisCase:
    given = {"tolerances": FORCES} | changes
    return dataclasses.replace(symmetric_design().in_si(), **given)


def total(values: np.ndarray) -> np.ndarray:
    return values.sum(axis=1)


def test_shares_of_the_variance_of_a_sum():
    """Those of the variances: 100, 30^2 / 3 and 25 N^2."""
    found = sobol_indices_of(case(), lambda values: total(values)[:, None])
    wanted = np.array([100.0, 300.0, 25.0]) / 425.0
    for got, error in (
        (found.first, found.first_error),
        (found.total, found.total_error),
    ):
        # Three intervals of 95 %; they are a per cent wide.
        assert (np.abs(got[:, 0] - wanted) < 2.0 * error[:, 0]).all()
        assert (error < 0.02).all()
    assert found.runs == 10 * 512 * 5


def test_dependent_parameters_have_no_shares():
    together = case(
        tolerances=FORCES
        | {
            "sc.cg_y": 0.01,
            "sc.cg_z": 0.01,
            "sc.inertia_xy": Normal(sigma=20.0, within=40.0),
        },
        ellipsoids=(Ellipsoid(names=("sc.cg_y", "sc.cg_z")),),
        correlations=(
            RankCorrelation(names=("s1.force_max", "s2.force_max"), rank=0.8),
        ),
    )
    ranks, ellipsoid, again = dependences(together)
    assert ranks == "the rank correlation of s1.force_max, s2.force_max"
    assert ellipsoid == "the ellipsoid of sc.cg_y, sc.cg_z"
    assert again.startswith("values that cannot be, ") and again.endswith("drawn again")
    assert dependences(case()) == []
    with pytest.raises(
        InputError, match=r"got the rank correlation of s1.*; the ellips"
    ):
        sobol_indices_of(together, lambda values: values)


@pytest.mark.parametrize("rank", [None, 0.8])
def test_a_sum_far_out(rank):
    """Of normal forces, correlated as Pearson's form says: the sum is normal."""
    names = ("s1.force_max", "s3.force_max")
    correlations = () if rank is None else (RankCorrelation(names=names, rank=rank),)
    normal = case(
        tolerances={name: FORCES[name] for name in names}, correlations=correlations
    )
    rho = 2.0 * math.sin(math.pi * (rank or 0.0) / 6.0)
    deviation = math.sqrt(100.0 + 25.0 + 2.0 * rho * 50.0)
    limit = 1000.0 + deviation * norm.isf(1e-5)
    found = probability_beyond(normal, total, float(limit))
    assert found.probability == pytest.approx(1e-5, rel=0.2)
    assert found.runs <= 100_000 and found.unreached == 0


def test_only_what_can_be_is_looked_at():
    """Given that a body can have the inertias: its products below a bound."""
    inertia = case(tolerances={"sc.inertia_xy": Normal(sigma=20.0, within=40.0)})
    seen = []

    def values(rows):
        seen.append(rows[:, 0])
        return np.abs(rows[:, 0])

    # Of Ixx = 180 and Iyy = Izz = 120 the principal moments are 150 +- s and 120, with
    # s^2 = 30^2 + Ixy^2; the largest is no more than the others together: s <= 60.
    bound = math.sqrt(60.0**2 - 30.0**2)
    found = probability_beyond(inertia, values, 45.0)
    assert 45.0 < max(np.abs(rows).max() for rows in seen) <= bound
    outside = [norm.sf(x, scale=20.0) for x in (45.0, bound)]
    wanted = (outside[0] - outside[1]) / (0.5 - outside[1])
    # Three coefficients of variation of some 4 %.
    assert found.probability == pytest.approx(wanted, rel=0.12)
    assert found.variation < 0.06
