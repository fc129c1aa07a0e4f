"""A case in SI, made in Python: what it refuses, and that copies are checked."""

import dataclasses
import math
import pickle

import pytest
from separations import generic_pair
from toy_metrics import RELATIVE, RELATIVE_MIN, registered

from drakesep.analysis.analysis_case import (
    AnalysisCase,
    ClearancePairs,
    PrintedResult,
    PublishedCase,
)
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.analysis.tolerances.ellipsoid import Ellipsoid
from drakesep.systems.checks import InputError
from drakesep.systems.model.parameters import parameters, with_values


SPEED = Requirement(metric="longitudinal_speed_after_separation", sense=">=", limit=0.5)
ROLL = Requirement(metric="deviation_at_separation_roll", sense="<=", limit=0.02)


def case(**changes) -> AnalysisCase:
    given = {
        "separation": generic_pair(),
        "tolerances": {"upper.mass": 20.0, "upper.cg_y": 0.01},
        "requirements": (SPEED, ROLL),
        "objectives": "paper",
        "published": (PublishedCase(label="paper", values={"upper.mass": 1210.0}),),
    }
    return AnalysisCase(**{**given, **changes})


def test_set_of_the_tolerances_is_around_the_separation():
    made = case(ellipsoids=(Ellipsoid(names=("upper.mass", "upper.cg_y")),))
    nominal = parameters(made.separation)
    assert made.box.names == ("upper.mass", "upper.cg_y")
    assert made.box.nominal.tolist() == [nominal[name] for name in made.box.names]
    assert made.box.tolerance.tolist() == [20.0, 0.01]
    # An ellipsoid holds the end of each axis, and no corner.
    assert made.tolerance_set.contains([[1.0, 0.0], [1.0, 1.0]]).tolist() == [
        True,
        False,
    ]
    heavier = with_values(made.separation, {"upper.mass": 1500.0})
    moved = dataclasses.replace(made, separation=heavier)
    assert moved.box.nominal[0] == 1500.0


def test_limits_of_deviations_and_objectives():
    made = case()
    assert made.deviation_limits == (0.02, math.inf, math.inf)
    of_requirements = (
        "lowest_longitudinal_speed_after_separation",
        *("deviation_at_separation_roll_up", "deviation_at_separation_roll_down"),
    )
    time, of_paper = "lowest_deviation_within_limits_until", ("L1", "L2", "Linf", "PM")
    assert made.objective_names == (*of_paper, *of_requirements, time)
    objectives = [objective.name for objective in made.requirement_objectives]
    assert tuple(objectives) == (*of_requirements, time)
    assert tuple(o.name for o in made.paper_objectives) == of_paper
    plain = dataclasses.replace(made, objectives=None, published=())
    assert plain.objective_names == of_requirements
    assert plain.paper_objectives == ()


WRONG = [
    ({"tolerances": {"upper.mas": 1.0}}, "unknown parameter 'upper.mas'; did you mean"),
    ({"tolerances": {"upper.mass": 1300.0}}, "upper.mass: tolerance must keep to phys"),
    ({"tolerances": {"upper.mass": -1.0}}, "upper.mass: tolerance must be > 0, got -1"),
    (
        {"ellipsoids": (Ellipsoid(names=("upper.cg_z", "upper.mass")),)},
        "ellipsoids: .*upper.cg_z",
    ),
    ({"requirements": (SPEED, SPEED)}, "requirements: longitudinal.* must stand once"),
    (
        {"requirements": (dataclasses.replace(SPEED, metric="velocity"),)},
        "requirements: unknown metric 'velocity'",
    ),
    (
        {"requirements": (Requirement(metric="clearance", sense=">=", limit=0.1),)},
        "requirements: clearance needs geometry on two bodies",
    ),
    (
        {"clearance": ClearancePairs(touching=(("ring", "flange"),))},
        "clearance: pair: unknown part 'ring'",
    ),
    ({"published": 2 * case().published}, "published: label 'paper' must stand once"),
    ({"objectives": "L1"}, "objectives: must be 'paper' or left out, got 'L1'"),
    ({"objectives": None}, "published: .* need 'objectives: paper' beside them"),
    (
        {"published": (PublishedCase(label="paper", values={"upper.mass": -1.0}),)},
        "published: paper: upper: mass must be > 0, got -1",
    ),
]


@pytest.mark.parametrize(("wrong", "message"), WRONG)
def test_what_does_not_fit_is_refused_when_made_and_when_varied(wrong, message):
    with pytest.raises(InputError, match=message):
        case(**wrong)
    with pytest.raises(InputError, match=message):
        dataclasses.replace(case(), **wrong)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: PublishedCase(label="../paper", values={}),
            "label must be made of letters, digits, _ and -, got '../paper'",
        ),
        (
            lambda: PublishedCase(label="paper", values={}, objectives=("L3",)),
            "published: paper: unknown objective 'L3'; did you mean",
        ),
        (
            lambda: PrintedResult(
                rate=(0.0, math.nan, 0.0),
                deviation_within_limits_until=1.0,
                longitudinal_speed=1.0,
                iterations=3,
            ),
            "rate must be finite, got nan",
        ),
    ],
)
def test_parts_check_themselves(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_it_is_a_value():
    """Equal to another made alike; the same after it was sent to a process."""
    made = case()
    assert made == case()
    assert made != case(tolerances={"upper.mass": 21.0, "upper.cg_y": 0.01})
    assert pickle.loads(pickle.dumps(made)) == made
    with pytest.raises(dataclasses.FrozenInstanceError):
        made.tolerances = {}


@pytest.mark.parametrize(
    ("metric", "sense", "limit", "message"),
    [
        (
            "clearance",
            "<=",
            0.1,
            "clearance: a limit from above must be none, of a clearance",
        ),
        ("clearance", ">=", 0.0, "from below must be > 0, got 0"),
        ("rate_after_separation_x", "<=", -0.1, "from above must be >= 0, got -0.1"),
        ("rate_after_separation_x", ">=", 0.0, "from below must be > 0, got 0"),
        ("separation_end", ">=", -1.0, "from below must be > 0, got -1"),
        ("rate_after_separation", "<=", 0.1, "unknown metric 'rate_after_separation'"),
        (
            "deviation_within_limits_until",
            ">=",
            1.0,
            "needs a requirement '<=' on deviation_at_separation, got none",
        ),
    ],
)
def test_limit_that_would_be_held_unseen_is_refused(metric, sense, limit, message):
    """Searched on its harmless side, it would be met."""
    required = Requirement(metric=metric, sense=sense, limit=limit)
    with pytest.raises(InputError, match=f"requirements: .*{message}"):
        case(requirements=(required,))


def test_a_largest_magnitude_says_nothing_from_below():
    """A rate that is large once would meet it, be it zero at all other times."""
    alone = dataclasses.replace(RELATIVE, at_least="")
    required = Requirement(metric=alone.names[0], sense=">=", limit=0.1)
    with registered(alone), pytest.raises(InputError, match="by a smallest magnitude"):
        case(requirements=(required,))
    with registered(RELATIVE, RELATIVE_MIN):
        assert case(requirements=(required,)).requirements == (required,)


def test_what_is_done_with_a_dict_changes_nothing():
    tolerances, values = {"upper.mass": 20.0}, {"upper.mass": 1210.0}
    published = PublishedCase(label="paper", values=values)
    made = case(tolerances=tolerances, published=(published,))
    tolerances["upper.mass"] = values["upper.mass"] = 40.0
    assert made.tolerances == {"upper.mass": 20.0}
    assert made.box.tolerance.tolist() == [20.0]
    assert published.values == {"upper.mass": 1210.0}
    for mine in (made.tolerances, published.values):
        with pytest.raises(TypeError, match="does not support item assignment"):
            mine["upper.mass"] = 1.0
    assert hash(pickle.loads(pickle.dumps(made.tolerances))) == hash(made.tolerances)
