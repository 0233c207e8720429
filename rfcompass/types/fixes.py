"""Where a tag is, as located from its own reads."""

from dataclasses import dataclass, field

from rfcompass.arrays import FloatArray, read_only
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class TagFix(Record):
    """Position of one tag in the antenna frame, with a box that says how sure the method is.

    Attributes:
        epc: EPC of the tag.
        point_m: Estimated position [m], shape (3,).
        box_m: Extent along x, y, z [m], shape (3,): for SAR of the region whose power exceeds 0.84 of the peak
            [Boroushaki2023], section 4.2; for the hyperbolic fit ± 4 standard deviations.
        confident: True if the box is smaller than its threshold along every axis and not clipped: no other place
            is left by the reads. Says nothing about the bias of reflections.
        clipped: True if the box touches the border of the search volume, so that its extent is a lower bound.
        method: Name of the method, for example `"sar"`.
        residual_rad: Root mean square phase residual at the fix [rad]; None where a method has none.
    """

    epc: str
    point_m: FloatArray
    box_m: FloatArray
    confident: bool
    clipped: bool = False
    method: str = field(default="sar")
    residual_rad: float | None = None

    def __post_init__(self) -> None:
        """Freeze and check the arrays."""
        object.__setattr__(self, "point_m", read_only(self.point_m, f"TagFix[{self.epc}].point_m", (3,)))
        object.__setattr__(self, "box_m", read_only(self.box_m, f"TagFix[{self.epc}].box_m", (3,)))
