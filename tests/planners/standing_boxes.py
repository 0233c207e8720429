"""Depth views of upright boxes and balls on a table, by marching along each ray; no simulator."""

from typing import NamedTuple

import numpy as np

from rfcompass.types import DepthView


class Upright(NamedTuple):
    """A box that stands on the table, turned about the vertical; or half an ellipsoid over the same rectangle."""

    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0
    length_m: float = 0.06
    width_m: float = 0.04
    height_m: float = 0.05
    round_top: bool = False

    def top_m(self, x, y):
        """Height over points, 0 beside it."""
        c, s = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        a = (c * (x - self.x_m) + s * (y - self.y_m)) / (self.length_m / 2)
        b = (-s * (x - self.x_m) + c * (y - self.y_m)) / (self.width_m / 2)
        if self.round_top:
            return self.height_m * np.sqrt(np.clip(1 - a**2 - b**2, 0, None))
        return np.where((np.abs(a) <= 1) & (np.abs(b) <= 1), self.height_m, 0.0)


def look(*things, shape=(90, 160), height_m=0.5, turn_rad=0.0, at_m=(0.0, 0.0)):
    """View from straight above, the camera turned about the vertical; 0.45 m of table along a row."""
    focal = shape[1] / 0.45 * height_m
    K = np.array([[focal, 0, (shape[1] - 1) / 2], [0, focal, (shape[0] - 1) / 2], [0, 0, 1]])
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    T = np.diag([1.0, -1.0, -1.0, 1.0])
    T[:3, :3] = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ T[:3, :3]
    T[:3, 3] = *at_m, height_m
    v, u = np.indices(shape)
    rays = np.stack([(u - K[0, 2]) / focal, (v - K[1, 2]) / focal, np.ones(shape)], axis=-1) @ T[:3, :3].T
    depth = np.full(shape, np.nan)
    top_m = max([thing.height_m for thing in things], default=0.0)
    for z in np.arange(top_m, -1e-9, -0.001):
        t = height_m - z
        x, y = at_m[0] + rays[..., 0] * t, at_m[1] + rays[..., 1] * t
        tops = np.max([thing.top_m(x, y) for thing in things] or [np.zeros(shape)], axis=0)
        depth = np.where(np.isnan(depth) & (tops >= z - 1e-9), t, depth)
    return DepthView(np.where(np.isnan(depth), height_m, depth), K, T)


def pixel_of(view, point_m):
    """Row and column of the pixel that shows a point of the world."""
    p = view.T_world_camera[:3, :3].T @ (np.asarray(point_m) - view.T_world_camera[:3, 3])
    u, v, z = view.intrinsics @ p
    return round(v / z), round(u / z)
