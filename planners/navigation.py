"""The way of a base that drives in any direction, around what stands in the world.

What must not touch is the whole robot as it drives, arm and hand included, against every body: more than a footprint,
since an arm reaches over obstacles and a table over the base. Coordinates are x, y and the heading; a radian of turning
counts as much as `_M_PER_RAD` of driving. The base goes straight from waypoint to waypoint and turns the shorter way.
"""

import numpy as np

from planners.motion_check import MotionChecker
from planners.path_search import FoundPath, SearchRules, SearchSpace, find_path
from rfcompass.arrays import FloatArray
from rfcompass.geometry.pose2 import Pose2
from rfcompass.robots import CollisionModel
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasps import Failure
from rfcompass.types.world import Body

# Ours. Half the length of the youBot's base; and how far around obstacles and ends a way may lead [m].
_M_PER_RAD = 0.3
_AROUND_M = 1.5


def plan_drive(
    checker: MotionChecker,
    start: Configuration,
    goal: Pose2,
    rng: np.random.Generator,
    rules: SearchRules | None = None,
) -> FoundPath | Failure:
    """Find a way of the base to a pose that touches nothing; the joints stay as they are.

    Args:
        checker: What must not be touched.
        start: Where the robot is, and how it holds its arm while it drives.
        goal: Pose of the base to drive to, in the same frame.
        rng: Seeds the search.
        rules: How hard to look.

    Returns:
        A path; or a failure: `"start_collision"`, `"goal_collision"` or `"no_path"`.

    Raises:
        ValueError: If the base cannot drive.
    """
    model = checker.checker.model
    if not model.robot.is_mobile:
        raise ValueError(f"the base of {model.robot.name} is fixed")
    ends = np.array([_coordinates(start.base), _coordinates(goal)])
    turn_rad = (ends[1, 2] - ends[0, 2] + np.pi) % (2 * np.pi) - np.pi
    ends[1, 2] = ends[0, 2] + turn_rad
    lower, upper = _around(model, ends)

    def build(values: FloatArray) -> Configuration:
        x_m, y_m, theta_rad = map(float, values)
        return Configuration(start.joints, Pose2(x_m, y_m, theta_rad))

    space = SearchSpace(lower, upper, np.array([1.0, 1.0, _M_PER_RAD]), build)
    return find_path(checker, space, ends[0], ends[1], rng, rules)


def _coordinates(pose: Pose2) -> FloatArray:
    return np.array([pose.x_m, pose.y_m, pose.theta_rad])


def _around(model: CollisionModel, ends: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Bounds of x, y and heading: a margin around both ends and all bodies that stand near the way."""
    low, high = ends[:, :2].min(axis=0) - 2 * _AROUND_M, ends[:, :2].max(axis=0) + 2 * _AROUND_M
    bodies = [body for body in model.world.bodies if body.stands_still]
    every = np.concatenate([ends[:, :2], *(np.clip(_corners(body), low, high) for body in bodies)])
    lower, upper = every.min(axis=0) - _AROUND_M, every.max(axis=0) + _AROUND_M
    turns = ends[:, 2].min() - np.pi, ends[:, 2].max() + np.pi
    return np.array([*lower, turns[0]]), np.array([*upper, turns[1]])


def _corners(body: Body) -> FloatArray:
    """Corners of a body's bounding box, seen from above [m], shape (8, 2)."""
    corners = np.array(np.meshgrid(*zip(body.shape.lower_m, body.shape.upper_m, strict=True))).reshape(3, -1).T
    T = body.T_parent_body
    return np.asarray((corners @ T[:3, :3].T + T[:3, 3])[:, :2])
