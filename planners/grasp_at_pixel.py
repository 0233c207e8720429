"""From a pixel of a depth image to where the hand goes.

The pose is that of `gripper_tool_link` of `urdf/ur5e_2f85.urdf`: z along the approach, y along the closing of the jaws.
The finger tips reach 13 mm beyond its origin. The hand comes straight down.
"""

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray
from rfcompass.errors import InputError
from rfcompass.mapping.camera import points_image
from rfcompass.types import DepthView, GraspMaps

TIP_BEYOND_M = 0.013  # of the URDF
GREATEST_M = 0.085  # opening of the 2F-85 [Boroushaki2023], section 6
ROOM_M = 0.02  # ours: how much wider the jaws open than what they close on
# Ours, where nothing looks like a grasp: how far the tips go below the surface, and how far they stay above the table.
_DEPTH_M, _ABOVE_M = 0.025, 0.005


def grasp_at_pixel(view: DepthView, maps: GraspMaps, row: int, column: int) -> tuple[FloatArray, float]:
    """Turn the grasp at a pixel into a pose of the hand and an opening of its jaws.

    Args:
        view: The image.
        maps: The best grasp at each of its pixels.
        row: Of the pixel.
        column: Of the pixel.

    Returns:
        T_world_hand, homogeneous, shape (4, 4), and the opening [m].

    Raises:
        InputError: If the pixel has no depth.
    """
    depth_m = float(view.depth_m[row, column])
    if not np.isfinite(depth_m):
        raise InputError(f"pixel ({row}, {column}) has no depth", row=row, column=column)
    ray = np.linalg.inv(view.intrinsics) @ np.array([column, row, 1.0])
    point_m = view.T_world_camera[:3, :3] @ (depth_m * ray) + view.T_world_camera[:3, 3]
    below_m, width_m = float(maps.depth_m[row, column]), float(maps.width_m[row, column])
    return _straight_down(point_m, float(maps.angle_rad[row, column]), below_m), _opening(width_m)


def grasp_across(view: DepthView, pixels: BoolArray, table_m: float) -> tuple[FloatArray, float]:
    """Grasp an object of which no pixel looks like a grasp: at its middle pixel, across its shorter extent; ours.

    Args:
        view: The image.
        pixels: The object's pixels, shape (H, W).
        table_m: Height of the table in the world; the finger tips stay above it [m].

    Returns:
        T_world_hand, homogeneous, shape (4, 4), and the opening [m].

    Raises:
        InputError: If none of the pixels has a depth.
    """
    row, column = middle_pixel(pixels & np.isfinite(view.depth_m))
    image_m = points_image(view)
    points_m, point_m = image_m[pixels & np.isfinite(view.depth_m)], image_m[row, column]
    across, width_m = _shorter_extent(points_m[:, :2])
    below_m = float(np.clip(point_m[2] - table_m - _ABOVE_M, 0.0, _DEPTH_M))
    return _straight_down(point_m, float(np.arctan2(across[1], across[0])), below_m), _opening(width_m)


def middle_pixel(pixels: BoolArray) -> tuple[int, int]:
    """Pixel of an object nearest to the mean of its pixels; the first of several.

    Raises:
        InputError: If there is no pixel.
    """
    where = np.argwhere(pixels)
    if not len(where):
        raise InputError("an object without a pixel that has a depth", pixels=0)
    row, column = where[np.argmin(((where - where.mean(axis=0)) ** 2).sum(axis=1).round(6))]
    return int(row), int(column)


def _shorter_extent(points_m: FloatArray) -> tuple[FloatArray, float]:
    """Level direction in which points spread least, and how far they do; points (P, 2)."""
    from_mean = points_m - points_m.mean(axis=0)
    _, directions = np.linalg.eigh(from_mean.T @ from_mean)
    across = directions[:, 0]
    return across, float(np.ptp(from_mean @ across))


def _straight_down(point_m: FloatArray, angle_rad: float, below_m: float) -> FloatArray:
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    T = np.eye(4)
    # Columns: across both, where the jaws close, down.
    T[:3, :3] = np.array([[-s, c, 0.0], [c, s, 0.0], [0.0, 0.0, -1.0]])
    T[:3, 3] = point_m[0], point_m[1], point_m[2] - below_m + TIP_BEYOND_M
    return T


def _opening(width_m: float) -> float:
    return min(width_m + ROOM_M, GREATEST_M)
