"""Scenes whose errors are drawn as reflections make them: every tag seems to be off its place, always in the same way.

Nine robot tags as on the youBot (a cross on the hand, two in front, two at the sides, one on the deck), the part
within 25 cm of the first place of the hand, and a fixed list of places where the hand goes while the base stands.
"""

from dataclasses import dataclass

import numpy as np
from compared_scenes import a_leg, leg_points

from rfcompass.geometry import Pose2
from rfcompass.types import Observation, ProximityMatrix, TagPositions

HAND_TAGS_M = np.array([[0.0, 0.06, 0.194], [0.0, -0.06, 0.194], [0.075, 0.0, 0.194], [-0.075, 0.0, 0.194]])
BASE_TAGS_M = np.array(
    [[0.297, 0.11, 0.062], [0.297, -0.11, 0.062], [0.1, 0.18, 0.1], [0.1, -0.18, 0.1], [-0.1, 0.0, 0.209]]
)
SWEEP = [(0.42, 0.0, 0), (0.34, -0.14, 60), (0.49, 0.14, 120), (0.34, 0.14, -60), (0.49, -0.14, 90)]
ROBOT_EPCS = tuple(f"r{n}" for n in range(9))
ODOMETRY_M, ODOMETRY_RAD = 0.004, np.radians(0.5)


@dataclass(frozen=True)
class Errors:
    """σ of a tag's bias along one axis [m], of an additional error of each distance [m], and of its logarithm."""

    bias_m: float
    noise_m: float = 0.003
    share: float = 0.0


NEAR, FAR = Errors(0.013, 0.004), Errors(0.024, 0.006)


def biased_stops(rng, K=4, M=3, errors=NEAR, base_moves=False, scale=1.0, height_m=0.05, stated_m=None):
    """M stops, newest last, and the part's true pose in the newest base frame.

    Args:
        rng: Source of everything.
        K: Number of part tags.
        M: Number of stops.
        errors: How far off the proximities are.
        base_moves: Whether the base drives between stops; then odometry errs as its covariance says.
        scale: Units of the meter per metre.
        height_m: True height of the part's tags.
        stated_m: Height that the observation states; the true one if None.
    """
    angle, radius = rng.uniform(-np.pi, np.pi), 0.25 * np.sqrt(rng.uniform())
    first = Pose2(0.42 + radius * np.cos(angle), radius * np.sin(angle), rng.uniform(-np.pi, np.pi))
    seeming = leg_points(K, height_m)
    bias_m = errors.bias_m * rng.normal(size=(K, 2))
    base_bias_m = errors.bias_m * rng.normal(size=(len(BASE_TAGS_M), 2))
    T_true, T_odom, covariance, stops = Pose2(), Pose2(), np.zeros((3, 3)), []
    part, stated = a_leg(seeming), np.full(K, height_m if stated_m is None else stated_m)
    for s in range(M):
        if s and base_moves:
            T_true, T_odom, covariance = _drive(rng, T_true, T_odom, covariance)
            base_bias_m = errors.bias_m * rng.normal(size=base_bias_m.shape)
        x, y, yaw = SWEEP[s]
        hand_m = Pose2(x, y, np.radians(yaw)).apply(HAND_TAGS_M)
        anchors_m = np.vstack([hand_m, BASE_TAGS_M])
        off_m = np.vstack([errors.bias_m * rng.normal(size=(4, 2)), base_bias_m])
        anchors_seem_m = T_true.apply(anchors_m + np.pad(off_m, ((0, 0), (0, 1))))
        tags_seem_m = first.apply(seeming) + np.pad(bias_m, ((0, 0), (0, 1)))
        m = _measured(rng, tags_seem_m, anchors_seem_m, errors)
        own = _measured(rng, anchors_seem_m, anchors_seem_m, errors)
        own = np.triu(own, 1) + np.triu(own, 1).T
        np.fill_diagonal(own, np.nan)
        matrix = ProximityMatrix(part.epcs, ROBOT_EPCS, scale * m, scale * own, "sar_nearfield")
        stops.append(
            Observation(
                s,
                TagPositions("base", ROBOT_EPCS, anchors_m),
                part,
                stated,
                proximity=matrix,
                base_pose=T_odom,
                base_covariance=covariance,
            )
        )
    return stops, T_true.inverse() @ first


def _measured(rng, targets_m, anchors_m, errors):
    d = np.linalg.norm(targets_m[:, None] - anchors_m[None], axis=2)
    noise = rng.normal(size=(2, *d.shape))
    return np.abs(d + errors.noise_m * noise[0]) * np.exp(errors.share * noise[1])


def _drive(rng, T_true, T_odom, covariance):
    """Drive a little way; odometry thinks that it went as planned."""
    step = Pose2(*rng.uniform(-0.15, 0.15, 2), rng.uniform(-0.5, 0.5))
    slip = Pose2(*(ODOMETRY_M * rng.normal(size=2)), ODOMETRY_RAD * rng.normal())
    way = T_odom.apply(step.translation_m[None])[0] - T_odom.translation_m
    J = np.array([[1.0, 0.0, -way[1]], [0.0, 1.0, way[0]], [0.0, 0.0, 1.0]])
    own = np.diag([ODOMETRY_M**2, ODOMETRY_M**2, ODOMETRY_RAD**2])
    return T_true @ step @ slip, T_odom @ step, J @ covariance @ J.T + own
