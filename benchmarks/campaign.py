"""What a campaign takes beside what the batch engine alone takes: VEGA, many runs.

    python benchmarks/campaign.py --runs 1000000

In turns within one process: `Batch.run` of values that are drawn beforehand; and the
same draws as a campaign has them, drawn, flown in chunks that are written and synced,
read again, merged, and judged. Then the memory of the process at its most. Without
clearance, which campaigns do not measure; without Drake, which flies the same few
hundred draws however many there are.
"""

import argparse
import dataclasses
import resource
import statistics
import tempfile
import time
from pathlib import Path

import numpy as np

from drakesep.analysis.campaigns.draws import Draws
from drakesep.analysis.campaigns.flights import CampaignFlights
from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.analysis.campaigns.shares import share_findings
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.registry import registered_metrics
from drakesep.case_file.reader import load_case
from drakesep.results.campaign_files import RecordedPlan, merged, write_chunk
from drakesep.studies.campaign.executors import flown_here


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=1_000_000)
    parser.add_argument("--rounds", type=int, default=1)
    asked = parser.parse_args()
    case = load_case("vega").in_si()
    required = tuple(r for r in case.requirements if not r.measured_apart)
    case = dataclasses.replace(case, requirements=required)
    plan = CampaignPlan.of(case, asked.runs)
    batch = Batch(
        case.separation,
        case.box.names,
        deviation_limits=case.limits_of_pairs,
        metrics=plan.metrics,
        without={metric.stem for metric in registered_metrics() if metric.objective},
    )
    flights = CampaignFlights(plan)
    few = np.arange(flights.together)
    batch.run(Draws(case, 0).at(few).values)
    flights.fly(few)
    alone, ratios = [], []
    for _ in range(asked.rounds):
        values = Draws(case, 0).at(np.arange(asked.runs)).values
        alone.append(seconds(lambda values=values: batch.run(values)))
        del values
        with tempfile.TemporaryDirectory() as scratch:
            took = seconds(lambda home=Path(scratch): campaign(flights, home))
        ratios.append(took / alone[-1])
        print(f"alone {alone[-1]:.1f} s, as a campaign {took:.1f} s", flush=True)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(f"{asked.runs} runs: {statistics.median(ratios):.2f} times as long")
    print(f"{peak:.2f} GiB at most")


def seconds(work) -> float:
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def campaign(flights: CampaignFlights, home: Path) -> None:
    recorded = RecordedPlan.of(flights.plan)
    for number, flown in flown_here(flights, range(flights.plan.chunks)):
        write_chunk(home, recorded, number, flown)
    together = merged(home, recorded)
    share_findings(flights.plan, together.metrics, [*together.reasons])


if __name__ == "__main__":
    main()
