"""Value, gradient and Hessian of a near-field image at one point, and the climb to its very top by Newton's method.

With g_k and H_k the gradient and Hessian of the round trip d(p, a_k), a look A = Σ_k h_k e^{jκd} has

    ∇A = Σ_k jκ h_k e^{jκd} g_k,        ∇²A = Σ_k h_k e^{jκd} (jκ H_k - κ² g_k g_kᵀ),
    ∇|A|² = 2 Re(A* ∇A),                ∇²|A|² = 2 Re(∇A* ∇Aᵀ + A* ∇²A).

Grids in single precision end where rounding makes neighbours equal, a tenth of a millimetre from the top. Differences
of tops are what proximity is made of, so the last bit is climbed in double precision.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from rfcompass.arrays import ComplexArray, FloatArray, IntArray
from rfcompass.rf.slope_kernels import LegArrays, leg_power
from rfcompass.types.volumes import SearchVolume

NEWTON_STEPS = 40
LONGEST_STEP = 1 / 8  # of a fringe: farther the parabola says nothing about the image
SHORT_STEP = 1e-4  # of a fringe: there values no longer tell up from down, and Newton's step is trusted
HALVINGS = 12
ENOUGH = 1e-10  # of a fringe


class Slopes(NamedTuple):
    """A function at one point: value, gradient [1/m], shape (3,), and Hessian [1/m²], shape (3, 3)."""

    value: float
    gradient: FloatArray
    hessian: FloatArray


@dataclass(frozen=True)
class LegSlopes:
    """Everything that the matched filter of one leg is made of.

    Attributes:
        rx_m: Receiving antenna [m], shape (M, 3).
        tx_m: Transmitting antenna [m], shape (M, 3); None if it is the receiving one.
        h: Channel as it is matched, shape (M, F).
        k: Phase per metre of round trip for each channel [rad/m], shape (F,).
        runs: Rows that share their phase constants.
        coherent: One look over all channels.
        norm: Power if all cells agreed.
    """

    rx_m: FloatArray
    tx_m: FloatArray | None
    h: ComplexArray
    k: FloatArray
    runs: tuple[IntArray, ...]
    coherent: bool
    norm: float

    def power(self, point_m: FloatArray) -> Slopes:
        """Share B of the power of perfect agreement, with its derivatives."""
        value, gradient, hessian = leg_power(np.asarray(point_m, dtype=np.float64), self._arrays)
        return Slopes(value / self.norm, gradient / self.norm, hessian / self.norm)

    @cached_property
    def _arrays(self) -> LegArrays:
        order = np.concatenate(self.runs)
        tx_m = np.zeros((0, 3)) if self.tx_m is None else np.ascontiguousarray(self.tx_m[order])
        ends = np.cumsum([len(rows) for rows in self.runs])
        return LegArrays(
            np.ascontiguousarray(self.rx_m[order]), tx_m, np.ascontiguousarray(self.h[order]),
            np.ascontiguousarray(self.k), ends, self.coherent,
        )  # fmt: skip


def product_slopes(legs: Sequence[LegSlopes], point_m: FloatArray) -> Slopes:
    """Σ log B over some legs; -inf where a leg vanishes."""
    value, gradient, hessian = 0.0, np.zeros(3), np.zeros((3, 3))
    for leg in legs:
        B = leg.power(point_m)
        if B.value <= 0.0:
            return Slopes(-np.inf, gradient, hessian)
        value += float(np.log(B.value))
        gradient = gradient + B.gradient / B.value
        hessian = hessian + B.hessian / B.value - np.outer(B.gradient, B.gradient) / B.value**2
    return Slopes(value, gradient, hessian)


def climb_to_top(
    slopes_at: Callable[[FloatArray], Slopes], volume: SearchVolume, start_m: FloatArray, fringe_m: float
) -> FloatArray:
    """Climb from a point to the top of its lobe, or to the border of the volume [m], shape (3,).

    Newton's step with the sizes of the Hessian's eigenvalues leads uphill from anywhere; it is kept short and halved
    until the image rises. At the border the axes that lead out are held.

    Args:
        slopes_at: The image's logarithm with its derivatives.
        volume: Borders; an axis of zero extent is not moved.
        start_m: Where to start [m], shape (3,).
        fringe_m: Distance between crests [m].
    """
    point_m, here = start_m, slopes_at(start_m)
    for _ in range(NEWTON_STEPS):
        step_m = _newton_step_m(here, volume, point_m, LONGEST_STEP * fringe_m)
        if np.linalg.norm(step_m) <= ENOUGH * fringe_m:
            break
        moved = _uphill(slopes_at, volume, point_m, here, step_m, fringe_m)
        if moved is None:
            break
        point_m, here = moved
    return point_m


def _newton_step_m(here: Slopes, volume: SearchVolume, point_m: FloatArray, longest_m: float) -> FloatArray:
    held = ~volume.free_axes | ((point_m <= volume.lower_m) & (here.gradient < 0))
    free = np.flatnonzero(~(held | ((point_m >= volume.upper_m) & (here.gradient > 0))))
    step_m = np.zeros(3)
    if free.size:
        sizes, axes = np.linalg.eigh(here.hessian[np.ix_(free, free)])
        sizes = np.maximum(np.abs(sizes), 1e-9 * np.abs(sizes).max() + 1e-300)
        step_m[free] = axes @ ((axes.T @ here.gradient[free]) / sizes)
    return step_m * min(1.0, longest_m / max(float(np.linalg.norm(step_m)), 1e-300))


def _uphill(
    slopes_at: Callable[[FloatArray], Slopes],
    volume: SearchVolume,
    point_m: FloatArray,
    here: Slopes,
    step_m: FloatArray,
    fringe_m: float,
) -> tuple[FloatArray, Slopes] | None:
    for _ in range(HALVINGS):
        tried_m = np.clip(point_m + step_m, volume.lower_m, volume.upper_m)
        there = slopes_at(tried_m)
        if there.value > here.value or np.linalg.norm(step_m) < SHORT_STEP * fringe_m:
            return tried_m, there
        step_m = step_m / 2.0
    return None
