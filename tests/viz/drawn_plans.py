"""A grasp to draw: a youBot that lifts a table leg over a box, with candidates of every kind."""

import numpy as np

from rfcompass.geometry import Pose2
from rfcompass.recordings import PartDatabase
from rfcompass.robots import YouBot
from rfcompass.types import Body, Box, Failure, GraspCandidate, GraspPlan, PartEstimate, TimedPath, World

ROBOT, LEG = YouBot(), PartDatabase(":memory:").part("table_leg_3")
# Straight down around the leg, 6 cm above that, and 13 cm above it.
GRASP = ROBOT.configuration([2.949606, 2.031871, -1.103905, 2.588873, 1.35263, 0.025, 0.025])
ABOVE = ROBOT.configuration([2.949606, 1.806071, -1.19885, 2.909617, 1.35263, 0.025, 0.025])
LIFTED = ROBOT.configuration([2.949606, 1.699627, -1.555157, 3.372368, 1.35263, 0.0, 0.0])
T_BASE_PART = np.array([[0, -1.0, 0, 0.42], [1.0, 0, 0, 0.0], [0, 0, 1.0, 0.025], [0, 0, 0, 1.0]])
REASONS = {"too_wide": 3, "joint_limit": 2, "scene_collision": 1}


def candidates():
    """Four that can be done and six that cannot, along the leg."""
    hand = np.linalg.inv(T_BASE_PART) @ ROBOT.tool_pose(GRASP).homogeneous
    kinds = [kind for kind, count in REASONS.items() for _ in range(count)]
    rows = []
    for index in range(10):
        T = hand.copy()
        T[:2, 3] = 0.04 * (index - 5), 0.0
        kind = None if index < 4 else kinds[index - 4]
        rejection = None if kind is None else Failure(kind, f"because of {kind}")
        rows.append(GraspCandidate(T, 0.075, None if kind else 0.25 * (index + 1), rejection))
    return tuple(rows)


def a_plan(base=None):
    """Reach, approach, close, lift and retreat, each in two seconds."""
    folded, closed = ROBOT.posture("folded").joints, GRASP.joints.copy()
    closed[-2:] = 0.0
    ways = {
        "reach": (folded, ABOVE.joints),
        "approach": (ABOVE.joints, GRASP.joints),
        "close": (GRASP.joints, closed),
        "lift": (closed, LIFTED.joints),
        "retreat": (LIFTED.joints, LIFTED.joints),
    }
    stages = [TimedPath(name, ROBOT.joint_names, [0.0, 2.0], np.array(way)) for name, way in ways.items()]
    if base is not None:
        bases = np.array([[0.0, 0.0, 0.0], [base.x_m, base.y_m, base.theta_rad]])
        stages.insert(0, TimedPath("drive", ROBOT.joint_names, [0.0, 2.0], np.array([folded, folded]), bases))
    T_base_hand = ROBOT.tool_pose(GRASP).homogeneous
    return GraspPlan(
        configuration=GRASP.joints,
        approach=np.array([ABOVE.joints, GRASP.joints]),
        retreat=np.array([closed, LIFTED.joints]),
        aperture_m=0.075,
        clearance_m=0.004,
        success_probability=0.91,
        candidates=candidates(),
        part_id=LEG.part_id,
        T_base_hand=T_base_hand,
        T_part_hand=np.linalg.inv(T_BASE_PART) @ T_base_hand,
        closed_m=0.05,
        success_sd=0.01,
        risks=(("hand_hits_part", 0.09),),
        stages=tuple(stages),
        base=base or Pose2(),
    )


def an_estimate(samples=400):
    """The leg across, in front of the base, known to a centimetre and five degrees."""
    covariance = np.diag([0.01**2, 0.02**2, np.deg2rad(5.0) ** 2])
    mean = np.array([0.42, 0.0, np.pi / 2])
    draws = np.random.default_rng(7).multivariate_normal(mean, covariance, samples)
    return PartEstimate(
        LEG.part_id, mean[:2], mean[2], "posterior", 3, height_m=0.025, covariance=covariance, samples=draws
    )


def a_world():
    """A box beside the leg."""
    T = np.eye(4)
    T[:3, 3] = 0.5, 0.4, 0.1
    return World((Body("crate", Box(np.array([0.2, 0.2, 0.2])), T),))
