"""Clearances of one body to another, and that nothing touches, by closed forms.

A spacecraft leaves straight along x and drifts sideways, past the ball of a neighbour,
which is let go at the same time, and stays where it is. All push through CGs: nothing
turns.
"""

import copy
import math

import numpy as np
import pytest
from command_line import run
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar
from small_case import write_case
from trade import JOINT

import drakesep
from drakesep.analysis.clearance.objective import LowestClearance
from drakesep.case_file.case import Case
from drakesep.case_file.objectives import choose_objectives, clearances_of
from drakesep.systems.model.run import Run, RunStatus, Trajectory
from drakesep.systems.model.separation import Pair, leaving_among
from drakesep.systems.simulation.simulation import Simulation


ENERGY, STROKE, FORCE = 60.0, 0.08, 1500.0
LV, SC, NEIGHBOUR = 2000.0, 500.0, 100.0
MU = 1.0 / (1.0 / SC + 1.0 / LV)
SPEED = math.sqrt(2.0 * ENERGY / MU)
"""m/s, of the spacecraft as seen from the launch vehicle."""
SIDE, SHARE = 60.0, 0.2
"""Force of the thruster that drives it sideways, N, and what is not known of it."""
PLACE = np.array([0.5, 0.5])
"""Of the neighbour's ball from the spacecraft's while mated, along x and y, m."""
RADII = 0.2
LITTLE = {"samples": 50, "starts": 2, "growth": False, "workers": 1}
EXACT = 0.06
"""mm, to which a clearance is measured, and a little more for the run's accuracy."""


def drifting(requirements, **changes) -> Case:
    """The case, with requirements and sections changed."""

    def body(mass, x, y=0.0, **ball):
        inertia = dict.fromkeys(("xx", "yy", "zz"), 0.4 * mass)
        sphere = {"sphere": {"radius_mm": 1e3 * 0.5 * RADII}, "position_mm": [x, y, 0]}
        return {
            "mass_kg": mass,
            "cg_mm": [x, y, 0.0],
            "inertia_kg_m2": inertia,
            "geometry": {f"{name}": sphere | more for name, more in ball.items()},
        }

    spring = {"law": "displacement", "force_max_N": FORCE, "stroke_mm": 1e3 * STROKE}
    x, y = 1e3 * PLACE
    data = {
        "name": "drifting",
        "pair": {"A": "lv", "B": "sc"},
        "bodies": {
            "lv": body(LV, -600.0, lv_ball={"position_mm": [-300, 0, 0]}),
            "sc": body(SC, 600.0, sc_ball={"position_mm": [0, 0, 0]}),
            "nb": body(NEIGHBOUR, -600.0, nb_ball={"position_mm": [x, y, 0]}),
        },
        "attachments": {
            "pad": {
                "A": "lv",
                "B": "sc",
                "position_mm": [0, 0, 0],
                "joint": JOINT,
                "spring": {"name": "push", **spring},
                "release_time_s": 0.0,
            },
            "hold": {
                "A": "lv",
                "B": "nb",
                "position_mm": [-600, 0, 0],
                "joint": JOINT,
                "release_time_s": 0.0,
            },
        },
        "loads": {
            "side": {
                "body": "sc",
                "position_mm": [600, 0, 0],
                "direction": [0, 1, 0],
                "times_s": [0.0, 2.0],
                "thrusts_N": [SIDE, SIDE],
            }
        },
        "dispersions": {"side.factor": SHARE},
        "requirements": requirements,
        "run": {"duration_s": 1.8, "accuracy": 1e-8},
    }
    return Case.model_validate(copy.deepcopy(data | changes))


def place(t: float, factor: float = 1.0) -> np.ndarray:
    """Where the spacecraft's ball is in W, m.

    As seen from the launch vehicle, along x: a quarter of a cosine, then straight on.
    """
    w = SPEED / STROKE
    end = 0.5 * math.pi / w
    x = STROKE * (1.0 - math.cos(w * t)) if t < end else STROKE + SPEED * (t - end)
    return np.array([x * MU / SC, 0.5 * factor * SIDE / SC * t**2])


def time_at(x: float) -> float:
    """When it has moved so far along x as seen from the launch vehicle, s."""
    return 0.5 * math.pi * STROKE / SPEED + (x - STROKE) / SPEED


def distance(factor: float, until: float) -> float:
    """How near it comes to the neighbour until it has moved so far along x, mm."""

    def apart(t):
        return float(np.linalg.norm(place(t, factor) - PLACE))

    end = time_at(until)
    inside = minimize_scalar(apart, bounds=(0.0, end), options={"xatol": 1e-9})
    return 1e3 * (min(inside.fun, apart(0.0), apart(end)) - RADII)


def moved(t: float) -> float:
    """How far the spacecraft has moved along x as seen from the launch vehicle, m."""
    return float(place(t)[0]) * SC / MU


CLEAR = {"quantity": "clearance_mm", "pair": "sc"}
NO_CONTACT = {"quantity": "no_contact"}
END = 0.9
"""m, which it moves in 1.7 s."""


@pytest.fixture(scope="module")
def study():
    return drakesep.verify(
        drifting(
            [
                {**CLEAR, "at_least": 99.0, "id": "A"},
                {**CLEAR, "at_least": 101.0, "id": "A+"},
                {**CLEAR, "to": "nb", "at_least": 20.0, "until_separation_mm": 300},
                {**CLEAR, "to": "nb", "at_least": 170.0, "until_separation_mm": 900},
                {**CLEAR, "to": "nb", "at_least": 20.0, "until_separation_mm": 5000},
                {**NO_CONTACT, "until_separation_mm": 900, "source": "UM"},
                {**NO_CONTACT, "pair": "sc", "to": "nb"},
            ]
        ),
        **LITTLE,
    )


@pytest.fixture(scope="module")
def rows(study):
    return study.requirements.to_dict("records")


def test_speed_by_the_closed_form(study):
    [nominal, *_] = study.runs
    speed = nominal.metrics["longitudinal_speed_max"]
    # As it drifts, the push is some millimetres beside A's CG, and turns it: 2e-4 of
    # the speed.
    assert speed == pytest.approx(SPEED, rel=4e-4)


def test_to_its_own_launch_vehicle_it_is_nearest_while_mated(rows):
    """Two balls that leave each other straight: 100 mm at the start."""
    for row, verdict in ((rows[0], "met"), (rows[1], "not met")):
        assert row["requirement"] == "clearance to lv"
        assert (row["nominal"], row["worst"]) == pytest.approx((100.0,) * 2, abs=EXACT)
        assert row["verdict"] == verdict


@pytest.mark.parametrize(("row", "until"), [(2, 0.3), (3, END)])
def test_past_its_neighbour_it_drifts_nearer(rows, row, until):
    found = rows[row]
    assert found["requirement"] == f"clearance to nb until {until:g} m"
    # That nothing is nearer than the extremes of the force is seen of the closed form.
    nominal, *ends = (distance(f, until) for f in (1.0, 1.0 - SHARE, 1.0 + SHARE))
    between = [distance(f, until) for f in np.linspace(1.0 - SHARE, 1.0 + SHARE, 21)]
    assert min(ends) == min(between)
    assert found["nominal"] == pytest.approx(nominal, abs=EXACT)
    assert found["worst"] == pytest.approx(min(ends), abs=EXACT)
    assert found["margin"] == pytest.approx(min(ends) - found["limit"], abs=EXACT)
    assert found["verdict"] == ("met" if found["margin"] > 0.0 else "not met")


def test_both_windows_have_their_own_verdict(rows):
    assert [row["verdict"] for row in rows[2:4]] == ["met", "not met"]
    assert rows[2]["worst"] > rows[3]["worst"]


def test_window_whose_end_is_not_reached_was_not_looked_at(rows, study):
    assert rows[4]["verdict"] == "not looked at"
    assert math.isnan(rows[4]["nominal"]) and math.isnan(rows[4]["worst"])
    assert not study.passed
    assert study.verdict == "not met"


def test_no_contact_is_met_by_any_clearance(rows):
    for row, said in (
        (rows[5], "no contact until 0.9 m"),
        (rows[6], "no contact to nb"),
    ):
        assert row["requirement"] == said
        assert (row["sense"], row["limit"], row["verdict"]) == (">", 0.0, "met")
    assert rows[5]["source"] == "UM"
    # All parts: the nearest are those of the launch vehicle and the spacecraft, or the
    # neighbour.
    least = min(100.0, distance(1.0 + SHARE, END))
    assert rows[5]["worst"] == pytest.approx(least, abs=EXACT)


def test_tables_have_a_column_for_each_clearance(study):
    table = study.table.set_index("label")
    name = "clearance_to_nb_until_0.9_m"
    worst = table.loc[f"worst_lowest_{name}"]
    assert worst["nearest"] == "sc_ball to nb_ball"
    assert worst[f"{name}_mm"] == study.requirements["worst"][3]
    assert worst["side.factor"] == pytest.approx(1.0 + SHARE)


def test_a_sweep_measures_each_clearance_that_is_required():
    near, far = (
        {**CLEAR, "to": "nb", "at_least": 20.0, "until_separation_mm": mm}
        for mm in (300, 900)
    )
    factors = [1.0 - SHARE, 1.0 + SHARE]
    table = drakesep.sweep(
        drifting([near, far]), {"side.factor": factors}, workers=1
    ).table
    for until in (0.3, 0.9):
        found = table[f"clearance_to_nb_until_{until}_m_mm"].tolist()
        expected = [distance(factor, until) for factor in factors]
        assert found == pytest.approx(expected, abs=EXACT)


def test_no_contact_is_not_met_where_parts_touch():
    """The neighbour stands in the way: the ball hits it, 0 mm."""
    bodies = drifting([NO_CONTACT]).model_dump(mode="json", exclude_none=True)["bodies"]
    bodies["nb"]["geometry"]["nb_ball"]["position_mm"] = [500.0, 80.0, 0.0]
    case = drifting([{**NO_CONTACT, "pair": "sc", "to": "nb"}], bodies=bodies)
    study = drakesep.verify(case.replaced(dispersions={}), workers=1)
    [row] = study.requirements.to_dict("records")
    assert (row["worst"], row["margin"], row["verdict"]) == (0.0, 0.0, "not met")
    assert study.completed and not study.passed
    # Nor is it where the run ends before the window does: they have touched.
    window = {**NO_CONTACT, "pair": "sc", "to": "nb", "until_separation_mm": 5000}
    case = drifting([window], bodies=bodies).replaced(dispersions={})
    [row] = drakesep.verify(case, workers=1).requirements.to_dict("records")
    assert (row["worst"], row["verdict"]) == (0.0, "not met")


def test_a_slow_run_whose_window_does_not_end_takes_the_verdict():
    """It moves 940 mm, with a spring of 10 % less 900; all are nearest at the start.

    Nothing else is required that would lead there.
    """
    window = {**CLEAR, "at_least": 50.0, "until_separation_mm": 930}
    case = drifting([window], dispersions={"push.force_max_N": 0.1 * FORCE})
    study = drakesep.verify(case, searches=["drake"], workers=1)
    [row] = study.requirements.to_dict("records")
    assert row["nominal"] == pytest.approx(100.0, abs=EXACT)
    assert row["verdict"] == "not looked at"
    assert row["which_run"] == "worst_lowest_longitudinal_displacement_at_end"
    assert study.completed and not study.passed


@pytest.mark.parametrize(
    ("required", "code"),
    [
        ({**NO_CONTACT}, 0),
        ({**CLEAR, "at_least": 101.0}, 1),
        ({**NO_CONTACT, "until_separation_mm": 5000}, 1),
    ],
)
def test_exit_code(tmp_path, capsys, monkeypatch, required, code):
    case = drifting([required], dispersions={})
    path = write_case(tmp_path, case.model_dump(mode="json", exclude_none=True))
    arguments = ("verify", path, "--workers", "1", "-o", tmp_path / "out")
    assert run(capsys, monkeypatch, *arguments)[0] == code


@given(
    sideways=st.floats(-3.0, 3.0), forward=st.floats(-3.0, 3.0), at=st.floats(0.3, 2.0)
)
def test_a_requirement_on_one_pair_does_not_look_at_others(sideways, forward, at):
    """Wherever the third body goes, through both of them too."""
    record = drifting([{**CLEAR, "at_least": 5.0, "until_separation_mm": 400}]).in_si()
    [requirement] = record.requirements
    [objective] = record.towards(requirement)
    still = straight_run(record.separation, (5.0, 5.0), (0.0, 0.0))
    crossing = straight_run(record.separation, (at, at), (sideways, forward))
    assert objective(crossing) == objective(still)
    # B leaves A at 1 m/s along x, from 300 mm between centres of balls of 100 mm.
    assert objective(still) == pytest.approx(-0.1, abs=1e-6)


def both_leave(requirement):
    """The neighbour is B of a pair too, and leaves along y; what leads out of it."""
    pairs = [
        {"A": "lv", "B": "sc"},
        {"A": "lv", "B": "nb", "direction": [0.0, 1.0, 0.0]},
    ]
    record = drifting([requirement], pair=None, pairs=pairs).in_si()
    [required] = record.requirements
    [objective] = record.towards(required)
    return required, objective, record.separation


@pytest.mark.parametrize(
    ("until", "expected", "ended"),
    [
        (200, math.hypot(0.3, 0.6), True),  # nearest at 0.2 s, of the 0.4 that count
        (50, math.hypot(0.4, 0.55), True),  # until 0.1 s
        (700, math.hypot(0.3, 0.6), False),  # in 1 s the neighbour moves 0.5 m
    ],
)
def test_the_window_is_that_of_the_body_that_is_named(until, expected, ended):
    window = {"at_least": 1.0, "until_separation_mm": until}
    required, objective, separation = both_leave(
        {"quantity": "clearance_mm", "pair": "nb", "to": "sc", **window}
    )
    assert required.metric == f"nb.clearance_to_sc_until_{1e-3 * until:g}_m"
    assert objective.name == f"lowest_{required.metric}"
    # The one leaves along x at 1 m/s, the other along y at 0.5: balls 500 mm aside.
    run = straight_run(separation, (0.0, 0.0), (0.0, 0.5))
    assert -objective(run) == pytest.approx(expected - RADII, abs=1e-6)
    assert objective.is_window_ended(run) == ended


def test_where_all_parts_are_measured_every_body_moves_so_far():
    for until, ended in ((400, True), (700, False)):
        window = {"at_least": 1.0, "until_separation_mm": until}
        _, objective, separation = both_leave({"quantity": "clearance_mm", **window})
        run = straight_run(separation, (0.0, 0.0), (0.0, 0.5))
        assert objective.is_window_ended(run) == ended
        assert -objective(run) == pytest.approx(0.1, abs=1e-6)


@pytest.mark.parametrize(
    ("parts", "ended"),
    [
        (("sc_ball", "nb_ball"), {400: True, 700: False}),  # both leave
        (("nb_ball", "lv_ball"), {400: True, 700: False}),
        (
            ("lv_ball", "sc_ball"),
            {400: True, 700: True},
        ),  # the neighbour does not count
    ],
)
def test_a_window_of_two_parts_is_that_of_their_bodies_that_leave(parts, ended):
    """In 1 s the spacecraft moves 1 m, the neighbour 0.5 m."""
    for until, expected in ended.items():
        window = {"at_least": 1.0, "until_separation_mm": until}
        required, objective, separation = both_leave(
            {"quantity": "clearance_mm", "parts": [parts], **window}
        )
        a, b = parts
        assert required.metric == f"clearance_of_{a}+{b}_until_{1e-3 * until:g}_m"
        run = straight_run(separation, (0.0, 0.0), (0.0, 0.5))
        assert objective.is_window_ended(run) == expected


def test_two_parts_alone_are_measured():
    """The nearest of all are others: balls of the launch vehicle and the spacecraft."""
    window = {"at_least": 1.0, "until_separation_mm": 200}
    parts = {"parts": [["sc_ball", "nb_ball"]]}
    _, objective, separation = both_leave(
        {"quantity": "clearance_mm", **parts, **window}
    )
    run = straight_run(separation, (0.0, 0.0), (0.0, 0.5))
    assert -objective(run) == pytest.approx(math.hypot(0.3, 0.6) - RADII, abs=1e-6)


def test_each_pair_of_parts_is_held_by_itself():
    pairs = [["sc_ball", "nb_ball"], ["sc_ball", "lv_ball"]]
    case = drifting([{**NO_CONTACT, "parts": pairs, "id": "UM"}])
    names = [f"clearance_of_{a}+{b}" for a, b in pairs]
    assert [(r.metric, r.id) for r in case.limits] == [(name, "UM") for name in names]
    assert case.in_si().objective_names == tuple(f"lowest_{name}" for name in names)


def test_parts_of_a_requirement_need_not_be_those_of_the_case():
    """To vary the place of one has an effect."""
    given = {
        "clearance": {"pairs": [["sc_ball", "lv_ball"]]},
        "dispersions": {"nb_ball.position_x_mm": 5.0},
    }
    drifting([{**NO_CONTACT, "parts": [["sc_ball", "nb_ball"]]}], **given)
    with pytest.raises(ValueError, match=r"nb_ball.position_x: must be of a part"):
        drifting([{**NO_CONTACT}], **given)


def test_whose_clearance_must_be_said_where_several_leave():
    with pytest.raises(ValueError, match="to nb: must have 'pair', got none"):
        both_leave({"quantity": "clearance_mm", "to": "nb", "at_least": 1.0})


def test_any_clearance_is_an_objective_by_its_name():
    record = drifting([NO_CONTACT]).in_si()
    names = ["lowest_clearance_to_nb_until_0.3_m", "lowest_clearance"]
    chosen = choose_objectives(record, names)
    assert [objective.name for objective in chosen] == names
    assert [*clearances_of(chosen)] == [n.removeprefix("lowest_") for n in names]
    with pytest.raises(ValueError, match="clearance_to_nc: unknown body 'nc'"):
        choose_objectives(record, ["lowest_clearance_to_nc"])


def straight_run(separation, start, velocity):
    """B leaves along x at 1 m/s, and the neighbour goes its way."""
    time = np.linspace(0.0, 1.0, 9)
    states = np.zeros((9, 3, 13))
    states[..., 0] = 1.0
    states[:, 1, 4] = time
    states[:, 1, 10] = 1.0
    for i, (p, v) in enumerate(zip(start, velocity, strict=True)):
        states[:, 2, 4 + i] = p + v * time
        states[:, 2, 10 + i] = v
    motion = Trajectory(names=("lv", "sc", "nb"), time=time, states=states)
    return Run(separation=separation, status=RunStatus.COMPLETED, trajectory=motion)


WRONG = [
    ({**CLEAR, "to": "nc", "at_least": 1.0}, "unknown body 'nc'; did you mean"),
    ({**CLEAR, "to": "sc", "at_least": 1.0}, "must be to another body than sc"),
    ({**CLEAR, "pair": "nb", "at_least": 1.0}, "unknown body that leaves 'nb'"),
    ({**CLEAR}, "must have 'at_most', 'at_least' or both, got none"),
    ({**CLEAR, "at_least": 0.0}, "that nothing touches is 'quantity: no_contact'"),
    ({**NO_CONTACT, "at_least": 1.0}, "no_contact has no limit"),
    ({"quantity": "separation_end_s", "at_most": 1, "to": "nb"}, "to must stand with"),
    ({**NO_CONTACT, "when": "at_end"}, "no_contact has no 'when'"),
    (
        {**CLEAR, "at_most": 1.0},
        "clearance_to_lv_mm: at_most must be none, of a clearance: .*, got 1",
    ),
    (
        {**CLEAR, "parts": [["sc_ball", "nb_ball"]], "at_least": 1.0},
        "must have 'parts', or 'pair' and 'to', got both",
    ),
    ({**NO_CONTACT, "parts": [["sc_ball", "nb_bal"]]}, "unknown part 'nb_bal'"),
    (
        {**NO_CONTACT, "parts": [["sc_ball", "sc_ball"]]},
        "of different bodies|two bodies",
    ),
    ({**NO_CONTACT, "parts": []}, "parts: must be one pair or more, got none"),
    ({"quantity": "speed_m_s", "at_most": 1, "parts": []}, "parts must stand with"),
    ({**NO_CONTACT, "of": "pad"}, "no_contact: must be of one by 'pair', got pad"),
]


@pytest.mark.parametrize(("wrong", "message"), WRONG)
def test_what_makes_no_sense_is_refused(wrong, message):
    with pytest.raises(ValueError, match=message):
        drifting([wrong])


def test_geometry_must_be_there():
    bodies = drifting([NO_CONTACT]).model_dump(mode="json", exclude_none=True)["bodies"]
    bodies["nb"]["geometry"] = {}
    assert drifting([NO_CONTACT], bodies=bodies).has_clearance
    with pytest.raises(ValueError, match="needs geometry on sc and nb that does not"):
        drifting([{**NO_CONTACT, "to": "nb"}], bodies=bodies)


def test_the_name_of_a_clearance_depends_on_itself_alone():
    """Whatever is required beside it; every window is in its name."""
    every = [
        {"quantity": "clearance_mm", "at_least": 30, "until_separation_mm": 500},
        {**NO_CONTACT},
        {**CLEAR, "to": "nb", "at_least": 20, "until_separation_mm": 300},
        {**NO_CONTACT, "parts": [["sc_ball", "nb_ball"]], "until_separation_mm": 250},
    ]
    names = [
        *("clearance_until_0.5_m", "clearance", "clearance_to_nb_until_0.3_m"),
        "clearance_of_sc_ball+nb_ball_until_0.25_m",
    ]
    together = drifting(every).in_si()
    assert [r.metric for r in together.requirements] == names
    for section, name in zip(every, names, strict=True):
        assert [r.metric for r in drifting([section]).limits] == [name]
    # And what keeps B from the end of a window.
    names += ["longitudinal_displacement_at_end"]
    assert together.objective_names == tuple(f"lowest_{name}" for name in names)


BOTH = [
    {"A": "lv", "B": "nb", "direction": [0, 1, 0]},
    {"A": "lv", "B": "sc", "direction": [1, 0, 0]},
]
"""The neighbour, which does not move along y, stands first."""
TURNED = 0.5
"""mm, within 1 m of the launch vehicle, which turns by less than 0.5 mrad: the push on
it wanders sideways with the pad, which the thruster drives aside meanwhile."""


def test_separation_is_that_of_the_body_that_leaves(tmp_path):
    """Of the launch vehicle and the spacecraft the second pair's, by closed form."""
    measured = drakesep.clearance(drifting([], pair=None, pairs=BOTH), output=tmp_path)
    rows = measured.summary.set_index(["first", "second"])
    for (first, second), row in rows.iterrows():
        of_second = {first, second} == {"lv_ball", "sc_ball"}
        expected = 1e3 * moved(row["time_s"]) if of_second else 0.0
        assert row["separation_mm"] == pytest.approx(expected, abs=TURNED)
    table = drakesep.read_results(tmp_path).table("clearance.csv")
    expected = [1e3 * moved(t) for t in table["time_s"]]
    assert table["sc.separation_mm"].to_numpy() == pytest.approx(expected, abs=TURNED)
    assert table["separation_mm"].to_numpy() == pytest.approx(0.0, abs=TURNED)
    drawn = measured._curves
    assert len(drawn) == 3
    for curve in drawn.values():
        pair = {curve.smallest.first, curve.smallest.second}
        end = 1e3 * curve.separation[-1]
        at_end = expected[-1] if pair == {"lv_ball", "sc_ball"} else 0.0
        assert end == pytest.approx(at_end, abs=TURNED)


@pytest.mark.parametrize(
    ("names", "end"),
    [(("lv_ball", "sc_ball"), moved(1.8)), (("lv_ball", "nb_ball"), 0)],
)
def test_an_approach_is_drawn_over_the_way_of_its_body(names, end):
    record = drifting([], pair=None, pairs=BOTH).in_si()
    flown = Simulation(record.separation, record.integration).run()
    clearance = LowestClearance(record.separation, [names])
    way, _ = clearance.approach(flown, clearance.nearest(flown))
    assert way[-1] == pytest.approx(end, abs=1e-3 * TURNED)


@pytest.mark.parametrize(
    ("bodies", "leaving"),
    [
        (("stage", "ring"), "ring"),
        (("ring", "sat"), "sat"),  # that of the two, though the ring leaves first
        (("stage", "sat"), "sat"),  # whatever it leaves
        (("cube", "sat"), "sat"),
        (("cube", "ring"), "ring"),
        (("stage", "arm"), "ring"),  # neither leaves
    ],
)
def test_which_body_leaves(bodies, leaving):
    chain = [("stage", "ring"), ("ring", "sat"), ("stage", "cube")]
    pairs = [Pair(A=A, B=B) for A, B in chain]
    assert leaving_among(pairs, bodies).B == leaving
    assert leaving_among(pairs, bodies[::-1]).B == leaving


@pytest.mark.slow
@pytest.mark.parametrize("until", [0.3, END])
def test_a_campaign_tells_what_the_closed_form_does_of_its_draws(until):
    """To its neighbour, which leaves as well; to its launch vehicle nothing changes."""
    required = {**CLEAR, "share": 0.6, "confidence": 0.9}
    near = {"to": "nb", "at_least": distance(1.1, until)}
    window = {"until_separation_mm": 1e3 * until}
    study = drakesep.campaign(
        drifting([{**required, **near, **window}, {**required, "at_least": 99.0}]), 100
    )
    to_nb, to_lv = study.findings
    rows = study.draws
    true = np.array([distance(factor, until) for factor in rows["side.factor"]])
    name = f"clearance_to_nb_until_{until:g}_m_mm"
    measured = rows[name].notna()
    assert rows.loc[measured, name].to_numpy() == pytest.approx(
        true[measured], abs=EXACT
    )
    assert (rows[f"at_least_{name}"] <= true + EXACT).all()
    sure = np.abs(true - near["at_least"]) > EXACT
    beyond = (true[sure] < near["at_least"]).sum()
    assert 10 < beyond <= to_nb.beyond <= beyond + (~sure).sum()
    bound = np.sort(true)[to_nb.size.rank - 1]
    assert 1e3 * to_nb.bound == pytest.approx(bound, abs=EXACT + 0.1)
    assert to_lv.beyond == 0
    assert 1e3 * to_lv.bound == pytest.approx(100.0, abs=EXACT + 0.1)
    assert study.passed and study.completed
