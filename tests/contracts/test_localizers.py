"""What every localizer owes its user, whatever its method."""

import pickle
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from rfcompass.errors import InputError
from rfcompass.geometry import Pose2, polygon_area_m2, polygon_contains
from rfcompass.interfaces import Localizer
from rfcompass.localization.consistency import ConsistencyLocalizer
from rfcompass.localization.nearest_tag import NearestTagLocalizer
from rfcompass.localization.partition import PartitionLocalizer
from rfcompass.localization.posterior import PosteriorLocalizer
from rfcompass.localization.sar_localizer import SarLocalizer
from rfcompass.types import Observation, ProximityMatrix, TagLayout, TagPositions

# Each localizer, and how far its answer may move when the same scene is described anew: the box of the bounds
# turns with the frame, and a search in boxes meets other boxes.
LOCALIZERS = [
    pytest.param(PartitionLocalizer(), 1e-3, id="partition"),
    pytest.param(PartitionLocalizer(centre="chebyshev"), 1e-2, id="partition-chebyshev"),
    pytest.param(PartitionLocalizer(centre="centroid"), 1e-4, id="partition-centroid"),
    pytest.param(ConsistencyLocalizer(), 1e-2, id="consistency"),
    # The scene has no pairs of anchors. From comparisons alone the standard deviation is 2.5 to 4 cm here.
    pytest.param(PosteriorLocalizer(), 5e-3, id="posterior-comparisons"),
    pytest.param(PosteriorLocalizer(use="distances"), 2e-3, id="posterior"),
    pytest.param(SarLocalizer(), 4e-3, id="sar"),  # its tags are sought in squares of 5 mm
]
COARSE = [pytest.param(NearestTagLocalizer(), 1e-9, id="nearest_tag")]
every_localizer = pytest.mark.parametrize(("localizer", "slack_m"), LOCALIZERS + COARSE)
every_exact_localizer = pytest.mark.parametrize(("localizer", "slack_m"), LOCALIZERS)

LEG_M = np.array([[-0.2, 0.0, 0.0], [-0.07, 0.0, 0.0], [0.07, 0.0, 0.0], [0.2, 0.0, 0.0]])
HEIGHT_M = 0.05


def a_scene(seed, stops=3, N=9):
    """Stops with exact distances as proximities, and the part's true pose in the newest base frame."""
    rng = np.random.default_rng(seed)
    poses = [Pose2(*rng.uniform(-0.3, 0.3, 2), rng.uniform(-0.6, 0.6)) for _ in range(stops - 1)] + [Pose2()]
    truth = Pose2(*rng.uniform(-0.4, 0.4, 2), rng.uniform(-np.pi, np.pi))
    anchors = [np.column_stack([rng.uniform(-0.5, 0.5, (N, 2)), rng.uniform(0.0, 0.4, N)]) for _ in poses]
    return [
        observe(s, pose, anchors_m, truth) for s, (pose, anchors_m) in enumerate(zip(poses, anchors, strict=True))
    ], truth


def observe(stop_id, T_odom_base, anchors_m, T_odom_part):
    tags_m = (T_odom_base.inverse() @ T_odom_part).apply(LEG_M) + np.array([0.0, 0.0, HEIGHT_M])
    m = np.linalg.norm(tags_m[:, None] - anchors_m[None], axis=2)
    robot = tuple(f"robot-{i}" for i in range(len(anchors_m)))
    part = TagLayout("leg", tuple("wxyz"), ("part",) * 4, LEG_M, np.tile([0.0, 0.0, 1.0], (4, 1)), ("part",) * 4)
    nothing = np.full((len(robot),) * 2, np.nan)
    return Observation(
        stop_id, TagPositions("base", robot, anchors_m), part, np.full(4, HEIGHT_M),
        proximity=ProximityMatrix(part.epcs, robot, m, nothing, "distance"), base_pose=T_odom_base,
    )  # fmt: skip


def turn_between(a_rad, b_rad):
    return abs((a_rad - b_rad + np.pi) % (2 * np.pi) - np.pi)


@every_localizer
def test_it_is_a_localizer(localizer, slack_m):
    assert isinstance(localizer, Localizer)


@every_exact_localizer
def test_exact_proximities_give_the_part(localizer, slack_m):
    errors_m, turns = [], []
    for seed in range(20):
        observations, truth = a_scene(seed)
        estimate = localizer.estimate(observations)
        errors_m.append(np.hypot(*(estimate.centre_m - truth.translation_m)))
        turns.append(turn_between(estimate.theta_rad, truth.theta_rad))
        assert estimate.part_id == "leg"
        assert estimate.stops == 3
    assert np.median(errors_m) < 0.015
    assert np.median(turns) < np.radians(4)


@every_localizer
def test_the_odometry_frame_does_not_matter(localizer, slack_m):
    world = Pose2(-4.0, 7.0, 2.0)
    for seed in range(5):
        observations, _ = a_scene(seed)
        moved = [replace(stop, base_pose=world @ stop.base_pose) for stop in observations]
        a, b = localizer.estimate(observations), localizer.estimate(moved)
        assert np.abs(a.centre_m - b.centre_m).max() < 1e-6
        assert turn_between(a.theta_rad, b.theta_rad) < 1e-6


@every_localizer
@pytest.mark.parametrize("mount", [Pose2(0.2, -0.1, 0.0), Pose2(0.0, 0.0, 0.7), Pose2(-0.3, 0.4, -2.5)])
def test_the_answer_moves_with_the_base_frame(localizer, slack_m, mount):
    """The same robot, its base frame fixed to it in another place."""
    for seed in range(5):
        observations, _ = a_scene(seed)
        moved = [
            replace(
                stop,
                anchors=TagPositions("base", stop.anchors.epcs, mount.inverse().apply(stop.anchors.points_m)),
                base_pose=stop.base_pose @ mount,
            )
            for stop in observations
        ]
        a, b = localizer.estimate(observations).in_frame(mount.inverse()), localizer.estimate(moved)
        assert np.hypot(*(a.centre_m - b.centre_m)) < slack_m
        assert turn_between(a.theta_rad, b.theta_rad) < slack_m / 0.1


@every_localizer
def test_names_and_order_of_tags_do_not_matter(localizer, slack_m):
    rng = np.random.default_rng(0)
    for seed in range(5):
        observations, _ = a_scene(seed)
        a, b = localizer.estimate(observations), localizer.estimate([rename(stop, rng) for stop in observations])
        assert np.abs(a.centre_m - b.centre_m).max() < 1e-6
        assert turn_between(a.theta_rad, b.theta_rad) < 1e-6


def rename(stop, rng):
    """Give every tag another name and another place in the lists."""
    rows, columns = rng.permutation(len(stop.part.epcs)), rng.permutation(len(stop.anchors.epcs))
    robot = tuple(f"{rng.integers(2**60):024x}" for _ in columns)
    names = tuple(f"{rng.integers(2**60):024X}-p" for _ in rows)
    part = stop.part
    return replace(
        stop,
        anchors=TagPositions("base", robot, stop.anchors.points_m[columns]),
        part=replace(part, epcs=names, points_m=part.points_m[rows]),
        part_tag_heights_m=stop.part_tag_heights_m[rows],
        proximity=replace(
            stop.proximity, target_epcs=names, anchor_epcs=robot, m=stop.proximity.m[np.ix_(rows, columns)]
        ),
    )


@every_localizer
def test_the_same_question_gets_the_same_answer_whatever_was_asked_before(localizer, slack_m):
    (one, _), (other, _) = a_scene(1), a_scene(2)
    first = localizer.estimate(one)
    localizer.estimate(other)
    again = localizer.estimate(one)
    assert pickle.dumps(first) == pickle.dumps(again)


@every_localizer
def test_localizer_and_estimate_survive_a_pickle(localizer, slack_m):
    observations, _ = a_scene(3)
    estimate = localizer.estimate(observations)
    copy = pickle.loads(pickle.dumps(localizer)).estimate(pickle.loads(pickle.dumps(observations)))
    assert pickle.dumps(copy) == pickle.dumps(estimate)
    assert np.array_equal(pickle.loads(pickle.dumps(estimate)).centre_m, estimate.centre_m)


@every_localizer
def test_the_covariance_is_one_and_the_region_holds_the_estimate(localizer, slack_m):
    for seed in range(5):
        estimate = localizer.estimate(a_scene(seed)[0])
        assert np.linalg.eigvalsh(estimate.covariance).min() > 0.0
        assert polygon_area_m2(estimate.region_m) > 0.0
        assert polygon_contains(estimate.region_m, estimate.centre_m[None], 1e-6).all()


@every_localizer
def test_no_observation_is_refused(localizer, slack_m):
    with pytest.raises(InputError):
        localizer.estimate([])


def test_more_exact_comparisons_never_enlarge_the_region_of_the_partition():
    bounds_m = np.array([[-3.0, 3.0], [-3.0, 3.0]])
    localizer = PartitionLocalizer(bounds_m=bounds_m)
    for seed in range(10):
        observations, _ = a_scene(seed)
        regions = [localizer.estimate(observations[-count:]).region_m for count in (1, 2, 3)]
        for larger, smaller in pairwise(regions):
            assert polygon_contains(larger, smaller, 1e-6).all()
