"""Proximity of target tags to anchors: the input of every comparison."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import DuplicateEpc, ShapeError
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class ProximityMatrix(Record):
    """How far each target tag seems from each anchor, in the linear units of a meter.

    m[k, i] grows with the distance between target k and anchor i; m = 0 is "same place". NaN means that the
    pair could not be measured.

    Attributes:
        target_epcs: Tags on the part (K).
        anchor_epcs: Tags whose position is known (N).
        m: Proximity of target k to anchor i, shape (K, N).
        anchor_m: Proximity of the anchors to each other, symmetric, NaN on the diagonal, shape (N, N).
        kind: Meter that was used, for example `"phase_l1"`.
        standard_errors: Standard error of `m`, shape (K, N), or None.
    """

    target_epcs: tuple[str, ...]
    anchor_epcs: tuple[str, ...]
    m: FloatArray
    anchor_m: FloatArray
    kind: str
    standard_errors: FloatArray | None = None

    def __post_init__(self) -> None:
        """Freeze the arrays; check sizes, signs, symmetry and that no EPC stands twice."""
        K, N = len(self.target_epcs), len(self.anchor_epcs)
        set_ = object.__setattr__
        set_(self, "target_epcs", tuple(self.target_epcs))
        set_(self, "anchor_epcs", tuple(self.anchor_epcs))
        set_(self, "m", read_only(self.m, "ProximityMatrix.m", (K, N), finite=False))
        set_(self, "anchor_m", read_only(self.anchor_m, "ProximityMatrix.anchor_m", (N, N), finite=False))
        if self.standard_errors is not None:
            errors = read_only(self.standard_errors, "ProximityMatrix.standard_errors", (K, N), finite=False)
            set_(self, "standard_errors", errors)
        self._check_values()

    def _check_values(self) -> None:
        for epcs in (self.target_epcs, self.anchor_epcs):
            for epc in epcs:
                if epcs.count(epc) > 1:
                    raise DuplicateEpc(f"EPC {epc} stands twice in a proximity matrix", epc=epc)
        if np.isinf(self.m).any() or np.isinf(self.anchor_m).any() or (self.m < 0).any() or (self.anchor_m < 0).any():
            raise ShapeError("ProximityMatrix: m must be finite and >= 0, or NaN where missing", name="m")
        if not np.array_equal(self.anchor_m, self.anchor_m.T, equal_nan=True):
            raise ShapeError("ProximityMatrix.anchor_m: must be symmetric", name="anchor_m")
        if not np.isnan(np.diagonal(self.anchor_m)).all():
            raise ShapeError("ProximityMatrix.anchor_m: a tag has no proximity to itself (NaN)", name="anchor_m")
