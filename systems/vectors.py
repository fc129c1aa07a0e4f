"""Vectors and rotations as tuples of scalars.

A scalar is a float or an array whose lanes are samples: the same line serves one
evaluation inside a LeafSystem and a whole trajectory at once. For single
3-vectors, tuples of floats are several times faster than numpy arrays.

A rotation matrix ``R`` is a 9-tuple in row-major order, a quaternion is
``(w, x, y, z)``. Frames follow Drake's monogram notation.
"""

from collections.abc import Sequence
from types import ModuleType
from typing import Any, TypeAlias


Scalar: TypeAlias = Any
Vector: TypeAlias = tuple[Scalar, Scalar, Scalar]
Rotation: TypeAlias = tuple[
    Scalar, Scalar, Scalar, Scalar, Scalar, Scalar, Scalar, Scalar, Scalar
]
Quaternion: TypeAlias = tuple[Scalar, Scalar, Scalar, Scalar]
Symmetric: TypeAlias = Sequence[Scalar]
"""Entries xx, yy, zz, xy, xz, yz of a symmetric matrix."""
Ops: TypeAlias = ModuleType
"""Where the elementary functions come from: ``math``, ``numpy`` or ``jax.numpy``."""

TINY = 1e-300
"""Keeps 0/0 out where a square goes to zero: no length that matters is below 1e-150."""


def add(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def subtract(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scale(s: Scalar, a: Vector) -> Vector:
    """Return s a."""
    return s * a[0], s * a[1], s * a[2]


def negate(a: Vector) -> Vector:
    """Return -a."""
    return -a[0], -a[1], -a[2]


def dot(a: Vector, b: Vector) -> Scalar:
    """Return the scalar product of a and b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b."""
    a_x, a_y, a_z = a
    b_x, b_y, b_z = b
    return a_y * b_z - a_z * b_y, a_z * b_x - a_x * b_z, a_x * b_y - a_y * b_x


def rotate(R: Rotation, v: Vector) -> Vector:
    """Return R v: with R_WB and v_B, v_W."""
    xx, xy, xz, yx, yy, yz, zx, zy, zz = R
    x, y, z = v
    return (
        xx * x + xy * y + xz * z,
        yx * x + yy * y + yz * z,
        zx * x + zy * y + zz * z,
    )


def unrotate(R: Rotation, v: Vector) -> Vector:
    """Return R^T v: with R_WB and v_W, v_B."""
    xx, xy, xz, yx, yy, yz, zx, zy, zz = R
    x, y, z = v
    return (
        xx * x + yx * y + zx * z,
        xy * x + yy * y + zy * z,
        xz * x + yz * y + zz * z,
    )


def apply(S: Symmetric, v: Vector) -> Vector:
    """Return S v."""
    xx, yy, zz, xy, xz, yz = S
    x, y, z = v
    return (
        xx * x + xy * y + xz * z,
        xy * x + yy * y + yz * z,
        xz * x + yz * y + zz * z,
    )


def transpose(R: Rotation) -> Rotation:
    """Return R^T: with R_AB, R_BA."""
    return R[0], R[3], R[6], R[1], R[4], R[7], R[2], R[5], R[8]


def compose(R: Rotation, S: Rotation) -> Rotation:
    """Return R S: with R_AB and S_BC, R_AC."""
    a, b, c, d, e, f, g, h, i = R
    A, B, C, D, E, F, G, H, K = S
    return (
        a * A + b * D + c * G,
        a * B + b * E + c * H,
        a * C + b * F + c * K,
        d * A + e * D + f * G,
        d * B + e * E + f * H,
        d * C + e * F + f * K,
        g * A + h * D + i * G,
        g * B + h * E + i * H,
        g * C + h * F + i * K,
    )


def rotation_matrix(q: Quaternion) -> Rotation:
    """Return the rotation matrix of a quaternion of any length but zero."""
    w, x, y, z = q
    s = 2.0 / (w * w + x * x + y * y + z * z)
    sx, sy, sz = s * x, s * y, s * z
    wx, wy, wz = w * sx, w * sy, w * sz
    xx, xy, xz = x * sx, x * sy, x * sz
    yy, yz, zz = y * sy, y * sz, z * sz
    return (
        1.0 - yy - zz,
        xy - wz,
        xz + wy,
        xy + wz,
        1.0 - xx - zz,
        yz - wx,
        xz - wy,
        yz + wx,
        1.0 - xx - yy,
    )


def conjugate(q: Quaternion) -> Quaternion:
    """Return the inverse rotation's quaternion."""
    return q[0], -q[1], -q[2], -q[3]


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the quaternion of rotation b followed by rotation a."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def quaternion(rpy: Vector, ops: Ops) -> Quaternion:
    """Return the quaternion of roll, pitch and yaw, rad: R = Rz(y) Ry(p) Rx(r)."""
    (cr, cp, cy) = (ops.cos(0.5 * angle) for angle in rpy)
    (sr, sp, sy) = (ops.sin(0.5 * angle) for angle in rpy)
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


def roll_pitch_yaw(R: Rotation, ops: Ops) -> Vector:
    """Return roll, pitch and yaw of R = Rz(yaw) Ry(pitch) Rx(roll), rad."""
    return (
        ops.atan2(R[7], R[8]),
        ops.atan2(-R[6], ops.sqrt(R[0] * R[0] + R[3] * R[3])),
        ops.atan2(R[3], R[0]),
    )


def rotation_vector(q: Quaternion, ops: Ops) -> Vector:
    """Return axis times angle of a quaternion, rad; unique below 180 deg."""
    w, x, y, z = q
    s = ops.sqrt(x * x + y * y + z * z + TINY)
    angle = 2.0 * ops.copysign(ops.atan2(s, abs(w)), w)
    return scale(angle / s, (x, y, z))
