"""What is kept of draws without rows as arrays, exact, and back."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drakesep.analysis.campaigns.answers import Tally
from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.analysis.campaigns.statistics import Histogram, Summary
from drakesep.analysis.campaigns.tallies import TalliedDraws


def lines_as_array(lines: Sequence[str]) -> NDArray[np.uint8]:
    """Return lines of text as bytes."""
    text = "".join(f"{line}\n" for line in lines)
    return np.frombuffer(text.encode(), np.uint8)


def array_as_lines(array: NDArray[np.uint8]) -> list[str]:
    """Return the lines that bytes are."""
    return array.tobytes().decode().split("\n")[:-1]


def tallies_as_arrays(draws: TalliedDraws) -> dict[str, Any]:
    """Return what is kept of draws as arrays, by names; without what failed."""
    tallies = (*draws.tallies, *draws.alone)
    known = [one for one in tallies if one is not None]
    judged = [one is not None for one in tallies]
    return {
        "draws": np.array(draws.runs, np.int64),
        "runs_failed": np.array(draws.failed, np.int64),
        "drawn_again": np.array(draws.again, np.int64),
        "untold": np.array([one.untold for one in draws.summaries], np.int64),
        # Whole numbers of any length, as text.
        "sums": lines_as_array([str(one.total) for one in draws.summaries]),
        "sums_of_squares": lines_as_array(
            [str(one.squares) for one in draws.summaries]
        ),
        "least": np.array([one.least for one in draws.summaries]),
        "greatest": np.array([one.greatest for one in draws.summaries]),
        "edges": np.array([one.histogram.edges for one in draws.summaries]),
        "counts": np.array([one.histogram.counts for one in draws.summaries], np.int64),
        "judged": np.array(judged),
        "beyond": np.array([one.beyond for one in known], np.int64),
        "do_not_tell": np.array([one.untold for one in known], np.int64),
        "kept": np.array([len(one.worst_draws) for one in known], np.int64),
        "worst_margins": _joined([one.worst_margins for one in known], np.float64),
        "worst_draws": _joined([one.worst_draws for one in known], np.int64),
    }


def _joined(parts: Sequence[Sequence[float]], kind: type) -> NDArray[Any]:
    return np.concatenate([np.empty(0, kind), *(np.array(p, kind) for p in parts)])


def tallies_of_arrays(
    first: int,
    reasons: Mapping[int, str],
    arrays: Mapping[str, Any],
    plan: CampaignPlan,
) -> TalliedDraws:
    """Return what is kept of draws, as `tallies_as_arrays` has it.

    Args:
        first: number of the first draw.
        reasons: why the first of those failed that did.
        arrays: by their names.
        plan: of the campaign.
    """
    runs = int(arrays["draws"])
    totals = map(int, array_as_lines(arrays["sums"]))
    squares = map(int, array_as_lines(arrays["sums_of_squares"]))
    tallies = _tallies(runs, arrays)
    count = len(plan.case.requirements)
    return TalliedDraws(
        first=first,
        runs=runs,
        summaries=tuple(
            Summary(
                draws=runs,
                untold=int(arrays["untold"][k]),
                total=total,
                squares=of_squares,
                least=float(arrays["least"][k]),
                greatest=float(arrays["greatest"][k]),
                histogram=Histogram(
                    edges=tuple(arrays["edges"][k].tolist()),
                    counts=tuple(arrays["counts"][k].tolist()),
                ),
            )
            for k, (total, of_squares) in enumerate(zip(totals, squares, strict=True))
        ),
        tallies=tallies[:count],
        alone=tallies[count:],
        failed=int(arrays["runs_failed"]),
        again=int(arrays["drawn_again"]),
        reasons=reasons,
    )


def _tallies(runs: int, arrays: Mapping[str, Any]) -> tuple[Tally | None, ...]:
    ends = np.cumsum(arrays["kept"])[:-1]
    margins = np.split(arrays["worst_margins"], ends)
    draws = np.split(arrays["worst_draws"], ends)
    known = iter(
        Tally(
            runs=runs,
            beyond=int(arrays["beyond"][k]),
            untold=int(arrays["do_not_tell"][k]),
            worst_margins=tuple(margins[k].tolist()),
            worst_draws=tuple(draws[k].tolist()),
        )
        for k in range(len(arrays["kept"]))
    )
    return tuple(next(known) if one else None for one in arrays["judged"].tolist())
