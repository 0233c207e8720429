"""Pinhole geometry of depth images: voxels into pixels, pixels into points.

Pixel (u, v) is column u, row v; its centre is at the whole numbers. A point p of the world appears at
(u z, v z, z) = K R^T (p - t), with K the intrinsics, R and t the camera's pose and z the depth.
"""

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray
from rfcompass.errors import CameraBlocked, InputError
from rfcompass.types.piles import DepthView
from rfcompass.types.workspace import Workspace

# Ours. A depth camera measures nothing nearer than its least range (a D415's is about 0.3 m at full size): if half of
# what it reports is nearer than this, something stands before it, or it is inside something.
NEAREST_M = 0.10
# Ours: where all that is seen lies so far over or under the table, depths or poses are in another unit [m].
_FAR_M = 5.0
_TRIFLE = 1e-4  # of a voxel


def clean_depth_m(raw_m: FloatArray) -> FloatArray:
    """Bring a camera's own image into the spelling of `DepthView`: what is no depth becomes NaN.

    Args:
        raw_m: Depth [m], with 0, a negative number, infinity or NaN where nothing was seen, shape (H, W).
    """
    depth_m = np.array(raw_m, dtype=np.float64)
    depth_m[~(np.isfinite(depth_m) & (depth_m > 0))] = np.nan
    return depth_m


def voxel_projection(view: DepthView, workspace: Workspace, first: tuple[int, int, int] = (0, 0, 0)) -> FloatArray:
    """Matrix that takes a voxel's indices (i, j, k, 1), counted from a first voxel, to (u z, v z, z), shape (3, 4)."""
    R, t = view.T_world_camera[:3, :3], view.T_world_camera[:3, 3]
    along = view.intrinsics @ R.T
    origin_m = workspace.origin_m + workspace.spacing_m * np.array(first)
    return np.column_stack([workspace.spacing_m * along, along @ (origin_m - t)])


def half_extent_m(view: DepthView, spacing_m: float) -> float:
    """Half the extent of a voxel along the optical axis [m], less a trifle, so that rounding decides nothing."""
    return (0.5 - _TRIFLE) * spacing_m * float(np.abs(view.T_world_camera[:3, 2]).sum())


def back_project(view: DepthView, pixels: BoolArray | None = None) -> FloatArray:
    """Points of the world that pixels show.

    Args:
        view: A depth image.
        pixels: Which pixels, shape (H, W); all if None. Pixels without depth give no point.

    Returns:
        Points in the world frame [m], row by row, shape (P, 3).
    """
    wanted = np.isfinite(view.depth_m) if pixels is None else pixels & np.isfinite(view.depth_m)
    return np.asarray(points_image(view)[wanted])


def points_image(view: DepthView) -> FloatArray:
    """Point of the world that each pixel shows [m], NaN where it shows none, shape (H, W, 3)."""
    v, u = np.indices(view.depth_m.shape, dtype=np.float64)
    rays = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(view.intrinsics).T
    R, t = view.T_world_camera[:3, :3], view.T_world_camera[:3, 3]
    return np.asarray((view.depth_m[..., None] * rays) @ R.T + t)


def check_view(view: DepthView, workspace: Workspace, nearest_m: float = NEAREST_M) -> None:
    """Check that a camera can have seen the table.

    Raises:
        InputError: If the camera stands below the table top, or all that it sees lies far below it.
        CameraBlocked: If it sees nothing, or if half of what it sees is nearer than `nearest_m`.
    """
    _check_over_table(view, workspace.table_m)
    depth_m = view.depth_m[np.isfinite(view.depth_m)]
    if not depth_m.size:
        raise CameraBlocked(f"none of the {view.depth_m.size} pixels has a depth", seen=0, median_m=None)
    if (median_m := float(np.median(depth_m))) < nearest_m:
        message = f"half of the pixels are nearer than {median_m:.3f} m: something stands before the camera"
        raise CameraBlocked(message, seen=int(depth_m.size), median_m=median_m, nearest_m=nearest_m)


def check_from_above(view: DepthView, table_m: float) -> None:
    """Check that a camera looks down on the table, as whoever grasps from straight above has to.

    Args:
        view: A depth image.
        table_m: Height of the table in the world [m].

    Raises:
        InputError: If the camera does not look down, stands below the table top, or all that it sees lies far below it.
    """
    down = -float(view.T_world_camera[2, 2])
    if down <= 0:
        rises = np.rad2deg(np.arcsin(min(-down, 1.0)))
        message = f"the camera does not look down, its axis rises by {rises:.0f} degrees: grasps come from above"
        raise InputError(message, down=down)
    _check_over_table(view, table_m)


def _check_over_table(view: DepthView, table_m: float) -> None:
    """Check that a camera stands over the table, and that its depths and its pose can be in metres."""
    height_m = float(view.T_world_camera[2, 3]) - table_m
    if height_m <= 0:
        raise InputError(f"the camera stands {-height_m:.3f} m below the table top", height_m=height_m)
    nearest_m = float(np.nanmin(view.depth_m, initial=np.inf))
    if np.isnan(view.depth_m).all() or (nearest_m < _FAR_M and height_m < _FAR_M):
        return
    heights_m = points_image(view)[..., 2] - table_m
    if (over_m := float(np.nanmin(heights_m))) > _FAR_M:
        message = f"a camera {height_m:.3g} m over the table, and nothing lower than {over_m:.3g} m: millimetres?"
        raise InputError(message, height_m=height_m, over_m=over_m)
    below_m = -float(np.nanmax(heights_m))
    if below_m > _FAR_M:
        median_m = float(np.nanmedian(view.depth_m))
        message = f"a depth of {median_m:.3g} m, and nothing less than {below_m:.3g} m below the table: millimetres?"
        raise InputError(message, median_m=median_m, below_m=below_m)
