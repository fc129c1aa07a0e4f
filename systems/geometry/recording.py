"""Runs drawn in Drake's Meshcat as one recording, a page that plays by itself."""

import logging
from collections.abc import Sequence
from typing import Any

import numpy as np
import pydrake.geometry as drake
from pydrake.math import RigidTransform, RotationMatrix

from drakesep.systems.arrays import Array
from drakesep.systems.geometry.colours import colour_of
from drakesep.systems.geometry.illustration import illustration_of
from drakesep.systems.geometry.relative_path import Pose
from drakesep.systems.model.separation import Separation


_BAR = 0.005
"""Radius of the bar between nearest points, m."""
_NEAREST = drake.Rgba(0.84, 0.1, 0.1, 1.0)
_ENDS = ("first", "second")
_FROM = np.array([-0.72, -0.78, 0.56])
"""Where the camera stands, for what is a metre large, m."""


class Recording:
    """Draws runs below paths of their own, seen from A, frame after frame.

    Times are those of the recording, s.
    """

    def __init__(self, frames_per_second: int):
        """Begin to record.

        Args:
            frames_per_second: of the recording.
        """
        self._meshcat = _meshcat()
        self._meshcat.SetProperty("/Grid", "visible", False)
        self._meshcat.SetProperty("/Axes", "visible", False)
        self._meshcat.SetProperty("/Background", "top_color", [1.0, 1.0, 1.0])
        self._meshcat.SetProperty("/Background", "bottom_color", [0.93, 0.94, 0.96])
        self._meshcat.StartRecording(
            frames_per_second=frames_per_second,
            set_visualizations_while_recording=False,
        )

    def look_at(self, centre: Array, size: float) -> None:
        """Put the camera where all of something is seen, from behind and the side.

        Args:
            centre: (3,) of it, in A, m.
            size: of it, m.
        """
        self._meshcat.SetCameraPose(centre + _FROM * size, centre)

    def draw(self, root: str, separation: Separation) -> None:
        """Draw the parts of all bodies, and a bar between nearest points.

        Args:
            root: path below which they are drawn.
            separation: whose bodies have parts.

        Raises:
            ValueError: a mesh is missing, empty or not closed.
        """
        for body in separation.bodies:
            for part in body.parts:
                shape, X_BG = illustration_of(part)
                path = f"{root}/{body.name}/{part.name}"
                rgba = drake.Rgba(*colour_of(part, body, separation))
                self._meshcat.SetObject(path, shape, rgba)
                self._meshcat.SetTransform(path, X_BG)
        self._meshcat.SetObject(f"{root}/bar", drake.Cylinder(_BAR, 1.0), _NEAREST)
        for end in _ENDS:
            self._meshcat.SetObject(f"{root}/{end}", drake.Sphere(2.0 * _BAR), _NEAREST)

    def place(self, path: str, pose: Pose, at: float) -> None:
        """Put a body where it is at a time."""
        X = RigidTransform(RotationMatrix(pose.R_AB), pose.p_AoBo_A)
        self._meshcat.SetTransform(path, X, at)

    def place_bar(self, root: str, ends: Sequence[Array], at: float) -> None:
        """Put the bar between two points (3,), in A, m, at a time."""
        along = ends[1] - ends[0]
        length = float(np.linalg.norm(along))
        R = RotationMatrix()
        if length > 0.0:
            R = RotationMatrix.MakeFromOneVector(along / length, axis_index=2)
        X = RigidTransform(R, 0.5 * (ends[0] + ends[1]))
        self._meshcat.SetTransform(f"{root}/bar", X, at)
        stretch = [1.0, 1.0, max(length, 1e-6)]
        self._meshcat.SetProperty(f"{root}/bar", "scale", stretch, at)
        for end, point in zip(_ENDS, ends, strict=True):
            self._meshcat.SetTransform(f"{root}/{end}", RigidTransform(point), at)

    def page(self) -> str:
        """End the recording, and return the HTML page that plays it."""
        self._meshcat.StopRecording()
        self._meshcat.PublishRecording()
        return str(self._meshcat.StaticHtml())


def _meshcat() -> Any:
    """Return a Meshcat that does not say where it listens: nobody needs to call it."""
    log = logging.getLogger("drake")
    level = log.level
    log.setLevel(logging.WARNING)
    try:
        return drake.Meshcat()
    finally:
        log.setLevel(level)
