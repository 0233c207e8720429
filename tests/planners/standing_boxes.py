"""Depth views of upright boxes on a table, as a camera half a metre above sees them."""

from typing import NamedTuple

import numpy as np
from box_scenes import Block, looking_down, see


class Upright(NamedTuple):
    """A box turned about the vertical that stands on the table, or floats."""

    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0
    length_m: float = 0.06
    width_m: float = 0.04
    height_m: float = 0.05
    from_m: float = 0.0  # its lower side


def look(*things, shape=(90, 160), height_m=0.5, turn_rad=0.0, at_m=(0.0, 0.0)):
    """View from straight above, the camera turned about the vertical; 0.45 m of table along a row."""
    focal = shape[1] / 0.45 * height_m
    K = np.array([[focal, 0, (shape[1] - 1) / 2], [0, focal, (shape[0] - 1) / 2], [0, 0, 1]])
    blocks = [
        Block((t.x_m, t.y_m, (t.from_m + t.height_m) / 2), (t.length_m, t.width_m, t.height_m - t.from_m), t.yaw_rad)
        for t in things
    ]
    return see(blocks, looking_down(*at_m, height_m, turn_rad=turn_rad), K, shape)[0]


def pixel_of(view, point_m):
    """Row and column of the pixel that shows a point of the world."""
    p = view.T_world_camera[:3, :3].T @ (np.asarray(point_m) - view.T_world_camera[:3, 3])
    u, v, z = view.intrinsics @ p
    return round(v / z), round(u / z)
