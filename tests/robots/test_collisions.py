"""Two independent checkers agree, and both know what touches what."""

import numpy as np
import pytest
import trimesh
from collision_scenes import ROBOT, at, random_configurations, things

from rfcompass.errors import RobotModelError, ShapeError
from rfcompass.geometry import Pose2
from rfcompass.robots import YouBot, load_robot
from rfcompass.robots.collision_model import CollisionModel
from rfcompass.robots.fcl_collisions import FclCollisions
from rfcompass.robots.packages import extra_folder
from rfcompass.robots.quick_collisions import QuickCollisions
from rfcompass.robots.touching_links import always_touching
from rfcompass.types import Body, Box, Configuration, Sphere, World

CANDLE = ROBOT.posture("candle")


def both(world=None, robot=ROBOT, **options):
    model = CollisionModel(robot, world or World(), **options)
    return QuickCollisions(model), FclCollisions(model)


def agree(model, configurations):
    """Number of configurations that collide; both checkers must say the same of each."""
    quick, slow = QuickCollisions(model), FclCollisions(model)
    answers = np.array([(quick.collides(c), slow.collides(c)) for c in configurations])
    assert (answers[:, 0] == answers[:, 1]).all(), np.flatnonzero(answers[:, 0] != answers[:, 1])
    return int(answers[:, 0].sum())


@pytest.mark.parametrize("padding_m", [0.0, 0.01])
def test_both_checkers_agree_on_every_random_configuration(padding_m):
    hits = agree(CollisionModel(ROBOT, things(), padding_m, with_tags=True), random_configurations(800, seed=1))
    assert 200 < hits < 790  # neither answer is the only one


@pytest.mark.slow
def test_both_checkers_agree_on_a_hundred_thousand_random_configurations():
    agree(CollisionModel(ROBOT, things()), random_configurations(100_000, seed=2))


def test_a_distance_is_negative_exactly_where_the_checker_sees_a_collision():
    quick, _ = both(things())
    for configuration in random_configurations(300, seed=3):
        nearest = quick.nearest(configuration)
        assert nearest.touching == quick.collides(configuration)
        assert bool(quick.touching(configuration)) == nearest.touching


def test_fcl_never_reports_less_distance_than_coal_and_mostly_the_same():
    quick, slow = both(things())
    assert quick.pair_names == slow.pair_names
    off = np.array([slow.distances(c) - quick.distances(c) for c in random_configurations(60, seed=4)])
    assert off.min() > -1e-4
    assert (np.abs(off) < 1e-4).mean() > 0.98


def test_the_floor_is_a_half_space_for_both():
    """The tip of the open hand, straight down, is as high over the floor as the tool."""
    quick, slow = both()
    scan = ROBOT.posture("scan")
    height_m = ROBOT.tool_pose(scan).translation[2]
    for checker in (quick, slow):
        rows = zip(checker.pair_names, checker.distances(scan), strict=True)
        fingers = [d for (first, second), d in rows if "finger" in first and second == "floor"]
        assert min(fingers) == pytest.approx(height_m, abs=1e-6)
    low = CollisionModel(ROBOT, World(floor_m=height_m + 1e-6))
    assert FclCollisions(low).collides(scan)
    assert QuickCollisions(low).collides(scan)
    high = CollisionModel(ROBOT, World(floor_m=height_m - 1e-6))
    assert not FclCollisions(high).collides(scan)
    assert not QuickCollisions(high).collides(scan)


def test_postures_are_free_except_where_the_primitives_are_too_large():
    """Folded, the boxes of links 2 and 4 overlap by 5 mm; the real links, rounder than boxes, do not."""
    quick, _ = both()
    assert not quick.collides(CANDLE)
    assert not quick.collides(ROBOT.posture("scan"))
    (row,) = quick.touching(ROBOT.posture("folded"))
    assert (row.first, row.second) == ("arm_link_2", "arm_link_4")
    assert -0.005 < row.distance_m < 0


def test_moving_the_base_is_moving_the_world_the_other_way():
    quick, slow = both(World((Body("ball", Sphere(0.1), at(0.6, 0.1, 0.5)),)))
    for configuration in random_configurations(20, seed=5):
        T = at(*configuration.base.translation_m, 0.0)
        T[:2, :2] = configuration.base.rotation
        moved = Body("ball", Sphere(0.1), np.linalg.inv(T) @ at(0.6, 0.1, 0.5))
        other, _ = both(World((moved,)))
        standing = Configuration(configuration.joints)
        assert quick.distances(configuration) == pytest.approx(other.distances(standing), abs=5e-6)  # GJK's tolerance
        assert slow.collides(configuration) == other.collides(standing)


def test_the_base_bumps_into_obstacles_but_stands_on_the_floor():
    for checker in both(World((Body("crate", Box(np.array([0.2, 0.2, 0.2])), at(0.35, 0, 0.1)),))):
        assert checker.collides(CANDLE)
        assert not checker.collides(Configuration(CANDLE.joints, Pose2(-0.2, 0, 0)))


def test_what_the_hand_holds_moves_with_it_and_may_touch_the_fingers_only():
    leg = Body("leg", Box(np.array([0.05, 0.4, 0.05])), at(0.42, 0, 0.025))
    held = World((leg,)).attach("leg", "gripper_tool_link", at(0, 0, 0), ["gripper_palm_link"])
    quick, slow = both(held)
    pairs = {frozenset(names) for names in quick.pair_names}
    assert frozenset({"leg", "floor"}) in pairs
    assert frozenset({"leg", "base_link"}) in pairs
    assert frozenset({"leg", "gripper_palm_link"}) not in pairs
    scan = ROBOT.posture("scan")
    rows = dict(zip(quick.pair_names, quick.distances(scan), strict=True))
    assert rows["leg", "floor"] == pytest.approx(0.10 - 0.025, abs=1e-6)
    assert slow.collides(scan) == quick.collides(scan)


def test_allowed_pairs_are_not_looked_at():
    folded = ROBOT.posture("folded")
    for checker in both(allowed=[("arm_link_4", "arm_link_2")]):
        assert not checker.collides(folded)


def test_padding_keeps_its_distance_from_the_world():
    ball = World((Body("ball", Sphere(0.05), at(0.42, 0.0, 0.06)),), floor_m=None)
    scan = ROBOT.posture("scan")
    gap_m = both(ball)[0].nearest(scan).distance_m
    assert 0 < gap_m < 0.02  # nearer than any two links are to each other
    for checker in both(ball, padding_m=gap_m / 2):
        assert not checker.collides(scan)
    for checker in both(ball, padding_m=gap_m * 1.001):
        assert checker.collides(scan)


def test_a_robot_without_anything_to_touch_has_no_nearest_pair():
    quick, _ = both(World(floor_m=None), allowed=())
    assert quick.nearest(CANDLE) is not None  # its own links
    bare = CollisionModel(ROBOT, World(floor_m=None))
    object.__setattr__(bare, "pairs", ())
    assert QuickCollisions(bare).nearest(CANDLE) is None


@pytest.mark.parametrize("padding_m", [-0.01, np.nan, np.inf])
def test_bad_padding_is_refused(padding_m):
    with pytest.raises(ShapeError):
        CollisionModel(ROBOT, padding_m=padding_m)


def test_unknown_names_are_refused_and_the_known_ones_listed():
    with pytest.raises(RobotModelError, match="arm_link_2"):
        CollisionModel(ROBOT, allowed=[("arm_link_2", "elbow")])
    with pytest.raises(RobotModelError, match="arm_link_2"):
        CollisionModel(ROBOT, World((Body("leg", Sphere(0.1), np.eye(4), "elbow"),)))
    with pytest.raises(RobotModelError, match="called like a link"):
        CollisionModel(ROBOT, World((Body("arm_link_2", Sphere(0.1), np.eye(4)),)))


def test_no_pair_of_the_youbots_links_always_touches():
    assert always_touching(YouBot()) == ()


@pytest.mark.skipif(extra_folder() is None, reason="the robots extra is not installed")
def test_links_of_a_robot_of_meshes_that_always_touch_are_found_and_both_checkers_agree():
    panda = load_robot("panda")
    allowed = always_touching(panda, samples=30)
    rng = np.random.default_rng(6)
    draws = rng.uniform(panda.limits.lower, panda.limits.upper, (40, len(panda.joint_names)))
    agree(CollisionModel(panda, things(), allowed=allowed), [panda.configuration(q) for q in draws])


OVERLAPPING = """<robot name="chain">
<link name="a"><collision><geometry><sphere radius="0.3"/></geometry></collision></link>
<link name="b"/><link name="c"><collision><geometry><sphere radius="0.3"/></geometry></collision></link>
<joint name="ab" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
<joint name="bc" type="revolute"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/><origin xyz="0.2 0 0"/>
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>"""


def test_links_that_overlap_everywhere_are_found_and_may_then_touch(tmp_path):
    (tmp_path / "chain.urdf").write_text(OVERLAPPING)
    chain = load_robot(tmp_path / "chain.urdf")
    assert always_touching(chain) == (("a", "c"),)
    for allowed, hit in (((), True), (always_touching(chain), False)):
        for checker in both(World(floor_m=None), chain, allowed=allowed):
            assert checker.collides(chain.configuration()) == hit


def test_a_collision_mesh_that_is_missing_is_named(tmp_path):
    text = OVERLAPPING.replace('<sphere radius="0.3"/>', '<mesh filename="lost.stl"/>', 1)
    (tmp_path / "chain.urdf").write_text(text)
    with pytest.raises(RobotModelError, match=r"link 'a'.*lost\.stl"):
        CollisionModel(load_robot(tmp_path / "chain.urdf"))


def test_a_collision_mesh_is_its_hull(tmp_path):
    trimesh.creation.box((0.2, 0.4, 0.6)).export(tmp_path / "block.stl")
    text = OVERLAPPING.replace('<sphere radius="0.3"/>', '<mesh filename="block.stl" scale="1 1 0.5"/>', 1)
    (tmp_path / "chain.urdf").write_text(text)
    model = CollisionModel(load_robot(tmp_path / "chain.urdf"))
    assert model.solids[0].half_size_m == pytest.approx([0.1, 0.2, 0.15])
    empty = OVERLAPPING.replace('<sphere radius="0.3"/>', '<mesh filename="bad.stl"/>', 1)
    (tmp_path / "bad.stl").write_text("solid nothing\nendsolid nothing\n")
    (tmp_path / "chain.urdf").write_text(empty)
    with pytest.raises(RobotModelError, match=r"bad\.stl"):
        CollisionModel(load_robot(tmp_path / "chain.urdf"))
