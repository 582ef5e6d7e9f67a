"""Clouds that tests look at."""

import numpy as np


def box_on_table(size=(0.06, 0.08, 0.12), width=240, height=180):
    """What a camera 0.7 m away sees of a box on a table: points in its optical frame as an
    organized cloud's arrays (points, width, height)."""
    focal = 260.0
    eye = np.array([0.55, 0.0, 0.45])
    forward = np.array([0.0, 0.0, 0.04]) - eye
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0, 0, 1.0])
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    v, u = np.mgrid[0:height, 0:width]
    rays = (forward + ((u - width / 2 + 0.5) / focal)[..., None] * right
            + ((v - height / 2 + 0.5) / focal)[..., None] * down)
    low, high = np.array([-size[0] / 2, -size[1] / 2, 0]), np.array([size[0] / 2, size[1] / 2, size[2]])
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = (low - eye) / rays, (high - eye) / rays
        enter = np.minimum(first, second).max(axis=-1)
        leave = np.maximum(first, second).min(axis=-1)
        on_table = -eye[2] / rays[..., 2]
    depth = np.where((enter < leave) & (enter > 0), enter, on_table)
    hit = eye + depth[..., None] * rays
    depth[(depth < 0) | (np.abs(hit[..., :2]).max(axis=-1) > 0.3)] = np.nan
    camera = np.stack([(u - width / 2 + 0.5) / focal * depth, (v - height / 2 + 0.5) / focal * depth,
                       depth], axis=-1)
    return camera.reshape(-1, 3).astype(np.float32), width, height


def cube(size=0.05):
    """(vertices, triangles) of a closed cube that stands on z = 0."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (0, 1.0)]) * size
    triangles = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6],
                 [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    return corners, np.array(triangles)
