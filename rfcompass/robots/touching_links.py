"""Links that touch wherever the joints are: pairs that a collision check must not look at.

The shapes of a real robot's links often overlap near a joint, beyond its direct neighbours. What touches in every one
of many random configurations says nothing.
"""

from dataclasses import replace

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.robots.collision_model import CollisionModel
from rfcompass.robots.quick_collisions import QuickCollisions
from rfcompass.robots.robot import Robot
from rfcompass.types.world import World


def always_touching(
    robot: Robot, rng: np.random.Generator | None = None, *, samples: int = 100
) -> tuple[tuple[str, str], ...]:
    """Find the pairs of links that overlap in every sampled configuration; for `CollisionModel(allowed=…)`.

    Args:
        robot: Whose links.
        rng: Draws the configurations; a fixed one if None.
        samples: Number of configurations.
    """
    checker = QuickCollisions(CollisionModel(robot, World(floor_m=None)))
    draws = random_joints(robot, rng or np.random.default_rng(0), samples)
    touching: set[tuple[str, str]] | None = None
    for joints in draws:
        now = {(row.first, row.second) for row in checker.touching(robot.configuration(joints))}
        touching = now if touching is None else touching & now
        if not touching:
            return ()
    return tuple(sorted(touching or ()))


def without_always_touching(model: CollisionModel) -> CollisionModel:
    """The same model, in which links that always touch may touch."""
    return replace(model, allowed=(*model.allowed, *always_touching(model.robot)))


def random_joints(robot: Robot, rng: np.random.Generator, count: int) -> FloatArray:
    """Joint values inside the limits, a joint without limits within half a turn of zero, shape (count, Q)."""
    lower, upper = robot.limits.lower, robot.limits.upper
    low, high = np.where(np.isfinite(lower), lower, -np.pi), np.where(np.isfinite(upper), upper, np.pi)
    return rng.uniform(low, high, (count, len(robot.joint_names)))
