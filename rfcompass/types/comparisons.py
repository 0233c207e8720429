"""Answers to "which of two anchors is the target nearer to?", and the half-spaces they cut."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, IntArray, read_only
from rfcompass.errors import InputError, ShapeError
from rfcompass.geometry.half_spaces import change_frame
from rfcompass.geometry.pose2 import Pose2
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class Comparisons(Record):
    """A list of comparisons: target k is nearer to anchor i than to anchor j [Wang2013], section 4.1.

    Attributes:
        target: Index k of the part tag, shape (M,).
        nearer: Index i of the anchor it is nearer to, shape (M,).
        farther: Index j of the other anchor, shape (M,).
        margin: 1 - m_ki / m_kj, NaN where a source has no proximities, shape (M,).
        abstained: Number of pairs that gave no answer: one of the two proximities is missing, or both are equal.
    """

    target: IntArray
    nearer: IntArray
    farther: IntArray
    margin: FloatArray
    abstained: int = 0

    def __post_init__(self) -> None:
        """Freeze the arrays; refuse negative indices, a pair of one anchor, and margins outside [0, 1]."""
        M = np.size(self.target)
        for name in ("target", "nearer", "farther"):
            values = read_only(getattr(self, name), f"Comparisons.{name}", (M,), np.int64)
            if (values < 0).any():
                raise ShapeError(f"Comparisons.{name}: index {int(values.min())} is negative", name=name)
            object.__setattr__(self, name, values)
        margin = read_only(self.margin, "Comparisons.margin", (M,), finite=False)
        if ((margin < 0) | (margin > 1)).any():
            raise ShapeError("Comparisons.margin: must lie in [0, 1], or be NaN", name="margin")
        object.__setattr__(self, "margin", margin)
        if (self.nearer == self.farther).any():
            row = int(np.flatnonzero(self.nearer == self.farther)[0])
            raise InputError(f"comparison {row} compares anchor {int(self.nearer[row])} with itself", row=row)

    def __len__(self) -> int:
        """Number of comparisons M."""
        return int(self.target.size)

    @property
    def has_margins(self) -> bool:
        """True if every comparison knows its margin, so that an epsilon can choose among them."""
        return len(self) > 0 and not bool(np.isnan(self.margin).any())

    def used_at(self, epsilon: float) -> BoolArray:
        """Comparisons that m_ki <= (1 - ε) m_kj keeps, shape (M,); those without margin are always kept."""
        return np.asarray(~(self.margin < epsilon - 1e-12))

    def take(self, rows: BoolArray | IntArray) -> "Comparisons":
        """Return the chosen comparisons, in order."""
        return Comparisons(
            self.target[rows], self.nearer[rows], self.farther[rows], self.margin[rows], self.abstained
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class HalfSpaces(Record):
    """Rows A z <= b over z = [x0, y0] or z' = [x0, y0, cos θ, sin θ] of the part [Wang2013], Eq. 3 and 7.

    Attributes:
        A: Row normals, shape (M, 2) or (M, 4).
        b: Right-hand sides, shape (M,).
        provenance: Index of the comparison that made each row, shape (M,).
    """

    A: FloatArray
    b: FloatArray
    provenance: IntArray

    def __post_init__(self) -> None:
        """Freeze the arrays and check that they belong together."""
        M, width = np.shape(self.A) if np.ndim(self.A) == 2 else (0, 0)
        if width not in (2, 4):
            raise ShapeError(f"HalfSpaces.A: expected shape (M, 2) or (M, 4), got {np.shape(self.A)}", name="A")
        object.__setattr__(self, "A", read_only(self.A, "HalfSpaces.A", (M, width)))
        object.__setattr__(self, "b", read_only(self.b, "HalfSpaces.b", (M,)))
        object.__setattr__(self, "provenance", read_only(self.provenance, "HalfSpaces.provenance", (M,), np.int64))

    def __len__(self) -> int:
        """Number of rows M."""
        return int(self.b.size)

    def in_frame(self, T_target_rows: Pose2) -> "HalfSpaces":
        """Express the rows in another frame [Wang2013], Eq. 9-12; see `geometry.half_spaces.change_frame`."""
        A, b = change_frame(self.A, self.b, T_target_rows)
        return HalfSpaces(A, b, self.provenance)

    def satisfied(self, z: FloatArray, tolerance: float = 0.0) -> BoolArray:
        """Tell which rows A z <= b + tolerance hold, shape (M,)."""
        return np.asarray(self.A @ np.asarray(z) <= self.b + tolerance)
