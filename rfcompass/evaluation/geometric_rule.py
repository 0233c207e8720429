"""The rule of a real hand: it comes down where it believes the part to be, and closes."""

from dataclasses import dataclass, field

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, IntArray, read_only
from rfcompass.evaluation.error_pairs import Draws
from rfcompass.robots.hand import Hand, judge_grasps
from rfcompass.types.record import Record
from rfcompass.types.shapes import Shape


@dataclass(frozen=True, slots=True)
class GeometricRule(Record):
    """A hand goes to its planned place on the part as estimated; what it meets is the true part.

        T_true_hand = T_true_estimated · T_part_hand,    T_true_estimated from the drawn error

    Attributes:
        hand: The hand; comes down along its approach axis, opened as far as it can.
        shape: The part.
        T_part_hand: Planned pose of the tool frame in the part's frame, shape (4, 4).
    """

    hand: Hand
    shape: Shape
    T_part_hand: FloatArray = field(repr=False)

    def __post_init__(self) -> None:
        """Freeze the pose."""
        object.__setattr__(self, "T_part_hand", read_only(self.T_part_hand, "GeometricRule.T_part_hand", (4, 4)))

    def verdicts(self, draws: Draws) -> IntArray:
        """Verdict of each attempt, an index into `robots.hand.VERDICTS`, shape (S,)."""
        return judge_grasps(self.hand, self.shape, self.poses(draws))

    def holds(self, draws: Draws) -> BoolArray:
        """Whether the part is in the hand, for each draw, shape (S,)."""
        return np.asarray(self.verdicts(draws) == 0)

    def poses(self, draws: Draws) -> FloatArray:
        """Where the hand truly is, in the frame of the true part, shape (S, 4, 4)."""
        T_true_estimated = np.tile(np.eye(4), (len(draws), 1, 1))
        cosine, sine = np.cos(draws.theta_rad), np.sin(draws.theta_rad)
        T_true_estimated[:, 0, 0], T_true_estimated[:, 0, 1] = cosine, -sine
        T_true_estimated[:, 1, 0], T_true_estimated[:, 1, 1] = sine, cosine
        T_true_estimated[:, :2, 3] = draws.offset_m
        return np.asarray(T_true_estimated @ self.T_part_hand)


def from_above(hand: Hand, height_m: float = 0.0, along_m: float = 0.0) -> FloatArray:
    """Pose of a hand over a part: pointing down, jaws across the part's x axis, shape (4, 4).

    Args:
        hand: The hand.
        height_m: How far its tool frame is above the part's centre [m].
        along_m: How far it is from the centre along x [m].
    """
    jaws_across_part = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])  # hand axes in the part frame
    T_part_hand = np.eye(4)
    T_part_hand[:3, :3] = jaws_across_part @ hand.R_tool_hand.T
    T_part_hand[:3, 3] = along_m, 0.0, height_m
    return T_part_hand
