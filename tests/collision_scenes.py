"""A youBot among things, for the tests of collision checks."""

import numpy as np

from rfcompass.geometry import Pose2
from rfcompass.robots import YouBot
from rfcompass.types import Body, Box, Configuration, Cylinder, Sphere, World

ROBOT = YouBot()


def at(x, y, z, R=None):
    """Homogeneous pose."""
    T = np.eye(4)
    T[:3, 3] = x, y, z
    if R is not None:
        T[:3, :3] = R
    return T


def things():
    """One of each shape within reach of the arm."""
    leg = Body("leg", Box(np.array([0.05, 0.4, 0.05])), at(0.42, 0, 0.025))
    post = Body("post", Cylinder(0.05, 0.6, "z"), at(0.3, 0.4, 0.3))
    pipe = Body("pipe", Cylinder(0.03, 0.6, "x"), at(0.3, -0.3, 0.2))
    ball = Body("ball", Sphere(0.08), at(0.5, 0.2, 0.4))
    return World((leg, post, pipe, ball))


def random_configurations(count, seed, *, moves_base=True):
    """Joints inside the limits, the base somewhere about the origin."""
    rng = np.random.default_rng(seed)
    joints = rng.uniform(ROBOT.limits.lower, ROBOT.limits.upper, (count, len(ROBOT.joint_names)))
    if not moves_base:
        return [Configuration(q) for q in joints]
    bases = np.column_stack([rng.uniform(-0.3, 0.3, (count, 2)), rng.uniform(-np.pi, np.pi, count)])
    return [Configuration(q, Pose2(*base)) for q, base in zip(joints, bases, strict=True)]
