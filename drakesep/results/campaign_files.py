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
from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.files import write_text, written
from drakesep.results import provenance
from drakesep.results.case_json import NO_RECORD, from_json, to_json
from drakesep.results.parts import parts_folder
from drakesep.results.recorded_case import as_recorded, with_meshes_in
from drakesep.systems.checks import InputError


PLAN, DRAWS = "plan.json", "campaign_runs.npz"
_FORMAT = 1
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
            "chunk": plan.chunk,
            "chunks": plan.chunks,
            "tolerance": plan.tolerance,
            "versions": provenance.versions(),
            "commit": provenance.commit(),
            "case": to_json(as_recorded(plan.case)),
        }
        return cls(plan=plan, text=json.dumps(data, indent=1) + "\n")

    @classmethod
    def parsed(cls, text: str, folder: Path, source: str = PLAN) -> "RecordedPlan":
        """Return the plan that a text says.

        Args:
            text: of its file.
            folder: that has the meshes of its case.
            source: what errors name.

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
                chunk=data["chunk"],
                tolerance=data["tolerance"],
            )
            was = {**data["versions"], "commit": data["commit"]}
        except NO_RECORD as error:
            raise InputError(f"{source}: must be a campaign's, got: {error}") from error
        _check_versions(source, was)
        return cls(plan=plan, text=text)

    def write(self, folder: Path) -> None:
        """Write it into the folder of a campaign."""
        write_text(folder / PLAN, self.text)

    @classmethod
    def read(cls, folder: Path) -> "RecordedPlan":
        """Return the plan of a campaign's folder.

        Raises:
            ValueError: there is none, or it was made with other versions.
        """
        file = folder / PLAN
        try:
            text = file.read_text(encoding="utf-8")
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            raise InputError(
                f"{file}: must be the plan of a campaign, got: {reason}"
            ) from None
        return cls.parsed(text, folder, str(file))


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
    folder: Path, recorded: RecordedPlan, number: int, flown: FlownDraws
) -> None:
    """Write a chunk, whole or not at all, down to the disk."""
    file = chunk_file(folder, number)
    file.parent.mkdir(exist_ok=True)
    _write(file, recorded, _arrays(flown))


def read_chunk(folder: Path, recorded: RecordedPlan, number: int) -> FlownDraws | None:
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
    flown = _flown(arrays)
    return flown if (flown.first, len(flown)) == (indices[0], len(indices)) else None


def missing_chunks(folder: Path, recorded: RecordedPlan) -> list[int]:
    """Return the numbers of chunks that are not there, or damaged.

    Raises:
        ValueError: one is of another plan.
    """
    numbers = range(recorded.plan.chunks)
    return [n for n in numbers if read_chunk(folder, recorded, n) is None]


def merged(folder: Path, recorded: RecordedPlan) -> FlownDraws:
    """Return all draws of a campaign, in their order, from its chunks.

    Raises:
        ValueError: a chunk is of another plan.
        RuntimeError: chunks are not there, or damaged; it says which.
    """
    plan = recorded.plan
    metrics = np.empty((plan.runs, len(plan.metrics)))
    failure = np.empty(plan.runs, np.int16)
    attempts = np.empty(plan.runs, np.int32)
    reasons: dict[int, str] = {}
    missing = []
    for number in range(plan.chunks):
        flown = read_chunk(folder, recorded, number)
        if flown is None:
            missing.append(number)
            continue
        mine = slice(flown.first, flown.first + len(flown))
        metrics[mine], failure[mine] = flown.metrics, flown.failure
        attempts[mine] = flown.attempts
        reasons |= flown.reasons
    if missing:
        raise RuntimeError(
            f"{folder}: of {plan.chunks} chunks {len(missing)} are not there, or "
            f"damaged: {_listed(missing)}; fly them with `drakesep campaign run-chunk`"
        )
    return FlownDraws(
        first=0, metrics=metrics, failure=failure, attempts=attempts, reasons=reasons
    )


def _listed(numbers: Sequence[int], most: int = 20) -> str:
    text = ", ".join(map(str, numbers[:most]))
    return f"{text}, ..." if len(numbers) > most else text


def write_draws(folder: Path, recorded: RecordedPlan, flown: FlownDraws) -> None:
    """Write all draws of a campaign."""
    _write(folder / DRAWS, recorded, _arrays(flown))


def read_draws(folder: Path, recorded: RecordedPlan) -> FlownDraws:
    """Return all draws of a campaign.

    Raises:
        ValueError: they are not there, damaged, or of another plan.
    """
    file = folder / DRAWS
    arrays = _read(file, recorded)
    if arrays is None:
        raise InputError(f"{file}: must be the draws of a campaign, got none, or less")
    return _flown(arrays)


def _arrays(flown: FlownDraws) -> dict[str, Any]:
    reasons = "\n".join(why.replace("\n", " ") for why in flown.reasons.values())
    return {
        "first": np.array(flown.first, np.int64),
        "metrics": flown.metrics,
        "failure_case": flown.failure,
        "attempts": flown.attempts,
        "failed": np.array([*flown.reasons], np.int64),
        "reasons": np.frombuffer(reasons.encode(), np.uint8),
    }


def _flown(arrays: Mapping[str, Any]) -> FlownDraws:
    reasons = arrays["reasons"].tobytes().decode().split("\n")
    failed = arrays["failed"].tolist()
    return FlownDraws(
        first=int(arrays["first"]),
        metrics=arrays["metrics"],
        failure=arrays["failure_case"],
        attempts=arrays["attempts"],
        reasons=dict(zip(failed, reasons, strict=True)) if failed else {},
    )


def _write(file: Path, recorded: RecordedPlan, arrays: Mapping[str, Any]) -> None:
    names = np.array(recorded.plan.metrics, dtype=np.str_)
    held = {"metric_names": names, **arrays}
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
