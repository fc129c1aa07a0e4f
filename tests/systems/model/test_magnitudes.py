"""What no separation has is refused by name; in case files too, and in `--set`."""

import copy
import math

import pytest

import drakesep
from drakesep.case_file.reader import builtin_cases
from drakesep.case_file.yaml_text import read_yaml
from drakesep.systems.checks import InputError
from drakesep.systems.model.magnitudes import MAGNITUDES, check_size, check_within
from drakesep.systems.model.parameters import declarations, parameters, with_values


EXTREME = (5e-324, 1e-300, 1e16, 1e308)
MAY_BE_SMALL = ("position", "cg", "rate", "attitude", "offset", "release", "damping")
"""Of what may be zero: all but zero is harmless."""


@pytest.mark.parametrize("kind", MAGNITUDES)
def test_both_ends_belong_to_it(kind):
    least, most, _ = MAGNITUDES[kind]
    for value in (least, most):
        check_size(kind, "x", value)
    check_within(kind, "x", -most, 0.0, 5e-324)
    beyond = math.nextafter(most, math.inf)
    for value in (math.nextafter(least, 0.0), beyond, 0.0, -1.0):
        with pytest.raises(InputError, match=r"^x must be "):
            check_size(kind, "x", value)
    with pytest.raises(InputError, match=r"^x must be at most .* in magnitude, got -"):
        check_within(kind, "x", -beyond)


@pytest.mark.parametrize("name", ["vega", "smallsat"])
def test_every_parameter(name):
    """Python's way, `--set`'s, and that of rows of a batch."""
    separation = drakesep.load_case(name).separation
    declared = declarations(separation)
    for key, nominal in parameters(separation).items():
        least, most = declared[key].limits
        for value in (1e16, 1e308, -1e308):
            with pytest.raises(InputError, match="must be "):
                with_values(separation, {key: value})
            assert not least <= value <= most
        assert least <= nominal <= most


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"spring_1.stroke_mm": 1e-9},
            "spring_1: stroke must be from 1e-09 to 100000 m",
        ),
        ({"payload.mass_kg": 1e-15}, "payload: mass must be from 1e-06 to 1e+09 kg"),
        (
            {"payload.cg_x_mm": -1e16},
            "must be at most 100000 m in magnitude, got -1e+13",
        ),
        (
            {"before_separation.rate_x_deg_s": 1e7},
            "at most 10000 rad/s in magnitude",
        ),
    ],
)
def test_refused_by_name(changes, message):
    with pytest.raises(InputError, match=message.replace("+", r"\+")):
        drakesep.simulate("vega", changes)


def leaves(data, place=()):
    if isinstance(data, dict | list):
        items = data.items() if isinstance(data, dict) else enumerate(data)
        for key, value in items:
            yield from leaves(value, (*place, key))
    elif isinstance(data, int | float) and not isinstance(data, bool):
        yield place


def with_leaf(data, place, value):
    changed = copy.deepcopy(data)
    within = changed
    for key in place[:-1]:
        within = within[key]
    within[place[-1]] = value
    return changed


@pytest.mark.parametrize("name", ["dual_launch", "smallsat"])
def test_every_number_of_a_case_file(name):
    """It is refused with a reason, or is none that a record has: a limit."""
    data = read_yaml(builtin_cases()[name].read_text())
    for place in leaves(data):
        if place[0] in ("requirements", "published"):
            continue
        for value in EXTREME:
            small = value < 1.0 and any(
                word in str(key) for key in place for word in MAY_BE_SMALL
            )
            if small or (value < 1.0 and "inertia_kg_m2" in place):
                continue
            try:
                drakesep.Case.model_validate(with_leaf(data, place, value)).in_si()
            except ValueError as error:
                assert "must be" in str(error), place
            else:
                assert value < 1.0, place
