"""No run of VEGA's tolerances is beyond its bounds: samples, corners, worst cases.

Ten million samples are `benchmarks/below_bounds.py`.
"""

import numpy as np
import pytest

from drakesep.analysis.bounds.proving import ProofSettings, asked_of, prove_bounds
from drakesep.analysis.metrics.of_run import metric_of_run


RATES = [f"rate_after_separation_{axis}" for axis in "yz"]
SPEED = "longitudinal_speed_after_separation"
OFF = 1e-8
"""By how much a metric of the batch engine may be off, relative and in SI."""


def are_within(bounds, metrics):
    """All but what the batch engine may be off."""
    for bound in bounds.proven.values():
        side = 1.0 if bound.claim.side == "highest" else -1.0
        farthest = (side * metrics[bound.claim.metric]).max()
        most = side * bound.value
        assert farthest <= most + OFF * (1.0 + abs(most)), bound.claim.metric


def test_samples_corners_and_the_papers_worst_cases_are_within(vega, vega_batch):
    case = vega.in_si()
    asked = [(SPEED, "lowest"), *((rate, "highest") for rate in RATES)]
    settings = ProofSettings(gap=0.02, seconds=60.0)
    bounds = prove_bounds(case, asked, settings)
    assert len(bounds.proven) == len(asked)
    tolerances, rng = case.tolerance_set, np.random.default_rng(5)
    corners = rng.choice((-1.0, 1.0), (1000, len(tolerances)))
    published = [case.box.scaled(one.values) for one in case.published]
    proven = [bound.proof.at for bound in bounds.proven.values()]
    drawn = tolerances.draw_back(np.concatenate([corners, published, proven]))
    points = np.concatenate([tolerances.draw(1000, rng), drawn])
    result = vega_batch.run(tolerances.rows(points))
    assert not result.failures
    are_within(bounds, result.metrics)


@pytest.mark.slow
def test_no_worst_case_that_was_found_is_beyond(vega_verification):
    """Nor any other run that was flown in Drake, published cases among them."""
    case = vega_verification.case
    bounds = prove_bounds(case, asked_of(case))
    assert len(bounds.proven) == 11
    assert [*bounds.not_covered] == ["lowest_clearance_until_0.5_m"]
    runs = [one.run for one in vega_verification.runs if one.run.motion is not None]
    assert len(runs) > len(case.published) + len(vega_verification.worst)
    for bound in bounds.proven.values():
        side = 1.0 if bound.claim.side == "highest" else -1.0
        metric = bound.claim.metric
        told = [side * metric_of_run(run, metric, case.limits_of_pairs) for run in runs]
        # Drake is as accurate as it is asked to be: 1e-6 of a value.
        assert max(told) <= side * bound.value + 1e-6 * abs(bound.value), metric
