"""The way of the arm from one posture to another."""

import numpy as np

from planners.motion_check import MotionChecker
from planners.path_search import FoundPath, SearchRules, SearchSpace, find_path
from rfcompass.arrays import FloatArray
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasps import Failure


def plan_arm(
    checker: MotionChecker,
    start: Configuration,
    goal: Configuration,
    rng: np.random.Generator,
    rules: SearchRules | None = None,
) -> FoundPath | Failure:
    """Find a way of all joints from start to goal that touches nothing; the base stays where it is.

    Joints that have the same value at both ends keep it; the others stay inside the soft limits, as far as both ends
    are inside.

    Args:
        checker: What must not be touched.
        start: Where the robot is.
        goal: Where its joints are to be.
        rng: Seeds the search.
        rules: How hard to look.

    Returns:
        A path; or a failure: `"start_collision"`, `"goal_collision"` or `"no_path"`.

    Raises:
        ValueError: If the base stands elsewhere at the goal.
    """
    if start.base != goal.base:
        raise ValueError("the base moves between start and goal; plan_drive is for that")
    robot = checker.checker.model.robot
    arm = {robot.joint_names.index(name) for name in robot.arm_joints}
    moving = np.array(
        [i for i in range(len(start.joints)) if i in arm or start.joints[i] != goal.joints[i]], dtype=np.int64
    )
    lower, upper = _bounds(robot.limits.soft_lower, robot.limits.soft_upper, start.joints, goal.joints)

    def build(values: FloatArray) -> Configuration:
        joints = start.joints.copy()
        joints[moving] = values
        return Configuration(joints, start.base)

    space = SearchSpace(lower[moving], upper[moving], np.ones(len(moving)), build)
    return find_path(checker, space, start.joints[moving], goal.joints[moving], rng, rules)


def _bounds(lower: FloatArray, upper: FloatArray, *ends: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Limits, widened to both ends; a joint without limits may go half a turn beyond them."""
    least, greatest = np.min(ends, axis=0), np.max(ends, axis=0)
    lower = np.where(np.isfinite(lower), lower, least - np.pi)
    upper = np.where(np.isfinite(upper), upper, greatest + np.pi)
    return np.minimum(lower, least), np.maximum(upper, greatest)
