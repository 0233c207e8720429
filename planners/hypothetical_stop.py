"""What a stop that was not made would tell about the pose of a part.

Distances d_ki of part tag k from the anchors i, drawn at a pose that might be true, have the covariance

    Σ_k = diag(α² + β² d_ki²) + b² U_k U_kᵀ

of the noise model, U_k (N, 3) being the directions between tag and anchors: the second term is the bias b of the tag's
place, which no number of anchors takes away.
"""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.localization import NoiseModel
from rfcompass.types.record import Record

# Standard deviation of a logistic of scale 1, shared by the two distances that are compared.
_OF_TWO_DISTANCES = np.pi / np.sqrt(6.0)


@dataclass(frozen=True, slots=True)
class Hearing(Record):
    """What a stop hears.

    Attributes:
        anchors_m: Robot tags in the frame of the poses [m], shape (N, 3).
        part_points_m: Part tags: x, y in the part frame, z in the base frame [m], shape (K, 3).
    """

    anchors_m: FloatArray
    part_points_m: FloatArray

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        for name in ("anchors_m", "part_points_m"):
            object.__setattr__(self, name, read_only(getattr(self, name), f"Hearing.{name}", (None, 3)))

    def offsets_m(self, poses: FloatArray) -> FloatArray:
        """From each anchor to each part tag, for poses (S, 3) [m], shape (S, K, N, 3)."""
        c, s = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
        x, y, z = self.part_points_m.T
        tags_m = np.stack([poses[:, :1] + c * x - s * y, poses[:, 1:2] + s * x + c * y, z + 0.0 * c], axis=2)
        return np.asarray(tags_m[:, :, None] - self.anchors_m)


def posteriors(
    poses: FloatArray, truths: IntArray, hearing: Hearing, noise: NoiseModel, rng: np.random.Generator
) -> FloatArray:
    """Weights of all poses after a measurement drawn at each of some of them.

    Args:
        poses: Poses in question, shape (S, 3).
        truths: Which of them are the truth, one for each measurement, shape (H,).
        hearing: What is measured.
        noise: How well.
        rng: Draws the errors.

    Returns:
        Weights that sum to one, shape (H, S).
    """
    offsets_m = hearing.offsets_m(poses)
    d = np.linalg.norm(offsets_m, axis=3)
    logs = np.zeros((len(truths), len(poses)))
    for k in range(d.shape[1]):
        whitener = _whitener(offsets_m[:, k].mean(axis=0), noise)
        seen = d[:, k] @ whitener.T
        heard = seen[truths] + rng.standard_normal((len(truths), d.shape[2]))
        logs -= ((heard[:, None] - seen) ** 2).sum(axis=2) / 2
    weights = np.exp(logs - logs.max(axis=1, keepdims=True))
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))


def _whitener(offsets_m: FloatArray, noise: NoiseModel) -> FloatArray:
    """W with Wᵀ W = Σ⁻¹ for one tag at mean offsets (N, 3), shape (N, N)."""
    d = np.linalg.norm(offsets_m, axis=1)
    alpha_m, beta = noise.alpha_m, noise.beta
    if noise.pairs and not noise.measures_distance:
        alpha_m, beta = noise.comparison_m * _OF_TWO_DISTANCES, 0.0
    directions = offsets_m / d[:, None]
    covariance = np.diag(alpha_m**2 + beta**2 * d**2) + noise.bias_m**2 * directions @ directions.T
    return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)))
