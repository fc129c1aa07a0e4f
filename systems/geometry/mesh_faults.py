"""What is wrong with a file that should hold a mesh, where its reader does not say."""

import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np


_HEADER, _TRIANGLE = 84, 50
"""Bytes of a binary STL: before its triangles, and of each."""


def fault_of(path: Path) -> str:
    """Return what is wrong with a file; empty if it looks like what its name says.

    Args:
        path: of a mesh.
    """
    data = path.read_bytes()
    if not data.strip():
        return "an empty file"
    match path.suffix.lower():
        case ".obj":
            return _of_obj(data)
        case ".stl":
            return _of_stl(data)
        case ".ply":
            return _of_ply(data)
        case ".glb":
            return _of_glb(data)
    return ""


def _of_ply(data: bytes) -> str:
    header, end, _ = data.partition(b"end_header")
    if data[:3] != b"ply" or not end:
        return "a file without the header of a PLY"
    names = {line.split()[-1] for line in header.splitlines() if line.split()}
    if not {b"x", b"y", b"z"} <= names:
        return "a PLY without corners (x, y and z)"
    return "" if b"element face" in header else "a PLY without faces"


def _of_glb(data: bytes) -> str:
    if data[:4] != b"glTF":
        return "a file without the header of a GLB"
    said = int.from_bytes(data[8:12], "little")
    return "" if said == len(data) else f"{len(data)} bytes where a GLB says {said}"


def _of_stl(data: bytes) -> str:
    if len(data) >= _HEADER:
        (count,) = struct.unpack_from("<I", data, _HEADER - 4)
        said = _HEADER + _TRIANGLE * count
        if said == len(data):
            kind = np.dtype([("numbers", "<f4", 12), ("rest", "<u2")])
            corners = np.frombuffer(data, kind, offset=_HEADER)["numbers"][:, 3:]
            broken = np.flatnonzero(~np.isfinite(corners).all(axis=1))
            return f"triangle {broken[0] + 1} that is not finite" if len(broken) else ""
    if data.lstrip()[:5].lower() == b"solid":
        if b"endsolid" not in data.lower():
            return "STL text that ends before its endsolid"
        return "" if b"facet" in data.lower() else "STL text without a facet"
    if len(data) < _HEADER:
        return f"{len(data)} bytes that are no STL"
    return (
        f"{len(data)} bytes where the header of an STL says {count} triangles, "
        f"{said} bytes"
    )


def _of_obj(data: bytes) -> str:
    if b"\0" in data:
        return "binary data, no OBJ text"
    lines = data.decode("utf-8", errors="replace").splitlines()
    return next(_faults_of_lines(lines), "")


def _faults_of_lines(lines: list[str]) -> Iterator[str]:
    corners = 0
    for number, line in enumerate(lines, 1):
        kind, *entries = line.split("#")[0].split() or [""]
        if kind == "v":
            corners += 1
            if not _finite(entries[:3]):
                yield f"no corner of three finite numbers in line {number}: {line[:40]}"
        elif kind == "f":
            for entry in entries:
                index = entry.split("/")[0]
                if not index.lstrip("-").isdigit() or not int(index):
                    yield f"no triangle in line {number}: {line[:40]}"
                elif int(index) > corners or -int(index) > corners:
                    yield f"corner {index} of {corners} in line {number}"
    if not corners:
        yield "text without a corner (v x y z), no OBJ"


def _finite(entries: list[str]) -> bool:
    try:
        return len(entries) == 3 and all(np.isfinite([float(e) for e in entries]))
    except ValueError:
        return False
