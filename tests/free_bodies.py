"""Two bodies that turn freely once they part: all that is told of them, by formulae.

Each is as stiff to turn about all axes across one of its own, which lies anywhere: such
a body turns evenly about that axis, and both together about its angular momentum
(Euler's top without torque). Their CGs go on along straight lines.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation
from separations import FREE

from drakesep.systems.model.separation import (
    Attachment,
    Body,
    InitialMotion,
    Separation,
)


class Top(NamedTuple):
    """A body that is symmetric about an axis, where it stands in the stack."""

    mass: float
    p_BoBcm_B: tuple[float, float, float]
    axis_B: tuple[float, float, float]
    I_about: float
    """About the axis, kg m^2."""
    I_across: float
    p_ABo: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rpy_AB: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def body(self, name: str) -> Body:
        n = np.array(self.axis_B)
        more = self.I_about - self.I_across
        M = self.I_across * np.eye(3) + more * np.outer(n, n)
        return Body(
            name=name,
            mass=self.mass,
            p_BoBcm_B=self.p_BoBcm_B,
            I_BBcm_B=(*np.diag(M).tolist(), M[0, 1], M[0, 2], M[1, 2]),
            p_ABo=self.p_ABo,
            rpy_AB=self.rpy_AB,
        )


LOWER = Top(700.0, (-0.8, 0.05, -0.03), (0.36, -0.48, 0.8), 150.0, 300.0)
UPPER = Top(
    *(500.0, (0.5, -0.1, 0.2), (0.6, 0.0, -0.8), 90.0, 230.0),
    p_ABo=(0.1, 0.03, -0.05),
    rpy_AB=(0.3, -0.2, 0.4),
)
DIRECTION = (0.6, 0.48, 0.64)
ATTITUDE = (0.15, -0.1, 0.2)
RATE = (-0.16, 0.38, -0.25)
RELEASES = (0.05, 0.2)
DURATION = 1.5


def separation() -> Separation:
    """Nothing holds and nothing pushes them: they are free from the start."""
    attachments = tuple(
        Attachment(
            name=f"pad_{i}",
            A="lower",
            B="upper",
            p_AoPad_A=(0.0, 0.1, 0.0),
            joint=FREE,
            release_time=time,
        )
        for i, time in enumerate(RELEASES, 1)
    )
    return Separation(
        bodies=(LOWER.body("lower"), UPPER.body("upper")),
        attachments=attachments,
        A="lower",
        B="upper",
        direction=DIRECTION,
        initial=InitialMotion(rpy_WA=ATTITUDE, w_WA_A=RATE),
        duration=DURATION,
    )


class Turning(NamedTuple):
    """How a top turns in W."""

    R_WB: Rotation
    w_WB_B: np.ndarray
    h_W: np.ndarray
    """Angular momentum about its CG, N m s."""


def turning(top: Top, R_0: Rotation, w_0_W: np.ndarray, t: np.ndarray) -> Turning:
    n = np.array(top.axis_B)
    w_0_B = R_0.apply(w_0_W, inverse=True)
    along = w_0_B @ n
    h_B = top.I_across * w_0_B + (top.I_about - top.I_across) * along * n
    h_W = R_0.apply(h_B)
    # w = h / I_across + own n: about h in W, and about n in B.
    own = (1.0 - top.I_about / top.I_across) * along
    about_h = Rotation.from_rotvec(t[:, None] * h_W / top.I_across)
    R_WB = about_h * R_0 * Rotation.from_rotvec(t[:, None] * own * n)
    w_WB_B = R_WB.apply(h_W, inverse=True) / top.I_across + own * n
    return Turning(R_WB, w_WB_B, h_W)


def signals(t: np.ndarray, rate: Sequence[float] = RATE) -> dict[str, np.ndarray]:
    """Each quantity of the pair at (n,) times, (n, axes), by its name.

    Args:
        t: (n,) s.
        rate: of the stack before, in A, rad/s.
    """
    R_0 = Rotation.from_euler("xyz", ATTITUDE)
    R_SB = Rotation.from_euler("xyz", UPPER.rpy_AB)
    w_0 = R_0.apply(rate)
    A, B = turning(LOWER, R_0, w_0, t), turning(UPPER, R_0 * R_SB, w_0, t)
    # A's CG is at rest, and B's has the velocity of a point of the stack.
    mated = R_SB.apply(UPPER.p_BoBcm_B) + UPPER.p_ABo - LOWER.p_BoBcm_B
    v = np.cross(w_0, R_0.apply(mated))
    r_A = A.R_WB.apply(R_0.apply(mated) + t[:, None] * v, inverse=True)
    moved = r_A - mated
    velocity = A.R_WB.apply(v, inverse=True) - np.cross(A.w_WB_B, r_A)
    relative = B.w_WB_B - (B.R_WB.inv() * A.R_WB).apply(A.w_WB_B)
    angle = (R_SB.inv() * B.R_WB).as_euler("xyz")
    d_A, d_B = np.array(DIRECTION), R_SB.apply(DIRECTION, inverse=True)
    h_B = B.R_WB.apply(B.h_W, inverse=True)
    told = {
        "deviation": angle,
        "angle": angle,
        "tip_off_angle": between(B.R_WB.apply(d_B), d_A),
        # From the side to which it spins about its axis.
        "nutation": between(np.sign(h_B @ d_B)[:, None] * h_B, d_B),
    }
    for prefix, w in (("", B.w_WB_B), ("relative_", relative)):
        told[f"{prefix}rate"] = w
        told[f"{prefix}rate_modulus"] = np.linalg.norm(w, axis=1)
        told[f"{prefix}spin_rate"] = w @ d_B
        told[f"{prefix}transverse_rate"] = np.linalg.norm(np.cross(w, d_B), axis=1)
    for name, vector in (("speed", velocity), ("displacement", moved)):
        told[name] = np.linalg.norm(vector, axis=1)
        told[f"longitudinal_{name}"] = vector @ d_A
        told[f"lateral_{name}"] = np.linalg.norm(np.cross(vector, d_A), axis=1)
    return {name: values.reshape(len(t), -1) for name, values in told.items()}


def between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angles between vectors (n, 3) and one (3,), rad."""
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), a @ b)
