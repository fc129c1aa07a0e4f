"""The worst cases of a problem, with their evidence."""

import math

import numpy as np
import pytest
from runs import evaluator_of
from scipy.stats import beta
from separations import generic_pair

from drakesep.analysis.engines.jax.batch_evaluator import BatchEvaluator
from drakesep.analysis.engines.run_evaluator import RunEvaluator
from drakesep.analysis.metrics.objectives import OBJECTIVES, highest, largest, of_run
from drakesep.analysis.metrics.requirements import deviation_limits
from drakesep.analysis.search.effort import SearchSettings
from drakesep.analysis.search.judge import find_worst_cases
from drakesep.analysis.search.problem import Problem
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.analysis.tolerances.tolerance_set import ToleranceSet
from drakesep.systems.model.run import Run, RunStatus


PAIR = generic_pair()
NAMES = ("upper.cg_x", "upper.cg_y", "upper.mass")
BOX = ToleranceBox.around(PAIR, dict(zip(NAMES, (0.02, 0.01, 1.0), strict=True)))
SET = ToleranceSet(PAIR, BOX)
QUICK = SearchSettings(starts=6, samples=200)
NO_LIMITS = (math.inf,) * 3
SEARCHES = ("samples", "vertices", "sqp", "multistart")


def test_worst_of_all_searches_with_its_evidence():
    """Two hills, the higher in a corner that SQP does not see from the nominal."""

    def hills(u):
        return max(u[0] + 0.5 * u[1], -2.0 * u[0] - 1.5 - 0.1 * u[1])

    problem = Problem(tolerances=SET, evaluator=evaluator_of(hills, tolerances=SET))
    told = []
    [worst] = find_worst_cases(problem, SEARCHES, QUICK, on_search=told.append)
    assert [searched.search for searched in told] == list(SEARCHES)
    assert worst.value == pytest.approx(1.5, abs=1e-9)
    evidence = worst.evidence
    assert worst.search == "vertices"  # the first that found as much
    assert evidence.by_search["sqp"] == pytest.approx(1.5, abs=1e-9)
    assert evidence.by_search["samples"] < 1.5
    assert evidence.samples == 200
    assert evidence.fraction == pytest.approx(1.0 - 0.05 ** (1 / 200))
    assert evidence.starts == 6
    assert evidence.ended_there == evidence.local_maxima[0][1]
    ended = sum(count for _, count in evidence.local_maxima)
    assert ended + evidence.unfinished == 6
    assert evidence.optimality.residual < 1e-6
    assert worst.values["upper.cg_x"] == BOX.values(worst.u)["upper.cg_x"]


def test_failed_runs_are_counted_and_the_others_searched():
    inner = evaluator_of(lambda u: u[0] - u[1], tolerances=SET)

    def fly(rows):
        return [
            Run(separation=run.separation, status=RunStatus.FAILED, message="boom")
            if row[2] > BOX.nominal[2] + 0.9
            else run
            for row, run in zip(rows, inner._fly(rows), strict=True)
        ]

    evaluator = RunEvaluator(fly, BOX.names, inner.objectives)
    problem = Problem(tolerances=SET, evaluator=evaluator)
    told = []
    searches = ["samples", "vertices"]
    [worst] = find_worst_cases(problem, searches, QUICK, on_search=told.append)
    assert worst.value == pytest.approx(2.0)
    drawn, vertices = told
    assert vertices.failures == {"boom": 4}
    failed = drawn.failures["boom"]
    # A twentieth of 200 samples are beyond; four standard deviations.
    assert 1 <= failed <= 22
    evidence = worst.evidence
    assert (evidence.samples, evidence.failed_samples) == (200, failed)
    # They could be worse: Clopper and Pearson's bound, by scipy's beta distribution.
    bound = beta.ppf(0.95, failed + 1, 200 - failed)
    assert evidence.fraction == pytest.approx(bound, rel=1e-12)
    evaluator = RunEvaluator(
        lambda rows: [
            Run(separation=PAIR, status=RunStatus.FAILED, message="boom") for _ in rows
        ],
        BOX.names,
        inner.objectives,
    )
    problem = Problem(tolerances=SET, evaluator=evaluator)
    with pytest.raises(
        RuntimeError, match=r"objective_0: no run of any search .* boom"
    ):
        find_worst_cases(problem, SEARCHES, QUICK)


@pytest.fixture(scope="module")
def vega_problem(vega, vega_batch):
    def fastest(run):
        return float(np.abs(run.completed_motion.rate[-1]).max())

    objectives = [
        OBJECTIVES["L2"],
        largest(highest("final_rate_x"), -2.0 * highest("final_rate_y")),
        of_run(fastest),
    ]
    limits = deviation_limits(vega.limits)
    return Problem(
        tolerances=vega.tolerance_set,
        evaluator=BatchEvaluator(vega_batch, objectives, limits),
    )


def test_objectives_on_the_batch_are_those_of_its_runs(vega_problem, vega_batch):
    """Of metrics, and through the sampled motion: splines every 10 ms."""
    evaluator = vega_problem.evaluator
    rows = vega_problem.tolerances.rows(
        vega_problem.tolerances.draw(5, np.random.default_rng(0))
    )
    every = evaluator.all(rows).values
    which = [0, 1, 2, 1, 0]
    assert evaluator.one(rows, which).values.tolist() == [
        every[i, k] for i, k in enumerate(which)
    ]
    runs = vega_batch.runs(rows)
    for k, objective in enumerate(evaluator.objectives):
        expected = [objective(run) for run in runs]
        assert every[:, k] == pytest.approx(expected, abs=1e-8)
    told, slopes = evaluator.slopes(rows[:2], [0, 1])
    # another program, with a round-off of its own
    assert told.values == pytest.approx([every[0, 0], every[1, 1]], rel=1e-10)
    h = 1e-4 * vega_problem.tolerances.box.tolerance
    for i, k in enumerate([0, 1]):
        steps = np.diag(h)
        up = evaluator.one(rows[i] + steps, [k] * len(h)).values
        down = evaluator.one(rows[i] - steps, [k] * len(h)).values
        # second-order differences at a relative step of 1e-4 of the tolerance
        assert slopes[i] * h == pytest.approx((up - down) / 2.0, rel=1e-4, abs=1e-13)
    assert [evaluator.exact(k) for k in range(3)] == [True, True, False]


def test_a_users_objective_is_searched_like_any_other(vega, vega_batch):
    """The final rate about y, as a function of the run and as a metric."""

    def rate(run):
        return float(run.completed_motion.rate[-1, 1])

    names = ("payload.cg_z", "spring_1.force_max")
    box = ToleranceBox.around(
        vega.separation, dict(zip(names, (0.013, 15.0), strict=True))
    )
    tolerances = ToleranceSet(vega.separation, box)
    columns = [vega.box.names.index(name) for name in names]

    def widened(rows):
        full = np.tile(vega.box.nominal, (len(rows), 1))
        full[:, columns] = rows
        return full

    objectives = [of_run(rate), highest("final_rate_y")]
    evaluator = RunEvaluator(
        lambda rows: vega_batch.runs(widened(rows)), names, objectives
    )
    problem = Problem(tolerances=tolerances, evaluator=evaluator)
    mine, metric = find_worst_cases(
        problem, ["vertices", "sqp"], SearchSettings(starts=2)
    )
    assert mine.name == "rate"
    assert mine.value == pytest.approx(metric.value, rel=1e-12)
    assert mine.u == metric.u
    assert mine.evidence.optimality.residual < 1e-6


def test_an_objective_that_is_no_number_is_refused(vega, vega_batch):
    evaluator = BatchEvaluator(
        vega_batch, [of_run(lambda run: math.nan, "mine")], (math.inf,) * 3
    )
    problem = Problem(tolerances=vega.tolerance_set, evaluator=evaluator)
    with pytest.raises(
        ValueError, match=r"objective mine must be finite .* payload.mass = 1860, .*low"
    ):
        find_worst_cases(problem, ["sqp"])


def test_no_fresh_sample_is_worse_than_what_was_found(vega, vega_batch):
    """30 000 points that no search has seen, against the values in the docs."""
    found = {"L1": 2.9395, "L2": 1.2124, "Linf": 1.0612}  # deg, deg/sqrt(s), deg/s
    evaluator = BatchEvaluator(vega_batch, [OBJECTIVES[k] for k in found], NO_LIMITS)
    tolerances = vega.tolerance_set
    u = tolerances.draw(30_000, np.random.default_rng(2026))
    largest_values = np.degrees(evaluator.all(tolerances.rows(u)).values.max(axis=0))
    assert (largest_values < list(found.values())).all()
    assert (largest_values > 0.6 * np.array(list(found.values()))).all()


def test_an_objective_that_raises_is_told_with_its_point(vega, vega_batch):
    def mine(run):
        return run.nonsense

    evaluator = BatchEvaluator(vega_batch, [of_run(mine)], NO_LIMITS)
    problem = Problem(tolerances=vega.tolerance_set, evaluator=evaluator)
    with pytest.raises(
        ValueError, match=r"objective mine must give .* AttributeError: .* payload.mass"
    ):
        find_worst_cases(problem, ["sqp"])
