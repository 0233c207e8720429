"""Kernels of the target: which share of it would lie in each voxel about its middle [Boroushaki2023], section 4.4."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import InputError, ShapeError
from rfcompass.mapping.readings import reading_called
from rfcompass.types.record import Record
from rfcompass.types.shapes import positive

YAWS = 12  # ours: 15 degrees apart, over half a turn
_FINE = 5  # samples along the edge of a voxel, for the footprint of a box


@dataclass(frozen=True, slots=True)
class TargetKernel(Record):
    """A kernel about the target's middle.

    Attributes:
        values: Weight of each voxel; the middle one is the target's middle, shape (2a + 1, 2b + 1, 2c + 1).
        spacing_m: Edge of a voxel [m].
        longest_m: Longest edge of the target [m].
    """

    values: FloatArray
    spacing_m: float
    longest_m: float

    def __post_init__(self) -> None:
        """Freeze the values; there is a middle voxel."""
        object.__setattr__(self, "values", read_only(self.values, "TargetKernel.values", (None, None, None)))
        object.__setattr__(self, "spacing_m", positive(self.spacing_m, "TargetKernel.spacing_m"))
        object.__setattr__(self, "longest_m", positive(self.longest_m, "TargetKernel.longest_m"))
        if any(count % 2 == 0 for count in self.values.shape):
            message = f"TargetKernel.values: {self.values.shape} has no middle voxel"
            raise ShapeError(message, name="values", got=self.values.shape)


def gaussian_target(
    shortest_m: float, longest_m: float, spacing_m: float, *, reading: str = "consistent"
) -> TargetKernel:
    """The paper's kernel [Boroushaki2023], Eq. 3: exp(-‖q‖² / (2 d_s²)) within ‖q‖ ≤ d_l / 2.

    Here d_s is a standard deviation, and the ball ends at half the longest edge: for most targets that is nearly
    a flat ball. The map's scale means nothing, so the reading `consistent` makes the weights sum to 1; then the map
    is the share of the target that would lie in unobserved space. The literal readings keep the factor
    1 / (d_s √(2π)), the printed ones also the growing exponent and the mask ‖q‖² ≤ d_l / 2.

    Args:
        shortest_m: d_s [m].
        longest_m: d_l [m].
        spacing_m: Edge of a voxel [m].
        reading: See `rfcompass.mapping.readings`.

    Raises:
        InputError: If a length is out of range or the reading unknown.
    """
    d_s, d_l, h = (positive(length, "length") for length in (shortest_m, longest_m, spacing_m))
    if d_l < d_s:
        raise InputError(f"longest edge {d_l} m is shorter than the shortest, {d_s} m", got=(d_s, d_l))
    unit_m, printed = reading_called(reading)
    reach_m = np.sqrt(d_l / 2 * unit_m) if printed and unit_m is not None else d_l / 2
    n = int(reach_m / h + 1e-9)
    q2 = (h * np.arange(-n, n + 1)) ** 2
    r2 = q2[:, None, None] + q2[:, None] + q2
    values = np.exp((r2 if printed else -r2) / (2 * d_s**2)) * (r2 <= reach_m**2 * (1 + 1e-12))
    scale = 1.0 / values.sum() if unit_m is None else 1.0 / (d_s / unit_m * np.sqrt(2 * np.pi))
    return TargetKernel(values * scale, h, d_l)


def box_target(
    size_m: FloatArray,
    spacing_m: float,
    *,
    yaws: int = YAWS,
    face_weights: tuple[float, float, float] = (1.0, 1.0, 1.0),
) -> TargetKernel:
    """Kernel of a box that lies on any of its six faces, turned by any yaw; ours, beside the paper's Gaussian.

    The mean over all these orientations of the share of the box in each voxel. Opposite faces, and turns of half a
    circle, give the same box, so three faces and yaws over half a turn are all there are. A box wedged at a slant is
    not among them.

    Args:
        size_m: Edges of the box [m], shape (3,).
        spacing_m: Edge of a voxel [m].
        yaws: Number of yaws, evenly spread over half a turn.
        face_weights: How often edge 1, 2 or 3 stands upright; any scale.

    Raises:
        InputError: If a length, the number of yaws or a weight is out of range.
    """
    edges_m = np.array([positive(edge, "size_m") for edge in read_only(size_m, "size_m", (3,))])
    h, weights = positive(spacing_m, "spacing_m"), read_only(face_weights, "face_weights", (3,))
    if yaws < 1 or (weights < 0).any() or not weights.sum() > 0:
        raise InputError(f"{yaws} yaws, face weights {weights.tolist()}: there is nothing to average", yaws=yaws)
    total = np.zeros((1, 1, 1))
    for up in np.flatnonzero(weights):
        a_m, b_m = np.delete(edges_m, up)
        turns = np.pi * np.arange(yaws) / yaws
        footprint = sum((_footprint(a_m, b_m, yaw, h) for yaw in turns), start=np.zeros((1, 1))) / yaws
        lying = footprint[:, :, None] * _profile(float(edges_m[up]), h)
        total = _padded_sum(total, lying * weights[up] / weights.sum())
    return TargetKernel(total, h, float(edges_m.max()))


def _footprint(a_m: float, b_m: float, yaw_rad: float, h: float) -> FloatArray:
    """Share of an a x b rectangle in each cell of a square that holds it at any yaw, shape (2n + 1, 2n + 1)."""
    n = int(np.ceil(np.hypot(a_m, b_m) / 2 / h + 0.5))
    fine = (np.arange((2 * n + 1) * _FINE) - ((2 * n + 1) * _FINE - 1) / 2) * (h / _FINE)
    x, y = fine[:, None], fine[None, :]
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    trifle = 1e-9 * h  # a sample on the border is inside at every yaw, whatever the rounding
    inside = (np.abs(c * x + s * y) <= a_m / 2 + trifle) & (np.abs(c * y - s * x) <= b_m / 2 + trifle)
    cells = inside.reshape(2 * n + 1, _FINE, 2 * n + 1, _FINE).sum(axis=(1, 3)).astype(np.float64)
    # A rectangle thinner than the samples lies in the middle cell.
    cells[n, n] += cells.sum() == 0
    return np.asarray(cells / cells.sum())


def _profile(edge_m: float, h: float) -> FloatArray:
    """Share of an interval about 0 in each cell, shape (2n + 1,)."""
    n = int(np.ceil(edge_m / 2 / h + 0.5))
    borders = (np.arange(-n, n + 2) - 0.5) * h
    covered = np.clip(borders, -edge_m / 2, edge_m / 2)
    return np.asarray(np.diff(covered) / edge_m)


def _padded_sum(one: FloatArray, other: FloatArray) -> FloatArray:
    """Add two kernels about a common middle."""
    shape = np.maximum(one.shape, other.shape)
    total = np.zeros(tuple(shape))
    for kernel in (one, other):
        low = (shape - kernel.shape) // 2
        total[tuple(slice(start, start + count) for start, count in zip(low, kernel.shape, strict=True))] += kernel
    return total
