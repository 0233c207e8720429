"""Antipodal grasps of a part for a hand with two fingers.

Each pair of opposite contacts (`contact_pairs`) is taken from several directions: turned about the closing axis by a
pitch from straight above and, from straight above, turned about the vertical within the friction cone. The tool's
origin goes a little beyond the contacts, so that the jaws close with more than their tips.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from planners.contact_pairs import ContactPair, contact_pairs
from rfcompass.arrays import FloatArray
from rfcompass.robots import Tool
from rfcompass.types.grasps import Failure, GraspCandidate
from rfcompass.types.record import Record
from rfcompass.types.shapes import Shape

TOO_WIDE, OUTSIDE_CONE = "too_wide", "outside_friction_cone"

# Ours: the tool's origin stays this far above what the part lies on [m].
_ABOVE_SUPPORT_M = 0.003
_DOWN = np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True, slots=True, kw_only=True)
class AntipodalRules(Record):
    """Which grasps to list. All values are ours.

    Attributes:
        spacing_m: Distance between contacts along the part [m].
        headings: Headings of the jaws around what is round, over half a turn.
        pitches_rad: Turns of the approach about the closing axis, from straight above [rad].
        yaws_rad: Turns about the vertical that a grasp from straight above is offered with as well [rad].
        depth_m: How far the tool's origin goes beyond the contacts [m].
        samples: Points drawn on a mesh.
        slack_m: How much wider than the part the jaws must open at least, in all [m].
    """

    spacing_m: float = 0.025
    headings: int = 8
    pitches_rad: tuple[float, ...] = tuple(np.deg2rad([0, 15, -15, 30, -30, 45, -45, 60, -60, 75, -75, 90, -90]))
    yaws_rad: tuple[float, ...] = tuple(np.deg2rad([8.0, -8.0]))
    depth_m: float = 0.010
    samples: int = 400
    slack_m: float = 0.002

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ValueError: If one is impossible.
        """
        counts_are_good = self.headings >= 1 and self.samples >= 1 and len(self.pitches_rad) > 0
        if not (self.spacing_m > 0 and counts_are_good and self.slack_m >= 0):
            raise ValueError(f"AntipodalRules: spacing, counts and slack must be positive: {self}")
        if not np.isfinite([self.depth_m, *self.pitches_rad, *self.yaws_rad]).all():
            raise ValueError(f"AntipodalRules: depth and angles must be finite: {self}")


def antipodal_grasps(
    shape: Shape,
    tool: Tool,
    *,
    opening_m: float,
    friction: float,
    rng: np.random.Generator,
    rules: AntipodalRules | None = None,
) -> tuple[GraspCandidate, ...]:
    """List the grasps of a part, those that are ruled out by its shape with their reason.

    Args:
        shape: The part, in its own frame, as it lies.
        tool: Axes of the hand.
        opening_m: Greatest opening of the jaws [m].
        friction: Coefficient μ between jaw and part.
        rng: Draws points on a mesh; not asked for anything else.
        rules: Which grasps to list.

    Returns:
        Candidates without their half-turned twins. The score of those that are left is geometric: 1 for opposite
        faces in the middle of the part, less with the angle to the normals and with the distance from the centre of
        mass. Empty only for a mesh of which no ray finds an opposite face.

    Raises:
        PartError: If the surface of a mesh has holes, and no single convex piece stands for the solid.
    """
    rules = rules or AntipodalRules()
    pairs = contact_pairs(
        shape, spacing_m=rules.spacing_m, headings=rules.headings, samples=rules.samples, rng=rng
    )  # fmt: skip
    half_length_m = float(np.linalg.norm(shape.upper_m - shape.lower_m)) / 2
    found = []
    for pair in pairs:
        rejection = _ruled_out(pair, opening_m - rules.slack_m, friction)
        off = min(1.0, float(np.linalg.norm(pair.middle_m)) / half_length_m)
        score = None if rejection else float(np.cos(pair.angle_rad)) * (1 - off / 2)
        turns = _poses(pair, tool, rules, float(shape.lower_m[2]))
        poses = [next(turns)] if rejection else list(turns)
        found += [GraspCandidate(T, opening_m, score, rejection) for T in poses]
    return tuple(without_twins(found, tool))


def _ruled_out(pair: ContactPair, widest_m: float, friction: float) -> Failure | None:
    if pair.width_m > widest_m:
        message = f"{pair.width_m * 1e3:.1f} mm wide here, more than the {widest_m * 1e3:.1f} mm that the jaws leave"
        return Failure(TOO_WIDE, message, (("width_m", pair.width_m), ("opening_m", widest_m)))
    cone_rad = float(np.arctan(friction))
    if pair.angle_rad > cone_rad:
        message = (
            f"the jaws would slip: {np.rad2deg(pair.angle_rad):.0f} degrees off the normal, "
            f"where friction holds {np.rad2deg(cone_rad):.0f}"
        )
        return Failure(OUTSIDE_CONE, message, (("angle_rad", pair.angle_rad), ("cone_rad", cone_rad)))
    return None


def _poses(pair: ContactPair, tool: Tool, rules: AntipodalRules, support_m: float) -> Iterator[FloatArray]:
    """Tool poses that close on a pair, from straight above first."""
    for approach in _upright(pair.closing):
        for pitch in rules.pitches_rad:
            yield _pose(pair, tool, turn(pair.closing, pitch) @ approach, pair.closing, rules.depth_m, support_m)
    if abs(pair.closing[2]) < 1e-6 and not pair.is_round:
        for yaw in rules.yaws_rad:
            yield _pose(pair, tool, _DOWN, turn(-_DOWN, yaw) @ pair.closing, rules.depth_m, support_m)


def _upright(closing: FloatArray) -> list[FloatArray]:
    """Directions across the closing axis that pitches count from: steepest down, or level where the jaws are not."""
    steep = _DOWN - (_DOWN @ closing) * closing
    if np.linalg.norm(steep) > 1e-6:
        return [steep / np.linalg.norm(steep)]
    return [np.array([1.0, 0.0, 0.0])]


def _pose(
    pair: ContactPair, tool: Tool, approach: FloatArray, closing: FloatArray, depth_m: float, support_m: float
) -> FloatArray:
    """Tool pose with these axes, its origin beyond the contacts but not in the support, shape (4, 4)."""
    room_m = float(pair.middle_m[2]) - support_m - _ABOVE_SUPPORT_M
    if approach[2] < -1e-9:
        depth_m = min(depth_m, max(0.0, room_m / -float(approach[2])))
    T = np.eye(4)
    T[:3, :3] = tool_rotation(tool, approach, closing)
    T[:3, 3] = pair.middle_m + depth_m * approach
    return T


def tool_rotation(tool: Tool, approach: FloatArray, closing: FloatArray) -> FloatArray:
    """Rotation that brings a tool's axes along two perpendicular directions, shape (3, 3)."""
    own = np.column_stack([tool.approach_axis, tool.closing_axis, np.cross(tool.approach_axis, tool.closing_axis)])
    wanted = np.column_stack([approach, closing, np.cross(approach, closing)])
    return np.asarray(wanted @ own.T)


def turn(axis: FloatArray, angle_rad: float) -> FloatArray:
    """Rotation about a unit vector, Rodrigues' formula, shape (3, 3)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle_rad) * cross + (1 - np.cos(angle_rad)) * cross @ cross)


def without_twins(candidates: Sequence[GraspCandidate], tool: Tool) -> list[GraspCandidate]:
    """Drop what a candidate before it says already: the same place and approach, with the jaws either way round."""
    if not candidates:
        return []
    T = np.array([candidate.T_part_hand for candidate in candidates])
    closing = T[:, :3, :3] @ tool.closing_axis
    first = (np.abs(closing) > 1e-6).argmax(axis=1)
    closing *= np.sign(np.take_along_axis(closing, first[:, None], axis=1))
    rows = np.round(np.concatenate([T[:, :3, 3], T[:, :3, :3] @ tool.approach_axis, closing], axis=1), 5) + 0.0
    _, kept = np.unique(rows, axis=0, return_index=True)
    return [candidates[i] for i in np.sort(kept)]
