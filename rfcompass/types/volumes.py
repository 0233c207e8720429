"""Where a surveyor looks for a tag."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, read_only
from rfcompass.errors import ShapeError
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class SearchVolume(Record):
    """Axis-aligned box in the frame of the antenna path; an axis of zero extent is known and not searched.

    Attributes:
        lower_m: Smallest x, y, z [m], shape (3,).
        upper_m: Largest x, y, z [m], shape (3,).
    """

    lower_m: FloatArray
    upper_m: FloatArray

    def __post_init__(self) -> None:
        """Freeze the corners and check their order."""
        object.__setattr__(self, "lower_m", read_only(self.lower_m, "SearchVolume.lower_m", (3,)))
        object.__setattr__(self, "upper_m", read_only(self.upper_m, "SearchVolume.upper_m", (3,)))
        if (self.upper_m < self.lower_m).any():
            raise ShapeError(
                f"SearchVolume: lower corner {self.lower_m.tolist()} m is not below upper {self.upper_m.tolist()} m",
                name="SearchVolume",
            )
        if not self.free_axes.any():
            raise ShapeError("SearchVolume: no axis is left to search", name="SearchVolume")

    @property
    def free_axes(self) -> BoolArray:
        """True for each axis that is searched, shape (3,)."""
        return np.asarray(self.upper_m > self.lower_m)

    def contains(self, points_m: FloatArray) -> BoolArray:
        """True for each point inside or on the border; points (P, 3) [m] in the volume's frame."""
        return np.asarray(((points_m >= self.lower_m) & (points_m <= self.upper_m)).all(axis=1))

    def at_border(self, point_m: FloatArray, tolerance_m: float = 1e-3) -> bool:
        """True if a point [m], shape (3,), lies on the border along an axis that is searched, or within tolerance."""
        room_m = np.minimum(point_m - self.lower_m, self.upper_m - point_m)
        return bool((room_m[self.free_axes] <= tolerance_m).any())
