"""What a study plans to do, by how fast its runs are."""

import dataclasses
import re
from pathlib import Path

import pytest

import drakesep
from drakesep.analysis.metrics.objectives import OBJECTIVES, highest
from drakesep.analysis.search.effort import SearchSettings
from drakesep.results.asked import Asked
from drakesep.studies.verification import planned
from drakesep.studies.worst_case.effort import MINUTES, in_time, planned_effort
from drakesep.studies.worst_case.pace import Pace
from drakesep.studies.worst_case.searches import WantedSearches, default_searches
from drakesep.studies.worst_case.speed import Speed, measured_speed
from drakesep.systems.checks import InputError


FAST = Speed(drake=0.02, call=6e-3, run=5e-5, cores=2)
"""VEGA on a usual machine."""
FOUR = [*OBJECTIVES.values()]


@pytest.fixture(scope="module")
def case():
    return drakesep.load_case("vega").in_si()


def plan(
    case,
    speed,
    *,
    objectives=FOUR,
    names=None,
    growth=None,
    minutes=None,
    **effort,
):
    wanted = WantedSearches.named(names, case.separation)
    return planned_effort(case, objectives, wanted, effort, growth, speed, minutes)


def slower(times, **others):
    return dataclasses.replace(
        FAST,
        drake=times * FAST.drake,
        call=times * FAST.call,
        run=times * FAST.run,
        **others,
    )


def test_all_effort_where_it_takes_minutes_at_most(case):
    """Ten times as slow a machine plans the same, and says that it takes longer."""
    plans = [plan(case, slower(times)) for times in (0.1, 1.0, 3.0, 10.0)]
    for one in plans:
        assert one.searches == ("samples", "vertices", "sqp", "multistart")
        assert one.settings == SearchSettings()
        assert one.growth
        assert one.options == plans[0].options
    totals = [one.total for one in plans]
    assert totals == sorted(totals)
    assert totals[-1] < 300.0


def test_what_is_flown_run_by_run_is_told_beforehand(case):
    """From the nominal and three starts: some 8 iterates of 20 runs each, so 640."""
    told = str(plan(case, FAST, objectives=[*FOUR, case.lowest_clearance()]))
    assert told.endswith("; flown run by run, some 600 runs: lowest_clearance")
    assert "run by run" not in str(plan(case, FAST))
    drake = str(plan(case, FAST, names=["drake"]))
    assert "; flown run by run in Drake, some 600 runs: L1, L2, Linf, PM" in drake


def test_the_page_has_what_is_told_of_vega(case):
    """But for the time."""
    objectives = planned(Asked.of("verify", case)).objectives
    told = str(plan(case, FAST, objectives=objectives)).partition("; about ")
    page = (Path(__file__).parents[3] / "docs/worst_cases.md").read_text("utf-8")
    [line] = re.findall(r"^ {4}Worst (cases of .*)$", page, re.M)
    before, _, after = line.partition("; about ")
    assert f"worst {before}" == told[0]
    assert after.partition("; ")[2] == told[2].partition("; ")[2]


def test_the_number_of_cores_changes_what_is_said_not_what_is_done(case):
    for times in (1.0, 100.0, 500.0):
        one, many = (plan(case, slower(times, cores=n)) for n in (1, 16))
        assert one.options == many.options
        assert one.total > many.total


@pytest.mark.parametrize("cores", [1, 2, 16])
@pytest.mark.parametrize("times", [30.0, 300.0, 1e3, 3e3, 3e4, 3e5])
def test_never_more_than_ten_minutes_unasked(case, times, cores):
    """Samples, vertices and starts become fewer, then what takes longest is left.

    The least is SQP, of 16 calls of 6 ms, and 8 runs of 20 ms in Drake: 26 minutes if
    all is 6000 times as slow.
    """
    try:
        one = plan(case, slower(times, cores=cores))
    except InputError:
        assert times > 600.0 / 0.26
        return
    assert times < 600.0 / 0.26
    assert one.total <= 60.0 * MINUTES == 600.0
    assert "sqp" in one.searches
    settings = one.settings
    assert settings.samples < SearchSettings().samples
    for name in one.left_out:
        assert name not in one.searches
        assert name in str(one)
    assert one.growth == ("growth" not in one.left_out)


def test_grades_are_quarters():
    samples = [SearchSettings.of_grade(grade).samples for grade in range(5)]
    assert samples == [50_000, 12_500, 3125, 781, 195]
    assert SearchSettings.of_grade(20).samples == 32
    assert SearchSettings.of_grade(20).starts == 2
    assert SearchSettings.of_grade(3, samples=7).samples == 7


def test_what_is_asked_for_is_done_however_long_it_takes(case):
    one = plan(
        case,
        slower(1e4),
        names=["samples", "multistart"],
        growth=True,
        samples=50_000,
        starts=8,
    )
    assert one.searches == ("samples", "multistart")
    assert one.settings.samples == 50_000
    assert one.growth
    assert one.total > 600.0
    assert not one.left_out


def test_what_is_asked_for_by_its_number_is_not_left_out(case):
    times = {"minutes": 15.0}
    without = plan(case, slower(3000.0), **times)
    assert without.left_out == ("growth", "multistart", "corners")
    rest = "SQP from 2 starts; .* left out, to stay within 15 min: growth, cor"
    with pytest.raises(InputError, match=f"must be 30 or more .* {rest}"):
        plan(case, slower(3000.0), **times, starts=2)


def test_nothing_is_left_out_in_vain(case):
    """What is left out first may have gone in vain: when what takes longest goes, too.

    A run of 50 ms: growth takes some 50 runs of each limit, flips of 18 parameters at
    least 64 x 18 + 2 x 18^2 of each of four objectives: 9 min on one core. An ascent
    from two starts takes 1.6 min.
    """
    one = plan(case, slower(1000.0))
    assert one.left_out == ("growth", "corners")
    assert "multistart" in one.searches


def test_refused_with_the_time_that_is_enough(case):
    """What is granted is enough, half as long again at most, and to five minutes."""
    with pytest.raises(InputError) as refused:
        plan(case, slower(3e4))
    assert str(refused.value).count("\n") == 0
    told = re.fullmatch(
        r"minutes: must be (\d+) or more on this machine, got 10, for worst cases of 4 "
        r"objectives over 18 parameters: SQP from the nominal; about (\d+) min; left "
        r"out, to stay within 10 min: growth, multistart, corners, samples",
        str(refused.value),
    )
    assert told, refused.value
    enough, takes = map(int, told.groups())
    assert 1.5 * (takes - 1) <= enough <= 1.5 * (takes + 1) + 5
    granted = plan(case, slower(3e4), minutes=float(enough))
    assert "sqp" in granted.searches
    assert granted.total <= 60.0 * enough


def test_more_time_is_used(case):
    ten, sixty = (plan(case, slower(300.0), minutes=m) for m in (10.0, 60.0))
    assert sixty.settings.samples > ten.settings.samples
    assert sixty.settings.vertices > ten.settings.vertices
    assert ten.total <= 600.0
    assert sixty.total <= 3600.0


def test_less_time_is_kept_whatever_is_named(case):
    with pytest.raises(InputError, match=r"minutes: must be 0.0\d .* got 0\.01"):
        plan(case, FAST, names=["samples"], samples=50_000, minutes=0.01)


@pytest.mark.parametrize("minutes", [0.0, -1.0, float("nan"), float("inf"), "10"])
def test_minutes_are_a_time(minutes, tmp_path):
    with pytest.raises(InputError, match=r"^minutes must be"):
        drakesep.worst_case("vega", ["PM"], minutes=minutes, output=tmp_path / "new")
    assert not (tmp_path / "new").exists()


def test_what_takes_too_long_leaves_the_last_results(case, tmp_path):
    few = dataclasses.replace(case, tolerances={"payload.mass": 20.0}, published=())
    how = {"searches": ["drake"], "workers": 1, "output": tmp_path}
    drakesep.worst_case(few, ["PM"], **how)
    before = {file: file.read_bytes() for file in tmp_path.rglob("*.*")}
    with pytest.raises(InputError, match=r"minutes: must be 0\.\d+ or more"):
        drakesep.worst_case(few, ["PM"], minutes=1e-6, **how)
    assert before == {file: file.read_bytes() for file in tmp_path.rglob("*.*")}


@pytest.mark.parametrize("asked", [None, ["multistart", "samples"], ["drake"]])
def test_the_options_of_a_plan_plan_it_again(case, asked):
    """On any machine."""
    first = plan(case, slower(300.0), names=asked)
    options = dict(first.options)
    names, growth = options.pop("searches"), options.pop("growth")
    again = plan(case, FAST, names=list(names), growth=growth, **options)
    assert again.options == first.options
    assert again.drake_alone == first.drake_alone


def test_the_plan_stands_in_the_folder(case, tmp_path):
    few = dataclasses.replace(case, tolerances={"payload.mass": 20.0}, published=())
    study = drakesep.worst_case(
        few, ["PM"], searches=["drake"], workers=1, output=tmp_path
    )
    record = drakesep.read_results(tmp_path).record
    assert study.effort is not None
    assert record.plan == {**study.effort.options, "searches": ["drake"]}


def test_searches_that_suit():
    full = SearchSettings()
    assert default_searches(18, full, FOUR)[1] == "vertices"
    assert default_searches(34, full, FOUR)[1] == "corners"
    few = dataclasses.replace(full, vertices=32)
    assert default_searches(18, few, FOUR)[1] == "corners"


def test_functions_of_a_whole_run_are_reckoned_with(case):
    windowed = highest("rate_max_after_separation_z", window=(1.0, 2.0))
    quick = plan(case, FAST, objectives=FOUR)
    slow = plan(case, dataclasses.replace(FAST, whole_run=3e-3), objectives=[windowed])
    assert slow.total > quick.total or slow.settings.samples < quick.settings.samples


def test_drake_alone_is_reckoned_by_its_runs(case):
    one = plan(case, Speed(drake=0.02), names=["drake"])
    assert one.searches == ("sqp",)
    assert not one.growth
    # Four ascents of some eight iterations, of twenty runs each.
    assert 5.0 < one.total < 50.0


def test_speed_is_measured_on_the_batch_engine(case, vega_batch):
    nominal = drakesep.simulate(case).run
    vega_batch.run(vega_batch.nominal[None])  # compiled
    speed = measured_speed(case, FOUR, vega_batch, nominal, 0.02)
    assert speed.cores == vega_batch.workers
    assert 0.0 < speed.run < 0.02
    assert speed.measurement == speed.whole_run == 0.0


def test_pace_follows_the_plan_then_the_clock():
    now = [100.0]
    pace = Pace({"samples": 10.0, "sqp": 10.0, "growth": 20.0}, clock=lambda: now[0])
    assert pace.at("plan", 0, None) == (0.0, 40.0)
    now[0] += 20.0  # twice as slow as planned
    share, left = pace.at("samples", 100, 100)
    assert share == pytest.approx(0.25)
    assert left == pytest.approx(60.0)
    now[0] += 5.0  # it does not say how far it has come: by the time planned
    assert pace.at("sqp", 3, None).share == pytest.approx(0.25)
    now[0] += 5.0
    assert pace.at("sqp", 4, None).share == pytest.approx(0.375)
    now[0] += 50.0
    assert pace.at("sqp", 5, None).share < 0.5
    assert pace.at("samples", 1, 100).share == pytest.approx(0.4875)  # never back
    assert pace.at("growth", 10, 10) == (1.0, 0.0)


def test_times_in_words():
    assert [in_time(s) for s in (0.2, 7.4, 23.0, 61.0, 99.0, 400.0)] == [
        *("1 s", "7 s", "25 s", "60 s", "100 s", "7 min")
    ]
