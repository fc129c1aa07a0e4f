"""Tables of failure cases: what came of each, side by side with the design."""

import math
from collections.abc import Hashable, Mapping
from typing import Any

import pandas as pd

from drakesep.analysis.metrics.metric import is_strict
from drakesep.analysis.metrics.requirements import Verdict
from drakesep.tables.columns import in_units
from drakesep.tables.labelled_run import LabelledRun


CASE = "failure_case"
HELD = "does not separate"
"""The verdict where a body stays that leaves in the design."""


def outcome_row(
    name: str,
    changed: Mapping[str, float],
    nominal: LabelledRun,
    requirements: pd.DataFrame,
    verdict: str | None,
) -> dict[str, object]:
    """Return what came of the design or of a failure case, in a row.

    Args:
        name: of it.
        changed: parameters that have failed, in SI.
        nominal: its run.
        requirements: as `requirements_table` has them.
        verdict: on all of them; None: there is none.
    """
    not_met = requirements[requirements["verdict"] == Verdict.NOT_MET.value]
    margins, strict = requirements["margin"], requirements["sense"].map(is_strict)
    beyond = (margins < 0.0) | (strict & (margins <= 0.0))
    force, torque = nominal.largest_loads
    return {
        CASE: name,
        "changed": changed_text(changed),
        "verdict": verdict or "failed",
        "not_met": len(not_met),
        "beyond": int(beyond.sum()),
        "requirements": len(requirements),
        **_nearest(requirements),
        "joint_force_N": force,
        "joint_torque_N_m": torque,
    }


def changed_text(values: Mapping[str, float]) -> str:
    """Return which parameters have failed, and what they are now.

    Args:
        values: in SI, by name.
    """
    return ", ".join(
        f"{key} {'never' if math.isinf(value) else f'{value:.10g}'}"
        for key, value in in_units(values).items()
    )


def _nearest(requirements: pd.DataFrame) -> dict[str, object]:
    """Return the requirement of the least margin, as a share of its limit."""
    columns = ("requirement", "axis", "pair", "limit", "worst", "unit")
    told = requirements[requirements["margin"].notna()]
    if told.empty:
        return {f"nearest_{name}": "" for name in ("requirement", "axis", "pair")} | {
            "nearest_limit": math.nan,
            "nearest_worst": math.nan,
            "nearest_unit": "",
        }
    rows = told.to_dict("records")
    nearest = min(rows, key=margin_share)
    return {f"nearest_{name}": nearest[name] for name in columns}


def margin_share(row: Mapping[Hashable, Any]) -> float:
    """Return a margin as a share of its limit; of one of zero, of the values.

    Args:
        row: of `requirements_table`.
    """
    size = abs(row["limit"]) or abs(row["nominal"]) or abs(row["worst"]) or 1.0
    return float(row["margin"] / size)


def under_each_other(frames: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Return tables of the design and of failure cases as one.

    Args:
        frames: by the names of the cases, which become the first column.
    """
    named = [frame.assign(**{CASE: name}) for name, frame in frames.items()]
    whole = pd.concat(named, ignore_index=True)
    return whole[[CASE, *(column for column in whole if column != CASE)]]
