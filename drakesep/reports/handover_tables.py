"""Tables of what is handed over: states after separation, and their statistics."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from drakesep.exchange.epochs import epoch_text
from drakesep.exchange.taken import ORIENTATION, POSITION, RATE, VELOCITY
from drakesep.reports.body_states import BodyStates, in_inertial_frame, states_in_W
from drakesep.reports.frames import InertialFrame
from drakesep.results.campaign_files import DRAWS
from drakesep.systems.checks import InputError
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.run import Run
from drakesep.systems.model.separation import Separation
from drakesep.tables.columns import in_units
from drakesep.tables.labelled_run import LabelledRun
from drakesep.tables.roles import role_in_tables
from drakesep.units import unit_of, with_unit


STATE = (*POSITION, *VELOCITY, *ORIENTATION)
"""Columns of a body's state, in W or about the Earth."""


def handover_table(
    runs: Sequence[LabelledRun], nominal: Separation, frame: InertialFrame | None
) -> pd.DataFrame:
    """Return a row for each run and body: its state after separation.

    That is the first sample at which every body is free and pushed by no spring, or the
    last of the run if one is not; in a worst case it is the worst state, and the
    parameters that it changes are its vector.

    Args:
        runs: completed.
        nominal: the separation that they vary.
        frame: inertial, to which the states are handed over; None: W alone.
    """
    before = parameters(nominal)
    varied = {
        name: None
        for one in runs
        for name, x in parameters(one.run.separation).items()
        if x != before.get(name)
    }
    rows = []
    for one in runs:
        sample = _after_separation(one.run)
        now = parameters(one.run.separation)
        values = in_units({name: now.get(name, math.inf) for name in varied})
        for body in one.run.separation.bodies:
            state = states_in_W(one.run, body.name)
            rows.append(
                {
                    "label": one.label,
                    "role": role_in_tables(one.role),
                    "body": body.name,
                    "mass_kg": body.mass,
                    "time_s": state.time[sample],
                    **_columns(state, sample, "in_W_"),
                    **(_inertial(state, sample, frame) if frame else {}),
                    **dict(zip(RATE, state.rate[sample], strict=True)),
                    **values,
                }
            )
    return pd.DataFrame(rows)


def _after_separation(run: Run) -> int:
    """Return the first sample at which every body that leaves is free."""
    time = run.completed_trajectory.time
    end = max(run.end_of(pair.B) for pair in run.separation.pairs)
    return min(int(np.searchsorted(time, end)), len(time) - 1)


def _columns(state: BodyStates, sample: int, prefix: str) -> dict[str, float]:
    parts = (state.position, state.velocity, state.orientation)
    numbers = np.concatenate([part[sample] for part in parts]).tolist()
    return {f"{prefix}{name}": x for name, x in zip(STATE, numbers, strict=True)}


def _inertial(state: BodyStates, sample: int, frame: InertialFrame) -> dict[str, Any]:
    inertial = in_inertial_frame(state, frame.orbit)
    return {
        "epoch": epoch_text(frame.epoch_at(state.time[sample])),
        "time_system": frame.time_system,
        "frame": frame.name,
        **_columns(inertial, sample, ""),
    }


def statistics_table(folder: Path) -> pd.DataFrame:
    """Return a row for each metric that a campaign keeps: its mean and covariances.

    Of the draws that tell all of them.

    Args:
        folder: of the campaign.

    Raises:
        ValueError: its draws cannot be read, or fewer than two tell all metrics.
    """
    file = folder / DRAWS
    try:
        with np.load(file) as held:
            names = [str(name) for name in held["metric_names"]]
            metrics = np.asarray(held["metrics"], dtype=float)
    except Exception as error:  # a damaged archive raises anything
        raise InputError(
            f"{file}: must be the draws of a campaign, got: {error}"
        ) from error
    told = metrics[np.isfinite(metrics).all(axis=1)]
    if len(told) < 2:
        raise InputError(f"{file}: must have two draws that tell all metrics, got less")
    scaled = told * [unit_of(name).per_si for name in names]
    covariance = np.atleast_2d(np.cov(scaled, rowvar=False))
    columns = [with_unit(name) for name in names]
    return pd.DataFrame(
        {
            "metric": columns,
            "draws": len(told),
            "left_out": len(metrics) - len(told),
            "mean": scaled.mean(axis=0),
            **{f"covariance_with_{c}": covariance[:, i] for i, c in enumerate(columns)},
        }
    )
