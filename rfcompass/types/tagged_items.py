"""An item of a pile whose tag was located, with all its edges and how far its place can be trusted."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import ShapeError
from rfcompass.types.items import ItemSize
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class TaggedItem(Record):
    """What the radio and the database know of one item together.

    Attributes:
        size: Its edges; its EPC is that of the tag.
        point_m: Where the tag is, in the world frame [m], shape (3,).
        covariance_m2: Covariance of that place [m²], shape (3, 3); zero for a place that is known exactly.
    """

    size: ItemSize
    point_m: FloatArray
    covariance_m2: FloatArray

    def __post_init__(self) -> None:
        """Freeze; the covariance must be one."""
        object.__setattr__(self, "point_m", read_only(self.point_m, "TaggedItem.point_m", (3,)))
        covariance = read_only(self.covariance_m2, "TaggedItem.covariance_m2", (3, 3))
        object.__setattr__(self, "covariance_m2", covariance)
        if self.size.epc is None:
            raise ShapeError(f"TaggedItem: {self.size.name} has no tag", name="size")
        lowest = float(np.linalg.eigvalsh((covariance + covariance.T) / 2).min())
        if np.abs(covariance - covariance.T).max() > 1e-9 or lowest < -1e-12:
            message = f"TaggedItem.covariance_m2 of {self.size.name}: not symmetric, or a variance of {lowest} m²"
            raise ShapeError(message, name="covariance_m2")

    @property
    def epc(self) -> str:
        """EPC of the tag."""
        return str(self.size.epc)
