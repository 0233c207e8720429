"""Maps of grasps hold what inverse kinematics says, come back from disk, and agree with an earlier reach study."""

from dataclasses import replace

import numpy as np
import pytest
from collision_scenes import ROBOT, at
from hypothesis import given
from hypothesis import strategies as st

from planners.ik import IkRules, InverseKinematics
from planners.reachability import MapMaker
from planners.task_map import TaskMap, ToolDirections, load_task_map, top_down
from rfcompass.errors import InputError, ShapeError
from rfcompass.robots import load_robot
from rfcompass.robots.layouts import data_folder
from rfcompass.robots.packages import extra_folder
from rfcompass.types import Body, Box, Configuration, GraspTask, SearchVolume, Solution, World

SCAN = ROBOT.posture("scan")
VOLUME = SearchVolume([0.24, -0.10, 0.02], [0.56, 0.10, 0.06])
DOWN = np.array([0, 0, -1.0])


def maker(robot=ROBOT, world=None, spacing_m=0.04, **rules):
    ik = InverseKinematics(robot, world, IkRules(certify=False, explain=False, **rules))
    return MapMaker(ik=ik, spacing_m=spacing_m, samples=3000)


MAP = maker().make(VOLUME, top_down(4), SCAN)


def test_every_voxel_says_what_inverse_kinematics_says():
    ik = maker().ik
    assert 0.1 < MAP.reached.mean() < 0.9
    for index in np.ndindex(MAP.reached.shape):
        point_m = MAP.centres_m(np.array(index[:3]))
        assert MAP.reached[index] == isinstance(ik.solve(MAP.directions.task(point_m, index[3]), SCAN), Solution)


def test_between_voxels_that_can_a_task_can_be_done_too():
    rng, fine = np.random.default_rng(1), maker(spacing_m=0.01).make(VOLUME, top_down(2), SCAN)
    closed, seen = maker().ik, 0
    while seen < 30:
        point = rng.uniform(VOLUME.lower_m, VOLUME.upper_m)
        task = GraspTask(point, DOWN, fine.directions.closing[seen % 2])
        if fine.can(point[None], np.array([seen % 2]))[0]:
            assert isinstance(closed.solve(task, SCAN), Solution)
            seen += 1


def test_a_task_counts_only_where_its_surroundings_can_be_done():
    centre = MAP.centres_m(np.argwhere(MAP.reached[..., 0])[0])
    assert MAP.can(centre[None], np.array([0]))[0]
    assert not MAP.can(np.array([[5.0, 0, 0]]), np.array([0]))[0]
    for point in np.random.default_rng(2).uniform(VOLUME.lower_m, VOLUME.upper_m, (200, 3)):
        nearest = np.round((point - MAP.origin_m) / MAP.spacing_m).astype(int)
        if MAP.can(point[None], np.array([1]))[0]:
            assert MAP.reached[(*nearest, 1)]


def test_the_share_is_that_of_the_directions():
    assert MAP.reach_map.share == pytest.approx(MAP.reached.mean(axis=3))


def test_an_obstacle_takes_voxels_away_and_gives_none():
    box = World((Body("box", Box(np.array([0.1, 0.1, 0.1])), at(0.42, 0.0, 0.05)),))
    less = maker(world=box).make(VOLUME, top_down(4), SCAN)
    assert not (less.reached & ~MAP.reached).any()
    assert less.reached.sum() < MAP.reached.sum()


def test_a_map_comes_back_from_disk(tmp_path):
    MAP.save(tmp_path / "map.npz")
    again = load_task_map(tmp_path / "map.npz")
    assert again.reached.tolist() == MAP.reached.tolist()
    assert again.spacing_m == MAP.spacing_m
    assert again.directions.closing.tolist() == MAP.directions.closing.tolist()
    assert [path.name for path in tmp_path.iterdir()] == ["map.npz"]


@pytest.mark.parametrize("content", [b"", b"no map", None])
def test_a_file_that_is_no_map_is_named(tmp_path, content):
    path = tmp_path / "map.npz"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=r"map\.npz"):
        load_task_map(path)


def test_a_map_of_another_kind_or_shape_is_refused(tmp_path):
    fields = {"origin_m": MAP.origin_m, "spacing_m": 0.1, "approach": MAP.directions.approach, "reached": MAP.reached}
    closing, schema = MAP.directions.closing, "rfcompass-task-map/1"
    changes = {
        "kind": {"schema": "x", "closing": closing},
        "lack": {"schema": schema},
        "shape": {"schema": schema, "closing": closing[:2]},
    }
    for name, change in changes.items():
        np.savez(tmp_path / f"{name}.npz", **fields, **change)
        with pytest.raises(InputError, match=name):
            load_task_map(tmp_path / f"{name}.npz")
    with pytest.raises(InputError, match="written"):
        MAP.save(tmp_path / "nowhere" / "map.npz")
    with pytest.raises(ShapeError):
        TaskMap(MAP.origin_m, 0.0, MAP.directions, MAP.reached)
    with pytest.raises(ShapeError):
        ToolDirections(np.eye(3), np.eye(3)[:2])


@given(count=st.integers(1, 24))
def test_headings_of_the_jaws_are_spread_over_half_a_turn(count):
    directions = top_down(count)
    assert np.abs((directions.approach * directions.closing).sum(axis=1)).max() < 1e-12
    headings = np.arctan2(directions.closing[:, 1], directions.closing[:, 0])
    assert np.diff(headings) == pytest.approx(np.pi / count)


@pytest.mark.skipif(extra_folder() is None, reason="the robots extra is not installed")
def test_an_arm_without_a_closed_form_is_sampled_and_verified():
    panda = load_robot("panda")
    made = maker(panda, World(floor_m=None), spacing_m=0.2, starts=2)
    start = panda.configuration([0, -0.5, 0, -2.0, 0, 1.6, 0.8, 0.04, 0.04][: len(panda.joint_names)])
    volume = SearchVolume([0.3, -0.2, 0.2], [0.7, 0.2, 0.6])
    directions = ToolDirections(DOWN[None], np.full((1, 3), np.nan))
    sampled = made.make(volume, directions, start, np.random.default_rng(3))
    assert sampled.reached.any()
    with pytest.raises(ValueError, match="rng"):
        made.make(volume, directions, start)


@pytest.mark.skipif(extra_folder() is None, reason="the robots extra is not installed")
def test_a_map_that_spreads_holds_all_that_was_sampled_and_is_verified_too():
    panda = load_robot("panda")
    start = panda.configuration({"panda_joint4": -2.0, "panda_joint6": 1.6, "panda_finger_joint1": 0.04})
    volume, directions = SearchVolume([0.3, -0.2, 0.2], [0.7, 0.2, 0.3]), top_down(2)
    plain = maker(panda, World(floor_m=None), spacing_m=0.2, starts=4)
    sampled = plain.make(volume, directions, start, np.random.default_rng(3)).reached
    spread = replace(plain, spread=True).make(volume, directions, start, np.random.default_rng(3))
    assert not (sampled & ~spread.reached).any()
    assert spread.reached.sum() > sampled.sum() > 0
    for index in np.argwhere(spread.reached)[::3]:
        task = directions.task(spread.centres_m(index[:3]), int(index[3]))
        assert isinstance(plain.ik.solve(task, start), Solution)


# --- The reach study: youBot, fingers of the published length, tips 0.0789 from arm_link_5, no tags ------------------

STUDY = load_robot(data_folder() / "variants" / "youbot_study_hand.json")
STUDY_SCAN = STUDY.posture("scan")
WITHIN_M = 0.005
SIDEWAYS, FORE_AFT = [0, 1.0, 0], [1.0, 0, 0]


def can(point, approach, closing, world=None):
    ik = InverseKinematics(STUDY, world, IkRules(certify=False, explain=False, soft_limits=False, method="closed_form"))
    return isinstance(ik.solve(GraspTask(point, approach, closing), STUDY_SCAN), Solution)


def lying(d, theta):
    c, s = np.cos(theta), np.sin(theta)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return World((Body("leg", Box(np.array([0.4, 0.05, 0.05])), at(d, 0, 0.025, R)),))


@pytest.mark.parametrize(
    ("height_m", "closing", "near_m", "far_m"),
    [(0.005, SIDEWAYS, 0.306, 0.488), (0.005, FORE_AFT, 0.340, 0.488), (0.025, SIDEWAYS, 0.304, 0.490),
     (0.025, FORE_AFT, 0.338, 0.490), (0.050, SIDEWAYS, 0.298, 0.490), (0.050, FORE_AFT, 0.336, 0.490)],
)  # fmt: skip
def test_a_vertical_hand_reaches_as_far_as_in_the_study(height_m, closing, near_m, far_m):
    for inside in (near_m + WITHIN_M, far_m - WITHIN_M):
        assert can([inside, 0, height_m], DOWN, closing)
    for outside in (near_m - WITHIN_M, far_m + WITHIN_M):
        assert not can([outside, 0, height_m], DOWN, closing)


def test_a_leg_across_the_base_is_grasped_at_its_centre_as_in_the_study():
    """0.34 to 0.48 m ahead, with hover, and nothing beyond 0.50."""
    for d, expected in ((0.345, True), (0.42, True), (0.475, True), (0.33, False), (0.50, False), (0.55, False)):
        world = lying(d, np.pi / 2)
        assert all(can([d, 0, z], DOWN, FORE_AFT, world) for z in (0.075, 0.025, 0.010)) == expected


@pytest.mark.parametrize("d", [0.52, 0.55, 0.585])
def test_a_radial_leg_is_grasped_only_with_a_pitch_of_150_to_165_degrees(d):
    def at_pitch(degrees):
        a = np.deg2rad(degrees)
        return can([d, 0, 0.025], [np.sin(a), 0, np.cos(a)], SIDEWAYS, lying(d, 0.0))

    assert [degrees for degrees in (105, 120, 135, 150, 165, 180) if at_pitch(degrees)] in ([150], [150, 165])


@pytest.mark.parametrize(("pitch", "far_m"), [(105, None), (120, 0.60), (135, 0.61), (150, 0.59), (165, 0.54)])
def test_a_pitched_hand_reaches_as_far_as_in_the_study(pitch, far_m):
    """Tip at 0.025 m; the study's grid is 1 cm."""
    a = np.deg2rad(pitch)
    reached = [x for x in np.arange(0.40, 0.70, 0.005) if can([x, 0, 0.025], [np.sin(a), 0, np.cos(a)], SIDEWAYS)]
    if far_m is None:
        assert not reached
    else:
        assert far_m - 0.005 <= max(reached) < far_m + 0.010 + 0.005


def test_the_study_hand_opens_to_75_mm_and_ends_0_0789_from_the_arm():
    T = STUDY.link_pose(STUDY_SCAN, "arm_link_5").actInv(STUDY.tool_pose(STUDY_SCAN))
    assert T.translation == pytest.approx([0, 0, 0.0789])
    inner = [STUDY.link_pose(STUDY_SCAN, f"gripper_finger_link_{side}").translation[1] for side in "lr"]
    assert abs(inner[0] - inner[1]) - 2 * 0.008 == pytest.approx(0.075)
    assert Configuration(STUDY_SCAN.joints).joints.size == 7
