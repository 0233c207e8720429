"""Which stop tells most about where the part is?

Over the poses z_s in question, s = 1 … S, a stop with anchors a_i would answer each comparison with the probability

    p_n(z) = λ/2 + (1 - λ) / (1 + exp(-Δd_n(z) / s)),        Δd_n = |q_k(z) - a_j| - |q_k(z) - a_i|,

and what it tells is taken from the spread of these answers beside their own chance [nat]:

    G = ½ log det(I + D^-½ C D^-½),    C = cov_z p(z),    D = diag(mean_z p_n (1 - p_n)), at least `LEAST_CHANCE`.

Answers that say the same twice count once, which a sum over comparisons would not see. Ours; [Wang2013] moves the hand
to fixed places.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import expit

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import InputError
from rfcompass.localization.noise_model import NoiseModel
from rfcompass.types.record import Record

LEAST_CHANCE = 0.02  # ours: no comparison is surer than one that is right 98 times of 100


@dataclass(frozen=True, slots=True)
class StopScores(Record):
    """What each stop would tell.

    Attributes:
        gain_nat: Information about the pose [nat], shape (C,).
        seconds: Time that each stop takes, its scan included [s], shape (C,).
    """

    gain_nat: FloatArray
    seconds: FloatArray

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        gain_nat = read_only(self.gain_nat, "StopScores.gain_nat", (None,))
        object.__setattr__(self, "gain_nat", gain_nat)
        object.__setattr__(self, "seconds", read_only(self.seconds, "StopScores.seconds", gain_nat.shape))

    @property
    def best(self) -> int:
        """Index of the stop with the largest gain per second; the first of several."""
        return int((self.gain_nat / self.seconds).argmax())


def next_best_stop(
    poses: FloatArray,
    part_points_m: FloatArray,
    anchors_m: Sequence[FloatArray],
    seconds: FloatArray,
    noise: NoiseModel | None = None,
) -> StopScores:
    """Score stops that the robot could make.

    Args:
        poses: Poses (x, y, θ) of the part in question, such as samples of a posterior [m, m, rad], shape (S, 3).
        part_points_m: Part tags: x, y in the part frame, z in the base frame [m], shape (K, 3).
        anchors_m: Anchors at each stop, in the frame of the poses [m], shape (N, 3) each.
        seconds: Time that each stop takes, its scan included [s], shape (C,).
        noise: How far comparisons can be trusted.

    Raises:
        InputError: If there is no stop or fewer than two poses, or a stop takes no time.
    """
    noise, seconds = noise or NoiseModel(), np.asarray(seconds, dtype=np.float64)
    if len(poses) < 2 or not len(anchors_m):
        raise InputError(f"{len(poses)} poses and {len(anchors_m)} stops: nothing to choose", stops=len(anchors_m))
    if (seconds <= 0.0).any():
        raise InputError(f"a stop takes {seconds.min()} s", seconds=float(seconds.min()))
    tags_m = _tags(poses, part_points_m)
    return StopScores(np.array([_gain_nat(_answers(tags_m, one, noise)) for one in anchors_m]), seconds)


def _tags(poses: FloatArray, part_points_m: FloatArray) -> FloatArray:
    """Part tags at each pose [m], shape (S, K, 3)."""
    c, s = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
    x, y = part_points_m[:, 0], part_points_m[:, 1]
    z = np.broadcast_to(part_points_m[:, 2], c.shape[:1] + x.shape)
    return np.stack([poses[:, :1] + c * x - s * y, poses[:, 1:2] + s * x + c * y, z], axis=2)


def _answers(tags_m: FloatArray, anchors_m: FloatArray, noise: NoiseModel) -> FloatArray:
    """Probability that the first of two anchors is the nearer one, for each pose and comparison, shape (S, K P)."""
    d = np.linalg.norm(tags_m[:, :, None, :] - anchors_m, axis=3)
    i, j = np.triu_indices(len(anchors_m), 1)
    nearer = expit((d[:, :, j] - d[:, :, i]) / noise.comparison_m)
    return np.asarray(noise.lapse / 2 + (1.0 - noise.lapse) * nearer).reshape(len(tags_m), -1)


def _gain_nat(p: FloatArray) -> float:
    chance = np.maximum((p * (1.0 - p)).mean(axis=0), LEAST_CHANCE)
    spread = (p - p.mean(axis=0)) / np.sqrt(chance * len(p))
    inner = spread @ spread.T if spread.shape[0] < spread.shape[1] else spread.T @ spread
    return float(np.linalg.slogdet(np.eye(len(inner)) + inner)[1] / 2.0)
