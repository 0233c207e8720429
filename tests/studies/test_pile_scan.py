"""The arm over the table: it can go round, and what it records is what `survey` reads."""

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the extra `piles` is not installed")

from planners import InverseKinematics
from rfcompass.recordings import open_trace, write_trace
from rfcompass.simulation import RIG_WRIST
from rfcompass.simulation.piles import PileFamily, make_pile, scan_pile, scan_poses, tag_items
from rfcompass.studies.pile_scan import T_WORLD_BASE, located, pile_trace, workspace, wrist_way
from rfcompass.types.grasp_task import GraspTask, Solution
from rfcompass.types.world import World


@pytest.fixture(scope="module")
def tagged_pile():
    scene = make_pile(PileFamily("tiny", "covered", (4,)), 1, "hidden")
    return scene.world(), tag_items(scene, "any", 3, np.random.default_rng(0))


@pytest.fixture(scope="module")
def scan(tagged_pile):
    way, (world, tags) = wrist_way("two"), tagged_pile
    return scan_pile(world, tags, way.camera_poses, way.track, np.random.default_rng(0))


def test_images_are_taken_where_scenes_are_judged_turned_by_half():
    way = wrist_way("one")
    assert way.camera_poses == pytest.approx(scan_poses() @ np.diag([-1, -1, 1, 1]), abs=1e-5)


def test_the_second_round_is_lower_and_antennas_look_down():
    way = wrist_way("two")
    heights_m = way.track.positions_m[:, 2]
    assert 0.4 < heights_m.min() < 0.5 < 0.6 < heights_m.max() < 0.75
    assert way.track.rotations[:, :, 0] == pytest.approx(np.tile([0, 0, -1.0], (len(way.track), 1)), abs=1e-6)
    tx_m = RIG_WRIST.tx.places(way.track)
    of_arm = way.motion.poses_of(way.robot, "antenna_tx_link", T_WORLD_BASE)[:, :3, 3]
    assert tx_m == pytest.approx(of_arm, abs=1e-9)


def test_what_was_recorded_is_what_was_scanned(scan, tagged_pile, tmp_path):
    epcs = [tag.epc for tag in tagged_pile[1].tags]
    write_trace(pile_trace(scan), tmp_path / "trace")
    read, made = open_trace(tmp_path / "trace").scan(), scan.scan(epcs)
    assert (read.frame, read.epcs) == ("table", made.epcs)
    for epc in made.epcs:
        assert np.array_equal(read.trace(epc).channel, made.trace(epc).channel, equal_nan=True)


def test_every_tag_is_located_or_refused_and_lies_on_the_table(scan, tagged_pile):
    epcs = [tag.epc for tag in tagged_pile[1].tags]
    found = located(scan.scan(epcs), epcs)
    assert {*found.fixes, *found.refusals} == set(epcs)
    for fix in found.fixes.values():
        assert workspace().contains(fix.point_m[None]).all()


@pytest.mark.parametrize("height_m", [0.03, 0.15])
def test_the_hand_reaches_the_table_where_piles_lie(height_m):
    robot = wrist_way("one").robot
    ik = InverseKinematics(robot, World(floor_m=-float(T_WORLD_BASE[2, 3])))
    down = np.array([0.0, 0.0, -1.0])
    for x_m in (-0.4, 0.0, 0.4):
        for y_m in (-0.3, 0.0, 0.3):
            point_m = (np.linalg.inv(T_WORLD_BASE) @ [x_m, y_m, height_m, 1.0])[:3]
            assert isinstance(ik.solve(GraspTask(point_m, down), robot.posture("scan")), Solution)
