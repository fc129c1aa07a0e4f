"""The case as a results folder keeps it: in SI, with copies of its meshes."""

import contextlib
import dataclasses
import json
import shutil
from collections.abc import Callable
from pathlib import Path

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.files import write_text, written
from drakesep.results.case_json import from_json, to_json
from drakesep.results.catalogue import GEOMETRY
from drakesep.systems.checks import InputError
from drakesep.systems.model.parts import Mesh, Part


CASE = "case.json"


def save_case(case: AnalysisCase, folder: Path) -> None:
    """Write a case into a results folder, and the meshes that it names beside it.

    Raises:
        ValueError: it holds what is no data.
    """

    def beside(part: Part, shape: Mesh) -> Mesh:
        name = Path(GEOMETRY, f"{part.name}{shape.file.suffix.lower()}")
        (folder / GEOMETRY).mkdir(exist_ok=True)
        with written(folder / name) as copy:
            shutil.copyfile(shape.file, copy)
        return dataclasses.replace(shape, file=name)

    text = json.dumps(to_json(_with_meshes(case, beside)), indent=1)
    write_text(folder / CASE, text + "\n")


def read_case(folder: Path) -> AnalysisCase:
    """Return the case of a results folder, with the meshes that stand there.

    Raises:
        ValueError: there is none, or it is not valid.
    """
    file = folder / CASE
    try:
        case = from_json(json.loads(file.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError) as error:
        raise InputError(f"{file}: must hold a case, got: {error}") from error
    if not isinstance(case, AnalysisCase):
        raise InputError(f"{file}: must hold a case, got {type(case).__name__}")

    def here(_: Part, shape: Mesh) -> Mesh:
        return dataclasses.replace(shape, file=folder / shape.file)

    return _with_meshes(case, here)


def other_bodies(folder: Path) -> tuple[str, ...]:
    """Return the bodies that leave, but the first; none if no case tells.

    Args:
        folder: of the results.
    """
    with contextlib.suppress(InputError):
        return tuple(pair.B for pair in read_case(folder).separation.others)
    return ()


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
