"""What both solvers see of a partition problem: unit rows over scaled unknowns.

A ball can only be fitted where all axes mean lengths, so y = [x0 - xc, y0 - yc, S c, S s] with S = 0.2 m and
(xc, yc) the middle of the bounds. The disc c² + s² <= 1 becomes a disc of radius S. The largest ball is fitted
inside the regular 64-gon around that disc, which makes it a linear program; the analytic centre takes the disc.
"""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.localization.problem import ORIENTATION_SCALE_M, PartitionProblem

POLYGON_SIDES = 64
_SIDE_RAD = np.arange(POLYGON_SIDES) * (2.0 * np.pi / POLYGON_SIDES)
_SIDES = np.column_stack([np.zeros((POLYGON_SIDES, 2)), np.cos(_SIDE_RAD), np.sin(_SIDE_RAD)])


@dataclass(frozen=True, slots=True)
class ScaledRows:
    """Rows G y <= h of a problem: comparisons and box, every row of unit length.

    Attributes:
        G: Rows over y, shape (M, n).
        h: Right-hand sides [m], shape (M,).
        middle: Middle of the bounds, zero for c and s, shape (n,).
        scale: Length of one unit of each unknown: 1 for x0 and y0, S for c and s, shape (n,).
    """

    G: FloatArray
    h: FloatArray
    middle: FloatArray
    scale: FloatArray

    @property
    def disc(self) -> float:
        """Radius of the disc of (S c, S s) [m]; 0 if c and s are no unknowns."""
        return ORIENTATION_SCALE_M if self.scale.size == 4 else 0.0

    def to_metric(self, y: FloatArray) -> FloatArray:
        """[x0, y0] or [x0, y0, c, s] of a scaled point, shape (n,)."""
        return np.asarray(self.middle + y / self.scale)

    def with_polygon(self) -> tuple[FloatArray, FloatArray]:
        """The rows and, with c and s, the sides of the 64-gon around the disc: G and h."""
        if not self.disc:
            return self.G, self.h
        return np.vstack([self.G, _SIDES]), np.concatenate([self.h, np.full(POLYGON_SIDES, self.disc)])


def scale_rows(problem: PartitionProblem) -> ScaledRows:
    """Scale the unknowns of a problem and give every row unit length.

    A row without normal (two anchors above each other) keeps its length: it is met or broken by every pose.
    """
    n = problem.unknowns
    scale, middle = np.ones(n), np.zeros(n)
    scale[2:], middle[:2] = ORIENTATION_SCALE_M, problem.bounds_m.mean(axis=1)
    A, b = problem.all_rows
    G = A / scale
    length = np.sqrt(np.einsum("mi,mi->m", G, G))
    length[length == 0.0] = 1.0
    return ScaledRows(G / length[:, None], (b - A @ middle) / length, middle, scale)
