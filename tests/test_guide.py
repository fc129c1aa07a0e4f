"""The code of the README, of the guide and of the other pages runs as it stands."""

import math
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from ruamel.yaml import YAML
from scipy.spatial.transform import Rotation

import drakesep
from drakesep.analysis.metrics.objectives import Needs, highest
from drakesep.analysis.metrics.registry import forget_metric
from drakesep.analysis.tolerances.distributions import distribution_of
from drakesep.case_file.case import Case
from drakesep.case_file.others import RequirementSection
from drakesep.case_file.reader import builtin_cases


ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
DOCS = ROOT / "docs"
GUIDE = DOCS / "guide.md"
WORST_CASES = DOCS / "worst_cases.md"
CLEARANCE = DOCS / "clearance.md"
METRICS_PAGE = DOCS / "metrics.md"
CAMPAIGNS = DOCS / "campaigns.md"


def blocks(page, language):
    text = page.read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.M | re.S)


COMMAND_LINE = DOCS / "command_line.md"
PAGES = (GUIDE, WORST_CASES, CLEARANCE, METRICS_PAGE, CAMPAIGNS, COMMAND_LINE)
BLOCKS = [b for page in PAGES for b in blocks(page, "python")]


def run(block, capsys):
    exec(compile(block, str(GUIDE), "exec"), {"__name__": "__main__"})
    return [
        float(x)
        for x in re.findall(r"-?\d+\.?\d*(?:e[+-]?\d+)?", capsys.readouterr().out)
    ]


def containing(words):
    [block] = [block for block in BLOCKS if words in block]
    return block


def test_case_file_of_the_readme(tmp_path, monkeypatch, capsys):
    """Fifteen lines. Nominally v = sqrt(2 E / mu), and nothing turns by symmetry."""
    [text] = blocks(README, "yaml")
    assert len(text.splitlines()) == 15
    monkeypatch.chdir(tmp_path)
    Path("mine.yaml").write_text(text, encoding="utf-8")
    [summary] = drakesep.simulate("mine.yaml").summary.to_dict("records")
    speed = math.sqrt(2.0 * (0.5 * 1500.0 * 0.1) * (1 / 900 + 1 / 400))
    # 2e-6 of the energy: the default accuracy, of a spring by displacement
    assert summary["longitudinal_speed_max_m_s"] == pytest.approx(speed, rel=2e-6)
    assert summary["final_rate_z_deg_s"] == pytest.approx(0.0, abs=1e-9)
    [code] = blocks(README, "python")
    run(code, capsys)
    motion = pd.read_csv("results/mine/motion.csv")
    # The push beside the CG, p dy over the inertia, but for what A turns: a tenth.
    p = math.sqrt(2.0 * 75.0 * 900.0 * 420.0 / 1320.0)
    assert abs(motion["rate_z_deg_s"].iloc[-1]) == pytest.approx(
        math.degrees(p * 0.005 / 140.0), rel=0.1
    )


def test_a_trajectory_hands_over_and_takes_back(capsys, tmp_path, monkeypatch):
    """The payload's orbit is that of the reference, and of what the push has added."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("drakesep.plots.motion.save_motion", lambda *_, **__: None)
    before, after, *state = run(containing("ascent.oem"), capsys)
    r, v = [-6045.0, -3490.0, 2500.0], [-3.457, 6.618, 2.533]
    mu = 398600.4418
    a = 1.0 / (2.0 / math.hypot(*r) - math.hypot(*v) ** 2 / mu)
    assert before == pytest.approx(a, rel=1e-9)
    results = drakesep.read_results("separated")
    one = results.run("nominal").run
    motion = one.completed_trajectory
    i = motion.time.tolist().index(one.separation_end)
    position, velocity = motion.of("payload")[i, 4:7], motion.of("payload")[i, 10:]
    body = results.case.separation.body("payload")
    turned = Rotation.from_quat(motion.of("payload")[i, :4], scalar_first=True)
    cg = turned.apply(body.p_BoBcm_B)
    moving = velocity + np.cross(motion.of("payload")[i, 7:10], cg)
    _, radius, across, climb = one.separation.orbit.start
    # Of the reference at t = 0, with the push: it turns by 2e-4 rad within that.
    speed = np.linalg.norm(np.add([across, 0.0, -climb], moving))
    energy = 0.5 * speed**2 - 1e9 * mu / (radius - (position + cg)[2])
    assert after == pytest.approx(-1e6 * mu / (2.0 * energy), rel=1e-6)
    coasted = 1.0 / (2.0 / math.hypot(*state[:3]) - math.hypot(*state[3:]) ** 2 / mu)
    assert coasted == pytest.approx(after, rel=1e-6)  # of the digits that are printed


def test_variants_of_the_command_line(capsys):
    """Springs of Eq. 5 give the same impulse, so that speeds go with 1/mu."""
    printed = run(containing("drakesep.sweep"), capsys)
    (_, light, fast), (_, nominal, speed), (_, heavy, slow) = zip(
        *[iter(printed)] * 3, strict=True
    )
    for mass, v in ((light, fast), (heavy, slow)):
        ratio = (1.0 / 750.0 + 1.0 / mass) / (1.0 / 750.0 + 1.0 / nominal)
        assert v / speed == pytest.approx(ratio, rel=1e-5)  # as they are printed


def test_body_of_a_shape(capsys):
    run(containing("mass_properties_of_shape"), capsys)


def test_proposed_gains(capsys):
    gains = run(containing("print(joint.K_F"), capsys)
    assert gains[:3] == [5e6] * 3  # 500 N over 0.1 mm
    assert min(gains[3:]) > 0.0


def test_separation_in_a_parent(capsys):
    """VEGA's rates, released by a command at the start."""
    rates = run(containing("ConstantVectorSource"), capsys)
    expected = [math.radians(rate) for rate in (0.5752, 0.2440, 0.3325)]
    assert rates == pytest.approx(expected, abs=math.radians(1e-4))


def test_separation_on_a_plant(capsys):
    """sqrt(2 E / mu) of 75 J."""
    speed = run(containing("add_separation(builder"), capsys)
    expected = (2.0 * 75.0 * (1 / 900 + 1 / 400)) ** 0.5
    assert speed == pytest.approx([expected, 0.0, 0.0], abs=1e-5)


def test_case_files_of_the_guide():
    """The loads that it shows can be read."""
    [block] = blocks(GUIDE, "yaml")
    data = YAML(typ="safe").load(builtin_cases()["vega"])
    data |= YAML(typ="safe").load(block)
    loads = Case.model_validate(data).separation.loads
    assert [load.name for load in loads] == ["retro_rocket", "gust"]


def test_a_case_in_python(capsys):
    """The heaviest payload is the slowest, and its mass is at the wider bound."""
    run_ = compile(containing("AnalysisCase("), str(GUIDE), "exec")
    exec(run_, {"__name__": "__main__"})
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "['nominal']"
    _, label, role, mass = lines[-1].split()
    assert (label, role) == ("worst_PM", "worst")
    assert float(mass) == pytest.approx(1860.0 + 40.0)


def test_a_requirement_of_your_own(capsys):
    block = containing("FunctionRequirement(")
    exec(compile(block, str(GUIDE), "exec"), {"__name__": "__main__"})
    *_, evidence, verdict = capsys.readouterr().out.splitlines()
    assert evidence.split()[1] == "highest_lateral_drift"
    assert "batch, run by run" in evidence
    assert verdict == "met"


def test_many_runs(capsys):
    rates = run(containing("batch.jacobian"), capsys)[-3:]
    # deg/s to the digits printed
    expected = [math.radians(x) for x in (0.5752, 0.2440, 0.3325)]
    assert rates == pytest.approx(expected, abs=1e-6)


def test_ellipsoids_of_the_page_on_worst_cases():
    [block] = [b for b in blocks(WORST_CASES, "yaml") if "ellipsoids" in b]
    data = YAML(typ="safe").load(builtin_cases()["vega"])
    data |= YAML(typ="safe").load(block)
    first, second = Case.model_validate(data).tolerance_set.ellipsoids
    assert first.names == ("payload.cg_y", "payload.cg_z")
    assert first.correlation is None
    assert second.correlation == ((1.0, 0.8), (0.8, 1.0))


def test_draws_of_the_page_on_campaigns(capsys):
    """What it shows can be read, and of VEGA's draws 2.3 % have to be drawn again."""
    [block] = [b for b in blocks(CAMPAIGNS, "yaml") if "correlations" in b]
    data = YAML(typ="safe").load(builtin_cases()["vega"])
    data |= YAML(typ="safe").load(block)
    del data["published"]  # of other tolerances
    case = Case.model_validate(data).in_si()
    kinds = [distribution_of(t).kind for t in case.tolerances.values()]
    assert kinds == [
        *("uniform", "normal", "normal", "normal"),
        *("lognormal", "lognormal", "table", "triangular", "triangular"),
    ]
    assert case.failure_probabilities == {"spring_3_out": 0.001}
    *_, share = run(containing("draws.at(["), capsys)
    # Of 10 000: the standard error is 0.15.
    assert share == pytest.approx(2.3, abs=0.5)


def test_objectives_of_the_page_on_worst_cases(capsys):
    """In Drake they are what they are in the batch engine."""
    exec(compile(containing("largest"), str(WORST_CASES), "exec"), {})
    rows = [line.split() for line in capsys.readouterr().out.splitlines()[1:]]
    assert len(rows) == 4
    for *_, worst, in_drake in rows:
        assert float(worst) == pytest.approx(float(in_drake), rel=1e-5)


def test_metrics_of_the_page_on_metrics(capsys):
    """A metric of one's own is registered; the requirements shown can be read."""
    try:
        run(containing("register_metric"), capsys)
        assert highest("turned_after_separation_y").needs is Needs.METRICS
    finally:
        forget_metric("turned_after_separation")
    [block] = blocks(METRICS_PAGE, "yaml")
    data = YAML(typ="safe").load(builtin_cases()["vega"])
    data |= YAML(typ="safe").load(block)
    limits = Case.model_validate(data).limits
    assert [(limit.metric, limit.sense) for limit in limits] == [
        *((f"rate_after_separation_{axis}", "<=") for axis in "xyz"),
        ("longitudinal_speed_after_separation", ">="),
        ("longitudinal_speed_after_separation", "<="),
        ("relative_rate_from_0.5_to_2_s_x", "<="),
        ("relative_rate_from_0.5_to_2_s_z", "<="),
        ("G_PM", "<="),
        ("transverse_rate_after_separation", "<="),
    ]
    assert limits[3].id == "UM-4.2"


def test_clearance_from_python(capsys):
    run(containing("drakesep.clearance("), capsys)
    run(containing("LowestClearance("), capsys)


def test_seen_in_a_diagram(capsys):
    run(containing("illustrated=True"), capsys)


def test_geometry_of_the_page_on_clearance(tmp_path):
    """What it shows can be read; the ring stands for what it leaves out."""
    geometry, chosen, required, of_pairs, of_parts, recontact = blocks(
        CLEARANCE, "yaml"
    )
    shown = YAML(typ="safe").load(geometry)["bodies"]["payload"]["geometry"]
    data = YAML(typ="safe").load(builtin_cases()["vega"])
    ring = data["bodies"]["launch_vehicle"]["geometry"]
    data["bodies"]["payload"]["geometry"] |= shown
    assert set(shown) == {"nozzle", "antenna", "tank"}
    [requirement] = YAML(typ="safe").load(required)["requirements"]
    assert requirement in data["requirements"]
    sections = YAML(typ="safe").load(of_pairs)["requirements"]
    assert all(RequirementSection(**section).of_clearance for section in sections)
    of_vega = YAML(typ="safe").load(builtin_cases()["vega"])
    case = Case.model_validate(of_vega | YAML(typ="safe").load(of_parts))
    assert [limit.metric for limit in case.limits] == [
        "clearance_of_nozzle+adapter_ring_until_0.5_m",
        "clearance_of_antenna+adapter_ring",
        "clearance_of_antenna+adapter_wall",
    ]
    chosen = YAML(typ="safe").load(chosen)
    ring["flange"] = ring["adapter_ring"]
    data["bodies"]["payload"]["geometry"]["flange"] = ring.pop("flange")
    case = Case.model_validate(data | chosen | YAML(typ="safe").load(recontact))
    assert case.separation.recontact.without == (("flange", "adapter_ring"),)
    assert case.clearance.pairs == [
        ("nozzle", "adapter_ring"),
        ("antenna", "adapter_wall"),
    ]
