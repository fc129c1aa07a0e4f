"""A model file read in a process of its own, where it can do no harm to the caller's.

What Drake's parser makes of some files ends its process, or never ends: then that of
the caller goes on, and says so. The process stands in the folder of the file, so that
includes are looked for beside it; it knows no packages, asks no network, and has limits
of time and memory.
"""

import json
import re
import signal
import subprocess
import sys
import tempfile
import textwrap
from pathlib import Path
from typing import Any, NamedTuple

from drakesep.systems.checks import InputError, unknown
from drakesep.systems.design.model_text import bare_model


_SECONDS = 30
"""That reading may take, whether or not the caller still is; a machine may be busy."""
_MESSAGE = 400
"""Characters of what the parser says, which may be lines and lines."""
_BYTES = 8 << 30
"""Of memory, addressed; on Linux."""


class ReadModel(NamedTuple):
    """What a model says, in the frame that becomes the body's."""

    mass: float
    """kg."""
    p_BoBcm_B: list[float]
    """(3,) m."""
    I_BBcm_B: list[list[float]]
    """(3, 3) kg m^2."""


def read_apart(path: Path, frame: str | None) -> ReadModel:
    """Return what a model says.

    Args:
        path: of the file.
        frame: name of the frame that becomes the body's; the first body's if None.

    Raises:
        ValueError: it is no model, or reading it does not end.
    """
    command = [sys.executable, "-m", __spec__.name, str(path.absolute()), frame or ""]
    try:
        done = subprocess.run(
            command,
            cwd=path.absolute().parent,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_SECONDS,
        )
    except subprocess.TimeoutExpired as error:
        raise InputError(
            f"{path.name}: must be a model, got one that takes more than {_SECONDS} s "
            "to read"
        ) from error
    try:
        told = json.loads(done.stdout)
    except ValueError:
        raise InputError(
            f"{path.name}: must be a model, got one at which Drake's parser ended: "
            f"{_why(done)}"
        ) from None
    if "error" in told:
        raise InputError(told["error"])
    return ReadModel(told["mass"], told["cg"], told["inertia"])


def _why(done: "subprocess.CompletedProcess[bytes]") -> str:
    if done.returncode < 0:
        return signal.Signals(-done.returncode).name
    said = done.stderr.decode(errors="replace").strip().splitlines()
    return said[-1] if said else f"exit code {done.returncode}"


def _read(path: Path, frame: str) -> dict[str, Any]:
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.multibody.tree import BodyIndex, FrameIndex

    plant = MultibodyPlant(time_step=0.0)
    parser = Parser(plant)
    packages = parser.package_map()
    for package in packages.GetPackageNames():
        packages.Remove(package)  # Drake's own would be downloaded
    # What the parser would mend with a warning, such as a negative mass, is an error.
    parser.SetStrictParsing()
    with tempfile.TemporaryDirectory() as folder:
        bare = bare_model(path, path.name, Path(folder))
        try:
            if bare is None:
                parser.AddModels(str(path))
            else:
                parser.AddModelsFromString(bare.text, bare.suffix)
            plant.Finalize()
        except RuntimeError as error:
            message = textwrap.shorten(str(error), _MESSAGE, placeholder=" ...")
            message = message.replace(str(path), path.name)
            message = re.sub(r"<literal-string>\.\w+", path.name, message)
            message = re.sub(rf"(file:)?/*{re.escape(folder)}/+\d+_", "", message)
            raise InputError(f"{path.name}: must be a model, got: {message}") from error
    indices = [BodyIndex(i) for i in range(1, plant.num_bodies())]
    if not indices:
        raise InputError(f"{path.name}: must be a model, got no body")
    base = plant.get_body(indices[0]).body_frame()
    frame = frame or (bare.first if bare is not None else "")
    if frame:
        frames = [plant.get_frame(FrameIndex(i)) for i in range(1, plant.num_frames())]
        names = [each.name() for each in frames]
        if names.count(frame) != 1:
            got = unknown("frame", frame, names) if frame not in names else "several"
            raise InputError(f"{path.name}: frame {frame!r} must be one of it; {got}")
        base = frames[names.index(frame)]
    M = plant.CalcSpatialInertia(plant.CreateDefaultContext(), base, indices)
    if not M.get_mass() > 0.0:
        raise InputError(f"{path.name}: mass must be > 0, got {M.get_mass():g}")
    about_cm = M.Shift(M.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
    return {
        "mass": M.get_mass(),
        "cg": M.get_com().tolist(),
        "inertia": about_cm.tolist(),
    }


def _main(file: str, frame: str) -> None:
    signal.alarm(_SECONDS)  # ends it whatever the parser is at
    path = Path(file)
    try:
        if sys.platform == "linux":
            import resource

            resource.setrlimit(resource.RLIMIT_AS, (_BYTES, _BYTES))
        told = _read(path, frame)
    except InputError as error:
        told = {"error": str(error)}
    sys.stdout.write(json.dumps(told))


if __name__ == "__main__":
    _main(*sys.argv[1:])
