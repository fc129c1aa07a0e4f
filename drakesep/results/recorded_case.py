"""The case as a results folder keeps it: in SI, with copies of its meshes."""

import contextlib
import dataclasses
import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.files import written
from drakesep.results.case_json import NO_RECORD, from_json, to_json
from drakesep.results.catalogue.names import CASE, GEOMETRY
from drakesep.systems.checks import InputError
from drakesep.systems.model.parts import Mesh, Part


@contextlib.contextmanager
def staged_case(
    case: AnalysisCase, folder: Path, meshes: Mapping[Path, bytes]
) -> Iterator[None]:
    """Write a case into a results folder, and the meshes that it names beside it.

    They take their places as the block ends, and not if it fails: what is there until
    then, the meshes of the case itself perhaps, may be cleared within.

    Args:
        case: the case.
        folder: of the results.
        meshes: what its meshes held when they were measured, by their files.

    Raises:
        ValueError: the case holds what is no data, or a mesh that is not among them.
    """
    with contextlib.ExitStack() as stack:

        def beside(part: Part, shape: Mesh) -> Mesh:
            recorded = _recorded(part, shape)
            (folder / GEOMETRY).mkdir(exist_ok=True)
            copy = stack.enter_context(written(folder / recorded.file))
            if shape.file not in meshes:
                raise InputError(f"{shape.file}: must be a mesh, got no such file")
            copy.write_bytes(meshes[shape.file])
            return recorded

        _with_meshes(case, beside)
        file = stack.enter_context(written(folder / CASE, synced=True))
        file.write_text(recorded_text(case), encoding="utf-8")
        yield


def recorded_text(case: AnalysisCase) -> str:
    """Return what a results folder says of a case."""
    return json.dumps(to_json(as_recorded(case)), indent=1) + "\n"


def as_recorded(case: AnalysisCase) -> AnalysisCase:
    """Return a case as a results folder keeps it: its meshes are named within that."""
    return _with_meshes(case, _recorded)


def _recorded(part: Part, shape: Mesh) -> Mesh:
    name = Path(GEOMETRY, f"{part.name}{shape.file.suffix.lower()}")
    return dataclasses.replace(shape, file=name)


def read_case(folder: Path) -> AnalysisCase:
    """Return the case of a results folder, with the meshes that stand there.

    Raises:
        ValueError: there is none, or it is not valid.
    """
    file = folder / CASE
    try:
        case = from_json(json.loads(file.read_text(encoding="utf-8")))
    except NO_RECORD as error:
        raise InputError(f"{file}: must hold a case, got: {error}") from error
    if not isinstance(case, AnalysisCase):
        raise InputError(f"{file}: must hold a case, got {type(case).__name__}")
    return with_meshes_in(case, folder)


def with_meshes_in(case: AnalysisCase, folder: Path) -> AnalysisCase:
    """Return a case as it was recorded, with the meshes of a results folder."""

    def here(_: Part, shape: Mesh) -> Mesh:
        return dataclasses.replace(shape, file=folder / shape.file)

    return _with_meshes(case, here)


def _with_meshes(
    case: AnalysisCase, moved: Callable[[Part, Mesh], Mesh]
) -> AnalysisCase:
    """Return a case whose meshes are in other files."""

    def of(part: Part) -> Part:
        if not isinstance(part.shape, Mesh):
            return part
        return dataclasses.replace(part, shape=moved(part, part.shape))

    before = case.separation.bodies
    if not any(isinstance(part.shape, Mesh) for body in before for part in body.parts):
        return case
    bodies = tuple(
        dataclasses.replace(body, parts=tuple(map(of, body.parts))) for body in before
    )
    separation = dataclasses.replace(case.separation, bodies=bodies)
    return dataclasses.replace(case, separation=separation)
