"""Poses in the plane: a frozen value, composed with `@` (3-D poses are `pinocchio.SE3`)."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import ShapeError
from rfcompass.geometry.angles import wrap_to_pi


@dataclass(frozen=True, slots=True)
class Pose2:
    """Pose `T_a_b` of frame b in frame a: p_a = R(θ) p_b + [x, y].

    Attributes:
        x_m: Origin of b in a along x [m].
        y_m: Origin of b in a along y [m].
        theta_rad: Turn from a to b, counter-clockwise [rad]; kept in [-π, π).
    """

    x_m: float = 0.0
    y_m: float = 0.0
    theta_rad: float = 0.0

    def __post_init__(self) -> None:
        """Wrap the angle; refuse NaN and infinity."""
        values = (self.x_m, self.y_m, self.theta_rad)
        if not np.isfinite(values).all():
            raise ShapeError(f"Pose2: {values} is not finite", name="Pose2", got=values)
        object.__setattr__(self, "x_m", float(self.x_m))
        object.__setattr__(self, "y_m", float(self.y_m))
        object.__setattr__(self, "theta_rad", float(wrap_to_pi(self.theta_rad)))

    def __matmul__(self, other: "Pose2") -> "Pose2":
        """Compose: `T_a_b @ T_b_c` is `T_a_c`."""
        x_m, y_m = self.apply(np.array([other.x_m, other.y_m]))
        return Pose2(x_m, y_m, self.theta_rad + other.theta_rad)

    @property
    def rotation(self) -> FloatArray:
        """R(θ), shape (2, 2)."""
        c, s = np.cos(self.theta_rad), np.sin(self.theta_rad)
        return np.array([[c, -s], [s, c]])

    @property
    def translation_m(self) -> FloatArray:
        """[x, y] in metres, shape (2,)."""
        return np.array([self.x_m, self.y_m])

    def inverse(self) -> "Pose2":
        """Return `T_b_a`."""
        x_m, y_m = -self.rotation.T @ self.translation_m
        return Pose2(x_m, y_m, -self.theta_rad)

    def apply(self, points_m: npt.ArrayLike) -> FloatArray:
        """Map points from frame b to frame a.

        Args:
            points_m: Points [m], shape (..., 2); or (..., 3), whose heights stay as they are.

        Returns:
            Points in frame a [m], same shape.

        Raises:
            ShapeError: If the last axis is neither 2 nor 3 long.
        """
        points = np.asarray(points_m, dtype=np.float64)
        if points.ndim == 0 or points.shape[-1] not in (2, 3):
            raise ShapeError(f"Pose2.apply: last axis of {points.shape} is neither 2 nor 3", got=points.shape)
        moved = points.copy()
        moved[..., :2] = points[..., :2] @ self.rotation.T + self.translation_m
        return moved


def as_pose2(xyt: npt.ArrayLike) -> Pose2:
    """Read [x_m, y_m, theta_rad], shape (3,), as a pose."""
    x_m, y_m, theta_rad = read_only(xyt, "pose", (3,))
    return Pose2(float(x_m), float(y_m), float(theta_rad))
