"""Chunks of campaigns as files: whole or not there, of their plan, and damaged or not.

Draws are numbers that follow from their own: nothing is flown.
"""

import json
import os
import random
import subprocess
import sys

import numpy as np
import pytest
from small_case import small_case

from drakesep.analysis.campaigns.flights import FlownDraws
from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.case_file.case import Case
from drakesep.results import provenance
from drakesep.results.campaign_files import (
    DRAWS,
    RecordedPlan,
    chunk_file,
    gathered,
    merged,
    read_chunk,
    read_draws,
    write_chunk,
    write_draws,
)


RUNS, CHUNK = 1000, 5


def planned(**changed):
    case = Case.model_validate(small_case(published=None, objectives=None)).in_si()
    how = {"runs": RUNS, "chunk": CHUNK, "metrics": ("final_rate_x", "final_rate_y")}
    return RecordedPlan.of(CampaignPlan(**{"case": case, **how, **changed}))


def drawn(plan, number):
    """What comes of a draw is made of its number; every seventh fails."""
    indices = plan.indices(number)
    metrics = np.stack([np.sqrt(indices), 1.0 / (1.0 + indices)], axis=1)
    reasons = {i: f"draw {i}\nfailed, ünd why" for i in indices.tolist() if i % 7 == 0}
    metrics[[i - indices[0] for i in reasons]] = np.nan
    return FlownDraws(
        first=int(indices[0]),
        metrics=metrics,
        failure=(indices % 3 - 1).astype(np.int16),
        attempts=(indices % 2).astype(np.int32),
        reasons=reasons,
    )


def write_all(folder, recorded, numbers):
    for number in numbers:
        write_chunk(folder, recorded, number, drawn(recorded.plan, number))


def bytes_of_all(folder, recorded):
    write_draws(folder, recorded, merged(folder, recorded))
    return (folder / DRAWS).read_bytes()


@pytest.fixture(scope="module")
def recorded():
    return planned()


@pytest.fixture(scope="module")
def expected(recorded, tmp_path_factory):
    folder = tmp_path_factory.mktemp("expected")
    write_all(folder, recorded, range(recorded.plan.chunks))
    return bytes_of_all(folder, recorded)


def test_what_is_written_is_read(recorded, tmp_path):
    for number in (0, 13):
        flown = drawn(recorded.plan, number)
        write_chunk(tmp_path, recorded, number, flown)
        read = read_chunk(tmp_path, recorded, number)
        assert read.first == flown.first
        for name in ("metrics", "failure", "attempts"):
            np.testing.assert_array_equal(getattr(read, name), getattr(flown, name))
            assert getattr(read, name).dtype == getattr(flown, name).dtype
        told = {i: why.replace("\n", " ") for i, why in flown.reasons.items()}
        assert read.reasons == told


def test_in_any_order_and_twice_all_are_the_same(recorded, expected, tmp_path):
    numbers = [*range(recorded.plan.chunks), *range(0, recorded.plan.chunks, 3)]
    random.Random(1).shuffle(numbers)
    write_all(tmp_path, recorded, numbers)
    assert bytes_of_all(tmp_path, recorded) == expected


def test_all_of_them_are_read_as_they_were(recorded, expected, tmp_path):
    (tmp_path / DRAWS).write_bytes(expected)
    flown = read_draws(tmp_path, recorded)
    failed = [i for i in range(RUNS) if i % 7 == 0]
    assert [*flown.reasons] == failed
    assert np.isnan(flown.metrics).all(axis=1).nonzero()[0].tolist() == failed
    told = np.delete(np.arange(RUNS), failed)
    np.testing.assert_array_equal(flown.metrics[told, 0], np.sqrt(told))
    with np.load(tmp_path / DRAWS) as members:  # as any user does
        assert members["metric_names"].tolist() == ["final_rate_x", "final_rate_y"]


def test_what_is_missing_is_named(recorded, tmp_path):
    write_all(tmp_path, recorded, set(range(recorded.plan.chunks)) - {3, 17})
    assert gathered(tmp_path, recorded).missing == [3, 17]
    with pytest.raises(RuntimeError, match=r"of 200 chunks 2 are not there.*: 3, 17;"):
        merged(tmp_path, recorded)


def test_a_damaged_chunk_is_missing_wherever_it_is_damaged(recorded, tmp_path):
    """A bit of any byte: of what it holds, of its hash, of what says what it holds."""
    write_all(tmp_path, recorded, [0])
    file = chunk_file(tmp_path, 0)
    whole = file.read_bytes()
    reference = drawn(recorded.plan, 0).metrics
    for place in range(0, len(whole), 7):
        file.write_bytes(
            whole[:place] + bytes([whole[place] ^ 0x10]) + whole[place + 1 :]
        )
        try:
            read = read_chunk(tmp_path, recorded, 0)
        except ValueError as error:  # the hash of its plan has changed
            assert "got one of another" in str(error)
            continue
        if read is not None:  # such as a time of day, which nobody reads
            np.testing.assert_array_equal(read.metrics, reference)
    for length in (0, 10, len(whole) // 2, len(whole) - 1):
        file.write_bytes(whole[:length])
        assert read_chunk(tmp_path, recorded, 0) is None


def test_a_chunk_of_another_place_is_no_chunk(recorded, tmp_path):
    write_all(tmp_path, recorded, [4])
    chunk_file(tmp_path, 4).rename(chunk_file(tmp_path, 5))
    assert read_chunk(tmp_path, recorded, 5) is None


@pytest.mark.parametrize(
    "changed", [{"seed": 1}, {"runs": 1001}, {"tolerance": 1e-8}, {"chunk": 6}]
)
def test_a_chunk_of_another_plan_is_refused(changed, recorded, tmp_path):
    write_all(tmp_path, recorded, [2])
    with pytest.raises(ValueError, match=r"chunk_000002.npz: must be of the plan"):
        read_chunk(tmp_path, planned(**changed), 2)


def test_a_plan_is_read_as_it_was(recorded, tmp_path):
    recorded.write(tmp_path)
    read = RecordedPlan.read(tmp_path)
    assert read.plan == recorded.plan
    assert read.sha256 == recorded.sha256
    assert json.loads(recorded.text)["chunks"] == 200


def test_a_plan_of_other_versions_is_refused(recorded, tmp_path, monkeypatch):
    recorded.write(tmp_path)
    others = {**provenance.versions(), "jax": "0.0.1"}
    monkeypatch.setattr(provenance, "versions", lambda: others)
    with pytest.raises(ValueError, match=r"must be flown with jax = .*, got 0\.0\.1"):
        RecordedPlan.read(tmp_path)


def test_a_plan_of_another_commit_is_refused(recorded, tmp_path, monkeypatch):
    recorded.write(tmp_path)
    monkeypatch.setattr(provenance, "commit", lambda: "f" * 40)
    with pytest.raises(ValueError, match="must be flown with commit = "):
        RecordedPlan.read(tmp_path)


@pytest.mark.parametrize(
    "text", ["", "3", "{}", '{"format": 2}', '{"format": 1, "case": {}}']
)
def test_what_is_no_plan_is_refused(text, tmp_path):
    (tmp_path / "plan.json").write_text(text)
    with pytest.raises(ValueError, match=r"plan\.json: must be a campaign's, got: "):
        RecordedPlan.read(tmp_path)
    (tmp_path / "plan.json").unlink()
    with pytest.raises(ValueError, match=r"plan\.json: must be the plan of a campaign"):
        RecordedPlan.read(tmp_path)


KILLER = """
import os, random, signal, sys, time
from pathlib import Path
sys.path.insert(0, sys.argv[2])
from test_campaign_files import planned, write_all
from drakesep.results.campaign_files import gathered
folder, recorded, rng = Path(sys.argv[1]), planned(), random.Random(0)
until = sorted(rng.randrange(150) for _ in range(int(sys.argv[3])))  # of 200
kills = 0
while True:
    writer = os.fork()
    if not writer:
        write_all(folder, recorded, gathered(folder, recorded).missing)
        os._exit(0)
    if kills < len(until):
        while len([*folder.glob(".parts/chunk*")]) < until[kills]:
            time.sleep(0.001)
        time.sleep(rng.uniform(0.0, 0.003))  # in the midst of one
        os.kill(writer, signal.SIGKILL)
    if os.waitpid(writer, 0)[1] == 0:
        break
    kills += 1
print(kills)
"""


@pytest.mark.parametrize("kills", [3, pytest.param(20, marks=pytest.mark.slow)])
def test_no_draw_is_lost_or_twice_whenever_who_flies_is_killed(
    kills, recorded, expected, tmp_path
):
    """Killed at random, and begun again."""
    here = os.path.dirname(__file__)
    tests = os.path.dirname(os.path.dirname(here))
    told = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", KILLER, str(tmp_path), here, str(kills)],
        env={**os.environ, "PYTHONPATH": tests},
        capture_output=True,
        text=True,
        check=True,
    )
    assert int(told.stdout) == kills
    assert bytes_of_all(tmp_path, recorded) == expected
