"""Random scenes for the comparison methods: anchors at mixed heights, a part, exact distances between them."""

import numpy as np

from rfcompass.geometry import Pose2
from rfcompass.localization.compared_stop import ComparedStop
from rfcompass.localization.comparing import compare_proximities
from rfcompass.types import Comparisons, Observation, ProximityMatrix, TagLayout, TagPositions

LEG_X_M = {1: [0.0], 2: [-0.2, 0.2], 3: [-0.2, 0.0, 0.2], 4: [-0.2, -0.2 / 3, 0.2 / 3, 0.2]}


def leg_points(K=4, height_m=0.05):
    """Tags along a leg of 0.4 m: x, y in the part frame, z in the base frame."""
    return np.column_stack([LEG_X_M[K], np.zeros(K), np.full(K, height_m)])


def distances(anchors_m, part_points_m, T_stop_part):
    """Distance of every part tag to every anchor, shape (K, N)."""
    tags_m = T_stop_part.apply(part_points_m)
    return np.linalg.norm(tags_m[:, None, :] - anchors_m[None, :, :], axis=2)


def random_scene(rng, K=4, N=9, S=3, reach_m=0.5):
    """Poses of the stops in the newest one, anchors of each stop, tags of the part, and the part's true pose."""
    poses = [Pose2(*rng.uniform(-0.3, 0.3, 2), rng.uniform(-0.6, 0.6)) for _ in range(S - 1)] + [Pose2()]
    anchors = [np.column_stack([rng.uniform(-0.5, 0.5, (N, 2)), rng.uniform(0.0, 0.4, N)]) for _ in range(S)]
    truth = Pose2(*rng.uniform(-reach_m, reach_m, 2), rng.uniform(-np.pi, np.pi))
    return poses, anchors, leg_points(K), truth


def random_stops(rng, flips=0.0, margins=False, **size):
    """Compared stops of a random scene, a share of the comparisons flipped, and the part's true pose."""
    poses, anchors, points_m, truth = random_scene(rng, **size)
    stops = []
    for T_newest_stop, anchors_m in zip(poses, anchors, strict=True):
        exact = compare_proximities(distances(anchors_m, points_m, T_newest_stop.inverse() @ truth))
        flip = rng.uniform(size=len(exact)) < flips
        nearer, farther = np.where(flip, exact.farther, exact.nearer), np.where(flip, exact.nearer, exact.farther)
        margin = exact.margin if margins else np.full(len(exact), np.nan)
        comparisons = Comparisons(exact.target, nearer, farther, margin)
        stops.append(ComparedStop(anchors_m, points_m, comparisons, T_newest_stop))
    return tuple(stops), truth


def random_observations(rng, noise_m=0.0, **size):
    """The same as observations, whose proximities are distances with noise, and the part's true pose."""
    poses, anchors, points_m, truth = random_scene(rng, **size)
    K, N = len(points_m), len(anchors[0])
    part = a_leg(points_m)
    observations = []
    for s, (T_newest_stop, anchors_m) in enumerate(zip(poses, anchors, strict=True)):
        m = distances(anchors_m, points_m, T_newest_stop.inverse() @ truth) + noise_m * rng.normal(size=(K, N))
        anchor_m = np.linalg.norm(anchors_m[:, None] - anchors_m[None], axis=2)
        np.fill_diagonal(anchor_m, np.nan)
        robot = tuple(f"r{i}" for i in range(N))
        matrix = ProximityMatrix(part.epcs, robot, np.abs(m), anchor_m, "distance")
        anchors_at = TagPositions("base", robot, anchors_m)
        observations.append(Observation(s, anchors_at, part, points_m[:, 2], proximity=matrix, base_pose=T_newest_stop))
    return tuple(observations), truth


def a_leg(points_m):
    """Layout of a part whose tags all lie in its own plane z = 0."""
    K = len(points_m)
    return TagLayout(
        "leg", tuple(f"p{k}" for k in range(K)), ("part",) * K, points_m * [1.0, 1.0, 0.0],
        np.tile([0.0, 0.0, 1.0], (K, 1)), ("part",) * K,
    )  # fmt: skip
