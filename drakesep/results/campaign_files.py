"""Files of a campaign: its plan, chunks that anyone may fly, and all draws together.

A chunk is written aside, synced and renamed: it is whole or not there, and to fly it
twice changes nothing. It bears the hash of its plan and that of what it holds. All are
``.npz``, which `numpy.load` reads, and the same to the last byte for the same content.
"""

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.campaigns.flights import FlownDraws
from drakesep.analysis.campaigns.gathering import Gathered, KeptDraws
from drakesep.analysis.campaigns.plan import ROWS, CampaignPlan
from drakesep.analysis.campaigns.screens import DrawnClearances
from drakesep.analysis.engines.registered import Registered
from drakesep.files import write_text, written
from drakesep.results import provenance
from drakesep.results.campaign_arrays import (
    array_as_lines,
    lines_as_array,
    tallies_as_arrays,
    tallies_of_arrays,
)
from drakesep.results.case_json import NO_RECORD, from_json, to_json
from drakesep.results.parts import parts_folder
from drakesep.results.recorded_case import as_recorded, with_meshes_in
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError


PLAN = "plan.json"
DRAWS, TALLIES = "campaign_runs.npz", "campaign_tallies.npz"
_FORMAT = 2
"""Of the plan and the chunks: another number means other keys."""


@dataclass(frozen=True, kw_only=True)
class RecordedPlan:
    """A plan as its file has it, by which chunks are known."""

    plan: CampaignPlan
    text: str
    """Of the file."""

    @property
    def sha256(self) -> str:
        """The hash of the text."""
        return provenance.sha256(self.text)

    @classmethod
    def of(cls, plan: CampaignPlan) -> "RecordedPlan":
        """Return a plan as it is written, with the versions of now."""
        data = {
            "format": _FORMAT,
            "runs": plan.runs,
            "seed": plan.seed,
            "metrics": list(plan.metrics),
            "clearances": list(plan.clearances),
            "chunk": plan.chunk,
            "chunks": plan.chunks,
            "keep": plan.keep,
            "spans": [list(span) for span in plan.spans],
            "tolerance": plan.tolerance,
            "registered": _definitions(plan),
            "versions": provenance.versions(),
            "commit": provenance.commit(),
            "case": to_json(as_recorded(plan.case)),
        }
        return cls(plan=plan, text=json.dumps(data, indent=1) + "\n")

    @classmethod
    def parsed(
        cls, text: str, folder: Path, source: str = PLAN, *, to_fly: bool = True
    ) -> "RecordedPlan":
        """Return the plan that a text says.

        Args:
            text: of its file.
            folder: that has the meshes of its case.
            source: what errors name.
            to_fly: whether its draws will be flown: by these versions, then.

        Raises:
            ValueError: it is none, or of other versions than these.
        """
        try:
            data = json.loads(text)
            if data["format"] != _FORMAT:
                raise InputError(f"format must be {_FORMAT}, got {data['format']}")
            case = from_json(data["case"])
            if not isinstance(case, AnalysisCase):
                raise InputError("case must be one")
            plan = CampaignPlan(
                case=with_meshes_in(case, folder),
                runs=data["runs"],
                seed=data["seed"],
                metrics=tuple(data["metrics"]),
                clearances=tuple(data["clearances"]),
                chunk=data["chunk"],
                tolerance=data["tolerance"],
                keep=data["keep"],
                spans=tuple((least, greatest) for least, greatest in data["spans"]),
            )
            was = {**data["versions"], "commit": data["commit"]}
        except NO_RECORD as error:
            raise InputError(f"{source}: must be a campaign's, got: {error}") from error
        if to_fly:
            _check_versions(source, was)
        return cls(plan=plan, text=text)

    def write(self, folder: Path) -> None:
        """Write it into the folder of a campaign."""
        write_text(folder / PLAN, self.text)

    @classmethod
    def read(cls, folder: Path, *, to_fly: bool = True) -> "RecordedPlan":
        """Return the plan of a campaign's folder.

        Args:
            folder: of the campaign.
            to_fly: whether its draws will be flown, and not only looked at.

        Raises:
            ValueError: there is none, it was made with other versions, or what was
                registered then is not now, or is something else.
        """
        file = folder / PLAN
        try:
            text = file.read_text(encoding="utf-8")
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            raise InputError(
                f"{file}: must be the plan of a campaign, got: {reason}"
            ) from None
        _check_names(str(file), text)
        recorded = cls.parsed(text, folder, str(file), to_fly=to_fly)
        for name, was in json.loads(text)["registered"].items() if to_fly else ():
            if _definitions(recorded.plan).get(name) != was:
                raise InputError(
                    f"{file}: must be flown where {name!r} is registered as it was "
                    "when it was planned, got another of this name"
                )
        return recorded


def _definitions(plan: CampaignPlan) -> dict[str, str]:
    """Return how what a plan uses is defined that is not drakesep's own."""
    required = [one.metric for one in plan.case.requirements]
    return Registered.here().definitions(
        [*plan.metrics, *required], plan.case.separation
    )


def _check_names(source: str, text: str) -> None:
    """Raise InputError unless all names of a plan that are not ours are registered."""
    try:
        names = [*json.loads(text).get("registered", ())]
    except NO_RECORD as error:
        raise InputError(f"{source}: must be a campaign's, got: {error}") from error
    here = Registered.here()
    known = {*here.pushers, *(metric.stem for metric in here.metrics)}
    if missing := [name for name in names if name not in known]:
        raise InputError(
            f"{source}: must be flown where {', '.join(missing)} are registered, as "
            "where it was planned"
        )


def _check_versions(source: str, was: Mapping[str, Any]) -> None:
    """Raise InputError unless a plan is flown by what it was made with."""
    now = {**provenance.versions(), "commit": provenance.commit()}
    for name in {**was, **now}:
        if was.get(name) != now.get(name):
            raise InputError(
                f"{source}: must be flown with {name} = {was.get(name)}, got "
                f"{now.get(name)}"
            )


def chunk_file(folder: Path, number: int) -> Path:
    """Return the file of a chunk in the folder of a campaign."""
    return parts_folder(folder) / f"chunk_{number:06d}.npz"


def write_chunk(
    folder: Path, recorded: RecordedPlan, number: int, flown: KeptDraws
) -> None:
    """Write a chunk, whole or not at all, down to the disk."""
    file = chunk_file(folder, number)
    file.parent.mkdir(exist_ok=True)
    _write(file, recorded, _arrays(flown))


def read_chunk(folder: Path, recorded: RecordedPlan, number: int) -> KeptDraws | None:
    """Return a chunk; None if it is not there, or damaged.

    Args:
        folder: of the campaign.
        recorded: its plan.
        number: of the chunk.

    Raises:
        ValueError: it is of another plan.
    """
    file = chunk_file(folder, number)
    arrays = _read(file, recorded)
    if arrays is None:
        return None
    indices = recorded.plan.indices(number)
    flown = _kept(arrays, recorded.plan)
    return flown if (flown.first, len(flown)) == (indices[0], len(indices)) else None


def gathered(folder: Path, recorded: RecordedPlan) -> Gathered:
    """Return the chunks of a campaign that are there, put together.

    One that is damaged is missing.

    Raises:
        ValueError: a chunk is of another plan.
    """
    chunks = Gathered(recorded.plan)
    for number in range(recorded.plan.chunks):
        if (flown := read_chunk(folder, recorded, number)) is not None:
            chunks.add(number, flown)
    return chunks


def merged(folder: Path, recorded: RecordedPlan) -> KeptDraws:
    """Return what is kept of all draws of a campaign, from its chunks.

    Raises:
        ValueError: a chunk is of another plan.
        RuntimeError: chunks are not there, or damaged; it says which.
    """
    chunks = gathered(folder, recorded)
    if chunks.missing:
        raise RuntimeError(
            f"{folder}: of {recorded.plan.chunks} chunks {len(chunks.missing)} are not "
            f"there, or damaged: {_listed(chunks.missing)}; fly them with `drakesep "
            "campaign run-chunk`"
        )
    return chunks.whole()


def _listed(numbers: Sequence[int], most: int = 20) -> str:
    text = ", ".join(map(str, numbers[:most]))
    return f"{text}, ..." if len(numbers) > most else text


def write_draws(folder: Path, recorded: RecordedPlan, flown: KeptDraws) -> None:
    """Write what is kept of all draws of a campaign."""
    _write(_file_of_all(folder, recorded.plan), recorded, _arrays(flown))


def read_draws(folder: Path, recorded: RecordedPlan) -> KeptDraws:
    """Return what is kept of all draws of a campaign.

    Raises:
        ValueError: they are not there, damaged, or of another plan.
    """
    file = _file_of_all(folder, recorded.plan)
    arrays = _read(file, recorded)
    if arrays is None:
        raise InputError(f"{file}: must be the draws of a campaign, got none, or less")
    return _kept(arrays, recorded.plan)


def _file_of_all(folder: Path, plan: CampaignPlan) -> Path:
    return folder / (DRAWS if plan.keep == ROWS else TALLIES)


def measured_file(folder: Path, clearance: int, number: int) -> Path:
    """Return the file of some draws whose clearance was measured.

    Args:
        folder: of the campaign.
        clearance: its place in the plan.
        number: which some draws they are, from 0.
    """
    return parts_folder(folder) / f"clearance_{clearance}_{number:06d}.npz"


def write_measured(
    file: Path, recorded: RecordedPlan, draws: Sequence[int], values: Array
) -> None:
    """Write what was measured of some draws (n,), m, whole or not at all."""
    file.parent.mkdir(exist_ok=True)
    _write(file, recorded, {"draws": np.array(draws, np.int64), "measured": values})


def read_measured(
    file: Path, recorded: RecordedPlan, draws: Sequence[int]
) -> Array | None:
    """Return what was measured of these draws (n,), m; None if it is not there.

    Raises:
        ValueError: it is of another plan.
    """
    held = _read(file, recorded)
    if held is None or not np.array_equal(held["draws"], draws):
        return None
    values: Array = held["measured"]
    return values


def _arrays(flown: KeptDraws) -> dict[str, Any]:
    reasons = [why.replace("\n", " ") for why in flown.reasons.values()]
    clearances: dict[str, Any] = {}
    if isinstance(flown, FlownDraws) and flown.clearances is not None:
        clearances["clearance_at_least"] = flown.clearances.at_least
        clearances["clearance_measured"] = flown.clearances.measured
    return {
        **clearances,
        "first": np.array(flown.first, np.int64),
        **(
            {
                "metrics": flown.metrics,
                "failure_case": flown.failure,
                "attempts": flown.attempts,
            }
            if isinstance(flown, FlownDraws)
            else tallies_as_arrays(flown)
        ),
        "failed": np.array([*flown.reasons], np.int64),
        "reasons": lines_as_array(reasons),
    }


def _kept(arrays: Mapping[str, Any], plan: CampaignPlan) -> KeptDraws:
    failed, reasons = arrays["failed"].tolist(), array_as_lines(arrays["reasons"])
    first, whys = int(arrays["first"]), dict(zip(failed, reasons, strict=True))
    if plan.keep != ROWS:
        return tallies_of_arrays(first, whys, arrays, plan)
    clearances = None
    if "clearance_at_least" in arrays:
        clearances = DrawnClearances(
            at_least=arrays["clearance_at_least"],
            measured=arrays["clearance_measured"],
        )
    return FlownDraws(
        first=first,
        metrics=arrays["metrics"],
        failure=arrays["failure_case"],
        attempts=arrays["attempts"],
        reasons=whys,
        clearances=clearances,
    )


def _write(file: Path, recorded: RecordedPlan, arrays: Mapping[str, Any]) -> None:
    names = np.array(recorded.plan.metrics, dtype=np.str_)
    held = {"metric_names": names, **arrays}
    if recorded.plan.clearances:
        held["clearance_names"] = np.array(recorded.plan.clearances, dtype=np.str_)
    with written(file, synced=True) as beside:
        # Members bear no time of writing: numpy leaves out what zip files may say.
        np.savez(
            beside,
            plan=np.array(recorded.sha256),
            sha256=np.array(_digest(held.items())),
            **held,
        )


def _read(file: Path, recorded: RecordedPlan) -> dict[str, Any] | None:
    """Return the arrays of a file; None if it is not there, or damaged.

    Raises:
        ValueError: it is of another plan.
    """
    try:
        with file.open("rb") as stream, np.load(stream) as members:
            held = {name: members[name] for name in members.files}
        plan, digest = str(held.pop("plan")), str(held.pop("sha256"))
    except Exception:  # a damaged archive raises anything
        return None
    if plan != recorded.sha256:
        raise InputError(f"{file}: must be of the plan beside it, got one of another")
    return held if _digest(held.items()) == digest else None


def _digest(arrays: Iterable[tuple[str, Any]]) -> str:
    """Return the SHA-256 of arrays: of their names, types, shapes and bytes."""
    total = hashlib.sha256()
    for name, array in arrays:
        total.update(f"{name} {array.dtype.str} {array.shape}\n".encode())
        total.update(np.ascontiguousarray(array).data)
    return total.hexdigest()
