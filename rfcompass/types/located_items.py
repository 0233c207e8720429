"""A tagged item of known size in a pile, and where its tag was located."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import PartError
from rfcompass.types.fixes import TagFix
from rfcompass.types.record import Record
from rfcompass.types.shapes import positive


@dataclass(frozen=True, slots=True)
class LocatedItem(Record):
    """What the radio knows of one item: a point on its surface, and what kind of thing hangs on it.

    Attributes:
        fix: Where its tag is, in the world frame.
        item: Its name in the part database.
        shortest_m: Shortest edge of its bounding box [m], d_s of [Boroushaki2023].
        longest_m: Longest edge of its bounding box [m], d_l of [Boroushaki2023].
        deformable: True for an item that yields under load.
    """

    fix: TagFix
    item: str
    shortest_m: float
    longest_m: float
    deformable: bool = False

    def __post_init__(self) -> None:
        """Check the lengths."""
        object.__setattr__(self, "shortest_m", positive(self.shortest_m, f"{self.item}.shortest_m"))
        object.__setattr__(self, "longest_m", positive(self.longest_m, f"{self.item}.longest_m"))
        if self.longest_m < self.shortest_m:
            message = f"{self.item}: longest edge {self.longest_m} m is shorter than the shortest, {self.shortest_m} m"
            raise PartError(message, part=self.item, got=(self.shortest_m, self.longest_m))
        if not isinstance(self.deformable, bool | np.bool_):
            raise PartError(f"{self.item}.deformable: {self.deformable!r} is neither True nor False", part=self.item)

    @property
    def epc(self) -> str:
        """EPC of the tag."""
        return self.fix.epc

    @property
    def point_m(self) -> FloatArray:
        """Where the tag is [m], shape (3,)."""
        return self.fix.point_m
