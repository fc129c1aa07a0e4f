"""What the page takes until it can be used, moves, searches and stops; and its growth.

It is used in a headless Chromium as a person would: for each case the time from the
command to a page that can be used, and from a slider to the motion that is drawn; of
VEGA, from *Start* to the first iterate, from *Stop* to what says so, and the memory of
all processes of the server and of the page's scripts as sliders move.

    python benchmarks/page.py [--soak SECONDS] [CASE ...]
"""

import argparse
import json
import statistics
import sys
import tempfile
import time
from collections import defaultdict
from pathlib import Path


sys.path[:0] = [str(Path(__file__).parents[1] / "tests")]

from browser import Browser, browser  # noqa: E402
from served import READY, served  # noqa: E402


SEARCH = 'section[aria-label="Search"]'
WORDS = "[...document.querySelectorAll('.study-words')].find(e => e.offsetParent)"
RANGE = "[...document.querySelectorAll('input[type=range]')]"
MOVED = """new Promise(done => {
  const chart = getElement(document.querySelector(".play-chart").id.slice(1)).chart;
  const slider = %s[%d];
  const began = performance.now();
  const drawn = () => {
    chart.off("finished", drawn);
    requestAnimationFrame(() => done(performance.now() - began));
  };
  chart.on("finished", drawn);
  const [low, high] = [Number(slider.min), Number(slider.max)];
  slider.value = low + %f * (high - low);
  slider.dispatchEvent(new Event("input", {bubbles: true}));
})"""
WARM = 8.0
"""In which a process gets ready for the search that is chosen, s."""


def usable(case: str, folder: Path, page: Browser) -> float:
    """Return how long it takes from the command until the page can be used, s."""
    began = time.perf_counter()
    with served(folder, case) as server:
        page.open(server.address, 1280, 800)
        page.wait(READY)
        return time.perf_counter() - began


def moves(page: Browser, times: int = 31) -> list[float]:
    """Return how long a slider takes to the motion that is drawn, ms, each time."""
    play(page)
    found = []
    for i in range(times):
        moved = MOVED % (RANGE, 0, (7 * i % times) / times)
        told = page.ask(
            "Runtime.evaluate", expression=moved, awaitPromise=True, returnByValue=True
        )
        found.append(told["result"]["value"])
        time.sleep(0.25)
    return found


def play(page: Browser) -> None:
    """Open the tab, and wait until it has flown."""
    page.click_text("Play", "header")
    page.wait("!!document.querySelector('.play-fares td')")
    time.sleep(2.0)


def searches(page: Browser, times: int = 5) -> tuple[list[float], list[float]]:
    """Return how long first iterates and stops take, s, each time."""
    page.click_text("Search")
    page.click_text("Objective on any metric", SEARCH)
    page.wait("!!document.querySelector('.form-metric button.q-btn')?.offsetParent")
    page.click_text("Add objective", SEARCH)
    page.wait("document.querySelector('.q-chip')?.textContent.includes('highest_rate')")
    firsts, stops = [], []
    for _ in range(times):
        time.sleep(WARM)
        began = time.perf_counter()
        page.click_text("Start", SEARCH)
        page.wait(f"/sqp|multistart/.test({WORDS}?.textContent)", 60.0)
        firsts.append(time.perf_counter() - began)
        began = time.perf_counter()
        page.click_text("Stop", SEARCH)
        page.wait(f"/^Stopped|^Ended/.test({WORDS}?.textContent)", 20.0)
        stops.append(time.perf_counter() - began)
    return firsts, stops


def growth(page: Browser, server: int, seconds: float) -> None:
    """Move sliders for a while; print the memory of processes and scripts, MB."""
    play(page)
    began = time.monotonic()
    told = 0.0
    moved = 0
    while (now := time.monotonic() - began) < seconds:
        share = (0.618034 * moved) % 1.0
        page.value(MOVED % (RANGE, moved % 5, share))
        moved += 1
        time.sleep(0.12)
        if now >= told:
            told += seconds / 10.0
            page.ask("HeapProfiler.collectGarbage")
            heap = page.ask("Runtime.getHeapUsage")["usedSize"] / 1e6
            print(
                f"{now:6.0f} s, {moved:5d} moves: processes {memory(server):7.1f} MB, "
                f"scripts {heap:5.1f} MB",
                flush=True,
            )


def memory(process: int) -> float:
    """Return what a process and its children hold that is theirs alone, MB."""
    children = defaultdict(list)
    for stat in Path("/proc").glob("[0-9]*/stat"):
        parent = int(stat.read_text().rpartition(") ")[2].split()[1])
        children[parent].append(int(stat.parent.name))
    mine, held = [process], 0.0
    while mine:
        one = mine.pop()
        mine += children[one]
        for line in Path(f"/proc/{one}/smaps_rollup").read_text().splitlines():
            if line.startswith("Private"):
                held += int(line.split()[1]) / 1e3
    return held


def main() -> None:
    """Measure, and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", nargs="*", default=["vega", "smallsat"])
    parser.add_argument("--soak", type=float, default=300.0)
    settings = parser.parse_args()
    with tempfile.TemporaryDirectory() as home, browser() as page:
        folder = Path(home)
        for case in settings.cases:
            took = [usable(case, folder, page) for _ in range(3)]
            print(f"{case}: usable after {listed(took)} s")
            with served(folder, case) as server:
                page.open(server.address, 1280, 800)
                page.wait(READY)
                took = moves(page)
            print(
                f"{case}: a slider {statistics.median(took):.0f} ms, the median of "
                f"{len(took)} ({min(took):.0f} to {max(took):.0f})"
            )
        with served(folder, "vega") as server:
            page.open(server.address, 1280, 800)
            page.wait(READY)
            firsts, stops = searches(page)
            print(f"vega: first iterate after {listed(firsts)} s")
            print(f"vega: stopped after {listed(stops)} s")
            growth(page, server.process.pid, settings.soak)


def listed(values: list[float]) -> str:
    return json.dumps([round(value, 2) for value in values])[1:-1]


if __name__ == "__main__":
    main()
