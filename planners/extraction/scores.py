r"""How much taking an object is worth [Boroushaki2023], Eq. 4, and whether it can be grasped, Eq. 5.

    s_i = Σ_{(x,y) ∈ m_i} Σ_{z=0}^{z_i} γ^((z_i - z) / 0.025 m) p(x, y, z)        g_i = max_{(x,y) ∈ m_i} g(x, y)

    take the i with the largest s_i ⌈g_i - τ⌉

m_i are the columns under mask i, p the occupancy map, and γ discounts what lies deep, for an object has only so much
thickness. z_i is "the maximum z under the ith mask": one number for each mask, read literally. So what lies under the
low end of a slanting object is discounted by the height of its high end. The reading `per_column` takes for z_i
the height of the surface in each column.

The ceiling is 1 for g_i > τ and 0 for all else. The prose says what is meant: masks with g_i > τ are compared by s_i,
"if no high probability grasps are available", all are. The formula itself then leaves everything at 0.
"""

import numpy as np

from planners.extraction.projection import MaskColumns, check_same_columns
from rfcompass.arrays import BoolArray, FloatArray, IntArray
from rfcompass.errors import InputError
from rfcompass.types import VoxelGrid

LAYER_M = 0.025  # [Boroushaki2023], Eq. 4
GAMMA, TAU = 0.7, 0.5  # ours; our text of the paper lacks its footnotes, where they stand


def mask_scores(
    grid: VoxelGrid, columns: MaskColumns, labels: IntArray, gamma: float = GAMMA, *, per_column: bool = False
) -> FloatArray:
    """Compute s_i, Eq. 4.

    Args:
        grid: The map p.
        columns: The columns under each mask.
        labels: Which masks, at least one, shape (K,).
        gamma: Discount for each 2.5 cm, in (0, 1].
        per_column: Read z_i as the height of each column's surface.

    Returns:
        One score for each label, shape (K,).

    Raises:
        InputError: If γ is out of range, or there is no label.
        ShapeError: If the columns are those of another map.
    """
    if not 0 < gamma <= 1:
        raise InputError(f"gamma {gamma} is not in (0, 1]", got=gamma)
    check_same_columns(grid, columns)
    owner, group = columns_by_label(columns, labels)
    tops_m = columns.surface_m[owner]
    if not per_column:
        highest_m = np.full(len(labels), -np.inf)
        np.maximum.at(highest_m, group, tops_m)
        tops_m = highest_m[group]
    heights_m = grid.origin_m[2] + grid.spacing_m * np.arange(grid.values.shape[2])
    below_m = tops_m[:, None] - heights_m
    # A trifle of a voxel, so that rounding does not decide on a voxel whose middle is as high as the surface.
    under = below_m > -1e-6 * grid.spacing_m
    discount = np.where(under, gamma ** (np.maximum(below_m, 0.0) / LAYER_M), 0.0)
    return np.asarray(np.bincount(group, (discount * grid.values[owner]).sum(axis=1), len(labels)), dtype=np.float64)


def columns_by_label(columns: MaskColumns, labels: IntArray) -> tuple[BoolArray, IntArray]:
    """Columns that belong to any of the labels, shape (X, Y), and the number of its label for each of them, (M,).

    Raises:
        InputError: If there is no label.
    """
    if not len(labels):
        raise InputError("labels: there is no mask to score", got=0)
    order = np.argsort(labels)
    place = np.searchsorted(labels[order], columns.owner).clip(max=len(labels) - 1)
    known = labels[order][place] == columns.owner
    return known, order[place[known]]


def passes(quality: FloatArray, tau: float = TAU) -> BoolArray:
    """Tell which masks are compared: those with g_i > τ, all if there is none; quality shape (K,)."""
    good = quality > tau
    return good if good.any() else np.ones_like(good)


def gated_literally(scores: FloatArray, quality: FloatArray, tau: float = TAU) -> FloatArray:
    """s_i ⌈g_i - τ⌉ as printed, shape (K,); with no g_i > τ all are 0, and a score below 0 loses to a 0."""
    return np.asarray(scores * np.ceil(quality - tau) + 0.0)
