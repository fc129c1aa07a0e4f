"""Springs of Eq. 5 outside their meaning: their energies by closed forms, and a word.

A spring of Eq. 5 gives sqrt(F m_S L) N s, whatever it moves, and stores F L / 2 J.
"""

import math
import re

import pytest
from command_line import run as run_command
from trade import PADS, symmetric_design

import drakesep
from drakesep.systems.equations.forces_of_run import spring_work
from drakesep.systems.model.springs import DisplacementSpring


FORCE, STROKE = 500.0, 0.08
STORED = 0.5 * FORCE * STROKE
HELD = 0.5
"""When the last pad lets go, long after the springs are spent, s."""
TIMED = {"law": "time", "force_max_N": FORCE, "stroke_mm": 1e3 * STROKE}
CLOSE = 1e-3
"""Trapezoids of 64 samples of a push: (pi / 2 / 64)^2 / 12, and some."""


def timed(design_mass=100.0, last=0.0, pads=PADS, **changes):
    """The symmetric design on springs of Eq. 5; the last pad lets go when it is told.

    Four springs on a reduced mass of 400 kg: each moves 100 kg.
    """
    plain = symmetric_design().model_dump(mode="json", exclude_none=True)
    pads = {
        name: attachment
        | {
            "position_mm": [0.0, *place],
            "spring": {"name": f"s{name[1]}", "design_mass_kg": design_mass, **TIMED},
        }
        for (name, attachment), place in zip(
            plain["attachments"].items(), pads, strict=True
        )
    }
    pads["a4"]["release_time_s"] = last
    return symmetric_design(attachments=pads, **changes)


def works(run):
    return [spring_work(run, attachment) for attachment, _ in run.separation.pushing]


def light():
    """5 kg on springs that are designed for 100 kg each, at 50 mm from the axis."""
    payload = {
        "mass_kg": 5.0,
        "cg_mm": [100.0, 0.0, 0.0],
        "inertia_kg_m2": {"xx": 0.05, "yy": 0.06, "zz": 0.06},
    }
    bodies = symmetric_design().model_dump(mode="json", exclude_none=True)["bodies"]
    near = [(y / 8.0, z / 8.0) for y, z in PADS]
    return timed(bodies=bodies | {"sc": payload}, pads=near)


def test_payload_far_lighter_than_the_design_mass():
    """Four impulses of sqrt(500 100 0.08) N s on a reduced mass of 4.9875 kg."""
    simulated = drakesep.simulate(light())
    reduced = 1.0 / (1.0 / 5.0 + 1.0 / 2000.0)
    impulse = 4.0 * math.sqrt(FORCE * 100.0 * STROKE)
    speed = simulated.run.completed_motion.relative_velocity[-1, 0]
    assert speed == pytest.approx(impulse / reduced, rel=1e-6)  # of 50.72 m/s
    given = impulse**2 / (2.0 * reduced)
    assert sum(works(simulated.run)) == pytest.approx(given, rel=CLOSE)
    [remark] = simulated.remarks
    assert remark.about == ("s1", "s2", "s3", "s4")
    assert remark.run == "nominal"
    assert "s1, s2, s3 and s4 give 6416 J and store 80 J" in remark.text


def test_springs_spent_while_a_joint_holds():
    """Three of four give nothing; the last pushes alone, off the axis."""
    simulated = drakesep.simulate(timed(last=HELD, run={"duration_s": 1.0}))
    spent, alone = simulated.remarks
    assert spent.about == ("s1", "s2", "s3")
    assert "spent while a4 still holds" in spent.text
    assert "of 60 J stored" in spent.text
    # Of what moves under one pad, 1/m = 1/mu + sum of r^2 / I.
    arm = 0.08  # y^2 of the pad, and z^2
    lightness = 1.0 / 400.0 + 2.0 * arm * (1.0 / 120.0 + 1.0 / 2500.0)
    given = 0.5 * FORCE * 100.0 * STROKE * lightness
    *held, last = works(simulated.run)
    # The pad that holds gives to forces and to torques on levers of 0.57 m, and swings
    # as far again.
    lever = 2e-3 * PADS[0][0]
    give = 3.0 * FORCE / 1e6, 2.0 * FORCE * lever / 1e5 * lever
    most = [2.0 * FORCE * (give[0] + n * give[1]) for n in (1, 2, 1)]
    assert all(0.0 < work < most[i] < 0.4 * STORED for i, work in enumerate(held))
    # It turns by a degree meanwhile: 0.6 m ahead of the pad that is 1 cm, of 0.28 m.
    assert last == pytest.approx(given, rel=4e-2)
    assert alone.about == ("s4",)
    assert "s4 gives" in alone.text and "stores 20 J" in alone.text


@pytest.mark.parametrize("share", [0.88, 0.92, 1.0, 1.08, 1.12])
def test_a_tenth_of_the_energy_goes_without_a_word(share):
    """On 100 kg a spring for m_S gives m_S / 100 kg of what it stores."""
    simulated = drakesep.simulate(timed(design_mass=100.0 * share))
    expected = [share * STORED] * 4
    assert works(simulated.run) == pytest.approx(expected, rel=CLOSE)
    assert bool(simulated.remarks) == (abs(share - 1.0) > 0.1)


@pytest.mark.parametrize("engine", ["drake", "batch"])
def test_a_sweep_says_of_which_variant_first(engine, tmp_path, capsys, monkeypatch):
    """On a reduced mass of 2000 m / (2000 + m) they give 400 kg over it of 80 J."""
    masses = [500.0, 460.0, 420.0, 400.0, 380.0]
    given = [80.0 * 400.0 / (2000.0 * m / (2000.0 + m)) for m in masses]
    first = next(n for n, energy in enumerate(given, 1) if energy > 88.0)
    if engine == "batch":  # which looks at both ends
        first = len(masses)
    study = drakesep.sweep(timed(), {"sc.mass_kg": masses}, engine=engine, workers=1)
    [remark] = study.remarks
    assert remark.about == ("s1", "s2", "s3", "s4")
    assert remark.run == f"variant {first}"
    assert f"give {given[first - 1]:.4g} J and store 80 J" in remark.text
    study.save(tmp_path / "saved")
    table = drakesep.read_results(tmp_path / "saved").table("remarks.csv")
    assert table["run"].tolist() == [remark.run]
    swept = f"sc.mass_kg={','.join(map(str, masses))}"
    case = tmp_path / "case.yaml"
    case.write_text(timed().model_dump_json(exclude_none=True), encoding="utf-8")
    words = ["sweep", case, swept, "--engine", engine, "-o", tmp_path / "out"]
    code, out, _ = run_command(capsys, monkeypatch, *words)
    assert code == 0
    assert f"Note: {remark.run}: s1, s2, s3 and s4 give" in " ".join(out.split())


def test_misses_of_opposite_sign_are_told_apart():
    """Impulses of 2 (sqrt(F L 196 kg) + sqrt(F L 36 kg)) on 400 kg: 80 J, as stored.

    Those for the heavier design mass push longer, while it moves faster: they give
    more.
    """
    case = timed()
    attachments = case.model_dump(mode="json", exclude_none=True)["attachments"]
    for name, attachment in attachments.items():
        heavy = name in ("a1", "a3")  # in opposite corners: nothing turns
        attachment["spring"]["design_mass_kg"] = 196.0 if heavy else 36.0
    simulated = drakesep.simulate(case.replaced(attachments=attachments))
    more, less = simulated.remarks
    assert (more.about, less.about) == (("s1", "s3"), ("s2", "s4"))
    given = [
        float(re.search(r"give ([\d.]+) J and store 40 J", one.text)[1])
        for one in (more, less)
    ]
    assert given[0] > 1.1 * 40.0
    assert given[1] < 0.9 * 40.0
    assert sum(given) == pytest.approx(4.0 * STORED, rel=CLOSE)


def test_springs_by_displacement_give_what_they_store():
    run = drakesep.simulate(symmetric_design()).run
    assert all(isinstance(s, DisplacementSpring) for s in run.separation.springs)
    assert works(run) == pytest.approx([STORED] * 4, rel=CLOSE)


def test_a_study_tells_it_once(capsys, monkeypatch, tmp_path):
    """However many runs its searches fly: on the screen, and in a table."""
    case = timed(
        design_mass=150.0,
        dispersions={f"s{i}.force_max_N": 5.0 for i in range(1, 5)},
        requirements=[
            {"quantity": "longitudinal_speed_after_separation_m_s", "at_least": 0.1}
        ],
    )
    file = tmp_path / "case.yaml"
    file.write_text(case.model_dump_json(exclude_none=True), encoding="utf-8")
    folder = tmp_path / "out"
    effort = ("--samples", "20", "--starts", "1", "--no-growth", "--workers", "1")
    code, out, err = run_command(
        capsys, monkeypatch, "verify", file, "-o", folder, *effort
    )
    assert code == 0
    said = " ".join((out + err).split())
    assert said.count("design mass") == 1
    assert said.count("Note") == 1
    table = drakesep.read_results(folder).table("remarks.csv")
    [row] = table.to_dict("records")
    assert (row["about"], row["run"]) == ("s1, s2, s3, s4", "nominal")
    assert row["remark"] in said


def test_what_only_a_worst_case_shows_is_told_of_it():
    """A mass that is a tenth off in its corner, not in the nominal."""
    case = timed(
        design_mass=105.0,
        dispersions={"sc.mass_kg": 50.0},
        requirements=[
            {"quantity": "longitudinal_speed_after_separation_m_s", "at_most": 9.0}
        ],
    )
    study = drakesep.verify(case, samples=20, starts=1, growth=False, workers=1)
    [remark] = study.remarks
    assert remark.run == "worst_highest_longitudinal_speed_max_after_separation"
    assert remark.about == ("s1", "s2", "s3", "s4")
