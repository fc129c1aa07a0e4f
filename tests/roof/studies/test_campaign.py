"""Campaigns of the small case: the same whoever flies, in whichever order, resumed."""

import dataclasses
import json
import random
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pandas as pd
import pytest
from batches import compiled_once
from left_behind import whole
from places import Folders, told_in
from scipy.stats import spearmanr
from small_case import small_case, write_case

import drakesep
from drakesep.analysis.campaigns.flights import CampaignFlights
from drakesep.analysis.engines.drake_pool import DrakePool
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.results.campaign_files import DRAWS, TALLIES, chunk_file
from drakesep.studies.campaign import confirmation, executors, flight
from drakesep.studies.campaign.settings import CampaignSettings
from drakesep.tables.draws_so_far import DrawsSoFar
from drakesep.units import unit_of, with_unit


RUNS, CHUNK = 300, 64
SHARE = {"share": 0.99, "confidence": 0.9}
"""230 runs show it without a failure: 0.99^230 = 0.099."""
HOW = {"seed": 3, "chunk": CHUNK, **SHARE}


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    data = small_case(published=None, objectives=None, failure_cases=None)
    data["requirements"] = data["requirements"][:2]
    return write_case(tmp_path_factory.mktemp("case"), data)


@pytest.fixture(scope="module", autouse=True)
def quick():
    """A batch is compiled once for all campaigns of a case, and few are confirmed."""
    with pytest.MonkeyPatch.context() as patch:
        compiled_once(patch, "drakesep.analysis.campaigns.flights")
        patch.setattr(confirmation, "SAMPLE", 2)
        patch.setattr("drakesep.plots.campaign.save_campaign", lambda *_: None)
        patch.setattr("drakesep.plots.campaign_scatter.save_scatter", lambda *_: None)
        yield


@pytest.fixture(scope="module")
def reference(case, tmp_path_factory):
    folder = tmp_path_factory.mktemp("reference")
    return drakesep.campaign(case, RUNS, output=folder, **HOW), folder


def tables(folder):
    names = (DRAWS, "campaign.csv", "campaign_worst.csv", "campaign_runs.csv.gz")
    return {name: (folder / name).read_bytes() for name in names}


def test_what_draws_show_is_told_as_they_come(reference, case, tmp_path):
    """At last what the table says; and histograms have every draw."""
    told, so_far = [], DrawsSoFar()
    drakesep.campaign(case, RUNS, output=tmp_path, on_progress=told.append, **HOW)
    shown = [so_far.add(p.plan, p.chunk) for p in told if p.chunk is not None]
    assert [draws for draws, _ in shown] == [64, 128, 192, 256, RUNS]
    table = pd.read_csv(reference[1] / "campaign.csv")
    rows = shown[-1][1]
    assert [row["limit"] for row in rows] == table["limit"].tolist()
    assert [row["failures"] for row in rows] == table["failures"].tolist()
    assert [row["share_shown"] for row in rows] == table["share_shown"].tolist()
    for row, worst in zip(rows, table["worst"], strict=True):
        assert sum(row["counts"]) == RUNS
        edge = row["edges"][-1 if row["sense"] == "<=" else 0]
        assert edge == pytest.approx(worst, rel=1e-12)


def test_its_report_tells_what_its_tables_have(reference, tmp_path):
    """Each number by its place; none of the campaign's tables is left out."""
    _, folder = reference
    page = drakesep.report(folder, output=tmp_path / "page.html").read_text("utf-8")
    told = [one for one in told_in(page) if one.place]
    there = Folders({folder.name: folder})
    for one in told:
        there.check(one)
    places = " ".join(one.place for one in told)
    for name in ("campaign", "campaign_worst", "campaign_statistics"):
        assert f"/{name}.csv:" in places
    assert "Share of draws beyond a value." in page


def test_metrics_are_those_of_runs_in_drake(reference):
    """Draw by draw, whichever chunk it is in; to what the engines promise."""
    study, _ = reference
    draws = [0, 63, 64, 150, 299]
    with DrakePool(study.case.separation, study.case.integration, workers=1) as pool:
        runs = pool.fly(study.flights.values(draws))
    for draw, run in zip(draws, runs, strict=True):
        told = metrics_of_run(run, study.case.limits_of_pairs, study.plan.metrics)
        for name, value in zip(
            study.plan.metrics, study.flown.metrics[draw], strict=True
        ):
            assert value == pytest.approx(told[name], rel=1e-5)


def test_shares_are_those_of_the_rows(reference):
    study, folder = reference
    rows = pd.read_csv(folder / "campaign_runs.csv.gz", keep_default_na=False)
    table = pd.read_csv(folder / "campaign.csv")
    assert rows["draw"].tolist() == [*range(RUNS)]
    assert set(rows["status"]) == {"completed"}
    speeds = rows["longitudinal_speed_after_separation_m_s"].to_numpy()
    row = table.iloc[0]
    assert row["failures"] == (speeds < row["limit"]).sum() == 0
    assert row["worst"] == speeds.min()
    assert row["worst_draw"] == speeds.argmin()
    assert row["allowed"] == 0  # 388 would be needed for one
    assert row["bound"] == pytest.approx(speeds.min(), rel=1e-14)
    assert study.verdict == "met"
    assert study.passed and study.completed


def test_what_the_first_draws_say_ends_as_all_do(reference, tallied):
    study, folder = reference
    ends = pd.read_csv(folder / "campaign_convergence.csv")
    ends = ends[ends["draws"] == RUNS]
    assert len(ends) == len(study.requirements)
    for name in ("failures", "limit", "sense"):
        assert ends[name].tolist() == study.requirements[name].tolist()
    judged = [study.plan.metrics.index(r.judged_by) for r in study.case.requirements]
    means = study.statistics["mean"].to_numpy()[judged]
    assert ends["mean"].to_numpy() == pytest.approx(means, rel=1e-12)
    assert not (tallied[1] / "campaign_convergence.csv").exists()


def test_points_are_those_of_the_rows(reference, tallied):
    """Over the parameters of largest rank correlation, by scipy's own."""
    study, folder = reference
    rows = pd.read_csv(folder / "campaign_runs.csv.gz")
    scatters = study.picture.scatters
    assert len(scatters) == 2  # speed, and the worst axis of the rate
    names = [with_unit(name) for name in study.flights.names]
    for one in scatters:
        values = rows[with_unit(one.requirement.judged_by)]
        per_si = unit_of(one.requirement.metric).per_si
        assert one.values * per_si == pytest.approx(values.to_numpy(), rel=1e-14)
        rho = {n: spearmanr(rows[n], values).statistic for n in names}
        largest = sorted(rho, key=lambda n: -abs(rho[n]))[:2]
        assert [with_unit(each.parameter) for each in one.over] == largest
        place = study.case.requirements.index(one.requirement)
        draw = study.requirements["deciding_draw"].iloc[place]
        assert one.deciding == one.values[draw]
        for each in one.over:
            drawn = each.values * unit_of(each.parameter).per_si
            name = with_unit(each.parameter)
            assert drawn == pytest.approx(rows[name].to_numpy(), rel=1e-14)
            assert each.deciding == each.values[draw]
            assert each.correlation == pytest.approx(rho[name], rel=1e-9)
    assert not tallied[0].picture.scatters


def test_reports_have_pictures_of_campaigns_without_rows_too(
    reference, tallied, tmp_path
):
    """Shares of both; convergence and points of rows alone."""
    words = ("Curves of the share", "more and more of the draws", "Draws as points")
    for (_, folder), count in ((reference, 3), (tallied, 1)):
        page = drakesep.report(folder, output=tmp_path / "page.html").read_text("utf-8")
        assert [word in page for word in words] == [k < count for k in range(3)]


def test_what_varies_is_within_the_tolerances_and_of_the_seed(case, reference):
    study, _ = reference
    other = drakesep.campaign(case, RUNS, **{**HOW, "seed": 4})
    masses = [one.draws["upper.mass_kg"] for one in (study, other)]
    assert all(each.between(1150.0, 1250.0).all() for each in masses)
    assert (masses[0] != masses[1]).all()


def test_more_draws_begin_with_the_same(case, reference):
    study, _ = reference
    fewer = drakesep.campaign(case, 250, **{**HOW, "chunk": 50})
    np.testing.assert_array_equal(fewer.flown.metrics, study.flown.metrics[:250])


def test_planned_flown_and_merged_in_any_order_it_is_the_same(
    case, reference, tmp_path
):
    recorded = drakesep.plan_campaign(case, RUNS, output=tmp_path, **HOW)
    numbers = [*range(recorded.plan.chunks), 1, 3]
    random.Random(0).shuffle(numbers)
    missing = numbers[-1]
    flown = [drakesep.run_chunk(tmp_path, n) for n in numbers if n != missing]
    assert sum(flown) == recorded.plan.chunks - 1  # what is there stays
    with pytest.raises(RuntimeError, match=f"1 are not there.*: {missing};"):
        drakesep.merge_campaign(tmp_path)
    assert drakesep.run_chunk(tmp_path, missing)
    assert drakesep.run_chunk(tmp_path, missing, again=True)
    study = drakesep.merge_campaign(tmp_path)
    assert tables(tmp_path) == tables(reference[1])
    assert whole(tmp_path, but=("again",)) == whole(reference[1], but=("again",))
    assert study.verdict == "met"
    with pytest.raises(ValueError, match="must be a folder with a study under way"):
        drakesep.merge_campaign(tmp_path)


def test_an_executor_flies_the_same(case, reference, tmp_path):
    with ThreadPoolExecutor(2) as executor:
        drakesep.campaign(case, RUNS, executor=executor, output=tmp_path, **HOW)
    assert tables(tmp_path) == tables(reference[1])


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2, 7])
def test_processes_fly_the_same(workers, case, reference, tmp_path):
    with executors.own_processes(workers) as executor:
        drakesep.campaign(case, RUNS, executor=executor, output=tmp_path, **HOW)
    assert tables(tmp_path) == tables(reference[1])


@pytest.mark.slow
def test_a_dask_cluster_flies_the_same(case, reference, tmp_path):
    distributed = pytest.importorskip("distributed")
    cluster = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None
    )
    with cluster, executors.dask_cluster(cluster.scheduler_address) as executor:
        assert executors._workers(executor) == 2
        drakesep.campaign(case, RUNS, executor=executor, output=tmp_path, **HOW)
    assert tables(tmp_path) == tables(reference[1])


TALLIED = ("campaign.csv", "campaign_worst.csv", "campaign_sensitivities.csv")


@pytest.fixture(scope="module")
def tallied(case, tmp_path_factory):
    folder = tmp_path_factory.mktemp("tallied")
    return drakesep.campaign(case, RUNS, keep="worst", output=folder, **HOW), folder


def test_without_rows_the_tables_are_the_same(reference, tallied):
    """But of quantiles, which are as exact as histograms, and of rows themselves."""
    (rows, folder), (study, other) = reference, tallied
    for name in TALLIED:
        assert (other / name).read_bytes() == (folder / name).read_bytes()
    assert not (other / DRAWS).exists()
    assert not (other / "campaign_runs.csv.gz").exists()
    both = [pd.read_csv(one / "campaign_statistics.csv") for one in (folder, other)]
    for name in ("draws", "untold", "mean", "mean_to", "deviation", "least"):
        assert both[0][name].tolist() == both[1][name].tolist()
    for name in ("low_3_sigma", "median", "high_3_sigma"):
        assert (both[1][f"{name}_from"] <= both[0][f"{name}_from"]).all()
        assert (both[1][f"{name}_to"] >= both[0][f"{name}_to"]).all()
        span = both[0]["greatest"] - both[0]["least"]
        # A bin is a fiftieth of what the first draws, here all, lie apart.
        assert (abs(both[1][name] - both[0][name]) <= span / 50.0).all()
    histograms = pd.read_csv(other / "campaign_histograms.csv")
    assert (histograms.groupby("metric")["draws"].sum() == RUNS).all()
    with pytest.raises(ValueError, match=r"^draws: must be of a campaign that keeps"):
        study.draws  # noqa: B018
    assert study.verdict == rows.verdict
    said = json.loads((other / "study.json").read_text(encoding="utf-8"))
    assert all(file["what"] for file in said["files"])
    columns = [one for file in said["files"] for one in file.get("columns", ())]
    assert all(one["what"] for one in columns)


def test_without_rows_curves_go_where_those_of_rows_go(reference, tallied):
    """Each point of them is the share of draws that are as bad or worse."""
    (rows, _), (study, _) = reference, tallied
    curves = study.picture.curves
    assert len(curves) == 4
    for curve in curves:
        place = rows.plan.metrics.index(curve.requirement.judged_by)
        values = rows.flown.metrics[:, place]
        sign = 1.0 if curve.requirement.from_above else -1.0
        for value, share in zip(curve.values, curve.shares, strict=True):
            beyond = sign * (values - value)
            low, high = (beyond > 0.0).mean(), (beyond >= 0.0).mean()
            assert low <= share <= high
        assert (np.diff(curve.shares) <= 0.0).all()


def test_without_rows_it_is_the_same_in_any_order_and_resumed(case, tallied, tmp_path):
    bytes_of = [(tallied[1] / name).read_bytes() for name in (TALLIES, "plan.json")]
    parts, resumed = tmp_path / "parts", tmp_path / "resumed"
    how = {**HOW, "keep": "worst"}
    recorded = drakesep.plan_campaign(case, RUNS, output=parts, **how)
    numbers = [*range(recorded.plan.chunks)]
    random.Random(2).shuffle(numbers)
    for number in numbers:
        drakesep.run_chunk(parts, number)
    drakesep.merge_campaign(parts)
    interrupted(case, resumed, after=2, keep="worst")
    drakesep.campaign(case, RUNS, output=resumed, resume=True, **how)
    for folder in (parts, resumed):
        names = (TALLIES, "plan.json")
        assert [(folder / name).read_bytes() for name in names] == bytes_of


def interrupted(case, folder, after, **how):
    """Fly until so many chunks are there, and be interrupted."""
    wrote = []

    def write(*arguments):
        if len(wrote) == after:
            raise KeyboardInterrupt
        wrote.append(arguments)
        write_chunk(*arguments)

    write_chunk = flight.write_chunk
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(flight, "write_chunk", write)
        with pytest.raises(KeyboardInterrupt):
            drakesep.campaign(case, RUNS, output=folder, **{**HOW, **how})


def test_interrupted_it_goes_on_and_ends_the_same(
    case, reference, tmp_path, monkeypatch
):
    """No chunk is flown twice but one that is damaged."""
    interrupted(case, tmp_path, after=3)
    damaged = chunk_file(tmp_path, 1)
    damaged.write_bytes(damaged.read_bytes()[:-100])
    flown, fly = [], CampaignFlights.chunk

    def noted(self, number, tell=None):
        flown.append(number)
        return fly(self, number, tell)

    monkeypatch.setattr(CampaignFlights, "chunk", noted)
    study = drakesep.campaign(case, RUNS, output=tmp_path, resume=True, **HOW)
    assert flown == [1, 3, 4]
    assert tables(tmp_path) == tables(reference[1])
    resumed = whole(tmp_path, but=("again",))
    assert resumed == whole(reference[1], but=("again",))
    assert study.passed
    with pytest.raises(ValueError, match=r"^resume: .*, completed$"):
        drakesep.campaign(case, RUNS, output=tmp_path, resume=True, **HOW)


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"seed": 5}, "seed = 3, got 5"),
        ({"share": 0.98}, "arguments.share = 0.99, got 0.98"),
    ],
)
def test_another_campaign_does_not_go_on(changed, told, case, tmp_path):
    interrupted(case, tmp_path, after=2)
    with pytest.raises(ValueError, match=r"^resume: must be") as error:
        drakesep.campaign(
            case, RUNS, output=tmp_path, resume=True, **{**HOW, **changed}
        )
    assert told in str(error.value) or "one that differs" in str(error.value)
    assert chunk_file(tmp_path, 0).exists()


def test_what_is_refused(case, tmp_path):
    with pytest.raises(ValueError, match=r"^runs: must be 230 or more to show a share"):
        drakesep.campaign(case, 229, **HOW)
    with pytest.raises(ValueError, match=r"^confidence: must stand with a share"):
        drakesep.campaign(case, RUNS, confidence=0.9)
    with pytest.raises(
        ValueError, match=r"^share must be a number or None, got 'most'"
    ):
        drakesep.campaign(case, RUNS, share="most")
    with pytest.raises(ValueError, match=r"^output: .* to resume, got None"):
        drakesep.campaign(case, RUNS, resume=True)
    nothing = write_case(
        tmp_path, small_case(requirements=None, objectives=None, published=None)
    )
    with pytest.raises(ValueError, match=r"^requirements: a campaign needs one"):
        drakesep.campaign(nothing, RUNS)


def test_a_share_alone_is_shown_at_90_per_cent(case):
    plans = [
        CampaignSettings(runs=RUNS, share=0.99, confidence=confidence)
        for confidence in (None, 0.9)
    ]
    loaded = drakesep.load_case(case).in_si()
    alone, given = (one.of_shares(loaded).requirements for one in plans)
    assert alone == given
    assert {one.confidence for one in alone} == {0.9}


def test_every_run_must_is_not_shown_by_any_number(case):
    study = drakesep.campaign(case, RUNS, seed=3, chunk=CHUNK)
    assert study.verdict == "not looked at"
    assert study.of_every_run == len(study.findings) == 4
    # The worst of each, which would disprove it, is flown in Drake.
    assert [one.rank for one in study.confirmed if one.requirement] == [1] * 4


def test_one_run_beyond_disproves_that_every_run_must(case, monkeypatch):
    """If Drake says so, too."""
    loaded = drakesep.load_case(case).in_si()
    speed = dataclasses.replace(loaded.requirements[0], limit=0.52)
    broken = dataclasses.replace(loaded, requirements=(speed,))
    study = drakesep.campaign(broken, RUNS, seed=3, chunk=CHUNK)
    assert (study.verdict, study.failure) == ("not met", "")
    fly = CampaignFlights.fly

    def too_low(self, indices, tell=None):
        flown = fly(self, indices, tell)
        return dataclasses.replace(flown, metrics=0.9 * flown.metrics)

    monkeypatch.setattr(CampaignFlights, "fly", too_low)
    doubted = drakesep.campaign(broken, RUNS, seed=3, chunk=CHUNK)
    assert doubted.verdict == "not looked at"
    assert "Drake gives" in doubted.failure


def test_what_drake_does_not_confirm_is_not_met(case, monkeypatch):
    """An engine that tells a speed too high by a thousandth."""
    fly = CampaignFlights.fly

    def too_high(self, indices, tell=None):
        flown = fly(self, indices, tell)
        metrics = flown.metrics * ([1.001] + [1.0] * (flown.metrics.shape[1] - 1))
        return dataclasses.replace(flown, metrics=metrics)

    monkeypatch.setattr(CampaignFlights, "fly", too_high)
    study = drakesep.campaign(case, RUNS, **HOW)
    assert not study.completed
    assert study.verdict == "not looked at"
    verdicts = study.requirements["verdict"].tolist()
    assert verdicts == ["not looked at", "met", "met", "met"]
    assert study.failure.startswith("Drake does not confirm 3 of ")
    failed = study.worst[study.worst["status"].str.startswith("failed")]
    assert set(failed["quantity"]) == {"longitudinal_speed_after_separation_m_s"}


@pytest.mark.parametrize("keep", ["rows", "worst"])
def test_a_run_that_fails_is_beyond_and_told(keep, tmp_path):
    """A stroke that the end of the run cuts short, in some draws."""
    data = small_case(published=None, objectives=None, failure_cases=None)
    data["requirements"] = data["requirements"][:1]
    data["requirements"][0]["at_least"] = 0.1
    spring = data["attachments"]["two"]["spring"]
    del spring["design_mass_kg"]
    spring["law"] = "displacement"
    data["dispersions"] = {"s2.stroke_mm": 100.0}
    data["run"] = {"duration_s": 0.25}
    study = drakesep.campaign(write_case(tmp_path, data), RUNS, keep=keep, **HOW)
    failed = len(study.failures)
    assert 0 < failed < RUNS
    assert all("stroke" in why for why in study.failures.values())
    [finding] = study.findings
    assert finding.beyond == failed
    assert finding.ranked[:failed] == (*study.failures,)
    if keep == "rows":
        assert study.draws["status"].str.startswith("failed: ").sum() == failed
    assert study.completed  # Drake says so, too
    assert study.verdict == "not shown"


def test_what_fails_in_a_launch_is_flown_as_it_failed(tmp_path):
    """A worn spring, which does not vary, and one whose attachment never lets go."""
    data = small_case(published=None, objectives=None)
    data["requirements"] = data["requirements"][:1]
    data["failure_cases"]["stuck"] = {"two.release_time_s": "never"}
    case = dataclasses.replace(
        drakesep.load_case(write_case(tmp_path, data)).in_si(),
        failure_probabilities={"s1_worn": 0.2, "stuck": 0.05},
    )
    study = drakesep.campaign(case, RUNS, **HOW)
    rows = study.draws
    worn, stuck = (rows["failure_case"] == name for name in ("s1_worn", "stuck"))
    assert 0.1 < worn.mean() < 0.3  # 0.2 within four deviations
    assert 0 < stuck.sum() < 40
    assert (rows.loc[worn, "s1.force_max_N"] == 1180.0).all()
    assert (rows.loc[stuck, "status"].str.contains("does not separate")).all()
    assert (rows["status"] != "completed").sum() == stuck.sum()
    [finding] = study.findings
    assert finding.beyond == stuck.sum()
    # What does not separate is the worst, and is known to be of that failure case.
    [row] = study.requirements.to_dict("records")
    assert stuck[row["worst_draw"]]
    assert row["worst_failure_case"] == "stuck"
    assert study.verdict == "not shown"
    draws = rows.index[worn][:3].tolist()
    with DrakePool(study.case.separation, study.case.integration, workers=1) as pool:
        runs = pool.fly(study.flights.values(draws))
    for draw, run in zip(draws, runs, strict=True):
        told = metrics_of_run(run, study.case.limits_of_pairs, study.plan.metrics)
        [name], [value] = study.plan.metrics, study.flown.metrics[draw]
        assert value == pytest.approx(told[name], rel=1e-5)
    assert study.completed  # Drake confirms that, too
