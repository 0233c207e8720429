"""Voxel maps as layers of a meshcat scene."""

from rfcompass.types.piles import VoxelGrid
from rfcompass.viz.overlay import Layer
from rfcompass.viz.robot_scene import RobotScene
from rfcompass.viz.voxel_points import voxel_points

MOST_POINTS = 40_000  # ours: 1.3 MB of a page


def draw_voxels(
    scene: RobotScene, node: str, name: str, grid: VoxelGrid, *, share: float = 0.2, shown: bool = True
) -> Layer:
    """Draw a map as a cloud of points, blue below zero and red above.

    Args:
        scene: Where to draw.
        node: Path of the node under `voxels`, for example `"C"`.
        name: What the legend says.
        grid: The map.
        share: Leave out what is smaller than this share of the largest size.
        shown: False to hide it until asked for.

    Returns:
        Row of the legend; its count has all voxels that are large enough, of which the largest 40,000 are drawn.
    """
    points = voxel_points(grid, share, MOST_POINTS)
    scene.draw_points(f"voxels/{node}", points.points_m, points.rgb, 0.8 * grid.spacing_m)
    return Layer(name, f"voxels/{node}", None, points.count, shown)
