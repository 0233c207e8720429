"""When to drive, when the part is in reach, when to grasp: decisions from proximities alone [Wang2013], section 4.

They need tag roles. "In reach" reads the hand's tags (`hand_left`, `hand_right`, `hand`) and those at the end of
the base (`base_end`). "Well positioned" reads `hand_left` and `hand_right` and, for a part with K tags, their
counterparts on it from the robot's `TagLayout.counterparts[K]`.
"""

import numpy as np

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.errors import InputError, TooFewReads
from rfcompass.geometry.pose2 import Pose2
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.observation import Observation
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.tags import TagLayout, TagPositions

HAND_ROLES = ("hand_left", "hand_right", "hand")
STOP_TOLERANCE_M = 0.01  # ours: the paper does not print its threshold


def next_goal(estimate: PartEstimate, share: float = 0.5) -> Pose2:
    """Where to drive next: half of the distance D in direction φ, facing the part [Wang2013], Eq. 11.

    Args:
        estimate: Where the part is, newest base frame.
        share: Part of the distance to drive; the paper takes a half.

    Returns:
        `T_base_goal` in the newest base frame.
    """
    step_m = share * estimate.distance_m
    phi = estimate.bearing_rad
    return Pose2(step_m * float(np.cos(phi)), step_m * float(np.sin(phi)), phi)


def in_reach_by_mean(matrix: ProximityMatrix, robot: TagLayout) -> bool:
    """First reach rule: the hand is as near to the part as the robot's tags are to each other.

    True iff the mean proximity between the hand's tags and the part's tags is at most the mean proximity of the
    robot's tags among themselves [Wang2013], section 4.2.B ("comparing the average distance between the robot
    tags themselves and their distances to the object tag").

    Raises:
        TooFewReads: If one of the two means has no value.
    """
    hand_to_part = matrix.m[:, _columns(matrix, robot, HAND_ROLES)]
    return _mean(hand_to_part, "hand and part") <= _mean(matrix.anchor_m, "robot tags")


def in_reach_by_base_end(matrix: ProximityMatrix, robot: TagLayout) -> bool:
    """Second reach rule: the hand's tags are nearer to the part's tags than to those at the end of the base.

    Each hand tag compares the mean over the part's tags with the mean over the `base_end` tags; all must agree
    [Wang2013], section 6. A hand tag that lacks one of the two means has no vote.

    Raises:
        InputError: If the layout has no tag with role `base_end`.
        TooFewReads: If no hand tag can vote.
    """
    ends = _columns(matrix, robot, ("base_end",))
    if not ends.size:
        raise InputError(f"layout {robot.body!r} has no tag with role base_end", layout=robot.body, role="base_end")
    hands = _columns(matrix, robot, HAND_ROLES)
    to_part = _row_means(matrix.m[:, hands].T)
    to_end = _row_means(matrix.anchor_m[np.ix_(hands, ends)])
    votes = ~np.isnan(to_part) & ~np.isnan(to_end)
    if not votes.any():
        raise TooFewReads("no hand tag was compared with both the part and the end of the base", reads=0, needed=1)
    return bool((to_part < to_end)[votes].all())


def well_positioned(
    observation: Observation,
    matrix: ProximityMatrix,
    robot: TagLayout,
    tolerance_m: float = STOP_TOLERANCE_M,
) -> bool:
    """Stop rule: left and right hand tag are near their counterparts on the part [Wang2013], section 4.3.A.

    True iff m(hand tag, its counterpart) is at most a threshold for both hand tags. The part looks the same after
    half a turn, so the counterparts may also be exchanged.

    Args:
        observation: Stop with the hand over the part: anchors, part layout and heights.
        matrix: Proximities at that stop.
        robot: Layout of the robot's tags: roles and counterparts.
        tolerance_m: How much farther than at the goal a counterpart may be [m].

    Raises:
        InputError: If the layout has no left or right hand tag, or no counterparts for the part's number of tags.
        TooFewReads: If a hand tag or its counterpart was not heard, or no pair of robot tags was.

    Deviations:
        The paper does not print its threshold. Ours is k (d + tolerance): d is the distance of hand tag and
        counterpart when the hand is centred over the part and closes across it, and k, the proximity per metre,
        is the median of m_ij / d_ij over all pairs of robot tags, whose distances are known.

        The rule is coarse, because a part that lies askew or aside can be as near to both hand tags. On distances
        with 1 cm of noise, the nine default tags, K = 4 and the hand 14 cm above the part's tags, it stops in
        about nine of ten cases where the part is centred to 1 cm and aligned to 3 degrees, falsely in eight of
        ten where the centre is 2.5 to 5 cm off in any direction and the part lies at any angle, in four of ten at 5
        to 10 cm, and in one of a hundred at 10 to 25 cm. Confirm with an estimate.
    """
    hands = _hand_tag(robot, "hand_left"), _hand_tag(robot, "hand_right")
    pair = _counterparts(observation, robot)
    limits = _goal_distances_m(observation, hands, pair) + tolerance_m
    limits *= proximity_per_metre(matrix, observation.anchors)
    rows = [_place(matrix.target_epcs, observation.part.epcs[k]) for k in pair]
    m = matrix.m[np.ix_(rows, [_place(matrix.anchor_epcs, epc) for epc in hands])]
    if np.isnan(m).any():
        raise TooFewReads("a hand tag and its counterpart on the part were not compared", reads=0, needed=1)
    return bool((np.diagonal(m) <= limits).all() or (np.diagonal(m[::-1]) <= limits).all())


def proximity_per_metre(matrix: ProximityMatrix, anchors: TagPositions) -> float:
    """Unit of a meter: median of m_ij / d_ij over the pairs of robot tags, whose distances d_ij are known.

    Raises:
        TooFewReads: If no pair was measured.
    """
    points_m = np.array([anchors.point_m(epc) for epc in matrix.anchor_epcs])
    distance_m = np.linalg.norm(points_m[:, None] - points_m[None, :], axis=2)
    i, j = np.triu_indices(len(points_m), 1)
    known = ~np.isnan(matrix.anchor_m[i, j]) & (distance_m[i, j] > 0.0)
    if not known.any():
        raise TooFewReads("no pair of robot tags was measured", reads=0, needed=1)
    return float(np.median(matrix.anchor_m[i, j][known] / distance_m[i, j][known]))


def _counterparts(observation: Observation, robot: TagLayout) -> tuple[int, int]:
    K = len(observation.part.epcs)
    if K not in robot.counterparts:
        known = sorted(robot.counterparts)
        raise InputError(f"layout {robot.body!r} has counterparts for K = {known}, not {K}", K=K, known=known)
    return robot.counterparts[K]["hand_left"], robot.counterparts[K]["hand_right"]


def _goal_distances_m(observation: Observation, hands: tuple[str, str], pair: tuple[int, int]) -> FloatArray:
    """Distance of left and right hand tag from their counterparts with the hand centred across the part, (2,)."""
    left_m, right_m = (observation.anchors.point_m(epc) for epc in hands)
    across_m = np.linalg.norm((left_m - right_m)[:2]) / 2.0
    along_m = np.linalg.norm(observation.part.points_m[list(pair), :2], axis=1)
    down_m = np.array([left_m[2], right_m[2]]) - observation.part_tag_heights_m[list(pair)]
    return np.asarray(np.sqrt(across_m**2 + along_m**2 + down_m**2))


def _columns(matrix: ProximityMatrix, robot: TagLayout, roles: tuple[str, ...]) -> IntArray:
    wanted = {robot.epcs[i] for role in roles for i in robot.with_role(role)}
    return np.array([i for i, epc in enumerate(matrix.anchor_epcs) if epc in wanted], dtype=np.int64)


def _hand_tag(robot: TagLayout, role: str) -> str:
    """EPC of the one tag with this role."""
    tags = robot.with_role(role)
    if len(tags) != 1:
        raise InputError(f"the stop rule needs one tag with role {role}, layout has {len(tags)}", role=role)
    return robot.epcs[tags[0]]


def _place(epcs: tuple[str, ...], epc: str) -> int:
    if epc not in epcs:
        raise TooFewReads(f"tag {epc} was not heard", epc=epc, reads=0, needed=1)
    return epcs.index(epc)


def _mean(m: FloatArray, what: str) -> float:
    heard = m[~np.isnan(m)]
    if not heard.size:
        raise TooFewReads(f"no proximity between {what}", reads=0, needed=1)
    return float(heard.mean())


def _row_means(m: FloatArray) -> FloatArray:
    """Mean of each row without NaN; NaN for a row of NaN."""
    heard = ~np.isnan(m)
    count = heard.sum(axis=1)
    total = np.where(heard, m, 0.0).sum(axis=1)
    return np.divide(total, count, out=np.full(len(m), np.nan), where=count > 0)
