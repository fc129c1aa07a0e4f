"""Ways to the worst case of VEGA: value reached against runs, and against seconds.

What a user would do without drakesep's searches (scipy's SLSQP with finite differences
on Drake runs, differential evolution and plain Monte Carlo on the same) beside the
searches of drakesep on its batch engine, for one objective of the paper. Programs are
compiled beforehand. Prints a table and draws docs/worst_case_search.png.

    python benchmarks/worst_case_search.py [SECONDS] [OBJECTIVE]
"""

import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from drakesep import load_case
from drakesep.analysis import (
    OBJECTIVES,
    SEARCHES,
    Batch,
    BatchEvaluator,
    DrakePool,
    Problem,
    RunEvaluator,
    SearchSettings,
    deviation_limits,
)


PICTURE = Path(__file__).parents[1] / "docs" / "worst_case_search.png"
IN_DRAKE = ("sqp", "evolution", "samples")
ON_BATCH = ("sqp", "multistart", "evolution", "vertices", "samples")
NAMES = {
    "sqp": "SLSQP from the nominal",
    "multistart": "SLSQP from 12 starts",
    "evolution": "differential evolution",
    "vertices": "all vertices",
    "samples": "Monte Carlo",
}
COLOURS = dict(
    zip(NAMES, ("#0072B2", "#009E73", "#CC79A7", "#E69F00", "#555555"), strict=True)
)


class OutOfTime(Exception):
    """The seconds that a search may take are over."""


class Recorded:
    """An evaluator that notes the best value so far after each call."""

    def __init__(self, evaluator, seconds, rows):
        self._evaluator, self._rows = evaluator, rows
        self.names, self.objectives = evaluator.names, evaluator.objectives
        self.exact = evaluator.exact
        self._end = time.perf_counter() + seconds
        self._start = time.perf_counter()
        self.runs, self.best = 0, -np.inf
        self.record = []

    def _note(self, values):
        self.runs += len(values)
        self.best = max(self.best, float(np.nanmax(values)))
        self.record.append((self.runs, time.perf_counter() - self._start, self.best))
        if time.perf_counter() > self._end:
            raise OutOfTime

    def all(self, rows, on_progress=None, of=None):
        """Note the values, some rows at a time."""
        told = []
        for first in range(0, len(rows), self._rows):
            some = rows[first : first + self._rows]
            told.append(self._evaluator.all(some, of=of))
            self._note(told[-1].values)
        return told[0]._replace(values=np.concatenate([t.values for t in told]))

    def one(self, rows, which):
        """Note the values."""
        told = self._evaluator.one(rows, which)
        self._note(told.values)
        return told

    def slopes(self, rows, which):
        """Note the values; derivatives count as one run."""
        told = self._evaluator.slopes(rows, which)
        self._note(told[0].values)
        return told


def main():
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60.0
    objective = OBJECTIVES[sys.argv[2] if len(sys.argv) > 2 else "Linf"]
    case = load_case("vega")
    limits, names = deviation_limits(case.limits), case.box.names
    batch = Batch(case.separation, names, deviation_limits=limits)
    batch.jacobian(batch.nominal[None])
    batch.run(batch.nominal[None])
    on_batch = BatchEvaluator(batch, [objective], limits)
    records = {}
    with DrakePool(case.separation, case.integration) as pool:

        def fly(rows):
            return pool.fly([dict(zip(names, row, strict=True)) for row in rows])

        fly(np.tile(batch.nominal, (8, 1)))  # the workers have started
        in_drake = RunEvaluator(fly, names, [objective], limits)
        for engine, evaluator, searches in (
            ("Drake", in_drake, IN_DRAKE),
            ("batch", on_batch, ON_BATCH),
        ):
            for search in searches:
                record = run(case, evaluator, search, seconds)
                records[engine, search] = record
                runs, elapsed, best = record[-1]
                print(
                    f"{engine:6} {search:11} {runs:8} runs {elapsed:7.2f} s {best:.7g}"
                )
    table = summary(records, objective)
    print(table.to_string(index=False))
    draw(records, objective, PICTURE)


def run(case, evaluator, search, seconds):
    in_drake = isinstance(evaluator, RunEvaluator)
    recorded = Recorded(evaluator, seconds, 32 if in_drake else 2048)
    problem = Problem(tolerances=case.tolerance_set, evaluator=recorded)
    settings = SearchSettings(samples=1_000_000, generations=1000)
    try:
        SEARCHES[search](problem, settings, (), lambda _: None)
    except OutOfTime:
        pass
    return recorded.record


def summary(records, objective):
    """What each way reached, and when it came within 1 % and 0.001 % of the best."""
    best = max(record[-1][2] for record in records.values())
    rows = []
    for (engine, search), record in records.items():
        row = {
            "engine": engine,
            "search": NAMES[search],
            "runs": record[-1][0],
            "seconds": round(record[-1][1], 2),
            "short of the best (%)": f"{100.0 * (1.0 - record[-1][2] / best):.4f}",
        }
        for share in (0.99, 0.99999):
            there = [r for r in record if r[2] >= share * best]
            row[f"s to {share:.3%}"] = f"{there[0][1]:.2f}" if there else "-"
        rows.append(row)
    return pd.DataFrame(rows)


def draw(records, objective, path):
    figure = Figure(figsize=(11, 4.6), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for (engine, search), record in records.items():
        runs, elapsed, best = np.array(record).T
        for axes, x in zip(panels, (runs, elapsed), strict=True):
            axes.plot(
                np.append(x, x[-1]),
                np.degrees(np.append(best, best[-1])),
                drawstyle="steps-post",
                color=COLOURS[search],
                linestyle="-" if engine == "batch" else (0, (4, 2)),
                linewidth=2.0 if engine == "batch" else 1.4,
                marker="o",
                markevery=[-1],
                label=f"{engine}: {NAMES[search]}",
            )
    for axes, label in zip(panels, ("runs", "time (s)"), strict=True):
        axes.set_xscale("log")
        axes.set_xlabel(label)
        axes.grid(alpha=0.3)
    panels[0].set_ylabel(f"G_{objective.name}, best so far (deg/s)")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False)
    figure.suptitle(f"Worst case of VEGA by G_{objective.name}: ways to find it")
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    main()
