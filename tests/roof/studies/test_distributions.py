"""Sobol' indices and rare events of the small case, against draws of a campaign."""

import dataclasses

import numpy as np
import pytest
from batches import compiled_once
from small_case import small_case

import drakesep
from drakesep.analysis.campaigns.flights import CampaignFlights
from drakesep.case_file.case import Case
from drakesep.systems.checks import InputError


VARYING = {
    "upper.mass_kg": {"normal": {"sigma": 15.0}},
    "s1.force_max_N": {"normal": {"sigma": 20.0}},
    "upper.cg_y_mm": {"uniform": 8.0},
}
RUNS = 4000
SPEED = "longitudinal_speed_after_separation"


@pytest.fixture(scope="module", autouse=True)
def quick():
    """A batch is compiled once for all studies of a case."""
    with pytest.MonkeyPatch.context() as patch:
        compiled_once(patch, "drakesep.analysis.campaigns.flights")
        patch.setattr("drakesep.plots.campaign.save_campaign", lambda *_: None)
        yield


def case(**sections):
    given = {"published": None, "objectives": None, "failure_cases": None}
    data = small_case(**{"dispersions": VARYING, **given, **sections})
    data["requirements"] = data["requirements"][:1]
    return Case.model_validate(data).in_si()


@pytest.fixture(scope="module")
def draws():
    """Independent draws: what a campaign has flown."""
    return drakesep.campaign(case(), RUNS, seed=9).draws


def test_shares_of_a_nearly_linear_metric_are_those_of_a_regression(draws):
    """Independent parameters: squares of standardised coefficients.

    Of 4000 draws, they are known to 4 / sqrt(4000) = 0.06 of themselves, four
    deviations, beside 0.01 for what is not linear.
    """
    study = drakesep.sensitivity(case(), base=128, replicates=4)
    table = study.table.set_index("parameter")
    names = [*table.index]
    values = draws[names].to_numpy()
    standard = (values - values.mean(axis=0)) / values.std(axis=0)
    speeds = draws[f"{SPEED}_m_s"].to_numpy()
    fitted, *_ = np.linalg.lstsq(standard, speeds - speeds.mean(), rcond=None)
    shares = fitted**2 / speeds.var()
    assert shares.sum() == pytest.approx(1.0, abs=0.01)
    for name, share in zip(names, shares, strict=True):
        assert table.loc[name, "total"] == pytest.approx(share, rel=0.06, abs=0.01)
    assert table["total"].is_monotonic_decreasing
    assert study.indices.runs == 4 * 128 * 5
    assert study.completed


def test_a_probability_is_what_counting_says(draws):
    """Of 4000 draws 80 are beyond a limit: 2 %, to 4 sqrt(80) / 4000 = 0.9 %."""
    limit = float(np.sort(draws[f"{SPEED}_m_s"])[79:81].mean())
    speed = dataclasses.replace(case().requirements[0], limit=limit, id="slow")
    asked = dataclasses.replace(case(), requirements=(speed,))
    study = drakesep.rare_events(asked, ["slow"], per_level=400, replicates=4)
    [row] = study.table.to_dict("records")
    assert row["probability"] == pytest.approx(0.02, abs=0.009)
    assert row["from"] < row["probability"] < row["to"]
    assert (row["unreached"], row["untold"]) == (0, 0)
    assert study.completed
    far = dataclasses.replace(speed, limit=0.1)
    asked = dataclasses.replace(case(), requirements=(far,))
    few = {"per_level": 40, "replicates": 2, "least": 0.01}
    [row] = drakesep.rare_events(asked, **few).table.to_dict("records")
    assert (row["unreached"], row["from"], row["probability"]) == (2, 0.0, 0.01)


def test_what_drake_does_not_say_is_a_failure(monkeypatch):
    """An engine that tells a speed too high by a thousandth."""
    fly = CampaignFlights.fly

    def too_high(self, indices, tell=None):
        flown = fly(self, indices, tell)
        return dataclasses.replace(flown, metrics=1.001 * flown.metrics)

    monkeypatch.setattr(CampaignFlights, "fly", too_high)
    study = drakesep.sensitivity(case(), base=4, replicates=2)
    assert not study.completed
    assert study.failure.startswith("Drake does not confirm 16 of 16 draws")


def test_what_is_refused(tmp_path):
    together = [{"of": ["s1.force_max_N", "upper.mass_kg"], "rank": 0.8}]
    with pytest.raises(
        InputError, match=r"must be of independent parameters.*the rank"
    ):
        drakesep.sensitivity(case(correlations=together), output=tmp_path)
    with pytest.raises(InputError, match=r"^base must be a power of two, got 3"):
        drakesep.sensitivity(case(), base=3, output=tmp_path)
    with pytest.raises(InputError, match=r"^unknown metric 'rat'"):
        drakesep.sensitivity(case(), ["rat"], output=tmp_path)
    for study in (drakesep.sensitivity, drakesep.campaign):
        with pytest.raises(InputError, match=r"^metrics: rate_x must stand once"):
            study(case(), metrics=["rate_x", "rate_x"], output=tmp_path)
    with pytest.raises(InputError, match=r"^unknown requirement 'fast'"):
        drakesep.rare_events(case(), ["fast"], output=tmp_path)
    with pytest.raises(InputError, match=r"^replicates must be >= 2, got 1"):
        drakesep.rare_events(case(), replicates=1, output=tmp_path)
    assert not [*tmp_path.iterdir()]


def test_what_is_correlated_has_probabilities():
    """Subset simulation takes correlated parameters."""
    together = [{"of": ["s1.force_max_N", "upper.mass_kg"], "rank": 0.8}]
    few = {"per_level": 40, "replicates": 2, "least": 0.01}
    study = drakesep.rare_events(case(correlations=together), **few)
    assert study.completed
