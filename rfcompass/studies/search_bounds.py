"""What can be known at most, told by the simulator: bounds to judge searches by, no methods."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray
from rfcompass.mapping import VisualMap, posterior_map
from rfcompass.mapping.view_kernels import FREE, UNOBSERVED
from rfcompass.simulation.piles import PileItem
from rfcompass.studies.pile_robot import SimulatedPileRobot
from rfcompass.types import ItemSize, TagFix, VoxelGrid


@dataclass(frozen=True, slots=True)
class TruePlace:
    """The target's place is known.

    Attributes:
        robot: Knows the truth.
    """

    robot: SimulatedPileRobot

    def believe(
        self,
        seen: VisualMap,
        target: ItemSize,  # noqa: ARG002
        fixes: Mapping[str, TagFix],  # noqa: ARG002
        sizes: Sequence[ItemSize],  # noqa: ARG002
    ) -> VoxelGrid:
        """All of it in the voxel that holds the target's middle."""
        table = seen.workspace
        values = np.zeros(table.shape)
        middle_m = self.robot.world.pose(self.robot.scene.target)[:3, 3]
        at = np.clip(table.indices(middle_m[None])[0], 0, np.array(table.shape) - 1)
        values[tuple(at)] = 1.0
        return table.grid(values)


@dataclass(frozen=True, slots=True)
class TrueOthers:
    """Place and shape of all things but the target are known: more than tags on all of them could tell.

    Attributes:
        robot: Knows the truth.
    """

    robot: SimulatedPileRobot

    def believe(
        self,
        seen: VisualMap,
        target: ItemSize,
        fixes: Mapping[str, TagFix],  # noqa: ARG002
        sizes: Sequence[ItemSize],  # noqa: ARG002
    ) -> VoxelGrid:
        """The posterior where no view looked and nothing else lies; what is seen says no more about what is below."""
        world, table = self.robot.world, seen.workspace
        hidden = seen.unobserved.copy()
        middles_m = np.stack(np.meshgrid(*table.axes_m(), indexing="ij"), axis=-1)[hidden]
        free = np.ones(len(middles_m), dtype=bool)
        for item in world.items:
            if item.number != self.robot.scene.target:
                for T in world.panel_poses(item.number):
                    free &= ~inside(item, T, middles_m)
        hidden[hidden] = free
        if not hidden.any():  # thinner than the grid can tell
            return posterior_map(seen, target)
        return posterior_map(VisualMap(table, np.where(hidden, UNOBSERVED, FREE).astype(np.uint8)), target)


def inside(item: PileItem, T: FloatArray, points_m: FloatArray) -> BoolArray:
    """Which points lie in an item, or in one of its panels, at a pose; points (P, 3) in the world [m], answer (P,)."""
    half_m = item.panel_size_m / 2
    local_m = np.abs((points_m - T[:3, 3]) @ T[:3, :3])
    if item.kind == "ellipsoid":
        return np.asarray(((local_m / half_m) ** 2).sum(axis=1) <= 1.0)
    level_m = np.hypot(local_m[:, 0], local_m[:, 1])
    if item.kind == "cylinder":
        return np.asarray((level_m <= half_m[0]) & (local_m[:, 2] <= half_m[2]))
    if item.kind == "capsule":
        return np.asarray(np.hypot(level_m, np.maximum(local_m[:, 2] - (half_m[2] - half_m[0]), 0.0)) <= half_m[0])
    return np.asarray((local_m <= half_m).all(axis=1))
