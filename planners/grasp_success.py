"""How often executed grasps of each score held: weights fitted on tuning scenes; see `docs/grasp_quality.md`."""

import numpy as np

from rfcompass.arrays import FloatArray, IntArray

# Weights of `grasp_number_kernels.CLOSING` and `PINCHING`, the constant last. All ours, fitted.
CLOSING_WEIGHTS = (0.37, -0.49, 0.76, 0.67, 0.78, 1.36, -0.21, -1.38, -1.22, 0.45, -2.03)
PINCHING_WEIGHTS = (0.88, -0.18, 1.51, 2.94, 1.07, -0.09, -2.17)


def success_of(log_odds: FloatArray, kind: IntArray) -> FloatArray:
    """Probability that a grasp holds, 0 where there is none; shape of the log-odds."""
    quality = np.zeros(log_odds.shape)
    there = kind > 0
    quality[there] = 1.0 / (1.0 + np.exp(-log_odds[there]))
    return quality
