"""A hand with two jaws that close along a line, as boxes in its own axes.

Hand axes: origin at the tool frame's origin, x along the closing axis (the left jaw is on its positive side),
z along the approach axis, y = z × x across both.
"""

from dataclasses import dataclass, replace

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import InputError
from rfcompass.types.record import Record

# Ours. Friction of a jaw on a part: what [Mahler2017] plans with; tables give metal on dry wood 0.2 to 0.6.
FRICTION = 0.5
# Ours: force of each jaw [N]. A URDF's effort is no source: many say 1 N, with which a hand could not lift its payload.
GRIP_N = 20.0
# Ours: how far a pad yields, so that a face which is not quite parallel to it still lies on it [m].
GIVE_M = 0.001


@dataclass(frozen=True, slots=True)
class Jaw(Record):
    """One finger. First coordinate: outwards from its inner face; then across, then along the approach.

    Attributes:
        boxes_m: Lower and upper corner of each box that it is made of [m], shape (B, 2, 3).
        pads_m: Lower and upper corner (across, along the approach) of each rectangle of its inner face [m], shape
            (P, 2, 2).
    """

    boxes_m: FloatArray
    pads_m: FloatArray

    def __post_init__(self) -> None:
        """Freeze; there must be a pad, and no corner the wrong way round."""
        object.__setattr__(self, "boxes_m", _corners(self.boxes_m, "Jaw.boxes_m", 3))
        object.__setattr__(self, "pads_m", _corners(self.pads_m, "Jaw.pads_m", 2))
        if not len(self.pads_m):
            raise InputError("Jaw.pads_m: a jaw needs an inner face to hold with", name="pads_m")


@dataclass(frozen=True, slots=True)
class Hand(Record):
    """A hand with two jaws; its axes are those of this module.

    Attributes:
        approach_axis: Direction in which the hand moves towards a part, in the tool frame, unit vector, shape (3,).
        closing_axis: Direction from the right to the left jaw, in the tool frame, unit vector, shape (3,).
        palm_m: Lower and upper corner of each box that is no jaw, in hand axes [m], shape (B, 2, 3).
        left: Jaw on the positive side of x.
        right: Jaw on the negative side; it looks outwards too, so its first coordinate is -x.
        least_m: Least distance of the inner faces [m].
        greatest_m: Greatest distance of the inner faces [m].
        payload_kg: Heaviest part; infinite if nobody said so.
        friction: Coefficient of friction between jaw and part.
        grip_n: Force with which each jaw presses [N].
        give_m: How far a pad yields [m].
    """

    approach_axis: FloatArray
    closing_axis: FloatArray
    palm_m: FloatArray
    left: Jaw
    right: Jaw
    least_m: float
    greatest_m: float
    payload_kg: float = np.inf
    friction: float = FRICTION
    grip_n: float = GRIP_N
    give_m: float = GIVE_M

    def __post_init__(self) -> None:
        """Freeze; check axes, openings and physics."""
        for name in ("approach_axis", "closing_axis"):
            object.__setattr__(self, name, read_only(getattr(self, name), f"Hand.{name}", (3,)))
        axes = np.array([self.approach_axis, self.closing_axis])
        if not np.allclose(axes @ axes.T, np.eye(2), atol=1e-6):
            raise InputError("Hand: approach and closing axis are no perpendicular unit vectors", axes=axes.tolist())
        object.__setattr__(self, "palm_m", _corners(self.palm_m, "Hand.palm_m", 3))
        if not 0 <= self.least_m < self.greatest_m < np.inf:
            message = f"Hand: opens from {self.least_m} to {self.greatest_m} m; 0 <= least < greatest is needed"
            raise InputError(message, least_m=self.least_m, greatest_m=self.greatest_m)
        for name in ("payload_kg", "friction", "grip_n", "give_m"):
            if not (value := getattr(self, name)) > 0:
                raise InputError(f"Hand.{name}: {value} is not above 0", name=name)

    @property
    def R_tool_hand(self) -> FloatArray:
        """Hand axes in the tool frame, shape (3, 3)."""
        across = np.cross(self.approach_axis, self.closing_axis)
        return np.column_stack([self.closing_axis, across, self.approach_axis])

    def with_opening(self, greatest_m: float) -> "Hand":
        """The same hand with its fingers mounted wider or narrower: another greatest opening [m].

        The least opening stays, so a wider hand has a longer travel.

        Raises:
            InputError: If that is not above the least opening.
        """
        return replace(self, greatest_m=greatest_m)

    def opening(self, opening_m: float | None = None) -> float:
        """An opening [m] that the hand has; its greatest if None.

        Raises:
            InputError: If the hand cannot open so far, or cannot close so far.
        """
        if opening_m is None:
            return self.greatest_m
        if not self.least_m - 1e-9 <= opening_m <= self.greatest_m + 1e-9:
            message = f"the hand opens from {self.least_m:.4g} to {self.greatest_m:.4g} m, not to {opening_m:.4g} m"
            raise InputError(message, opening_m=opening_m, least_m=self.least_m, greatest_m=self.greatest_m)
        return float(opening_m)

    def boxes_m(self, opening_m: float | None = None) -> FloatArray:
        """Lower and upper corners of all boxes at an opening, in hand axes [m], shape (B, 2, 3).

        First those of the palm, then of the left, then of the right jaw.

        Raises:
            InputError: If the hand does not open so far.
        """
        outwards = np.array([self.opening(opening_m) / 2, 0.0, 0.0])
        left = self.left.boxes_m + outwards
        right = (self.right.boxes_m + outwards) * [-1.0, 1.0, 1.0]
        right[:, :, 0] = right[:, ::-1, 0]
        return np.concatenate([self.palm_m, left, right])


def _corners(value: FloatArray, name: str, dimensions: int) -> FloatArray:
    """Boxes as a read-only array, lower corners first, shape (B, 2, D)."""
    corners = read_only(value, name, (None, 2, dimensions))
    if (corners[:, 0] > corners[:, 1]).any():
        raise InputError(f"{name}: a lower corner lies above the upper one", name=name)
    return corners
