"""Design a tag layout for a robot and a part: candidates from its mounts, stops with the hand over the part."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from planners.hand_over import hand_over
from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError
from rfcompass.localization import DesignedLayout, LayoutError, design_layout
from rfcompass.robots import Mounts, Robot
from rfcompass.robots.mounts import epcs_of
from rfcompass.types.configuration import Configuration
from rfcompass.types.record import Record
from rfcompass.types.tags import TagLayout

# All ours.
PITCH_M = 0.03
HAND_STOPS = ((0.42, 0.0, 0.0), (0.34, -0.14, 60.0), (0.451, 0.123, 120.0))  # x, y [m] and heading [°]
HAND_HEIGHT_M = 0.10
DISC_M = 0.25  # the part's centre is expected this near to the hand at the first stop
BODY_HALF_M = (0.29, 0.19)  # of the youBot; a part does not lie under it
JAW_ROLES = ("hand_left", "hand_right")  # what the stop rule looks at


@dataclass(frozen=True, slots=True)
class TagDesign(Record):
    """A designed layout, and what it is better than.

    Attributes:
        layout: Where the tags go.
        error_m: Its mean expected error, see `localization.layout_error` [m].
        present_error_m: The same of the robot's present layout [m].
        rounds: Rounds of exchange.
    """

    layout: TagLayout
    error_m: float
    present_error_m: float
    rounds: int


def design_for(
    robot: Robot, mounts: Mounts, part_points_m: FloatArray, count: int, rng: np.random.Generator, *, poses: int = 100
) -> TagDesign:
    """Choose places for some tags; those beside the jaws stay where they are, since the stop rule needs them.

    Args:
        robot: The robot with its present layout.
        mounts: Where tags may go.
        part_points_m: Part tags: x, y in the part frame, z in the base frame [m], shape (K, 3).
        count: How many tags, those beside the jaws included.
        rng: Source of the poses to expect.
        poses: How many of them.

    Raises:
        InputError: If there are no poses, or fewer tags than stay.
        NoRoomForTags: If the mounts leave no room for so many tags.
    """
    if poses < 1:
        raise InputError(f"{poses} poses to expect", poses=poses)
    kept = [i for i, role in enumerate(robot.layout.roles) if role in JAW_ROLES]
    candidates = _joined(_taken(robot.layout, kept), mounts.candidates(PITCH_M))
    expected = expected_poses(part_points_m, poses, rng)
    error = layout_error(Robot(replace(robot.description, layout=candidates)), part_points_m, expected)
    found = design_layout(error, count, spacing_m=mounts.spacing_m, kept=range(len(kept)))
    present = layout_error(robot, part_points_m, expected).errors_m(np.arange(len(robot.layout.epcs)))
    return TagDesign(_renamed(candidates, found, robot.layout), found.error_m, float(present.mean()), found.rounds)


def layout_error(robot: Robot, part_points_m: FloatArray, poses: FloatArray) -> LayoutError:
    """Expected error of all tags of a robot, over three stops with the hand over the floor."""
    joints = np.array([one.joints for one in hand_stops(robot)])
    return LayoutError(anchors_m=robot.tag_positions_batch(joints), part_points_m=part_points_m, poses=poses)


@dataclass(frozen=True, slots=True)
class ErrorMap(Record):
    """Expected error over the plane before the robot, in the mean over all orientations of the part.

    Attributes:
        x_m: Columns, base frame [m], shape (X,).
        y_m: Rows [m], shape (Y,).
        errors_m: Expected error; NaN under the base [m], shape (Y, X).
    """

    x_m: FloatArray
    y_m: FloatArray
    errors_m: FloatArray


def error_map(robot: Robot, part_points_m: FloatArray, pitch_m: float = 0.04, turns: int = 8) -> ErrorMap:
    """Expected error of a robot's layout wherever the part may be about the hand.

    Args:
        robot: The robot with its layout.
        part_points_m: Part tags: x, y in the part frame, z in the base frame [m], shape (K, 3).
        pitch_m: Distance between places [m].
        turns: Orientations of the part at each place.
    """
    x_m = np.arange(0.0, 0.88, pitch_m)
    y_m = np.arange(-0.44, 0.44 + pitch_m / 2, pitch_m)
    X, Y, T = np.meshgrid(x_m, y_m, np.arange(turns) * 2.0 * np.pi / turns)
    poses = np.column_stack([X.ravel(), Y.ravel(), T.ravel()])
    errors_m = layout_error(robot, part_points_m, poses).errors_m(np.arange(len(robot.layout.epcs)))
    mean_m = np.sqrt((errors_m.reshape(X.shape) ** 2).mean(axis=2))
    under = np.all(np.abs(np.stack([X[:, :, 0], Y[:, :, 0]])) < np.array(BODY_HALF_M)[:, None, None], axis=0)
    return ErrorMap(x_m, y_m, np.where(under, np.nan, mean_m))


def hand_stops(robot: Robot) -> Sequence[Configuration]:
    """Three poses of the hand over the floor before the base."""
    start = robot.posture("scan")
    return [
        hand_over(robot, start, np.array([x_m, y_m, HAND_HEIGHT_M]), float(np.deg2rad(yaw)))
        for x_m, y_m, yaw in HAND_STOPS
    ]


def expected_poses(part_points_m: FloatArray, count: int, rng: np.random.Generator) -> FloatArray:
    """Poses (x, y, θ) of a part within 25 cm of the hand, turned anyhow, not under the base, shape (count, 3)."""
    found: list[FloatArray] = []
    while len(found) < count:
        radius_m, angle_rad, theta_rad = DISC_M * np.sqrt(rng.uniform()), *rng.uniform(-np.pi, np.pi, 2)
        x_m, y_m = HAND_STOPS[0][:2] + radius_m * np.array([np.cos(angle_rad), np.sin(angle_rad)])
        c, s = np.cos(theta_rad), np.sin(theta_rad)
        tags_m = np.array([x_m, y_m]) + part_points_m[:, :2] @ np.array([[c, s], [-s, c]])
        if not np.any(np.all(np.abs(tags_m) < BODY_HALF_M, axis=1)):
            found.append(np.array([x_m, y_m, theta_rad]))
    return np.array(found)


def _taken(layout: TagLayout, rows: Sequence[int]) -> TagLayout:
    chosen = list(rows)
    return TagLayout(
        layout.body, tuple(layout.epcs[i] for i in chosen), tuple(layout.frames[i] for i in chosen),
        layout.points_m[chosen], layout.dipoles[chosen], tuple(layout.roles[i] for i in chosen),
    )  # fmt: skip


def _joined(one: TagLayout, other: TagLayout) -> TagLayout:
    return TagLayout(
        one.body, epcs_of(len(one.epcs) + len(other.epcs)), one.frames + other.frames,
        np.vstack([one.points_m, other.points_m]), np.vstack([one.dipoles, other.dipoles]), one.roles + other.roles,
    )  # fmt: skip


def _renamed(candidates: TagLayout, found: DesignedLayout, present: TagLayout) -> TagLayout:
    """The chosen candidates with EPCs in order; which part tag belongs to which jaw stays as it was."""
    chosen = _taken(candidates, found.chosen)
    return replace(chosen, epcs=epcs_of(len(chosen.epcs)), counterparts=present.counterparts)
