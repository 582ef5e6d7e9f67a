"""Poses in doubles: mathutils' matrices have 32 bits."""

import math

import numpy as np


def typed(value):
    """A number as it was typed: Blender's properties have 32 bits, 0.1 comes as 0.10000000149."""
    return float(f"{value:.7g}")


def typed_angle(value):
    """An angle [rad] as it was typed in degrees."""
    return math.radians(typed(math.degrees(value)))


def rotation(axis, angle):
    """4 x 4, about a unit axis by an angle [rad]."""
    x, y, z = axis
    c, s = math.cos(angle), math.sin(angle)
    t = 1 - c
    X = np.eye(4)
    X[:3, :3] = [[t * x * x + c, t * x * y - s * z, t * x * z + s * y],
                 [t * x * y + s * z, t * y * y + c, t * y * z - s * x],
                 [t * x * z - s * y, t * y * z + s * x, t * z * z + c]]
    return X


def translation(by):
    X = np.eye(4)
    X[:3, 3] = by
    return X


def rpy(angles):
    """4 x 4 of Rz(yaw) Ry(pitch) Rx(roll), as URDF's."""
    return (rotation((0, 0, 1), angles[2]) @ rotation((0, 1, 0), angles[1])
            @ rotation((1, 0, 0), angles[0]))


def to_rpy(X):
    """Roll, pitch, yaw [rad] of a 4 x 4."""
    pitch = math.atan2(-X[2, 0], math.hypot(X[0, 0], X[1, 0]))
    if math.hypot(X[0, 0], X[1, 0]) < 1e-12:  # straight up or down: all of it is roll
        return math.atan2(X[0, 1] if X[2, 0] < 0 else -X[0, 1], X[1, 1]), pitch, 0.0
    return math.atan2(X[2, 1], X[2, 2]), pitch, math.atan2(X[1, 0], X[0, 0])


def matrix(pose):
    """4 x 4 of {position, quaternion} of the JSON; None: identity."""
    if not pose:
        return np.eye(4)
    w, x, y, z = np.array(pose.get("quaternion", (1, 0, 0, 0)), float)
    X = np.eye(4)
    X[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                 [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                 [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    X[:3, 3] = pose.get("position", (0, 0, 0))
    return X


def quaternion(X):
    """w, x, y, z of a 4 x 4; the greatest of the four is found first, so that none is lost."""
    R = X[:3, :3]
    squares = np.array([1 + R[0, 0] + R[1, 1] + R[2, 2], 1 + R[0, 0] - R[1, 1] - R[2, 2],
                        1 - R[0, 0] + R[1, 1] - R[2, 2], 1 - R[0, 0] - R[1, 1] + R[2, 2]])
    most = int(squares.argmax())
    s = 2 * math.sqrt(squares[most])
    w, x, y, z = (
        (s / 4, (R[2, 1] - R[1, 2]) / s, (R[0, 2] - R[2, 0]) / s, (R[1, 0] - R[0, 1]) / s),
        ((R[2, 1] - R[1, 2]) / s, s / 4, (R[0, 1] + R[1, 0]) / s, (R[0, 2] + R[2, 0]) / s),
        ((R[0, 2] - R[2, 0]) / s, (R[0, 1] + R[1, 0]) / s, s / 4, (R[1, 2] + R[2, 1]) / s),
        ((R[1, 0] - R[0, 1]) / s, (R[0, 2] + R[2, 0]) / s, (R[1, 2] + R[2, 1]) / s, s / 4))[most]
    q = np.array((w, x, y, z))
    return q / np.linalg.norm(q)


def pose(X):
    """{position, quaternion} of a 4 x 4."""
    return {"position": [float(v) for v in X[:3, 3]],
            "quaternion": [float(v) for v in quaternion(X)]}


def is_identity(X):
    return bool((np.abs(X - np.eye(4)) < 1e-15).all())


def inverse(X):
    Y = np.eye(4)
    Y[:3, :3] = X[:3, :3].T
    Y[:3, 3] = -X[:3, :3].T @ X[:3, 3]
    return Y


def frame(origin, z, y):
    """4 x 4 with its z along `z`, its y near `y`."""
    z = np.asarray(z, float) / np.linalg.norm(z)
    y = np.asarray(y, float)
    across = y - z * (y @ z)
    if np.linalg.norm(across) < 1e-6 * max(np.linalg.norm(y), 1e-12):
        other = np.eye(3)[int(np.abs(z).argmin())]
        across = other - z * (other @ z)
    y = across / np.linalg.norm(across)
    X = np.eye(4)
    X[:3, :3] = np.column_stack((np.cross(y, z), y, z))
    X[:3, 3] = origin
    return X


def denavit_hartenberg(theta, d, a, alpha, is_craig):
    """Rz(theta) Tz(d) Tx(a) Rx(alpha), or by Craig Rx(alpha) Tx(a) Rz(theta) Tz(d)."""
    about_z = rotation((0, 0, 1), theta) @ translation((0, 0, d))
    about_x = rotation((1, 0, 0), alpha) @ translation((a, 0, 0))
    return about_x @ about_z if is_craig else about_z @ about_x
