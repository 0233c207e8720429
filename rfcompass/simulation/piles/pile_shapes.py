"""A pile as other parts of the software take it: solids in the radio channel, shapes to draw."""

import numpy as np

from rfcompass.simulation.piles.items import PileItem
from rfcompass.simulation.piles.materials import PILE_MATERIALS
from rfcompass.simulation.piles.world import PileWorld
from rfcompass.types.placed_shape import PlacedShape
from rfcompass.types.scene import Obstacle, Scene

_TABLE_M = (1.4, 1.0, 0.01)
_TABLE_RGBA = (0.69, 0.62, 0.52, 1.0)


def radio_scene(world: PileWorld, T_scene_world: np.ndarray | None = None) -> Scene:
    """Everything in the pile as obstacles of the radio channel, in free space.

    Capsules and ellipsoids become cylinders and boxes of the same volume.

    Args:
        world: The pile.
        T_scene_world: Where the table's frame is in the scene, homogeneous, shape (4, 4); the same frame if None.
    """
    T = np.eye(4) if T_scene_world is None else np.asarray(T_scene_world)
    obstacles = tuple(
        Obstacle(f"{item.name}_{panel}", item.radio_shape, T @ T_world_panel, item.material)
        for item in world.items
        for panel, T_world_panel in enumerate(world.panel_poses(item.number))
    )
    used = {item.material for item in world.items}
    return Scene("pile", None, obstacles, {name: PILE_MATERIALS[name] for name in sorted(used)})


def drawn_shapes(world: PileWorld, *, opacity: float = 1.0, solid: tuple[int, ...] = ()) -> list[PlacedShape]:
    """Table and items as shapes to draw.

    Args:
        world: The pile.
        opacity: Of the items; 1 hides what is behind.
        solid: Numbers of items that hide what is behind all the same, such as the target.
    """
    T = np.eye(4)
    T[2, 3] = -_TABLE_M[2] / 2
    shapes = [PlacedShape("table", "box", np.array(_TABLE_M), T, np.array(_TABLE_RGBA))]
    for item in world.items:
        rgba = np.array([*(np.array(item.rgb) / 255), 1.0 if item.number in solid else opacity])
        for panel, T_world_panel in enumerate(world.panel_poses(item.number)):
            parts = _parts(item)
            for index, (kind, dimensions_m, offset_m) in enumerate(parts):
                T_world_part = T_world_panel.copy()
                T_world_part[:3, 3] += offset_m * T_world_panel[:3, 2]
                link = f"{item.name}_{panel}_{index}"
                shapes.append(PlacedShape(link, kind, np.array(dimensions_m), T_world_part, rgba))
    return shapes


def _parts(item: PileItem) -> list[tuple[str, list[float], float]]:
    """Primitive shapes of an item or a panel: kind, dimensions [m], and shift along z [m]."""
    size_m = item.panel_size_m
    radius_m, length_m = float(size_m[0] / 2), float(size_m[2])
    if item.kind == "cylinder":
        return [("cylinder", [radius_m, length_m], 0.0)]
    if item.kind == "ellipsoid":
        return [("ellipsoid", (size_m / 2).tolist(), 0.0)]
    if item.kind == "capsule":
        straight_m = length_m - 2 * radius_m
        ends = [("sphere", [radius_m], sign * straight_m / 2) for sign in (-1, 1)]
        return [("cylinder", [radius_m, straight_m], 0.0), *ends]
    return [("box", size_m.tolist(), 0.0)]
