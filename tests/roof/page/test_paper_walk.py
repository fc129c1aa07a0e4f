"""The paper's way through the page, in a browser: from a tolerance to equal bytes.

Where `DRAKESEP_PICTURES` names a folder, what is seen at each step is kept there.
"""

import json
import os
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest
from browser import browser
from served import READY, opened, served


pytestmark = pytest.mark.browser
SEARCH = 'section[aria-label="Search"]'
VISIBLE = "[...document.querySelectorAll('.study-words')].find(e => e.offsetParent)"


@pytest.fixture
def see():
    """What keeps a picture of the page."""
    folder = os.environ.get("DRAKESEP_PICTURES")
    number = 0

    def keep(page, name):
        nonlocal number
        number += 1
        if folder:
            (Path(folder) / f"{number:02} {name}.png").write_bytes(page.picture())

    return keep


def says(text):
    """What is true once the study of the tab that is shown says so."""
    return f"{VISIBLE}?.textContent.includes({text!r})"


def shown(selector):
    return f"!!document.querySelector({selector!r})?.offsetParent"


def start(page):
    page.click_text("Start", SEARCH)
    page.wait(shown('button[aria-label="Iterate before"]'), 60.0)


def tables(folder):
    return {file.name: file.read_bytes() for file in sorted(folder.glob("*.csv"))}


def test_the_papers_way_on_vega(tmp_path, see):
    with opened(tmp_path, "vega") as page:
        see(page, "vega opened")
        cell = page.wait(
            "[...document.querySelectorAll('[data-cell]')].map(e => e.dataset.cell)"
            ".find(k => k.includes('dispersions') && k.includes('payload.mass_kg'))"
        )
        page.fill(f"[data-cell='{cell}']", "25")
        page.wait("document.querySelector('.case-state').textContent === 'not saved'")
        see(page, "a tolerance set")
        page.click_text("Search")
        page.click_text("Objective on any metric", SEARCH)
        page.wait(shown(".form-metric button.q-btn"))
        page.click_text("Add objective")
        page.wait(
            "document.querySelector('.q-chip')?.textContent.includes('highest_rate')"
        )
        see(page, "an objective on the payload's rate")
        start(page)
        see(page, "the first iterates")
        page.wait(says("Ended"), 90.0)
        page.wait(shown(".frame"), 20.0)
        page.wait("document.querySelectorAll('.response canvas').length === 3", 20.0)
        see(page, "the search ended")
        page.value("document.querySelector('.frame button').scrollIntoView()")
        time.sleep(0.3)  # a click lands where the browser has drawn it
        page.click_text("Show run")
        page.wait(
            "document.querySelector('.study-where').textContent.includes('worst case')"
        )
        see(page, "the worst case")
        page.click_text("Export")
        command = page.wait("document.querySelector('.study-command').textContent")
        see(page, "exported")
        assert not [
            url for url in page.requests if not url.startswith("http://127.0.0.1:")
        ]
    folder = tmp_path / "results" / "vega" / "worst-case-1"
    iterates = pd.read_csv(folder / "iterates.csv")
    assert iterates["payload.mass_kg"].max() > 1880.0  # which the paper's do not leave
    run_exported(command)
    again = tmp_path / "results" / "vega" / "worst-case-1-export" / "again"
    assert tables(again) == tables(folder)
    assert len(tables(folder)) > 5


def run_exported(command):
    """Run what the page says, by this Python's drakesep."""
    home, _, words = command.partition(" && ")
    _, *arguments = shlex.split(words)
    script = "from drakesep.cli.entry import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", script, *arguments], cwd=shlex.split(home)[1]
    )
    assert done.returncode in (0, 1)


def test_a_search_is_stopped_killed_and_goes_on(tmp_path, see):
    with served(tmp_path, "vega") as server, browser() as page:
        page.open(server.address, 1280, 800)
        page.wait(READY)
        page.click_text("Search")
        choose_objective(page)
        start(page)
        page.click_text("Stop", SEARCH)
        page.wait(says("Stopped"), 5.0)
        see(page, "stopped")
        page.click_text("Go on", SEARCH)
        page.wait(f"!{says('Stopped')}", 5.0)
        page.wait(f"/sqp|multistart/.test({VISIBLE}?.textContent)")
        os.kill(searching(server.process.pid), signal.SIGKILL)
        page.wait(says("SIGKILL"), 5.0)
        see(page, "killed")
        page.click_text("Go on", SEARCH)
        page.wait(says("Ended"), 90.0)
        see(page, "gone on")
    held = pd.read_csv(tmp_path / "results" / "vega" / "worst-case-1" / "iterates.csv")
    assert {*held["search"]} == {"sqp", "multistart"}


def searching(parent):
    """The process of the server that runs a command."""
    [found] = [
        int(folder.name)
        for folder in Path("/proc").glob("[0-9]*")
        if (folder / "cmdline").read_bytes().count(b"drakesep.cli.watched")
        and f" {parent} " in (folder / "stat").read_text().rpartition(")")[2][:16]
    ]
    return found


def choose_objective(page):
    page.click_text("Objective on any metric", SEARCH)
    page.wait(shown(".form-metric button.q-btn"))
    page.click_text("Add objective", SEARCH)
    page.wait("document.querySelector('.q-chip')?.textContent.includes('highest_rate')")


def test_the_smallsat_is_mended_and_verified(tmp_path, see):
    """Not met; then with its CG on the axis, and a limit that springs allow."""
    with opened(tmp_path, "smallsat") as page:
        page.click_text("Search")
        page.click_text("Requirements", SEARCH)
        page.wait(shown(f"{SEARCH} .q-toggle"))
        verify(page)
        see(page, "smallsat not met")
        assert "not met" in page.value(f"{VISIBLE}.textContent")
        page.click_text("Case")
        for path in (
            ["bodies", "smallsat", "cg_mm", 1],
            ["bodies", "smallsat", "cg_mm", 2],
        ):
            fill(page, path, "0")
        fill(page, ["requirements", 1, "at_most"], "7")
        see(page, "smallsat mended")
        page.click_text("Search")
        verify(page)
        see(page, "smallsat met")
        assert "Ended: met" in page.value(f"{VISIBLE}.textContent")
        page.click_text("Results")
        page.wait("document.querySelectorAll('.results-table tbody tr').length === 2")
        for name in ("verify-1", "verify-2"):  # the one in place of the other
            page.click_text(f"smallsat/{name}", ".results-table")
            title = "document.querySelector('[aria-label=Results] .study-title')"
            page.wait(f"{title}?.textContent === 'smallsat/{name}'")
            page.wait("document.querySelector('[aria-label=Results] .frame')")
        see(page, "results")


def fill(page, path, text):
    cell = json.dumps(path, separators=(",", ":"))
    page.wait(
        f"!!document.querySelector({json.dumps(f'[data-cell={json.dumps(cell)}]')})"
    )
    page.fill(f"[data-cell={json.dumps(cell)}]", text)
    page.wait("document.querySelector('.case-state').textContent === 'not saved'")


def verify(page):
    page.click_text("Start", SEARCH)
    page.wait(f"!{says('Ended')}", 10.0)
    page.wait(says("Ended"), 200.0)
    page.wait(shown(".frame"), 20.0)
