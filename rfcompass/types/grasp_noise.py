"""What differs from try to try of a grasp: where the arm puts the hand, and how slippery the part is."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import InputError
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class GraspDraws(Record):
    """Draws of a `GraspNoise`.

    Attributes:
        shifts_m: Where the hand is off, in the axes that its pose is given in [m], shape (S, 3).
        T_hand_turned: How it is turned about its own axes, homogeneous, shape (S, 4, 4).
        friction: Coefficients, shape (S,).
    """

    shifts_m: FloatArray
    T_hand_turned: FloatArray
    friction: FloatArray

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        S = len(np.asarray(self.friction))
        for name, shape in (("shifts_m", (S, 3)), ("T_hand_turned", (S, 4, 4)), ("friction", (S,))):
            object.__setattr__(self, name, read_only(getattr(self, name), f"GraspDraws.{name}", shape))

    def executed(self, T_frame_hand: FloatArray) -> FloatArray:
        """Where the hand ends up in each draw when it is sent to a pose (4, 4) or to poses (S, 4, 4); (S, 4, 4)."""
        T = np.asarray(T_frame_hand @ self.T_hand_turned)
        T[:, :3, 3] += self.shifts_m
        return T


@dataclass(frozen=True, slots=True, kw_only=True)
class GraspNoise:
    """How tries of one grasp differ. All values are ours: neither paper prints any.

    Friction is a normal distribution, cut off: between the tables' extremes for metal on dry wood, about what
    [Mahler2017] plans with.

    Attributes:
        position_m: Standard deviation of the hand along each axis [m].
        turn_rad: Standard deviation of its turn about each axis [rad].
        friction: Mean coefficient.
        friction_sd: Its standard deviation.
        friction_range: Least and greatest coefficient.
    """

    position_m: float = 0.001
    turn_rad: float = 0.005
    friction: float = 0.5
    friction_sd: float = 0.1
    friction_range: tuple[float, float] = (0.2, 0.8)

    def __post_init__(self) -> None:
        """Refuse noise that cannot be."""
        for name in ("position_m", "turn_rad", "friction_sd"):
            if not (np.isfinite(value := getattr(self, name)) and value >= 0):
                raise InputError(f"GraspNoise.{name}: {value} is not a finite number >= 0", name=name)
        least, greatest = self.friction_range
        if not 0 < least <= self.friction <= greatest < np.inf:
            message = f"GraspNoise: friction {self.friction} is not inside {least} .. {greatest}, above 0"
            raise InputError(message, name="friction")

    def draw(self, count: int, rng: np.random.Generator) -> GraspDraws:
        """Draw tries.

        Args:
            count: How many (S).
            rng: Source of all draws.
        """
        shifts_m = rng.normal(0.0, self.position_m, (count, 3))
        turns = rng.normal(0.0, self.turn_rad, (count, 3))
        return GraspDraws(shifts_m, _small_turns(turns), self._frictions(count, rng))

    def _frictions(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Draw until all lie inside the range."""
        least, greatest = self.friction_range
        drawn = rng.normal(self.friction, self.friction_sd, count)
        while (outside := (drawn < least) | (drawn > greatest)).any():
            drawn[outside] = rng.normal(self.friction, self.friction_sd, int(outside.sum()))
        return drawn


def _small_turns(vectors: FloatArray) -> FloatArray:
    """Rotations by vectors (S, 3) [rad] as homogeneous transforms, (S, 4, 4): Rodrigues' formula."""
    angles = np.linalg.norm(vectors, axis=1)[:, None, None]
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    sine = np.sinc(angles / np.pi)
    cosine = 0.5 * np.sinc(angles / (2 * np.pi)) ** 2
    T = np.tile(np.eye(4), (len(vectors), 1, 1))
    T[:, :3, :3] += sine * cross + cosine * (cross @ cross)
    return T
