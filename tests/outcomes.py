"""Every command by every outcome: what is asked of it, and its exit code."""

import functools
import json
import shutil
import tempfile
from pathlib import Path

from certificates import LARGEST, TIGHT, push
from small_case import small_case, write_case

import drakesep
from drakesep.systems.simulation.simulation import Simulation


GOOD, NOT_MET, RUN_FAILED, OTHER_RUN_FAILED, BAD_FILE, BAD_SETTING, NO_FOLDER = (
    *("good", "not met", "run failed", "another run failed"),
    *("bad file", "bad setting", "folder in the way"),
)
INTERRUPTED = "interrupted"
SEARCH = ("--search", "drake", "--workers", "1")
"""Drake alone: no program to compile."""
OF_STUDY = {
    GOOD: 0,
    RUN_FAILED: 4,
    BAD_FILE: 2,
    BAD_SETTING: 2,
    NO_FOLDER: 2,
    INTERRUPTED: 130,
}
OF_CLEARANCE = {**OF_STUDY, NOT_MET: 1}
OF_DISTRIBUTIONS = {one: code for one, code in OF_STUDY.items() if one != RUN_FAILED}
CODES = {
    "cases": {GOOD: 0, INTERRUPTED: 130},
    "show": {GOOD: 0, BAD_FILE: 2, INTERRUPTED: 130},
    "new": {GOOD: 0, BAD_SETTING: 2, NO_FOLDER: 2, INTERRUPTED: 130},
    "simulate": OF_STUDY,
    "sweep": {**OF_STUDY, OTHER_RUN_FAILED: 4},
    "clearance": OF_CLEARANCE,
    "campaign": {**OF_STUDY, NOT_MET: 1},
    "campaign sensitivity": OF_DISTRIBUTIONS,
    "campaign rare-events": OF_DISTRIBUTIONS,
    "replay": {GOOD: 0, BAD_SETTING: 2, NO_FOLDER: 2, INTERRUPTED: 130},
    "animate": {**OF_STUDY, OTHER_RUN_FAILED: 4},
    "worst-case": {**OF_STUDY, OTHER_RUN_FAILED: 4},
    "verify": {**OF_STUDY, NOT_MET: 1, OTHER_RUN_FAILED: 4},
    "prove": {one: code for one, code in OF_CLEARANCE.items() if one != RUN_FAILED},
    "check-proof": {GOOD: 0, NOT_MET: 1, BAD_FILE: 2, INTERRUPTED: 130},
    "compare": {GOOD: 0, NOT_MET: 1, BAD_SETTING: 2, NO_FOLDER: 2, INTERRUPTED: 130},
    "report": {GOOD: 0, BAD_SETTING: 2, NO_FOLDER: 2, INTERRUPTED: 130},
    "export": {GOOD: 0, BAD_SETTING: 2, NO_FOLDER: 2, INTERRUPTED: 130},
}
"""What else there is does not come about: no requirement is asked of `simulate`."""
SETTINGS = {
    "new": ("--from", "vga"),
    "simulate": ("--set", "upper.mass_kg=heavy"),
    "sweep": ("--engine", "steam"),
    "clearance": ("--set", "upper.mas_kg=1200"),
    "campaign": ("--runs", "10"),
    "campaign sensitivity": ("--base", "3"),
    "campaign rare-events": ("--replicates", "1"),
    "replay": ("--run", "300"),
    "animate": ("--run", "worst_L1"),
    "worst-case": ("--objective", "L3"),
    "verify": ("--samples", "0"),
    "prove": ("--gap-percent", "0"),
    "compare": ("--tolerance", "-1"),
    "report": ("nowhere",),
    "export": ("--epoch", "tomorrow"),
}


def case_for(outcome, command):
    """The small case, so that it comes to the outcome."""
    if outcome == BAD_FILE:
        return small_case(pair={"A": "lower", "B": "uper"})
    data = small_case(dispersions={"upper.mass_kg": 20.0}, published=None)
    if command == "campaign sensitivity":  # of one parameter there is nothing to share
        data["dispersions"]["s1.force_max_N"] = 20.0
    data["requirements"] = data["requirements"][:1]
    if outcome == NOT_MET:
        data["requirements"][0]["at_least"] = 5.0
        data["bodies"]["lower"]["geometry"]["post"]["position_mm"][1] = 300.0
    if outcome in (RUN_FAILED, OTHER_RUN_FAILED):
        spring = data["attachments"]["two"]["spring"]
        del spring["design_mass_kg"]
        spring["law"] = "displacement"
    if outcome == RUN_FAILED:
        spring["stroke_mm"] = 5000.0  # the run ends sooner
    if outcome == OTHER_RUN_FAILED:
        [published] = small_case()["published"]
        published["values"] = {"s2.stroke_mm": 5000.0}
        data["published"] = [published]
    return data


@functools.cache
def flown_once():
    """The results of a run, which nobody may change."""
    home = Path(tempfile.mkdtemp())
    case = write_case(home, case_for(GOOD, "simulate"))
    drakesep.simulate(case, output=home / "out")
    return home / "out"


def to_compare(outcome, folder):
    """Two folders, and where the changes go."""
    copy = shutil.copytree(flown_once(), folder / "copy")
    if outcome == NOT_MET:
        table = copy / "summary.csv"
        table.write_text(table.read_text().replace("1200.0", "1201.0"))
    output = folder / "out"
    if outcome == NO_FOLDER:
        output.write_text("")
    return [flown_once(), copy, "--tolerance", 1e-6, "-o", output / "changes.csv"]


def arguments(command, outcome, folder):
    if command == "cases":
        return []
    if command == "new":
        if outcome == NO_FOLDER:
            (folder / "out").write_text("")
        setting = SETTINGS[command] if outcome == BAD_SETTING else ()
        return ["small", "-o", folder / "out", *setting]
    if command == "export":
        setting = SETTINGS[command] if outcome == BAD_SETTING else ()
        if outcome == NO_FOLDER:
            (folder / "out").write_text("")
        words = [flown_once(), "--format", "csv", "-o", folder / "out" / "there"]
        return [*words, *setting]
    if command == "compare":
        setting = SETTINGS[command] if outcome == BAD_SETTING else ()
        return [*to_compare(outcome, folder), *setting]
    if command == "check-proof":
        bound = 0.999 * LARGEST if outcome == NOT_MET else TIGHT
        file = folder / "proof.json"
        file.write_text("{}" if outcome == BAD_FILE else json.dumps(push(bound)))
        return [file, "--workers", 1]
    case = write_case(folder, case_for(outcome, command))
    if command == "show":
        return [case]
    output = folder / "out"
    if outcome == NO_FOLDER:
        output.write_text("")
    if command in ("animate", "report"):
        output = output / "page.html"
    more = [*SEARCH, "--objective", "PM"] if command == "worst-case" else []
    more = [*SEARCH] if command == "verify" else more
    if command == "campaign":
        more = ["--share", 0.99, "--confidence", 0.9, "--workers", 1]
        more += [] if outcome == BAD_SETTING else ["--runs", 300]
    if command == "campaign sensitivity":
        more = [] if outcome == BAD_SETTING else ["--base", 4, "--replicates", 2]
    if command == "campaign rare-events":
        more = ["--per-level", 40, "--least", 0.01]
        more += [] if outcome == BAD_SETTING else ["--replicates", 2]
    if command == "sweep":
        other = outcome == OTHER_RUN_FAILED
        more = ["s2.stroke_mm=110,5000" if other else "upper.mass_kg=1180:1220:3"]
    setting = SETTINGS[command] if outcome == BAD_SETTING else ()
    if command in ("replay", "report"):
        campaign = folder / "campaign"
        drakesep.plan_campaign(case, 300, output=campaign)
    if command == "report":
        return [campaign, "-o", output, *setting]
    if command == "replay":
        setting = setting or ("--run", "5", "--no-animation")
        return [campaign, "-o", output, *setting]
    return [case, "-o", output, *more, *setting]


def interrupt(monkeypatch):
    """Ctrl-C as the first run flies; where none does, as the work begins."""

    def stop(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(Simulation, "run", stop)
    monkeypatch.setattr("drakesep.studies.prove.proven_answers", stop)
    monkeypatch.setattr("drakesep.check_proof.tree.Walk.verify", stop)
    monkeypatch.setattr("drakesep.cli.console.print_cases", stop)
    monkeypatch.setattr("drakesep.cli.console.print_case", stop)
    monkeypatch.setattr("drakesep.case_file.new_case.new_case", stop)
    monkeypatch.setattr("drakesep.reports.compare.differences", stop)
    monkeypatch.setattr("drakesep.reports.html.page_of", stop)
    monkeypatch.setattr("drakesep.reports.export.handover_table", stop)
