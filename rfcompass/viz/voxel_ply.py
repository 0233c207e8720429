"""Voxel maps as PLY files, which MeshLab, CloudCompare and Blender open."""

from pathlib import Path

import numpy as np

from rfcompass.files import write_atomic
from rfcompass.types.piles import VoxelGrid
from rfcompass.viz.voxel_points import voxel_points

_POINT = np.dtype([("xyz", "<f4", 3), ("value", "<f4"), ("rgb", "u1", 3)])
_HEADER = """ply
format binary_little_endian 1.0
comment voxel centres in the world frame, metres; edge of a voxel {spacing_m} m
element vertex {count}
property float x
property float y
property float z
property float value
property uchar red
property uchar green
property uchar blue
end_header
"""


def write_ply(path: Path, grid: VoxelGrid, share: float = 0.0) -> int:
    """Write the voxels that are not zero as points with value and colour, atomically.

    Args:
        path: File to write.
        grid: The map.
        share: Leave out what is smaller than this share of the largest size.

    Returns:
        Number of points.

    Raises:
        InputError: If the share is not in [0, 1].
    """
    shown = voxel_points(grid, share)
    table = np.empty(len(shown.points_m), dtype=_POINT)
    table["xyz"], table["value"], table["rgb"] = shown.points_m, shown.values, np.round(255 * shown.rgb)
    header = _HEADER.format(count=table.size, spacing_m=grid.spacing_m).encode("ascii")
    write_atomic(path, lambda draft: draft.write_bytes(header + table.tobytes()))
    return int(table.size)
