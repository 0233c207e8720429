"""How good is a map of where something is? Judged by the place where it truly was."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray
from rfcompass.errors import ShapeError
from rfcompass.types.piles import VoxelGrid

# Ours: this share of every map is spread evenly over all voxels, so that a miss costs bits and not everything.
FLOOR = 0.01


@dataclass(frozen=True, slots=True)
class MapQuality:
    """A map against the truth.

    Attributes:
        bits: -log2 of the probability of the true voxel: what it takes to say where it was, knowing the map.
        rank: Share of the voxels in question that are likelier than the true one, ties by half; 0 is best.
    """

    bits: float
    rank: float


def map_quality(grid: VoxelGrid, true_m: FloatArray, among: BoolArray, floor: float = FLOOR) -> MapQuality:
    """Judge a map, of any scale, by the true place.

    p = (1 - f) · m / Σ m + f / N over all N voxels, m the map without what is below 0; evenly if nothing is left.

    Args:
        grid: The map.
        true_m: True place [m], shape (3,).
        among: Voxels that ranks are counted over, the true one always with them, shape (X, Y, Z).
        floor: f.

    Raises:
        ShapeError: If the true place is outside the map, or `among` is over other voxels.
    """
    if among.shape != grid.values.shape:
        raise ShapeError(f"among: {among.shape}, the map {grid.values.shape}", name="among", got=among.shape)
    place = np.floor((np.asarray(true_m) - grid.origin_m) / grid.spacing_m + 0.5).astype(np.int64)
    if (place < 0).any() or (place >= np.array(grid.values.shape)).any():
        raise ShapeError(f"true_m: {np.asarray(true_m).tolist()} m is outside the map", name="true_m", got=true_m)
    x, y, z = place
    mass = np.maximum(grid.values, 0.0)
    total = float(mass.sum())
    share = float(mass[x, y, z]) / total if total > 0 else 1.0 / mass.size
    counted = among.copy()
    counted[x, y, z] = True
    others, own = grid.values[counted], grid.values[x, y, z]
    rank = float((others > own).mean() + (others == own).mean() / 2)
    return MapQuality(float(-np.log2((1 - floor) * share + floor / mass.size)), rank)
