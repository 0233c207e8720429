"""Where a known box can lie hidden, as a distribution over the image: X-Ray's labels [XRay2020], own code.

The target lies on the support plane, on any of its faces, turned by any of 16 yaws, anywhere on a grid. A pose counts
if no pixel of it is before what the camera sees. The distribution is the sum of the silhouettes of all poses
that count, as if nothing were before them. X-Ray learned to predict such images; here they are computed, so this
is an upper bound on what its network knows.

Deviations: The published grid is every eighth pixel of its own camera, here it is about a centimetre. Eight yaws over
half a turn are the sixteen over a whole one, for a box. Poses that a camera sees in part do not count: whoever sees the
target does not ask. A pixel without depth may hide anything.

`xray_map` is ours, and knows more than X-Ray: the same from above, over the heights of all views.
"""

import numpy as np
from scipy import ndimage

from rfcompass.arrays import BoolArray, FloatArray, read_only
from rfcompass.errors import InputError
from rfcompass.mapping.camera import check_view
from rfcompass.mapping.visual_map import VisualMap
from rfcompass.mapping.xray_kernels import add_silhouettes, inverse_ways
from rfcompass.types.piles import DepthView, VoxelGrid
from rfcompass.types.shapes import positive
from rfcompass.types.workspace import Workspace

YAWS = 8  # over half a turn [XRay2020]
STEP_M = 0.01  # ours
SLACK_M = 0.003  # ours: twice the noise of the depth camera


def xray_occupancy(
    view: DepthView, target_m: FloatArray, table_m: float = 0.0, *, step_m: float = STEP_M, yaws: int = YAWS
) -> FloatArray:
    """Compute X-Ray's distribution for one image.

    Args:
        view: Taken from above.
        target_m: Edges of the target [m], shape (3,).
        table_m: Height of the support plane in the world [m].
        step_m: Distance of neighbouring poses, to a whole number of pixels [m].
        yaws: Yaws over half a turn.

    Returns:
        One value for each pixel; sums to 1, or is 0 everywhere if the target can be nowhere, shape (H, W).

    Raises:
        InputError: If a length or the number of yaws is out of range, or the camera stands below the table.
        CameraBlocked: If the camera sees nothing.
    """
    edges_m, step_m = _checked(target_m, yaws), positive(step_m, "step_m")
    check_view(view, Workspace(np.array([0.0, 0.0, table_m]), (1, 1, 1), 1.0), 0.0)
    height_m = float(view.T_world_camera[2, 3]) - table_m
    stride = max(1, round(step_m * float(view.intrinsics[0, 0]) / height_m))
    total, depth_m = np.zeros(view.depth_m.shape), view.depth_m - SLACK_M
    K, R, eye_m = view.intrinsics, view.T_world_camera[:3, :3], view.T_world_camera[:3, 3]
    for yaw in np.pi * np.arange(yaws) / yaws:
        turn = (float(np.cos(yaw)), float(np.sin(yaw)))
        inverse = inverse_ways(depth_m.shape, (K, R, eye_m), turn)
        for size_m in _lying(edges_m):
            from_middle_m = eye_m - [0.0, 0.0, table_m + size_m[2] / 2]
            add_silhouettes(total, depth_m, inverse, (K, R, from_middle_m), size_m / 2, turn, stride)
    return total / max(float(total.sum()), 1.0)


def xray_map(seen: VisualMap, target_m: FloatArray, *, yaws: int = YAWS) -> VoxelGrid:
    """Compute X-Ray's distribution from above, over the heights that all views together saw; ours, a stronger one.

    Args:
        seen: All views so far.
        target_m: Edges of the target [m], shape (3,).
        yaws: Yaws over half a turn.

    Returns:
        One layer of voxels on the table: the distribution knows no height. Sums to 1, or is 0 everywhere.

    Raises:
        InputError: If a length or the number of yaws is out of range.
    """
    edges_m, table = _checked(target_m, yaws), seen.workspace
    heights_m, total = seen.heights_m(), np.zeros(table.shape[:2])
    for size_m in _lying(edges_m):
        # Half a voxel of the target may stick out: heights are known to no more than that.
        roofed = heights_m >= size_m[2] - table.spacing_m / 2
        for yaw in np.pi * np.arange(yaws) / yaws:
            footprint = _footprint(size_m[:2] / table.spacing_m, float(yaw))
            places = ndimage.binary_erosion(roofed, footprint)
            total += ndimage.convolve(places.astype(np.float64), footprint.astype(np.float64), mode="constant")
    return VoxelGrid(table.origin_m, table.spacing_m, (total / max(float(total.sum()), 1.0))[:, :, None])


def _checked(target_m: FloatArray, yaws: int) -> FloatArray:
    if yaws < 1:
        raise InputError(f"{yaws} yaws: there is no pose", got=yaws)
    return np.array([positive(edge, "target_m") for edge in read_only(target_m, "target_m", (3,))])


def _lying(edges_m: FloatArray) -> tuple[FloatArray, ...]:
    """Edges along x, y and up, for each of three faces that it can lie on."""
    a, b, c = edges_m
    return np.array([a, b, c]), np.array([b, c, a]), np.array([c, a, b])


def _footprint(edges: FloatArray, yaw_rad: float) -> BoolArray:
    """Cells with their middles in a turned rectangle about the middle cell; edges in cells, shape (2n + 1, 2n + 1)."""
    n = int(np.ceil(np.hypot(*edges) / 2))
    x, y = np.mgrid[-n : n + 1, -n : n + 1]
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    trifle = 1e-9
    inside = (np.abs(c * x + s * y) <= edges[0] / 2 + trifle) & (np.abs(c * y - s * x) <= edges[1] / 2 + trifle)
    return np.asarray(inside)
