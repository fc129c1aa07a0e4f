"""Frozen records as JSON, and back: exact, and without running anything it says.

A record is an object with its type under ``record``; a tuple is a list; a number that
JSON does not have is ``{"number": "inf"}``.
"""

import dataclasses
import enum
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from drakesep.analysis.analysis_case import (
    AnalysisCase,
    ClearancePairs,
    PrintedResult,
    PublishedCase,
)
from drakesep.analysis.bounds.branch_and_bound import Proof
from drakesep.analysis.bounds.quantities import Quantity, Signal, Term
from drakesep.analysis.campaigns.answers import (
    CampaignAnswer,
    LaunchRequirement,
    Tally,
)
from drakesep.analysis.campaigns.sensitivity import RankCorrelations, SobolIndices
from drakesep.analysis.campaigns.statistics import Histogram, Summary
from drakesep.analysis.campaigns.subset_simulation import RareProbability
from drakesep.analysis.clearance.contact import Contact
from drakesep.analysis.clearance.of_pair import Clearance
from drakesep.analysis.failure_cases import FailureCase
from drakesep.analysis.margins.tolerance_margins import Growth, Limit
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.analysis.search.effort import SearchSettings
from drakesep.analysis.search.problem import Candidate, Searched
from drakesep.analysis.search.sqp import (
    Ascent,
    AscentSettings,
    Iteration,
    SearchStatus,
)
from drakesep.analysis.tolerances.correlations import RankCorrelation
from drakesep.analysis.tolerances.distributions import (
    Discrete,
    Lognormal,
    Normal,
    Table,
    Triangular,
    TruncatedNormal,
    Uniform,
)
from drakesep.analysis.tolerances.ellipsoid import Ellipsoid
from drakesep.analysis.tolerances.sides import Sides
from drakesep.systems.checks import InputError, unknown
from drakesep.systems.equations.springs import PUSHERS
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.loads import Load
from drakesep.systems.model.orbit import Orbit
from drakesep.systems.model.parts import Box, Capsule, Cone, Mesh, Part, Sphere
from drakesep.systems.model.recontact import Recontact
from drakesep.systems.model.run import ContactForces, RunStatus
from drakesep.systems.model.separation import (
    Attachment,
    Body,
    InitialMotion,
    Pair,
    Separation,
)
from drakesep.tables.roles import (
    Changed,
    Ending,
    Nominal,
    Outcome,
    Published,
    SearchEnd,
    Worst,
)


_RECORDS: tuple[type[Any], ...] = (
    *(AnalysisCase, ClearancePairs, PrintedResult, PublishedCase, Requirement),
    FailureCase,
    *(Sides, Ellipsoid, RankCorrelation, Integration, Joint, Load),
    *(Uniform, Normal, TruncatedNormal, Triangular, Lognormal, Table, Discrete),
    *(Part, Box, Capsule, Cone, Mesh, Sphere),
    *(Recontact, Attachment, Body, InitialMotion, Orbit, Pair, Separation),
    *(Changed, Nominal, Outcome, Published, SearchEnd, Worst),
    *(Clearance, Contact, ContactForces),
    *(Searched, Candidate, Ascent, Iteration, AscentSettings, SearchSettings),
    *(Growth, Limit),
    *(Proof, Quantity, Term, Signal),
    *(CampaignAnswer, LaunchRequirement, Tally, Histogram, Summary),
    *(RankCorrelations, SobolIndices, RareProbability),
)
_ENUMS: tuple[type[enum.Enum], ...] = (Ending, RunStatus, SearchStatus)
NO_RECORD = (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError)
"""What comes of reading a file that somebody has changed: JSON may hold anything."""


def to_json(value: Any) -> Any:
    """Return a record, or what it is made of, as JSON has it."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = [f.name for f in dataclasses.fields(value) if f.init]
        return {
            "record": type(value).__name__,
            **{name: to_json(getattr(value, name)) for name in fields},
        }
    match value:
        case enum.Enum():
            return {"member": [type(value).__name__, value.name]}
        case np.ndarray():
            return {"array": value.tolist()}
        case Path():
            return str(value)
        case Mapping():
            return {str(key): to_json(entry) for key, entry in value.items()}
        case list() | tuple():
            return [to_json(entry) for entry in value]
        case float() if not math.isfinite(value):
            return {"number": str(value)}
        case None | bool() | int() | float() | str():
            return value
    raise InputError(f"a record to be written must hold data, got {value!r}")


def from_json(value: Any) -> Any:
    """Return what `to_json` has written.

    Raises:
        ValueError: it names a record that is not known, or one that is not valid.
    """
    match value:
        case list():
            return tuple(from_json(entry) for entry in value)
        case {"record": name, **fields}:
            return _record(name, {str(k): from_json(v) for k, v in fields.items()})
        case {"member": [name, member]}:
            return _known(name, _ENUMS)[member]
        case {"array": rows}:
            return np.array(rows, dtype=float)
        case {"number": text}:
            return float(text)
        case dict():
            return {str(key): from_json(entry) for key, entry in value.items()}
    return value


def _record(name: str, fields: dict[str, Any]) -> Any:
    pushers = dict.fromkeys(kind.record for kind in PUSHERS.values())
    record = _known(name, (*_RECORDS, *pushers))
    if record is Mesh:
        fields["file"] = Path(fields["file"])
    try:
        return record(**fields)
    except TypeError as error:
        raise InputError(f"{name}: must have its fields, got: {error}") from error


def _known(name: Any, types: tuple[type[Any], ...]) -> Any:
    by_name = {each.__name__: each for each in types}
    if name not in by_name:
        raise InputError(unknown("record", name, by_name))
    return by_name[name]
