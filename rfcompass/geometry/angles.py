"""Angles on the circle."""

import numpy as np
import numpy.typing as npt

from rfcompass.arrays import FloatArray


def wrap_to_pi(angle_rad: npt.ArrayLike) -> FloatArray:
    """Map angles to [-π, π) [rad], any shape."""
    return np.asarray((np.asarray(angle_rad, dtype=np.float64) + np.pi) % (2.0 * np.pi) - np.pi)


def angle_difference(a_rad: npt.ArrayLike, b_rad: npt.ArrayLike, period_rad: float = 2.0 * np.pi) -> FloatArray:
    """Shortest signed turn from b to a [rad], in [-period/2, period/2).

    Args:
        a_rad: Angles [rad], any shape.
        b_rad: Angles [rad], broadcast against `a_rad`.
        period_rad: 2π, or π for things that look the same after half a turn.
    """
    difference = np.asarray(a_rad, dtype=np.float64) - np.asarray(b_rad, dtype=np.float64)
    return np.asarray((difference + period_rad / 2.0) % period_rad - period_rad / 2.0)


def circular_mean(angle_rad: npt.ArrayLike) -> float:
    """Direction of the mean unit vector [rad]; NaN if the angles cancel or there are none."""
    angles = np.asarray(angle_rad, dtype=np.float64)
    if angles.size == 0:
        return float("nan")
    resultant = np.exp(1j * angles).mean()
    return float(np.angle(resultant)) if abs(resultant) > 1e-12 else float("nan")
