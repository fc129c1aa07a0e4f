"""A run as CCSDS messages, one for each body."""

import itertools
import os
import textwrap
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from drakesep.exchange.aem import aem_text
from drakesep.exchange.epochs import PLACES
from drakesep.exchange.histories import AttitudeHistory, Ephemeris
from drakesep.exchange.oem import check_inertial, oem_text
from drakesep.files import write_text
from drakesep.reports.body_states import BodyStates
from drakesep.reports.handed_run import HandedRun, given_words
from drakesep.version import __version__


_BODY_FRAME = "SC_BODY_1"
_ORIGINATOR = "DRAKESEP"
_COMMENT = 76
"""Letters of a line of comment."""


def save_oem(handed: HandedRun, folder: Path) -> list[Path]:
    """Write the orbit of every body, and return the files."""
    return [
        _save(handed, body, folder, "oem", _oem_text(handed, body))
        for body in handed.bodies
    ]


def save_aem(handed: HandedRun, folder: Path) -> list[Path]:
    """Write attitude and rate of every body, and return the files."""
    return [
        _save(handed, body, folder, "aem", _aem_text(handed, body))
        for body in handed.bodies
    ]


def _save(handed: HandedRun, body: str, folder: Path, ending: str, text: str) -> Path:
    file = folder / f"{handed.label}_{body}.{ending}"
    write_text(file, text)
    return file


def _oem_text(handed: HandedRun, body: str) -> str:
    states, common, kept = _common(handed, body)
    comments = [
        *_comments(handed, body),
        "Position and velocity are those of the centre of mass of this body alone.",
        "Lines are near each other where forces change.",
    ]
    ephemeris = Ephemeris(
        position=states.position[kept], velocity=states.velocity[kept], **common
    )
    return oem_text(ephemeris, comments, _created(), _ORIGINATOR)


def _aem_text(handed: HandedRun, body: str) -> str:
    states, common, kept = _common(handed, body)
    comments = [
        *_comments(handed, body),
        f"{_BODY_FRAME} is the frame of this body in its case.",
        "Q1 Q2 Q3 QC, the scalar last, is the rotation that takes the axes of",
        "REF_FRAME_A into those of REF_FRAME_B: it takes components in B into",
        "components in A. ANGVEL is that of B in A, in the axes of B, in deg/s.",
    ]
    attitudes = AttitudeHistory(
        body_frame=_BODY_FRAME,
        orientation=states.orientation[kept],
        rate=states.rate[kept],
        **common,
    )
    return aem_text(attitudes, comments, _created(), _ORIGINATOR)


def _common(
    handed: HandedRun, body: str
) -> tuple[BodyStates, Mapping[str, Any], np.ndarray]:
    """Return the states, what both messages say, and the samples that they have."""
    inertial = handed.inertial
    assert inertial is not None
    check_inertial("frame", "it", inertial.name)
    states = handed.in_frame(body)
    epochs = [inertial.epoch_at(t).quantize(PLACES) for t in states.time]
    # No epoch may stand twice.
    kept = np.flatnonzero([True, *(b > a for a, b in itertools.pairwise(epochs))])
    common = {
        "object_name": body.upper(),
        "frame": inertial.name.upper(),
        "time_system": inertial.time_system,
        "epochs": [epochs[i] for i in kept],
    }
    return states, common, kept


def _comments(handed: HandedRun, body: str) -> list[str]:
    told = [
        f"Case {handed.case}, run {handed.label}, body {body}",
        f"by drakesep {__version__}.",
    ]
    if handed.inertial is not None and handed.inertial.given:
        words = f"Not of the case, but given: {given_words(handed.inertial.given)}."
        told += textwrap.wrap(words, _COMMENT)
    return told


def _created() -> str:
    """Return when a file is made, in UTC; SOURCE_DATE_EPOCH stands for it."""
    source = os.environ.get("SOURCE_DATE_EPOCH")
    made = datetime.now(UTC)
    if source is not None:
        made = datetime.fromtimestamp(int(source), UTC)
    return f"{made:%Y-%m-%dT%H:%M:%S}"
