"""What a database knows about an item in a pile: its size, whether it gives way, and its tag."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import ShapeError
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class ItemSize(Record):
    """Dimensions of an item, as its maker states them [Boroushaki2023], Sec. 4.3.

    Says nothing about where the item is.

    Attributes:
        name: What the item is called.
        size_m: Edges of its bounding box when it lies flat, longest first [m], shape (3,).
        deformable: True for cloth and the like, whose box changes in a pile.
        epc: EPC of the tag on it; None for an item without one, such as an untagged target.
    """

    name: str
    size_m: FloatArray
    deformable: bool = False
    epc: str | None = None

    def __post_init__(self) -> None:
        """Freeze the edges, longest first; check that they are lengths."""
        size_m = read_only(self.size_m, "ItemSize.size_m", (3,))
        if not (size_m > 0).all():
            raise ShapeError(f"ItemSize.size_m: {size_m.tolist()} m are not three lengths above 0", name="size_m")
        object.__setattr__(self, "size_m", read_only(np.sort(size_m)[::-1], "ItemSize.size_m", (3,)))

    @property
    def shortest_m(self) -> float:
        """Shortest edge, d_s [m]."""
        return float(self.size_m[2])

    @property
    def longest_m(self) -> float:
        """Longest edge, d_l [m]."""
        return float(self.size_m[0])
