"""Boxes on a table, seen by a ray caster of a few lines: nothing here depends on a physics engine."""

from dataclasses import dataclass

import numpy as np

from rfcompass.types import DepthView


@dataclass(frozen=True)
class Block:
    """A box that stands on the table or floats: middle, edges, turn about z, colour."""

    centre_m: tuple
    size_m: tuple
    yaw_rad: float = 0.0
    colour: tuple = (120, 120, 120)


def looking_down(x_m=0.0, y_m=0.0, height_m=0.75, tilt_rad=0.0, turn_rad=0.0):
    """Pose of a camera above a point; tilt is about its own x axis, turn about the vertical."""
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    down = np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, -1.0]])
    ct, st = np.cos(tilt_rad), np.sin(tilt_rad)
    T = np.eye(4)
    T[:3, :3] = down @ np.array([[1.0, 0.0, 0.0], [0.0, ct, -st], [0.0, st, ct]])
    T[:3, 3] = x_m, y_m, height_m
    return T


def intrinsics(width=80, height=60, focal=64.0):
    return np.array([[focal, 0.0, (width - 1) / 2], [0.0, focal, (height - 1) / 2], [0.0, 0.0, 1.0]])


def see(blocks, T_world_camera, K=None, shape=(60, 80), table_m=0.0, table_colour=(200, 190, 170)):
    """Depth and colour of the nearest block or of the endless table, with the label image beside it."""
    K = intrinsics(shape[1], shape[0], 0.8 * shape[1]) if K is None else K
    v, u = np.indices(shape)
    rays = np.stack([u, v, np.ones(shape)], axis=-1) @ np.linalg.inv(K).T @ T_world_camera[:3, :3].T
    eye = T_world_camera[:3, 3]
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = np.where(rays[..., 2] < 0, (table_m - eye[2]) / rays[..., 2], np.inf)
        labels = np.zeros(shape, dtype=np.int64)
        for number, block in enumerate(blocks, start=1):
            c, s = np.cos(block.yaw_rad), np.sin(block.yaw_rad)
            R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
            start, way, half = (eye - block.centre_m) @ R, rays @ R, np.array(block.size_m) / 2
            a, b = (-half - start) / way, (half - start) / way
            enter, leave = np.fmin(a, b).max(axis=-1), np.fmax(a, b).min(axis=-1)
            hit = (enter <= leave) & (enter > 0) & (enter < depth)
            depth[hit], labels[hit] = enter[hit], number
    colours = np.array([table_colour, *(block.colour for block in blocks)], dtype=np.int64)
    depth[~np.isfinite(depth)] = np.nan
    return DepthView(depth, K, T_world_camera, colours[labels]), labels


def views_of(blocks, poses, **options):
    return [see(blocks, pose, **options)[0] for pose in poses]


def square_scan(side_m=0.44, height_m=0.7):
    """Eight cameras on a square that look straight down."""
    steps = (-side_m / 2, 0.0, side_m / 2)
    return [looking_down(x, y, height_m) for x in steps for y in steps if (x, y) != (0.0, 0.0)]
