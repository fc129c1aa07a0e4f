"""Messages in keyword-value notation (KVN), of CCSDS 502.0-B and 504.0-B."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from pathlib import Path

from drakesep.exchange.epochs import check_time_system, epoch_text
from drakesep.files import check_readable
from drakesep.systems.checks import InputError


_LONGEST = 100_000_000
"""Bytes of a message."""


@dataclass
class Segment:
    """A block of metadata, and the lines of data that follow it."""

    metadata: dict[str, str] = field(default_factory=dict)
    lines: list[str] = field(default_factory=list)


@dataclass
class Message:
    """A message as it stands."""

    source: str
    kind: str
    """Such as ``OEM``."""
    version: str
    segments: list[Segment]

    def value(self, key: str, default: str | None = None) -> str:
        """Return what all segments say of a key.

        Raises:
            ValueError: they do not say it, or say different things.
        """
        values = {segment.metadata.get(key, default) for segment in self.segments}
        if len(values) != 1 or None in values:
            got = ", ".join(sorted(str(value) for value in values))
            raise InputError(f"{self.source}: {key} must be one, got {got}")
        return str(values.pop())

    @property
    def time_system(self) -> str:
        """Of its epochs.

        Raises:
            ValueError: it is none that is known.
        """
        return check_time_system(
            f"{self.source}: TIME_SYSTEM", self.value("TIME_SYSTEM")
        )


_BLOCKS = ("META", "DATA", "COVARIANCE")
"""That stand between ``..._START`` and ``..._STOP``, none within another."""


def read_message(file: Path) -> Message:
    """Return the message that a file holds.

    Raises:
        ValueError: it cannot be read, or is none in KVN.
    """
    try:
        check_readable(file, _LONGEST)
        text = file.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not a text file"
        raise InputError(f"{file}: must be an OEM or an AEM, got: {reason}") from error
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    key, equals, version = (part.strip() for part in _parted(lines[0] if lines else ""))
    if not equals or not (key.startswith("CCSDS_") and key.endswith("_VERS")):
        raise InputError(
            f"{file}: must begin with CCSDS_OEM_VERS or CCSDS_AEM_VERS = ..., got "
            f"{(lines[0] if lines else '')[:60]!r}"
        )
    kind = key.removeprefix("CCSDS_").removesuffix("_VERS")
    return Message(str(file), kind, version, _segments(str(file), lines[1:]))


def _parted(line: str) -> tuple[str, str, str]:
    return line.partition("=")


def _segments(source: str, lines: Iterable[str]) -> list[Segment]:
    segments: list[Segment] = []
    inside = ""
    for line in lines:
        block, _, edge = line.partition("_")
        if line.startswith("COMMENT"):
            continue
        if block in _BLOCKS and edge in ("START", "STOP"):
            _check_edge(source, inside, line)
            inside = block if edge == "START" else ""
            if line == "META_START":
                segments.append(Segment())
        elif inside == "META":
            key, equals, value = (part.strip() for part in _parted(line))
            if not equals:
                raise InputError(
                    f"{source}: a line of metadata must be a key, = and its value, got "
                    f"{line[:80]!r}"
                )
            segments[-1].metadata[key] = value
        elif segments and inside != "COVARIANCE":
            segments[-1].lines.append(line)
    _check_edge(source, inside, "")
    if not any(segment.lines for segment in segments):
        raise InputError(f"{source}: must have lines of data after META_STOP, got none")
    return segments


def _check_edge(source: str, inside: str, line: str) -> None:
    """Raise InputError unless a block may begin or end at a line.

    Args:
        source: the file, for errors.
        inside: the block that the line stands in; empty: in none.
        line: that begins or ends one; empty: the end of the message.
    """
    wanted = f"{inside}_STOP" if inside else ""
    if inside and line != wanted:
        raise InputError(
            f"{source}: {inside}_START must be followed by {wanted}, got "
            f"{line or 'the end of the message'}"
        )
    if not inside and line.endswith("_STOP"):
        raise InputError(f"{source}: {line} must follow its START, got it without")


def rows_of(
    message: Message, count: int, also: int | None = None
) -> tuple[list[str], list[list[float]]]:
    """Return the epochs and the numbers of all lines of data.

    Args:
        message: the message.
        count: of numbers that a line must have.
        also: how many it may have in place of these; the others are left out.

    Raises:
        ValueError: a line is not such.
    """
    epochs, rows = [], []
    for line in (line for segment in message.segments for line in segment.lines):
        epoch, *numbers = line.split()
        try:
            row = [float(number) for number in numbers]
        except ValueError:
            row = []
        if len(row) not in (count, also) or not all(map(math.isfinite, row)):
            raise InputError(
                f"{message.source}: a line of data must be an epoch and {count} "
                f"numbers, all finite, got {line[:80]!r}"
            )
        epochs.append(epoch)
        rows.append(row[:count])
    return epochs, rows


def message_text(
    kind: str,
    version: str,
    header: Mapping[str, str],
    comments: Sequence[str],
    metadata: Mapping[str, str],
    lines: Iterable[str],
) -> str:
    """Return the text of a message of one segment.

    Args:
        kind: such as ``OEM``.
        version: of its format.
        header: keys and values after the version.
        comments: lines that say what is meant, in the metadata.
        metadata: keys and values.
        lines: of data.
    """
    begin, end = (["DATA_START"], ["DATA_STOP"]) if kind == "AEM" else ([], [])
    told = [
        f"CCSDS_{kind}_VERS = {version}",
        *(f"{key} = {value}" for key, value in header.items()),
        "META_START",
        *(f"COMMENT {comment}" for comment in comments),
        *(f"{key} = {value}" for key, value in metadata.items()),
        "META_STOP",
        *begin,
        *lines,
        *end,
    ]
    return "\n".join(told) + "\n"


def data_line(epoch: Decimal, numbers: Iterable[float]) -> str:
    """Return a line of data: an epoch, and numbers to 16 digits, as CCSDS has them."""
    return " ".join([epoch_text(epoch), *(f"{x + 0.0:.15e}" for x in numbers)])
