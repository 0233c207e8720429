r"""Where the target is, given all views, tags and the shapes of things; ours, beside the paper's map.

The unknown is the target's pose: its middle p on the grid of voxels, and one of its orientations o, one edge upright
and a yaw. With K_o(v - p) the share of the target that lies in voxel v,

    P(p, o) ∝ exp(-b / ζ) · h(p)^η · c(p)^κ · exp(-Σ_v K_o(v - p) [λ_f F(v) + λ_q Q(v) + λ_t (1 - Q(v)) T(v)]).

F is 1 where a view saw free space, and beyond what is mapped. Elsewhere Q is the probability that the thing seen above
a voxel reaches down into it, exp(-depth / τ), and T that a tagged item fills it (`item_occupancy`). The exponential
stands for "no part of the target is in free space, nothing else is where it is". Neighbouring voxels are far from
independent, so each λ is a number to be fitted, as is how things lie: b is the height of the target's lowest point over
the table; h how much is hidden in the columns about p, blurred by 4 cm; and c = ε + Σ_i exp(-r_i² / 2s²), with r_i the
level distance to the tag of item i, says that things in a pile keep company.

Removals need no term. What was removed is seen to be gone in the views after it, and its tag is no longer among the
items.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from rfcompass.arrays import BoolArray, FloatArray
from rfcompass.errors import InputError, NothingHidden, TargetTooLarge
from rfcompass.mapping.box_kernels import box_kernels, convolve_boxes
from rfcompass.mapping.item_occupancy import items_occupancy
from rfcompass.mapping.view_kernels import FREE, OUTSIDE, SURFACE, UNOBSERVED, StateArray
from rfcompass.mapping.visual_map import VisualMap
from rfcompass.types.items import ItemSize
from rfcompass.types.piles import VoxelGrid
from rfcompass.types.record import Record
from rfcompass.types.tagged_items import TaggedItem
from rfcompass.types.tags import check_distinct
from rfcompass.types.workspace import Workspace

_BLUR_M = 0.04
_LONELY = 0.1  # ε


@dataclass(frozen=True, slots=True, kw_only=True)
class PosteriorRules(Record):
    """Numbers of the formula; fitted to where targets were in 48 piles of seeds below 12 (`docs/posterior_map.md`).

    Attributes:
        free_cost: λ_f.
        seen_cost: λ_q.
        tagged_cost: λ_t.
        thickness_m: τ, mean thickness of what is seen [m].
        height_m: ζ, how fast the chance falls with the height over the table [m].
        hidden_power: η.
        company_power: κ.
        company_m: s [m].
        yaws: Yaws over half a turn.
    """

    free_cost: float = 12.0
    seen_cost: float = 8.0
    tagged_cost: float = 2.0
    thickness_m: float = 0.03
    height_m: float = 0.02
    hidden_power: float = 2.0
    company_power: float = 0.5
    company_m: float = 0.05
    yaws: int = 4

    def __post_init__(self) -> None:
        """Check the ranges: lengths and yaws above 0, all else not below."""
        for name in self.__slots__:
            value = getattr(self, name)
            fine = value > 0 if name.endswith("_m") or name == "yaws" else value >= 0
            if not (np.isfinite(value) and fine):
                raise InputError(f"PosteriorRules.{name}: {value!r} cannot be", name=name, got=value)


def posterior_map(
    seen: VisualMap, target: ItemSize, items: Sequence[TaggedItem] = (), *, rules: PosteriorRules | None = None
) -> VoxelGrid:
    """Say how likely the target's middle is in each voxel.

    Args:
        seen: All views so far, also those after removals.
        target: Its edges; it is rigid, and hidden from all views.
        items: Tagged items that are still in the pile.
        rules: Numbers of the formula.

    Returns:
        Probabilities, which sum to 1.

    Raises:
        DuplicateEpc: If an item stands twice.
        TargetTooLarge: If the target is longer than the workspace's diagonal.
        NothingHidden: If no voxel is unobserved: there is no place for it.
    """
    rules = PosteriorRules() if rules is None else rules
    check_distinct((item.epc for item in items), "posterior_map")
    table = seen.workspace
    _check_target(seen, target)
    block = _block(seen.unobserved, float(target.size_m[0]), table.spacing_m)
    part, states = _part(table, block), seen.states[block]
    free = (states == FREE) | (states == OUTSIDE)
    filled = thing_above(states, table.spacing_m, rules.thickness_m)
    cost = rules.seen_cost * filled
    if items:
        cost += rules.tagged_cost * (1.0 - filled) * items_occupancy(items, part, free)
    prior = _hidden_about(states, table.spacing_m) ** rules.hidden_power
    prior *= _company(part, items, rules.company_m) ** rules.company_power
    mass = _mass(np.where(free, 0.0, rules.free_cost - cost), target, part, rules) * prior[:, :, None]
    values = np.zeros(table.shape)
    values[block] = mass / mass.sum()
    return table.grid(values)


def thing_above(states: StateArray, spacing_m: float, thickness_m: float) -> FloatArray:
    """Probability that the thing seen above a voxel reaches down into it: 1 at its surface, exp(-depth / τ) below.

    Args:
        states: State of each voxel, as in `VisualMap`, shape (X, Y, Z).
        spacing_m: Edge of a voxel [m].
        thickness_m: τ [m].
    """
    heights, beyond = np.arange(states.shape[2]), states.shape[2] + 10**6
    lowest = np.where(states == SURFACE, heights, beyond)
    lowest = np.minimum.accumulate(lowest[:, :, ::-1], axis=2)[:, :, ::-1]
    depth_m = (lowest - heights) * spacing_m
    return np.where(np.isin(states, (SURFACE, UNOBSERVED)), np.exp(-depth_m / thickness_m), 0.0)


def _check_target(seen: VisualMap, target: ItemSize) -> None:
    longest_m, diagonal_m = float(target.size_m[0]), seen.workspace.diagonal_m
    if longest_m > diagonal_m:
        message = f"a target of {longest_m} m cannot lie in a workspace with a diagonal of {diagonal_m:.3f} m"
        raise TargetTooLarge(message, longest_m=longest_m, diagonal_m=diagonal_m)
    if not seen.unobserved.any():
        voxels = int(seen.covered.sum())
        raise NothingHidden(f"all {voxels} voxels that views reached were looked into", voxels=voxels)


def _mass(gain: FloatArray, target: ItemSize, part: Workspace, rules: PosteriorRules) -> FloatArray:
    """Sum over orientations of exp(-b/ζ - costs), shape (X, Y, Z).

    What can be is gained, not what cannot lost: beyond the block all is then as good as free.
    """
    h = part.spacing_m
    kernels = box_kernels(target.size_m, h, rules.yaws)
    heights_m = (np.arange(part.shape[2]) + 0.5) * h
    total = np.zeros(part.shape)
    for kernel, inside in zip(kernels, convolve_boxes(gain, kernels), strict=True):
        lowest_m = heights_m - kernel.half_height_m
        # Half a voxel of the target may be in the table: that is what the grid can tell.
        stands = np.where(lowest_m > -0.6 * h, np.exp(-np.maximum(lowest_m, 0.0) / rules.height_m), 0.0)
        total += np.exp(inside - rules.free_cost) * stands
    return total


def _hidden_about(states: StateArray, spacing_m: float) -> FloatArray:
    """Height of what is unobserved in each column, blurred, as a share of its largest value, shape (X, Y)."""
    columns = (states == UNOBSERVED).sum(axis=2).astype(np.float64)
    blurred = ndimage.gaussian_filter(columns, _BLUR_M / spacing_m, mode="constant")
    return np.asarray(blurred / blurred.max())


def _company(part: Workspace, items: Sequence[TaggedItem], company_m: float) -> FloatArray:
    """C of each column: how near tagged items are, each blurred by the error of its tag, shape (X, Y)."""
    x, y, _ = part.axes_m()
    total = np.full(part.shape[:2], _LONELY)
    for item in items:
        off_m = np.stack(np.meshgrid(x - item.point_m[0], y - item.point_m[1], indexing="ij"), axis=-1)
        spread = item.covariance_m2[:2, :2] + company_m**2 * np.eye(2)
        exponent = np.einsum("xyi,ij,xyj->xy", off_m, np.linalg.inv(spread), off_m)
        total += company_m**2 / np.sqrt(np.linalg.det(spread)) * np.exp(-exponent / 2)
    return total


def _block(unobserved: BoolArray, longest_m: float, spacing_m: float) -> tuple[slice, slice, slice]:
    """Voxels that a target which lies partly in unobserved space can reach, from the table up."""
    margin, spans = int(np.ceil(longest_m / spacing_m)), []
    for axis in range(3):
        along = np.flatnonzero(unobserved.any(axis=tuple(other for other in range(3) if other != axis)))
        first = 0 if axis == 2 else max(int(along[0]) - margin, 0)
        spans.append(slice(first, min(int(along[-1]) + margin + 1, unobserved.shape[axis])))
    x, y, z = spans
    return x, y, z


def _part(table: Workspace, block: tuple[slice, slice, slice]) -> Workspace:
    """A block of a workspace."""
    first = np.array([span.start for span in block])
    shape = (block[0].stop - block[0].start, block[1].stop - block[1].start, block[2].stop - block[2].start)
    return Workspace(table.lower_m + table.spacing_m * first, shape, table.spacing_m)
