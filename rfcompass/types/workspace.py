"""The part of a table that is mapped, cut into voxels."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, IntArray, read_only
from rfcompass.errors import ShapeError
from rfcompass.types.piles import VoxelGrid
from rfcompass.types.record import Record

MOST_VOXELS = 100_000_000  # ours: one map of that size takes 0.8 GB


@dataclass(frozen=True, slots=True)
class Workspace(Record):
    """A box that stands on the table, in the world frame, z up: what lies under the table is no part of it.

    Attributes:
        lower_m: Its lowest corner [m], shape (3,); z is the height of the table top.
        shape: Number of voxels along x, y and z.
        spacing_m: Edge of a voxel [m].
    """

    lower_m: FloatArray
    shape: tuple[int, int, int]
    spacing_m: float

    def __post_init__(self) -> None:
        """Freeze the corner; check that there are voxels, and not too many."""
        object.__setattr__(self, "lower_m", read_only(self.lower_m, "Workspace.lower_m", (3,)))
        object.__setattr__(self, "shape", tuple(int(count) for count in self.shape))
        if not (np.isfinite(self.spacing_m) and self.spacing_m > 0):
            raise ShapeError(f"Workspace.spacing_m: {self.spacing_m} is not a length above 0", name="spacing_m")
        if len(self.shape) != 3 or min(self.shape) < 1:
            raise ShapeError(f"Workspace.shape: {self.shape} is not three counts of at least 1", name="shape")
        if (voxels := int(np.prod(self.shape, dtype=np.float64))) > MOST_VOXELS:
            message = f"Workspace: {voxels:.3g} voxels; more than {MOST_VOXELS:.0e} are refused"
            raise ShapeError(message, name="shape", got=voxels, most=MOST_VOXELS)

    @classmethod
    def between(cls, lower_m: FloatArray, upper_m: FloatArray, spacing_m: float = 0.01) -> "Workspace":
        """Cover the box between two corners [m], shape (3,) each; the last voxels may reach beyond the upper one.

        Raises:
            ShapeError: If the upper corner is not above the lower one, or the voxels would be too many.
        """
        low, high = (read_only(corner, "Workspace", (3,)) for corner in (lower_m, upper_m))
        if not (high > low).all():
            message = f"Workspace: upper corner {high.tolist()} m is not above {low.tolist()} m"
            raise ShapeError(message, name="upper_m")
        if not spacing_m > 0:
            raise ShapeError(f"Workspace.spacing_m: {spacing_m} is not a length above 0", name="spacing_m")
        x, y, z = np.ceil((high - low) / spacing_m - 1e-9).clip(1)
        return cls(low, (int(x), int(y), int(z)), spacing_m)

    @property
    def upper_m(self) -> FloatArray:
        """Highest corner [m], shape (3,)."""
        return self.lower_m + self.spacing_m * np.array(self.shape)

    @property
    def origin_m(self) -> FloatArray:
        """Centre of the first voxel [m], shape (3,)."""
        return self.lower_m + self.spacing_m / 2

    @property
    def table_m(self) -> float:
        """Height of the table top in the world frame [m]."""
        return float(self.lower_m[2])

    @property
    def diagonal_m(self) -> float:
        """Longest distance between two points of it [m]."""
        return float(np.linalg.norm(self.spacing_m * np.array(self.shape)))

    def axes_m(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Centres of the voxels along x, y and z [m], shapes (X,), (Y,), (Z,)."""
        x, y, z = (low + self.spacing_m * np.arange(n) for low, n in zip(self.origin_m, self.shape, strict=True))
        return x, y, z

    def indices(self, points_m: FloatArray) -> IntArray:
        """Voxel that each point lies in, also beyond the border; points (P, 3) [m], answer (P, 3)."""
        return np.floor((points_m - self.lower_m) / self.spacing_m).astype(np.int64)

    def contains(self, points_m: FloatArray) -> BoolArray:
        """True for each point inside; points (P, 3) [m]."""
        voxels = self.indices(points_m)
        return np.asarray(((voxels >= 0) & (voxels < np.array(self.shape))).all(axis=1))

    def grid(self, values: FloatArray) -> VoxelGrid:
        """Give each voxel a value, shape (X, Y, Z).

        Raises:
            ShapeError: If there is not one value for each voxel.
        """
        if values.shape != self.shape:
            message = f"Workspace: {values.shape} values for {self.shape} voxels"
            raise ShapeError(message, name="values", expected=self.shape, got=values.shape)
        return VoxelGrid(self.origin_m, self.spacing_m, values)
