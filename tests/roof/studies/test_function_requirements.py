"""Functions of a run as requirements: flown run by run, held against closed forms."""

import math

import pytest
from trade import SPEED, symmetric_design

import drakesep
from drakesep.analysis.engines.drake_pool import DrakePool
from drakesep.analysis.metrics.functions import FunctionRequirement


TOLERANCE = 20.0
"""Of the spacecraft's mass, kg."""
LIMITED = [{"quantity": "longitudinal_speed_m_s", "when": "at_end", "at_most": 1.0}]
LITTLE = {"samples": 50, "starts": 2, "growth": False}
EXACT = 1e-6
"""Of the speed: 100 times the accuracy of a run."""


def speed_in_mm_s(run) -> float:
    """Of the spacecraft as seen from the launch vehicle at the end, mm/s."""
    return 1e3 * float(run.completed_motion.relative_velocity[-1, 0])


def by_energy(mass: float) -> float:
    """The same by the closed form: 80 J between two masses, mm/s."""
    return 1e3 * math.sqrt(160.0 * (1.0 / mass + 1.0 / 2000.0))


def required(**limits) -> FunctionRequirement:
    given = {"name": "mine", "function": speed_in_mm_s, "unit": "mm/s"}
    return FunctionRequirement(**{**given, **limits})


def case(requirements=LIMITED, tolerance=TOLERANCE):
    dispersions = {"sc.mass_kg": tolerance} if tolerance else {}
    return symmetric_design(requirements=requirements, dispersions=dispersions)


FASTEST, SLOWEST = by_energy(500.0 - TOLERANCE), by_energy(500.0 + TOLERANCE)


@pytest.fixture(scope="module")
def studied():
    plans = []
    band = required(
        at_least=SLOWEST + 1.0, at_most=FASTEST + 1.0, id="UM-9", source="manual"
    )
    study = drakesep.verify(
        case(),
        requirements=[band],
        on_progress=lambda progress: plans.append(str(progress.effort)),
        **LITTLE,
    )
    return study, plans[0]


def test_each_limit_has_its_worst_by_the_closed_form(studied):
    study, _ = studied
    _, high, low = study.requirements.to_dict("records")
    assert by_energy(500.0) == pytest.approx(1e3 * SPEED, rel=1e-12)
    for row, sense, worst, margin, verdict in (
        (high, "<=", FASTEST, 1.0, "met"),
        (low, ">=", SLOWEST, -1.0, "not met"),
    ):
        assert (row["requirement"], row["unit"], row["sense"]) == (
            "mine",
            "mm/s",
            sense,
        )
        assert (row["id"], row["source"], row["pair"]) == ("UM-9", "manual", "")
        assert row["nominal"] == pytest.approx(1e3 * SPEED, rel=EXACT)
        assert row["worst"] == pytest.approx(worst, rel=EXACT)
        assert row["margin"] == pytest.approx(margin, abs=EXACT * worst)
        assert row["verdict"] == verdict
    assert study.completed and not study.passed
    assert study.verdict == "not met"


def test_tables_say_that_it_was_flown_run_by_run(studied):
    study, plan = studied
    evidence = study.evidence.set_index("objective")
    batch, *mine = evidence["flown_by"]
    assert (batch, *mine) == ("batch", *["batch, run by run"] * 2)
    assert evidence["run_by_run"].tolist()[0] == 0
    for name, sign in (("highest_mine", 1.0), ("lowest_mine", -1.0)):
        row = evidence.loc[name]
        assert row["unit"] == "mm/s"
        # A nominal and a slope at each iterate, at the least; nothing is swept.
        assert 4 <= row["run_by_run"] < 100
        assert math.isnan(row["samples"])
        at = study.table.set_index("label").loc[f"worst_{name}"]
        assert row["in_drake"] == at["mine_mm_s"]
        assert at["sc.mass_kg"] == 500.0 - sign * TOLERANCE
    assert "; flown run by run, some " in plan
    assert plan.endswith(" runs: highest_mine, lowest_mine")


def test_met_alone_and_without_tolerances():
    """The nominal run is all there is."""
    bare = case(requirements=[], tolerance=0.0)
    limit = required(at_most=1e3 * SPEED + 1.0)
    study = drakesep.verify(bare, requirements=[limit], workers=1)
    [row] = study.requirements.to_dict("records")
    assert row["worst"] == pytest.approx(1e3 * SPEED, rel=EXACT)
    assert study.passed and study.verdict == "met"
    with pytest.raises(
        ValueError, match="requirements: a case to verify must have som"
    ):
        drakesep.verify(bare, workers=1)


def test_in_drake_alone_every_run_that_is_asked_for_is_counted(monkeypatch):
    flown = []
    fly = DrakePool.fly

    def counted(pool, variations, *more):
        flown.append(len(variations))
        return fly(pool, variations, *more)

    monkeypatch.setattr(DrakePool, "fly", counted)
    plans = []
    study = drakesep.verify(
        case(requirements=[]),
        requirements=[required(at_most=FASTEST + 1.0)],
        searches=["drake"],
        workers=1,
        on_progress=lambda progress: plans.append(str(progress.effort)),
    )
    [row] = study.evidence.to_dict("records")
    assert row["flown_by"] == "Drake, run by run"
    confirmation = flown.pop()
    # One that is asked for again is known: it counts, and is not flown.
    assert row["run_by_run"] >= sum(flown) > 0 and confirmation == 1
    assert "; flown run by run in Drake, some " in plans[0]
    assert study.requirements["worst"].item() == pytest.approx(FASTEST, rel=EXACT)
    assert study.passed


def test_results_keep_what_functions_tell(tmp_path):
    """Of a run; the function itself no folder holds, so that no command is told."""
    study = drakesep.verify(
        case(requirements=[], tolerance=0.0),
        requirements=[required(at_most=1.0)],
        output=tmp_path,
        workers=1,
    )
    results = drakesep.read_results(tmp_path)
    [one] = results.runs
    assert one.of_functions == study.runs[0].of_functions
    assert results.record.verdict == "not met"
    assert results.table("requirements.csv")["worst"].item() == one.of_functions["mine"]


def fails(run):
    return run.no_such_thing


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"name": "my own"}, "name must be of letters, digits and _, got 'my own'"),
        ({"name": "G_L1"}, "'G_L1' is the name of a metric"),
        ({"name": "speed_at_end"}, "'speed_at_end' is the name of a metric"),
        ({"function": 3.0}, "function must be a function, got 3.0"),
        ({"at_most": None}, "mine: must have at_most or at_least, got none"),
        ({"at_most": math.nan}, "mine: limit must be finite, got nan"),
        ({"at_least": 2.0}, "at_least must not be above at_most, got 2 and 1"),
    ],
)
def test_what_makes_no_sense_is_refused(wrong, message):
    with pytest.raises(ValueError, match=message):
        required(**{"at_most": 1.0, **wrong})


def test_a_worst_case_that_another_run_beats_has_failed(tmp_path):
    """Differences lead to the heavy corner; the worst case of the speed is light."""

    def two_sided(run) -> float:
        speed = speed_in_mm_s(run) - by_energy(500.0)
        return min(speed, -30.0 * speed)

    study = drakesep.verify(
        case(),
        requirements=[required(function=two_sided, at_least=-1e6)],
        searches=["vertices", "sqp"],
        growth=False,
        workers=1,
        output=tmp_path,
    )
    evidence = study.evidence.set_index("objective")
    found = evidence.loc["lowest_mine"]
    heavy, light = SLOWEST - by_energy(500.0), -30.0 * (FASTEST - by_energy(500.0))
    assert found["worst"] == pytest.approx(heavy, rel=300 * EXACT)
    other = f"worst_{evidence.index[0]}"
    assert found["beaten_by"] == other
    row = study.requirements.iloc[-1]
    assert row["worst"] == pytest.approx(light, rel=300 * EXACT)
    assert row["which_run"] == other
    status = study.table.set_index("label").loc["worst_lowest_mine", "status"]
    assert status.startswith(f"failed: {other} is worse, {light:.4g}")
    assert not study.completed
    assert drakesep.read_results(tmp_path).record.ended.value == "failed"


def test_a_corner_to_which_no_slope_leads():
    """At the nominal the function falls with the mass, in a corner it is higher."""

    def two_sided(run) -> float:
        speed = speed_in_mm_s(run) - by_energy(500.0)
        return max(speed, -30.0 * speed)

    study = drakesep.verify(
        case(),
        requirements=[required(function=two_sided, at_most=60.0)],
        samples=50,
        starts=8,
        growth=False,
    )
    worst = -30.0 * (SLOWEST - by_energy(500.0))
    assert worst > 60.0 > FASTEST - by_energy(500.0)
    row = study.requirements.iloc[-1]
    assert row["worst"] == pytest.approx(worst, rel=30 * EXACT)
    assert row["verdict"] == "not met"


@pytest.mark.parametrize(
    ("functions", "message"),
    [
        ([required(at_most=1.0, function=fails)], "nominal: mine: must give a number"),
        (
            [required(at_most=1.0, function=lambda run: math.nan)],
            "nominal: mine of every run must be finite, got nan",
        ),
        ([required(at_most=1.0), required(at_least=1.0)], "'mine' must stand once"),
        ([speed_in_mm_s], "must be a FunctionRequirement, got <function"),
        ([required(at_most=1.0, name="status", unit="")], "be the column 'status' of"),
        ([required(at_most=1.0, name="label", unit="")], "be the column 'label' of"),
        ([required(at_most=1.0, name="nearest_time", unit="s")], "which is another's"),
        ([required(at_most=1.0, name="rate_at_end_x_deg", unit="s")], "another's"),
    ],
)
def test_function_that_tells_nothing_gives_no_verdict(functions, message):
    with pytest.raises(ValueError, match=message):
        drakesep.verify(case(tolerance=0.0), requirements=functions, workers=1)


def test_tolerances_grow_along_the_ray_to_the_worst_case():
    """Until the closed form is at the limit: downward where it is beyond already."""
    factors = (0.5, 2.25)
    limits = [by_energy(500.0 + TOLERANCE * factor) for factor in factors]
    study = drakesep.verify(
        case(requirements=[]),
        requirements=[
            required(name=f"mine_{i}", at_least=limit) for i, limit in enumerate(limits)
        ],
        searches=["sqp"],
        growth=True,
        workers=1,
    )
    rows = study.requirements
    assert rows["verdict"].tolist() == ["not met", "met"]
    assert rows["growth_by"].tolist() == ["ray", "ray"]
    for found, factor in zip(rows["growth_factor"], factors, strict=True):
        assert factor - 1e-3 <= found <= factor + 0.01 + 1e-3
    assert rows["first_tolerance"].tolist() == ["not looked at"] * 2


def test_what_was_not_looked_at_is_said(studied):
    study, _ = studied
    assert {*study.requirements["growth_by"]} == {"not looked at"}
    assert {*study.requirements["first_tolerance"]} == {"not looked at"}


@pytest.mark.parametrize("beyond", [False, True])
def test_a_share_of_launches_is_left_to_a_campaign(beyond):
    """How bad it gets is told; it is neither met nor violated by that."""
    bare = case(requirements=[], tolerance=0.0)
    speed = 1e3 * SPEED + (-1.0 if beyond else 1.0)
    limit = required(at_most=speed, share=0.99865, confidence=0.9)
    study = drakesep.verify(bare, requirements=[limit], workers=1)
    [row] = study.requirements.to_dict("records")
    assert row["worst"] == pytest.approx(1e3 * SPEED, rel=EXACT)
    assert (row["margin"] < 0.0) == beyond
    assert (row["share"], row["confidence"], row["sides"]) == (0.99865, 0.9, "one")
    assert row["verdict"] == study.verdict == "not looked at" and not study.passed
    other = required(name="other", at_most=1e3 * SPEED - 1.0)
    study = drakesep.verify(bare, requirements=[limit, other], workers=1)
    assert study.verdict == "not met"


def test_two_sides_have_two_limits():
    with pytest.raises(ValueError, match="of two sides must have at_most and at_least"):
        required(at_most=1.0, share=0.9973, confidence=0.9, sides="two")
    with pytest.raises(ValueError, match="must have share and confidence, got no sha"):
        required(at_most=1.0, confidence=0.9)
