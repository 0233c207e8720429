"""How well could a part be located with these tags? The expected error of a layout, before any tag is glued on.

A comparison of anchors i and j by part tag k is right with probability p = 1 / (1 + exp(-Δd / s)), Δd = d_j - d_i. What
all comparisons of some stops tell about the pose z = (x, y, θ) is Fisher's information,

    J(z) = P⁻¹ + Σ_(stop, k, i<j) p (1 - p) / s²  ∇Δd ∇Δdᵀ,

with P the covariance of what is known before. The expected error is that of the part's tags, in root mean square:

    e(z)² = mean_k tr(E_k J⁻¹ E_kᵀ),    E_k = ∂q_k/∂z.

It takes comparisons for independent, which those of one tag are not, so it compares layouts and promises nothing. Ours.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numba
import numpy as np

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.errors import InputError, ShapeError

SCALE_M = 0.025  # s: as fitted on near-field images in simulated rooms
KNOWN_TO_M, KNOWN_TO_RAD = 0.15, 1.8  # before anything is compared; a uniform θ has a deviation of 1.8 rad


class Seen(NamedTuple):
    """Distances from part tags to candidate anchors, and how they change with the pose.

    Attributes:
        d: Distance [m], shape (Z, S, K, C).
        slope: ∂d/∂(x, y, θ) [1, 1, m], shape (Z, S, K, C, 3).
        lever: ∂q_k/∂θ in the plane [m], shape (Z, K, 2).
    """

    d: FloatArray
    slope: FloatArray
    lever: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class LayoutError:
    """Expected error for anchors that are chosen among candidates.

    Attributes:
        anchors_m: Every candidate at every stop, in one frame [m], shape (S, C, 3).
        part_points_m: Part tags: x, y in the part frame, z in that frame [m], shape (K, 3).
        poses: Poses (x, y, θ) of the part to expect [m, m, rad], shape (Z, 3).
        scale_m: s of a comparison [m].
    """

    anchors_m: FloatArray
    part_points_m: FloatArray
    poses: FloatArray
    scale_m: float = SCALE_M

    def __post_init__(self) -> None:
        """Refuse what has no error."""
        if np.ndim(self.anchors_m) != 3 or np.shape(self.anchors_m)[2] != 3 or not len(self.poses):
            raise ShapeError(f"anchors_m: expected (S, C, 3), got {np.shape(self.anchors_m)}", name="anchors_m")
        if not self.scale_m > 0.0:
            raise InputError(f"scale_m = {self.scale_m} is not above 0", scale_m=self.scale_m)

    def seen(self) -> Seen:
        """Distances and slopes of all candidates, once for all choices."""
        c, s = np.cos(self.poses[:, 2:]), np.sin(self.poses[:, 2:])
        x, y = self.part_points_m[:, 0], self.part_points_m[:, 1]
        turned = np.stack([c * x - s * y, s * x + c * y], axis=2)
        lever = np.stack([-turned[:, :, 1], turned[:, :, 0]], axis=2)
        z = np.broadcast_to(self.part_points_m[:, 2], turned.shape[:2])
        tags_m = np.concatenate([self.poses[:, None, :2] + turned, z[:, :, None]], axis=2)
        away_m = tags_m[:, None, :, None, :] - self.anchors_m[None, :, None, :, :]
        d = np.linalg.norm(away_m, axis=4)
        unit = away_m[..., :2] / np.maximum(d, 1e-9)[..., None]
        about = (unit * lever[:, None, :, None, :]).sum(axis=4)
        return Seen(d, np.concatenate([unit, about[..., None]], axis=4), lever)

    def errors_m(self, chosen: IntArray, seen: Seen | None = None) -> FloatArray:
        """e(z) for each pose [m], shape (Z,).

        Args:
            chosen: Which candidates carry a tag, at least two.
            seen: What `seen` returned, to save time.
        """
        if len(chosen) < 2:
            raise InputError(f"{len(chosen)} anchor(s): a comparison needs two", anchors=len(chosen))
        seen = seen or self.seen()
        prior = np.array([KNOWN_TO_M, KNOWN_TO_M, KNOWN_TO_RAD]) ** -2
        return np.asarray(_errors(seen.d, seen.slope, seen.lever, np.asarray(chosen), prior, self.scale_m))


@numba.njit(cache=True)
def _errors(
    d: FloatArray, slope: FloatArray, lever: FloatArray, chosen: IntArray, prior: FloatArray, scale_m: float
) -> FloatArray:
    Z, S, K, _ = d.shape
    errors = np.empty(Z)
    for z in range(Z):
        J = np.diag(prior)
        for s in range(S):
            for k in range(K):
                _add_information(J, d[z, s, k], slope[z, s, k], chosen, scale_m)
        C = np.linalg.inv(J)
        total = 0.0
        for k in range(K):
            lx, ly = lever[z, k]
            total += C[0, 0] + C[1, 1] + 2.0 * (lx * C[0, 2] + ly * C[1, 2]) + (lx * lx + ly * ly) * C[2, 2]
        errors[z] = np.sqrt(total / K)
    return errors


@numba.njit(cache=True)
def _add_information(J: FloatArray, d: FloatArray, slope: FloatArray, chosen: IntArray, scale_m: float) -> None:
    """Add what one part tag's comparisons at one stop tell."""
    g = np.empty(3)
    for a in range(len(chosen)):
        for b in range(a):
            i, j = chosen[a], chosen[b]
            p = 1.0 / (1.0 + np.exp(-(d[j] - d[i]) / scale_m))
            weight = p * (1.0 - p) / (scale_m * scale_m)
            for axis in range(3):
                g[axis] = slope[j, axis] - slope[i, axis]
            for row in range(3):
                for column in range(3):
                    J[row, column] += weight * g[row] * g[column]
