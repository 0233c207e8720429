"""Blocks on a table with a map under them and made-up grasps: what an extraction policy is asked."""

from dataclasses import dataclass

import numpy as np
from box_scenes import Block, looking_down, see

from rfcompass.types import DepthView, GraspMaps, InstanceMasks, VoxelGrid

THREE = (
    Block((-0.13, 0.02, 0.03), (0.14, 0.10, 0.06)),
    Block((0.06, -0.03, 0.02), (0.12, 0.08, 0.04), 0.4),
    Block((0.2, 0.08, 0.04), (0.06, 0.06, 0.08)),
)


@dataclass(frozen=True)
class Question:
    """What `choose` takes, in its order."""

    grid: VoxelGrid
    view: DepthView
    masks: InstanceMasks
    grasps: GraspMaps

    def parts(self):
        return self.grid, self.view, self.masks, self.grasps


def question(blocks=THREE, mass=None, quality=(0.8, 0.7, 0.6), shape=(120, 160), height_m=0.7, noise=0):
    """Ask about blocks seen from above; mass and quality of each: at its middle column, at all its pixels."""
    view, labels = see(blocks, looking_down(height_m=height_m), shape=shape)
    values = np.random.default_rng(noise).uniform(0, 1e-5, (60, 40, 12))
    for block, weight in zip(blocks, mass or [1.0] * len(blocks), strict=True):
        i, j = np.floor((np.array(block.centre_m[:2]) - [-0.3, -0.2]) / 0.01 + 1e-9).astype(int)
        values[i, j, 0] += weight
    grid = VoxelGrid(np.array([-0.295, -0.195, 0.005]), 0.01, values)
    return Question(grid, view, InstanceMasks(labels), grasps_of(labels, quality))


def grasps_of(labels, quality):
    """The same grasp all over each object, best at its first pixel, none on the table."""
    image = np.array([0.0, *quality])[labels]
    width = np.where(labels > 0, 0.05, 0.0)
    return GraspMaps(image, 0.3 * labels, width, 0.2 * width)
