"""Bounds of a turned, spinning body on tilted and stuck springs are verified."""

import numpy as np
import oracle
import pytest
from turned_stack import OF_EACH_KIND, TOLERANCES, TURNED

from drakesep.analysis import AnalysisCase
from drakesep.analysis.bounds.certificate import certificate
from drakesep.analysis.bounds.proving import ProofSettings, prove_bounds
from drakesep.check_proof.certificate import certificate as as_read
from drakesep.check_proof.checking import outcomes
from drakesep.systems.model.parameters import with_values


CASE = AnalysisCase(
    separation=TURNED,
    tolerances={name: 0.2 * TOLERANCES[name] for name in OF_EACH_KIND},
)
ASKED = [
    ("rate_value_at_end_x", "highest"),
    ("longitudinal_speed_at_end", "lowest"),
    ("relative_rate_value_at_end_y", "lowest"),
]


@pytest.fixture(scope="module")
def bounds():
    settings = ProofSettings(gap=0.1, seconds=20.0, push=12, coast=2)
    return prove_bounds(CASE, ASKED, settings)


def test_runs_are_within_bounds(bounds):
    rng = np.random.default_rng(7)
    for _ in range(4):
        corner = rng.choice([-1.0, 1.0], len(OF_EACH_KIND))
        values = CASE.box.values(corner)
        run = oracle.fly(with_values(TURNED, values), np.array([0.0, 0.3]))
        speed, rate = run.relative_velocity[-1, 0], run.relative_rate[-1, 1]
        proven = {name: bound.value for name, bound in bounds.proven.items()}
        assert run.rate[-1, 0] <= proven["highest_rate_value_at_end_x"]
        assert speed >= proven["lowest_longitudinal_speed_at_end"]
        assert rate >= proven["lowest_relative_rate_value_at_end_y"]


def test_the_checker_verifies_them(bounds):
    proofs = {name: bound.proof for name, bound in bounds.proven.items()}
    record = certificate(bounds.problem, bounds.grid, proofs)
    assert len(proofs) == len(ASKED)
    for outcome in outcomes(as_read(record), range(len(ASKED))):
        assert outcome.failure is None
