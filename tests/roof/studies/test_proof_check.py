"""`drakesep check-proof`: a certificate is checked, and the user told.

What the checker refuses, and why, is tested in roof/test_check_proof.py.
"""

import copy
import json
import sys

import pytest
from certificates import LARGEST, TIGHT, hexadecimal, push
from command_line import run

from drakesep.studies.proof_check import check_certificate
from drakesep.systems.checks import InputError


@pytest.fixture
def two_claims(tmp_path):
    """The supremum and a little, and a little less than it."""
    record = push(TIGHT)
    [good] = record["claims"]
    narrow = copy.deepcopy(good)
    narrow |= {"name": "narrow", "bound": hexadecimal(LARGEST * (1 - 1e-9))}
    record["claims"].append(narrow)
    path = tmp_path / "proof.json"
    path.write_text(json.dumps(record))
    return path


@pytest.mark.parametrize("workers", [1, 2])
def test_each_claim_is_told(workers, two_claims, capsys, monkeypatch):
    words = ["check-proof", two_claims, "--workers", workers]
    code, out, err = run(capsys, monkeypatch, *words)
    said = " ".join(out.split())
    assert code == 1
    assert "verified: speed: the largest value of the x of the velocity" in said
    assert "NOT VERIFIED: narrow: node " in said
    assert "its bound is" in said
    assert "1 of 2 claims are verified." in said
    assert "spring.force_max" in said and "1515" in said
    assert "Check of 2 claims in Arb, 14 nodes: about" in err
    assert "100%" in err and "2 of 2 claims checked" in err


def test_progress_goes_from_none_to_all(two_claims):
    told = []
    found = check_certificate(two_claims, workers=1, on_progress=told.append)
    assert [one.done for one in told] == [0, 1, 2]
    assert (told[0].remaining.share, told[-1].remaining.share) == (0.0, 1.0)
    assert [claim.verified for claim in found.claims] == [True, False]
    good = found.claims[0]
    assert (good.bound, good.nodes) == (TIGHT, 7)
    # What a point reaches is enclosed to round-off.
    assert good.reaches == pytest.approx(LARGEST, rel=1e-12)
    row = found.parameters.iloc[0].tolist()
    assert row == ["spring.force_max", 1485.0, 1515.0]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (None, "No such file or directory"),
        ("[1, 2", "Expecting ',' delimiter"),
        ('{"format": "drakesep proof 0"}', "certificate: "),
    ],
)
def test_a_file_that_is_no_certificate_is_refused(
    text, why, tmp_path, capsys, monkeypatch
):
    path = tmp_path / "proof.json"
    if text is not None:
        path.write_text(text)
    code, _, err = run(capsys, monkeypatch, "check-proof", path)
    [line] = err.splitlines()
    begins = f"drakesep: {path}: must be a certificate of proven bounds, got: "
    assert (code, line.startswith(begins), why in line) == (2, True, True), err


def test_without_flint_it_is_said_what_installs_it(two_claims, monkeypatch):
    monkeypatch.setitem(sys.modules, "flint", None)
    with pytest.raises(InputError, match=r"^check-proof needs python-flint: pip inst"):
        check_certificate(two_claims)
