"""Choose the next stop: what a robot can do, scored by what it would tell."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError, OutOfReach
from rfcompass.interfaces import StopProposer
from rfcompass.localization import NoiseModel, StopScores, next_best_stop
from rfcompass.robots import Robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.stops import ProposedStop

SCAN_S = 20.0  # ours: two legs of 3 m at 0.3 m/s
# Ours: half length and half width of the youBot's body with 4 cm to spare; the part must not be run over.
BODY_HALF_M = (0.33, 0.22)
RUN_OVER_SHARE = 0.02  # ours: of the poses in question


@dataclass(frozen=True, slots=True)
class NextStop:
    """The chosen stop and all that it was chosen from.

    Attributes:
        configuration: Where to stop.
        stops: All stops that would not run over the part; one that stays where it is never does.
        scores: Their scores, in the same order.
    """

    configuration: Configuration
    stops: tuple[ProposedStop, ...]
    scores: StopScores


def choose_next_stop(
    robot: Robot,
    now: Configuration,
    proposer: StopProposer,
    poses: FloatArray,
    part_points_m: FloatArray,
    noise: NoiseModel | None = None,
) -> NextStop:
    """Find the stop that tells most about the part for the time it takes.

    Args:
        robot: Kinematics, for where its tags would be.
        now: Where the robot is; the poses are in its base frame.
        proposer: What it can do.
        poses: Poses (x, y, θ) of the part in question [m, m, rad], shape (S, 3).
        part_points_m: Part tags: x, y in the part frame, z in the base frame [m], shape (K, 3).
        noise: How far comparisons can be trusted.

    Raises:
        InputError: If there are no poses.
        OutOfReach: If no stop is left.
    """
    if len(poses) < 2:
        raise InputError(f"{len(poses)} poses: nothing to be unsure about", poses=len(poses))
    offered = proposer.candidates(now)
    stops = [
        stop
        for stop in offered
        if stop.configuration.base == now.base or not _runs_over(now, stop, poses, part_points_m)
    ]
    if not stops:
        raise OutOfReach(f"none of {len(offered)} stops leaves the part alone", stops=len(offered))
    points_m = robot.tag_positions_batch(np.array([stop.configuration.joints for stop in stops]))
    anchors_m = [
        (now.base.inverse() @ stop.configuration.base).apply(one) for stop, one in zip(stops, points_m, strict=True)
    ]
    seconds = np.array([stop.seconds + SCAN_S for stop in stops])
    scores = next_best_stop(poses, part_points_m, anchors_m, seconds, noise)
    return NextStop(stops[scores.best].configuration, tuple(stops), scores)


def _runs_over(now: Configuration, stop: ProposedStop, poses: FloatArray, part_points_m: FloatArray) -> bool:
    """True if the body would stand on the part, at too many of its poses."""
    c, s = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
    x, y = part_points_m[:, 0], part_points_m[:, 1]
    tags_m = np.stack([poses[:, :1] + c * x - s * y, poses[:, 1:2] + s * x + c * y], axis=2)
    in_body_m = (stop.configuration.base.inverse() @ now.base).apply(tags_m.reshape(-1, 2)).reshape(tags_m.shape)
    under = np.any(np.all(np.abs(in_body_m) < BODY_HALF_M, axis=2), axis=1)
    return float(np.mean(under)) > RUN_OVER_SHARE
