"""The checker of proofs: closed forms are verified, faulty certificates are not."""

import copy
import json
import math
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from certificates import (
    LARGEST,
    MASS_A,
    MASS_B,
    TIGHT,
    body,
    hexadecimal,
    parameter,
    push,
    value,
)
from flint import arb

import drakesep.check_proof
from drakesep.check_proof.certificate import certificate
from drakesep.check_proof.command import main
from drakesep.check_proof.quantities import _direction
from drakesep.check_proof.tree import SHARPER, Motions


def outcome(
    record: dict[str, Any], folder: Path, capsys: pytest.CaptureFixture[str]
) -> tuple[int, str]:
    path = folder / "proof.json"
    path.write_text(json.dumps(record))
    status = main([str(path)])
    return status, capsys.readouterr().out


def test_a_spring_through_both_cgs_is_verified_to_round_off(tmp_path, capsys):
    status, said = outcome(push(TIGHT), tmp_path, capsys)
    assert status == 0, said
    assert "verified  speed: the largest value of the x of the velocity" in said
    assert 'of "B"' in said and "after the last stroke ends" in said and "m/s" in said


def test_nothing_below_the_supremum_is_verified(tmp_path, capsys):
    record = push(LARGEST * (1 - 1e-9))
    status, said = outcome(record, tmp_path, capsys)
    assert status == 1 and "its bound is" in said and "claimed" in said


def test_a_free_top_keeps_its_rate(tmp_path, capsys):
    """Torque-free about an axis of symmetry: w_x stays what it is, exactly."""
    record = push(TIGHT)
    record["problem"]["parameters"].append(parameter("rate", 0.015, 0.005))
    record["problem"]["rate"] = [value(0.015, 2), value(0.01), value(0.0)]
    record["problem"]["bodies"][1] = body(
        "B", value(MASS_B, 1), (700, 3100, 3100, 0, 0, 0)
    )
    claim = record["claims"][0]
    [term] = claim["quantity"]["terms"]
    term |= {"field": "rate", "pieces": [0, 4]}
    claim |= {"at": [hexadecimal(x) for x in (0, 0, 1)]}
    claim["tree"] = [["leaf", None]]
    for springs in (record["problem"]["springs"], []):
        record["problem"]["springs"] = springs
        claim |= {
            "bound": hexadecimal(0.02 * (1 + 1e-12)),
            "found": hexadecimal(0.02 * (1 - 1e-12)),
        }
        status, said = outcome(record, tmp_path, capsys)
        assert status == 0, said
        claim |= {"bound": hexadecimal(0.0199), "found": hexadecimal(0.0198)}
        assert outcome(record, tmp_path, capsys)[0] == 1


@pytest.mark.parametrize("a", [(1.0, 3.0), (-3.0, -1.0), (-2.0, 3.0)])
def test_products_hold_what_balls_about_zero_hold(a):
    """Of an end that is known to a half, whatever it is."""
    from flint import arb

    from drakesep.check_proof.intervals import product

    end = arb(0.0, 0.5)
    low, high = product((arb(a[0]), arb(a[1])), (end, end))
    exact = [x * y for x in a for y in (-0.5, 0.5)]
    assert low.lower() <= min(exact) and max(exact) <= high.upper()


def _tilted(record: dict[str, Any]) -> tuple[int, float]:
    """The velocity across, of a push through both CGs along a tilted axis.

    The carrier hardly turns, whatever the enclosure of the pad's place from its CG.
    """
    stiff = body("A", value(MASS_A), (1e13, 1e13, 1e13, 0, 0, 0))
    record["problem"]["bodies"][0] = stiff
    record["problem"]["springs"][0]["tilt"] = [value(0.0), value(0.02, 2)]
    return 1, LARGEST * math.sin(0.03)


def _stuck(record: dict[str, Any]) -> tuple[int, float]:
    """Eq. 5 until the sine of its phase is sqrt(1 - lost^2)."""
    record["problem"]["springs"][0]["lost_stroke"] = value(0.02, 2)
    return 0, LARGEST * math.sqrt(1 - 0.01**2)


@pytest.mark.parametrize(("vary", "side"), [(_tilted, "upper"), (_stuck, "lower")])
def test_what_varies_of_a_spring_is_verified_to_round_off(vary, side, tmp_path, capsys):
    record = push(TIGHT)
    record["problem"]["parameters"].append(parameter("third", 0.02, 0.01))
    component, largest = vary(record)
    [claim] = record["claims"]
    claim["quantity"]["terms"][0]["component"] = component
    claim["at"] = [*claim["at"], hexadecimal(1 if side == "upper" else -1)]
    claim["tree"] = [["collapse", {"2": side}], *claim["tree"]]
    for node in claim["tree"]:
        if node[0] == "leaf":
            node[1] = [*node[1], claim["at"][2]]
    for bound, status in ((1 + 1e-9, 0), (1 - 1e-9, 1)):
        claim |= {"bound": hexadecimal(largest * bound)}
        claim |= {"found": hexadecimal(largest * (1 - 1e-6))}
        got, said = outcome(record, tmp_path, capsys)
        assert got == status, said


def _spinning(record: dict[str, Any]) -> str:
    """About an axis of symmetry through the CG: the rate about it stays."""
    spin = {
        "rate": value(0.02, 2),
        "axis": [hexadecimal(x) for x in (1, 0, 0)],
        "place": [value(0.0)] * 3,
    }
    record["problem"]["pairs"][0]["spin"] = spin
    return "rate"


def _misaligned(record: dict[str, Any]) -> str:
    """Pushed through its CG, at which it is turned: it keeps its attitude."""
    turn = [value(0.02, 2), value(0.0), value(0.0)]
    record["problem"]["bodies"][1]["turn"] = turn
    return "angle"


def _turned_stack(record: dict[str, Any]) -> str:
    record["problem"]["attitude"] = [value(0.02, 2), value(0.0), value(0.0)]
    return "angle"


@pytest.mark.parametrize("vary", [_spinning, _misaligned, _turned_stack])
def test_what_varies_of_the_stack_is_verified_to_round_off(vary, tmp_path, capsys):
    record = push(TIGHT)
    record["problem"]["parameters"].append(parameter("third", 0.02, 0.01))
    symmetric = body("B", value(MASS_B, 1), (700, 3100, 3100, 0, 0, 0))
    record["problem"]["bodies"][1] = symmetric
    [claim] = record["claims"]
    claim["quantity"]["terms"][0] |= {"field": vary(record), "pieces": [0, 4]}
    claim["at"] = [hexadecimal(x) for x in (0, 0, 1)]
    claim["tree"] = [["leaf", None]]
    for bound, status in ((1 + 1e-9, 0), (1 - 1e-9, 1)):
        claim |= {"bound": hexadecimal(0.03 * bound)}
        claim |= {"found": hexadecimal(0.03 * (1 - 1e-6))}
        got, said = outcome(record, tmp_path, capsys)
        assert got == status, said


def _square_of_a_constant_rate() -> dict[str, Any]:
    """Of a top that is free after the push: the integral of w_x^2 over 1 s."""
    record = push(TIGHT)
    record["problem"]["rate"] = [value(x) for x in (0.02, 0.01, 0.0)]
    record["problem"]["bodies"][1] = body(
        "B", value(MASS_B, 1), (700, 3100, 3100, 0, 0, 0)
    )
    [claim] = record["claims"]
    claim["quantity"]["kind"] = "integral_of_square"
    [term] = claim["quantity"]["terms"]
    levels = [hexadecimal(x) for x in (-0.01, 0.01)]
    term |= {"field": "rate", "pieces": [0, 4], "coast": 4, "levels": levels}
    claim |= {
        "bound": hexadecimal(0.0004 * (1 + 1e-9)),
        "found": hexadecimal(0.0004 * (1 - 1e-9)),
    }
    leaf = ["leaf", [hexadecimal(0)] * 2]
    # The top choice is looked at alone, then the others together.
    claim["tree"] = [["split", [[2], [0, 1]], None], leaf, leaf]
    return record


def test_an_integral_that_is_looked_at_as_a_whole_is_verified(tmp_path, capsys):
    status, said = outcome(_square_of_a_constant_rate(), tmp_path, capsys)
    assert status == 0, said


WHOLE_FAULTS: dict[str, tuple[dict[str, Any], int, str]] = {
    "during the push": ({"coast": 3}, 1, "springs may push"),
    "of no piece": ({"coast": 5}, 2, "coast: wanted a whole number below 5"),
    "levels fall": (
        {"levels": [hexadecimal(0.01), hexadecimal(-0.01)]},
        2,
        "levels: must grow",
    ),
    "of a velocity": ({"field": "relative_velocity"}, 2, "rates alone"),
}


@pytest.mark.parametrize("fault", WHOLE_FAULTS)
def test_a_coast_that_is_none_is_refused(fault, tmp_path, capsys):
    change, wanted, reason = WHOLE_FAULTS[fault]
    record = _square_of_a_constant_rate()
    record["claims"][0]["quantity"]["terms"][0] |= change
    status, said = outcome(record, tmp_path, capsys)
    assert (status, reason in said) == (wanted, True), said


def test_a_choice_that_is_left_out_must_hold(tmp_path, capsys):
    record = _square_of_a_constant_rate()
    [claim] = record["claims"]
    claim |= {"bound": hexadecimal(0.00035), "found": hexadecimal(0.0003)}
    claim["tree"] = [["split", [[0, 1]], None], ["leaf", None]]
    status, said = outcome(record, tmp_path, capsys)
    assert status == 1 and "above what is claimed" in said, said


Record = dict[str, Any]


def _claim(record: Record) -> Record:
    return record["claims"][0]


def _term(record: Record) -> Record:
    return _claim(record)["quantity"]["terms"][0]


def _problem(record: Record) -> Record:
    return record["problem"]


def _wrong_face(record: Record) -> None:
    """Beside a bound that is not met: where all is below it, faces do not matter."""
    _claim(record)["bound"] = hexadecimal(0.99999 * LARGEST)
    _claim(record)["tree"][2] = ["collapse", {"0": "lower"}]


def _no_sign(record: Record) -> None:
    """The largest y speed is zero for all parameters: it grows to no face."""
    _term(record)["component"] = 1
    _claim(record)["found"] = hexadecimal(-1.0)
    _claim(record)["bound"] = hexadecimal(-0.5)
    _claim(record)["tree"] = [["collapse", {"0": "upper"}], ["leaf", None]]


FAULTS: dict[str, tuple[Callable[[Record], Any], int, str]] = {
    "bound narrowed by half a per cent": (
        lambda r: _claim(r).update(
            bound=hexadecimal(0.995 * LARGEST), found=hexadecimal(0.99 * LARGEST)
        ),
        1,
        "above what is claimed",
    ),
    "box lost": (lambda r: _claim(r)["tree"].pop(), 1, "a node is missing"),
    "box too many": (
        lambda r: _claim(r)["tree"].append(["leaf", None]),
        1,
        "belong to no box",
    ),
    "cut outside the box": (
        lambda r: _claim(r)["tree"].__setitem__(0, ["cut", 0, hexadecimal(1)]),
        1,
        "not inside the box",
    ),
    "group of no choices": (
        lambda r: _claim(r).update(tree=[["split", [[], [0]], None], ["leaf", None]]),
        1,
        "wanted choices in each group",
    ),
    "axis left out": (
        lambda r: _problem(r)["parameters"][0].update(scale=hexadecimal(0)),
        2,
        "parameters[0].scale: wanted more than 0",
    ),
    "axis of no width": (
        lambda r: _problem(r)["parameters"][0].update(lower=hexadecimal(1)),
        2,
        "lower < upper",
    ),
    "collapse to the wrong face": (_wrong_face, 1, "may not grow to the lower face"),
    "sign taken for constant": (_no_sign, 1, "may not grow to the upper face"),
    "collapse of what is collapsed": (
        lambda r: _claim(r)["tree"].__setitem__(4, ["collapse", {"0": "upper"}]),
        1,
        "does not vary",
    ),
    "s* outside its box": (
        lambda r: _claim(r)["tree"].__setitem__(1, ["leaf", [hexadecimal(1)] * 2]),
        1,
        "s* is outside the box",
    ),
    "NaN": (lambda r: _claim(r).update(bound="nan"), 2, "wanted a finite number"),
    "infinity": (lambda r: _claim(r).update(bound="inf"), 2, "wanted a finite number"),
    "decimal number": (lambda r: _claim(r).update(bound=1.0), 2, "hexadecimal float"),
    "first body off the origin": (
        lambda r: _problem(r)["bodies"][0].update(offset=[value(0.1)] * 3),
        2,
        "problem.bodies[0]: wanted one that stands where the stack does",
    ),
    "rotation altered": (
        lambda r: _problem(r)["attitude"].__setitem__(1, hexadecimal(1e-6)),
        2,
        "attitude",
    ),
    "no attitude": (
        lambda r: _problem(r).update(attitude=None),
        2,
        "problem.attitude: wanted a list of 3",
    ),
    "axis of a spring altered": (
        lambda r: _problem(r)["springs"][0]["frame"].__setitem__(1, hexadecimal(1e-3)),
        2,
        "frame: its length is not 1",
    ),
    "spring that loses all of its stroke": (
        lambda r: _problem(r)["springs"][0].update(lost_stroke=value(1.0)),
        2,
        "lost_stroke: wanted from 0 to below 1",
    ),
    "shorter duration": (
        lambda r: _problem(r).update(duration=hexadecimal(0.5)),
        2,
        "grid: wanted times from 0 to the duration",
    ),
    "grid that does not start at 0": (
        lambda r: r["grid"]["times"].pop(0),
        2,
        "grid: wanted times from 0",
    ),
    "grid that goes back": (
        lambda r: r["grid"]["times"].__setitem__(1, hexadecimal(0)),
        2,
        "must grow",
    ),
    "blocks that leave pieces out": (
        lambda r: _term(r).update(blocks=[0, 1]),
        2,
        "blocks: wanted to rise from 0 to 2",
    ),
    "key that is not known": (
        lambda r: _problem(r).update(thrust=hexadecimal(1)),
        2,
        "not known are thrust",
    ),
    "group without choices": (
        lambda r: _claim(r).update(
            tree=[["split", [[0], []], None], *_claim(r)["tree"], ["leaf", None]]
        ),
        1,
        "wanted choices in each group",
    ),
    "face of a coordinate that is none": (
        lambda r: _claim(r)["tree"].__setitem__(2, ["collapse", {"9" * 5000: "upper"}]),
        1,
        "does not vary",
    ),
    "found where it is not": (
        lambda r: _claim(r).update(at=[hexadecimal(-1), hexadecimal(1)]),
        1,
        "is not reached at its point",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_refused_with_its_reason(fault, tmp_path, capsys):
    alter, wanted, reason = FAULTS[fault]
    record = copy.deepcopy(push(TIGHT))
    alter(record)
    status, said = outcome(record, tmp_path, capsys)
    assert (status, reason in said) == (wanted, True), said


def test_a_window_that_lacks_pieces_is_not_called_after_the_push(tmp_path, capsys):
    record = push(TIGHT)
    record["grid"]["times"].insert(5, hexadecimal(0.9))
    status, said = outcome(record, tmp_path, capsys)
    assert status == 0 and "after the last stroke ends" not in said, said


def test_a_key_that_stands_twice_is_refused(tmp_path, capsys):
    path = tmp_path / "proof.json"
    path.write_text('{"format": "drakesep proof 2", "format": "drakesep proof 2"}')
    assert main([str(path)]) == 2
    assert "stands twice" in capsys.readouterr().out


def test_it_stands_alone(tmp_path):
    """Copied elsewhere, it runs with the standard library and python-flint only."""
    folder = Path(drakesep.check_proof.__file__).parent
    (tmp_path / "check_proof").mkdir()
    for path in folder.glob("*.py"):
        (tmp_path / "check_proof" / path.name).write_text(path.read_text())
    (tmp_path / "proof.json").write_text(json.dumps(push(TIGHT)))
    code = (
        "import sys\nfrom check_proof.command import main\n"
        "status = main(['proof.json'])\n"
        "roots = {name.partition('.')[0] for name in sys.modules}\n"
        "alien = roots - set(sys.stdlib_module_names) - {'check_proof', 'flint'}\n"
        "print(status, sorted(alien & {'numpy', 'jax', 'drakesep', 'pydrake'}))"
    )
    ran = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True
    )
    assert ran.stdout.splitlines()[-1] == "0 []", ran.stdout + ran.stderr


def test_without_flint_it_says_what_it_needs(tmp_path):
    hidden = "import sys, runpy; sys.modules['flint'] = None; sys.argv = ['x', 'y'];"
    run = f"{hidden} runpy.run_module('drakesep.check_proof', run_name='__main__')"
    told = subprocess.run(
        [sys.executable, "-c", run], capture_output=True, text=True, check=False
    )
    assert told.returncode == 2
    assert told.stderr == "check_proof needs python-flint: pip install python-flint\n"


def test_the_derivative_of_an_angle_keeps_the_sign_of_its_numerator():
    """atan2(y, x)' = (x y' - y x') / (x^2 + y^2): its divisor is divided by once."""
    y, x = [(0.3, 0.4), (0.4, 0.4)], [(0.85, 0.95), (0.75, 0.8)]
    _, (low, high) = _direction(*([(arb(a), arb(b)) for a, b in jet] for jet in (y, x)))
    least, most = 0.85 * 0.4 - 0.4 * 0.8, 0.95 * 0.4 - 0.3 * 0.75
    over = 1 / (0.4**2 + 0.95**2), 1 / (0.3**2 + 0.85**2)
    # The products of the ends; 1e-12 is far more than rounding.
    assert float(low) == pytest.approx(least * over[0], rel=1e-12)
    assert float(high) == pytest.approx(most * over[1], rel=1e-12)


def test_an_angle_is_verified_where_another_is_beyond_a_right_angle(tmp_path, capsys):
    """The stack stands still, rolled by 0.2, yawed by 2 rad; roll alone is claimed."""
    record = push(TIGHT)
    record["problem"]["attitude"] = [value(0.2), value(0.0), value(2.0)]
    claim = record["claims"][0]
    [term] = claim["quantity"]["terms"]
    term |= {"field": "angle", "pieces": [0, 4]}
    claim |= {"bound": hexadecimal(0.2 + 1e-12), "found": hexadecimal(0.2 - 1e-12)}
    claim["tree"] = [["leaf", None]]
    status, said = outcome(record, tmp_path, capsys)
    assert status == 0, said
    term |= {"component": 2}
    status, said = outcome(record, tmp_path, capsys)
    assert status == 1 and "beyond 90 deg" in said


def test_what_is_enclosed_anew_is_within_what_was_enclosed():
    record = push(TIGHT)
    # Beside both CGs, so that bodies turn while it pushes.
    record["problem"]["springs"][0]["place"] = [value(0), value(0.3), value(0)]
    problem = certificate(record).problem
    first, anew = (Motions(problem).on(problem.root, (), n) for n in (0, SHARPER))
    narrower = 0
    for wide, sharp in zip(first.state.Q[0], anew.state.Q[0], strict=True):
        for a, b in ((0, 1), (1, 0)):
            (low, high), (least, most) = wide[a][b][0], sharp[a][b][0]
            assert low <= least and most <= high
            narrower += bool(low < least and most < high)
    assert narrower
