"""What every arm over a pile does, so that a search cannot tell a simulated one from a real one."""

from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest
from same_records import differences

pytest.importorskip("mujoco", reason="the extra `piles` is not installed")

from simulation.pile_scenes import tiny

from planners.pile_arm import link_poses
from rfcompass.errors import OutOfReach
from rfcompass.interfaces import PileRobot
from rfcompass.mapping.camera import points_image
from rfcompass.studies.pile_robot import SimulatedPileRobot
from rfcompass.studies.pile_scan import CAMERA
from rfcompass.studies.searching import tagged_items_of
from rfcompass.types import ExtractionAction, TagFix

SEED, HIGH_M = 1, 0.10  # nothing but the leaning cylinder of this pile is so high
STRAY = TagFix("ff" * 12, np.array([0.1, 0.0, 0.05]), np.full(3, 0.05), True)
BESIDE_M, OVER_M, FAR_M = np.array([0.15, 0.05, 0.0]), np.array([-0.1, 0.0, 0.05]), np.array([3.0, 0.0, 0.0])


def simulated(tags):
    return SimulatedPileRobot(scene=tiny(), tags=tagged_items_of(tiny(), "any", tags, SEED), seed=SEED)


ROBOTS = {"simulated": lambda: simulated(0), "simulated, tagged": lambda: simulated(4)}
every_robot = pytest.mark.parametrize("name", ROBOTS)


class Said(NamedTuple):
    """One answer of a robot, and its clock before and after [s]."""

    asked: str
    told: tuple[Any, ...]
    answer: Any
    before_s: float
    after_s: float


def down_at(x_m, y_m, z_m):
    T = np.array([[1.0, 0, 0, x_m], [0, -1, 0, y_m], [0, 0, -1, z_m], [0, 0, 0, 1]])
    return ExtractionAction(1, T, 0.08, 1.0)


NOWHERE, BARE = down_at(2.0, 0.0, 0.05), down_at(0.2, 0.1, 0.04)


def top_m(view):
    """Middle of what is higher than all but the cylinder, in the world [m]; None if nothing is."""
    points_m = points_image(view).reshape(-1, 3)
    high = points_m[points_m[:, 2] > HIGH_M]
    return np.median(high, axis=0) if len(high) > 20 else None


class Day:
    """What a robot says to all that it can be asked.

    Args:
        robot: The arm.
        asks: Ask in between what must change nothing.
    """

    def __init__(self, robot, *, asks=False):
        self.robot, self.asks, self.said = robot, asks, []
        self.ask("scan")
        fixes = self.ask("listen_again")
        self.ask("look", BESIDE_M, 0.6)
        x_m, y_m, z_m = top_m(self.ask("look", OVER_M, 0.6, [*fixes, STRAY]).views[0])
        self.ask("look", FAR_M, 0.6)
        self.camera_by_joints = link_poses(robot.arm, [robot.motions[-1][1].end.joints], CAMERA)[0]
        for action in (NOWHERE, BARE, down_at(x_m, y_m, z_m - 0.012)):
            self.ask("reaches", action)
            self.ask("grasp", action)
        self.ask("look", OVER_M, 0.6)

    def ask(self, asked, *told):
        if self.asks:
            self.robot.reaches(BARE)
            if asked == "look":
                self.robot.reaches(NOWHERE)
        if self.asks and len(self.said) == 1:
            with pytest.raises(OutOfReach):
                self.robot.look(FAR_M, 0.6)
        before_s = self.robot.elapsed_s
        try:
            answer = getattr(self.robot, asked)(*told)
        except OutOfReach as why:
            answer = why
        self.said.append(Said(asked, told, answer, before_s, self.robot.elapsed_s))
        return answer

    def all(self, asked):
        """What was said to one question, refusals left out."""
        return [one for one in self.said if one.asked == asked and not isinstance(one.answer, OutOfReach)]

    @property
    def views(self):
        return [view for one in (*self.all("scan"), *self.all("look")) for view in one.answer.views]


@cache
def day(name):
    return Day(ROBOTS[name]())


@every_robot
def test_it_is_a_pile_robot_that_has_not_moved(name):
    robot = ROBOTS[name]()
    assert isinstance(robot, PileRobot)
    assert robot.elapsed_s == 0


@every_robot
def test_its_time_rises_with_each_motion_and_never_falls(name):
    clock = 0.0
    for one in day(name).said:
        moves = one.asked != "reaches" and not isinstance(one.answer, OutOfReach)
        moves = moves and getattr(one.answer, "outcome", "") != "unreachable"
        assert one.before_s == clock
        assert (one.after_s > clock) if moves else (one.after_s == clock)
        clock = one.after_s


@every_robot
def test_to_be_asked_whether_it_reaches_or_to_refuse_a_look_changes_nothing(name):
    """All that is said afterwards is the same to the last bit."""
    other = Day(ROBOTS[name](), asks=True)
    for one, again in zip(day(name).said, other.said, strict=True):
        assert (one.before_s, one.after_s) == (again.before_s, again.after_s)
        if not isinstance(one.answer, OutOfReach | bool):
            assert differences(again.answer, one.answer) == []


@every_robot
def test_every_view_has_colour_and_the_table_and_what_stands_on_it_where_they_are(name):
    """A camera that stands higher or is turned otherwise than the robot says sees them elsewhere from each place."""
    views = day(name).views
    assert len(views) >= 9
    for view in views:
        assert view.colour is not None
        assert abs(np.nanmedian(points_image(view)[..., 2])) < 0.005
    tops_m = np.array([seen_m for view in views if (seen_m := top_m(view)) is not None])
    assert len(tops_m) >= 6
    assert np.abs(tops_m - np.median(tops_m, axis=0)).max() < 0.01


@every_robot
def test_a_look_is_from_straight_above_the_point_as_high_as_was_asked(name):
    for one in day(name).all("look"):
        (view,), (point_m, height_m, *_) = one.answer.views, one.told
        assert view.T_world_camera[:3, 3] == pytest.approx([*point_m[:2], height_m], abs=2e-3)
        assert view.T_world_camera[:3, 2] == pytest.approx([0, 0, -1], abs=5e-3)


@every_robot
def test_the_camera_is_where_the_joints_say(name):
    last = day(name).all("look")[1].answer.views[0]
    assert last.T_world_camera == pytest.approx(day(name).camera_by_joints, abs=1e-9)


@every_robot
def test_a_look_where_the_arm_cannot_go_is_refused_with_the_reason(name):
    (refused,) = (one.answer for one in day(name).said if isinstance(one.answer, OutOfReach))
    assert "cannot look" in str(refused)


@every_robot
def test_tags_are_located_once_each_and_a_look_tells_of_those_that_it_was_asked_for(name):
    known = {tag.epc for tag in day(name).robot.tags.tags}
    (scan,), (again,) = day(name).all("scan"), day(name).all("listen_again")
    for fixes in (scan.answer.fixes, again.answer):
        assert len(fixes) == len({fix.epc for fix in fixes} & known) == len(known)
    for one in day(name).all("look"):
        asked = {fix.epc for tags in one.told[2:] for fix in tags}
        heard = [fix.epc for fix in one.answer.fixes]
        assert len(heard) == len(set(heard))
        assert set(heard) <= asked & known
        assert bool(heard) == bool(asked & known)


@every_robot
def test_what_it_reaches_it_goes_for_and_nothing_else(name):
    day_ = day(name)
    for said, done in zip(day_.all("reaches"), day_.all("grasp"), strict=True):
        assert said.answer is (said.told[0] is not NOWHERE)
        assert (done.answer.outcome == "unreachable") == (not said.answer)
        assert done.answer.duration_s == pytest.approx(done.after_s - done.before_s, abs=1e-9)
        assert done.answer.success or done.answer.message


@every_robot
def test_what_is_held_is_off_the_table_and_its_tag_answers_in_the_drop_zone(name):
    day_ = day(name)
    nowhere, bare, cylinder = (one.answer for one in day_.all("grasp"))
    assert (nowhere.outcome, bare.outcome, cylinder.outcome) == ("unreachable", "missed", "held")
    before, after = (one.answer.views[0] for one in day_.all("look")[1:])
    assert top_m(before) is not None
    assert top_m(after) is None
    known = {tag.epc for tag in day_.robot.tags.tags}
    assert len(cylinder.epcs) == bool(known)
    assert set(cylinder.epcs) <= known
    assert (nowhere.epcs, bare.epcs, cylinder.shows_target) == ((), (), False)
