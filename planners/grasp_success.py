"""How often executed grasps of each score held: weights fitted on tuning scenes; see `docs/grasp_quality.md`."""

import numpy as np

from rfcompass.arrays import FloatArray, IntArray

# Weights of `grasp_number_kernels.CLOSING` and `PINCHING`, the constant last. All ours, fitted.
CLOSING_WEIGHTS = (1.5, -0.5, 1.0, 1.0, 1.0, -0.5, -0.5, -1.0, -2.0, 1.0, -2.5)
PINCHING_WEIGHTS = (-0.5, -2.0, 1.5, 2.0, -2.0, 1.0, -2.5)


def success_of(log_odds: FloatArray, kind: IntArray) -> FloatArray:
    """Probability that a grasp holds, 0 where there is none; shape of the log-odds."""
    quality = np.zeros(log_odds.shape)
    there = kind > 0
    quality[there] = 1.0 / (1.0 + np.exp(-log_odds[there]))
    return quality
