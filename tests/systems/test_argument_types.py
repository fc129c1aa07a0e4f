"""Arguments of another type than they are said to be are refused by their names.

Of every public function and class, found by walking what the packages export; before
anything is done, whatever else is given or missing.
"""

import collections.abc
import importlib
import inspect
import types
import typing

import numpy as np
import pytest

from drakesep.case_file.reader import load_case
from drakesep.studies.simulate import simulate
from drakesep.studies.verification import verify
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError
from drakesep.systems.model.separation import Body
from drakesep.systems.simulation.simulation import Simulation


PACKAGES = ("drakesep", "drakesep.systems", "drakesep.analysis")
RESULTS = {
    *("Ascent", "BatchEvaluator", "BatchResult", "Campaign", "CampaignProgress"),
    *("Bound", "Bounds"),
    *("Clearance", "Clearances", "Comparison", "Contact", "RareEvents"),
    *("Sensitivity", "Summary", "Tally"),
    *("ContactForces", "Evaluator", "Evidence", "Finding", "Growth", "Iteration"),
    *(
        "MassProperties",
        "MetricObjective",
        "Motion",
        "Objective",
        "Optimality",
        "Progress",
        "Results",
    ),
    *("Run", "RunEvaluator", "RunStatus", "SearchProgress", "SearchStatus", "Searched"),
    *("Simulated", "Sweep", "SweepProgress", "Trajectory", "Verification"),
    *("WorstCase", "WorstCases"),
}
"""What we make, and what a user subclasses."""
ELSEWHERE = {"Case", "CaseError", "DrakesepWarning", "InputError"}
"""A case is checked by its schema: test_sections.py."""
BAD = {
    "none": None,
    "text": "x",
    "true": True,
    "number": 1.5,
    "whole": 3,
    "digits": 10**5000,
    "complex": 1j,
    "masked": np.ma.masked,
    "masked array": np.ma.array([1.0, 2.0, 3.0], mask=[False, True, False]),
    "list": [object()],
    "bytes": b"x",
}
GOOD = {
    type(None): {"none"},
    str: {"text"},
    bool: {"true"},
    int: {"whole"},
    float: {"whole", "number"},
    np.ndarray: {"whole", "number"},
    typing.Literal: {"text"},
}
"""Which of them an argument takes that is of a type."""


def public():
    for package in PACKAGES:
        module = importlib.import_module(package)
        for name in module.__all__:
            thing = getattr(module, name)
            if callable(thing) and name not in RESULTS | ELSEWHERE:
                yield pytest.param(thing, id=f"{package}.{name}")


def taken(wanted):
    """Names of what an argument takes."""
    origin = typing.get_origin(wanted)
    if origin in (typing.Union, types.UnionType):
        return set().union(*map(taken, typing.get_args(wanted)))
    if wanted is typing.Any or origin is type:
        return set(BAD)
    return GOOD.get(origin or wanted, set())


@pytest.mark.parametrize("thing", list(public()))
def test_of_all_that_is_public(thing):
    function = thing.__init__ if inspect.isclass(thing) else thing
    hints = typing.get_type_hints(function)
    looked_at = 0
    for name, parameter in inspect.signature(thing).parameters.items():
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            continue
        for bad in BAD.keys() - taken(hints[name]):
            with pytest.raises(InputError, match=rf"^{name}( \(entry 1\))? must be "):
                thing(**{name: BAD[bad]})
            looked_at += 1
    assert looked_at or not inspect.signature(thing).parameters


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: verify("vega", workers=1.5),
            "workers must be a whole number",
        ),
        (
            lambda: verify("vega", searches="sqp"),
            "searches must be a sequence",
        ),
        (
            lambda: verify("vega", searches=["sqp", 3]),
            r"searches \(entry 2\) ",
        ),
        (lambda: verify("vega", samples=10**400), "samples must be a whole"),
        (
            lambda: verify("vega", objectives=[3]),
            r"objectives \(entry 1\) must be an",
        ),
        (
            lambda: simulate("vega", {"payload.mass_kg": True}),
            "values: payload.mass_kg must be a number, got True",
        ),
        (
            lambda: simulate("vega", {3: 1.0}),
            "values: key must be text, got 3",
        ),
        (
            lambda: Body(name="b", mass="1", p_BoBcm_B=(0,) * 3, I_BBcm_B=(1,) * 6),
            "b: mass must be a number, got '1'",
        ),
        (
            lambda: Simulation(load_case("vega").separation).run({"x": None}),
            "values: x must be a number, got None",
        ),
    ],
)
def test_what_is_said(call, message):
    with pytest.raises(InputError, match=f"^{message}"):
        call()


def test_what_is_right_is_passed_on():
    @typed
    def told(x: float, *rest: int, y: collections.abc.Sequence[float] = (), **how: int):
        return x, rest, y, how

    numbers = np.array([1.0, 2.0])
    assert told(np.float32(1.0), 2, y=numbers, z=3) == (1.0, (2,), numbers, {"z": 3})
    with pytest.raises(TypeError, match="missing 1 required positional argument: 'x'"):
        told()
