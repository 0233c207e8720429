"""How often executed grasps of each score held: weights fitted on tuning scenes; see `docs/grasp_quality.md`."""

import numpy as np

from rfcompass.arrays import FloatArray, IntArray

# Weights of `grasp_number_kernels.CLOSING` and `PINCHING`, the constant last. All ours, fitted.
CLOSING_WEIGHTS = (0.35, -0.47, 0.72, 0.64, 0.74, 1.30, -0.20, -1.32, -1.16, 0.43, -1.46)
PINCHING_WEIGHTS = (0.18, -1.29, 8.64, 4.21, 3.65, -0.02, -7.87)


def success_of(log_odds: FloatArray, kind: IntArray) -> FloatArray:
    """Probability that a grasp holds, 0 where there is none; shape of the log-odds."""
    quality = np.zeros(log_odds.shape)
    there = kind > 0
    quality[there] = 1.0 / (1.0 + np.exp(-log_odds[there]))
    return quality
