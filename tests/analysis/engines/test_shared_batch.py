"""Batches that fly the same are one; what flies otherwise has another."""

from small_case import small_case
from toy_metrics import RELATIVE, registered

from drakesep.analysis.engines.jax.shared_batch import shared_batch
from drakesep.case_file.case import Case
from drakesep.systems.model.parameters import with_values


CASE = Case.model_validate(small_case()).in_si()


def batch(separation=CASE.separation, metrics=(), without=()):
    names, limits = CASE.box.names, CASE.limits_of_pairs
    return shared_batch(separation, names, limits, metrics=metrics, without=without)


def test_which_axis_of_a_metric_is_asked_for_does_not_matter():
    assert batch() is batch(metrics=["rate_max_after_separation_x"])  # told anyway
    one = batch(metrics=["rate_max_until_separation_x"])
    assert one is batch(
        metrics=["rate_max_until_separation_y", "rate_max_until_separation_x"]
    )
    assert one is not batch()
    assert set(one.metrics) > {f"rate_max_until_separation_{axis}" for axis in "xyz"}


def test_what_flies_otherwise_has_another():
    usual = batch()
    heavier = with_values(CASE.separation, {"lower.mass": 800.0})
    assert batch(heavier) is not usual
    assert batch(heavier) is batch(heavier)
    assert batch(without=["G_L1"]) is not usual
    with registered(RELATIVE):
        mine = batch()
        assert mine is not usual
        assert {*mine.metrics} > {*usual.metrics}
    assert batch() is usual
