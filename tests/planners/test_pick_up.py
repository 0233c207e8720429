"""The last phase: a try is made as planned, what is bumped is measured anew, and the budget ends in a typed way."""

from dataclasses import replace

import numpy as np
import pytest

from planners.fetch import Fetch, FetchStep
from planners.grasp import GraspPlanner
from planners.pick_up import GraspTrial, PickUp, PickUpRules
from rfcompass.errors import GraspFailed
from rfcompass.geometry import Pose2
from rfcompass.recordings import PartDatabase
from rfcompass.robots import YouBot
from rfcompass.simulation import NoisyDistances, PlaneRoom, SimulatedRobot, WheelSlip
from rfcompass.types import Failure, GraspOutcome, GraspPlan, PartEstimate

ROBOT = YouBot()
LEG = PartDatabase(":memory:").part("table_leg_3")
PLANNER = GraspPlanner(ROBOT)
START = ROBOT.posture("scan")


class Device(SimulatedRobot):
    """A simulated robot that remembers what it was told, and whose first closings may be made to fail."""

    def __init__(self, x_m=0.42, y_m=0.0, theta_rad=1.5, failing=0):
        room = PlaneRoom(T_room_base=Pose2(), T_room_part=Pose2(x_m, y_m, theta_rad))
        still = WheelSlip(position_m=0.0, heading_rad=0.0)
        super().__init__(
            ROBOT, LEG, LEG.layout(4), room, np.random.default_rng(0), START.joints, NoisyDistances(0.0), still
        )
        self.failing, self.told = failing, []

    def move_arm(self, joints):
        super().move_arm(joints)
        self.told.append(("arm", tuple(joints)))

    def move_base(self, T_base_goal):
        self.told.append(("base", T_base_goal))
        return super().move_base(T_base_goal)

    def close_hand(self):
        self.told.append(("close", None))
        if sum(kind == "close" for kind, _ in self.told) <= self.failing:
            return GraspOutcome(False, Failure("nothing_held", "the jaws have closed and hold nothing"))
        return super().close_hand()


class Told:
    """Stands in for a localizer: is told where the part is, give or take."""

    def __init__(self, device, sd_m=1e-3, theta=True):
        self.device, self.sd_m, self.theta, self.asked = device, sd_m, theta, []

    def estimate(self, observations):
        self.asked.append(len(observations))
        pose = self.device.true_pose_in_base()
        mean = np.array([*pose.translation_m, pose.theta_rad])
        covariance = np.diag([self.sd_m**2, self.sd_m**2, 0.01**2])
        samples = np.random.default_rng(1).multivariate_normal(mean, covariance, 300)
        return PartEstimate(
            LEG.part_id, mean[:2], mean[2] if self.theta else None, "told", len(observations), LEG.resting_height_m,
            samples=samples if self.theta else np.zeros((0, 3)),
        )  # fmt: skip


def picked_up(device, localizer, **rules):
    """All that happens after one stop with the hand over the part, and how it ended."""
    fetch = Fetch(ROBOT, device, localizer, START)
    fetch._joints = START.joints
    found = next(fetch._stop("localise"))
    job, events = PickUp(fetch, PLANNER, LEG, PickUpRules(**rules)), []
    try:
        events.extend(job.events(found))  # keeps what came before an error
    except GraspFailed as failure:
        return events, failure
    return events, None


def test_a_known_part_is_in_the_hand_after_one_try():
    device = Device()
    events, failure = picked_up(device, Told(device))
    assert failure is None
    (trial,) = events
    assert isinstance(trial, GraspTrial)
    assert trial.outcome.success
    assert not trial.plan.defects


def test_the_arm_goes_through_every_waypoint_of_the_plan_in_order():
    device = Device()
    ((trial,), _) = picked_up(device, Told(device))
    waypoints = [("arm", tuple(joints)) for stage in trial.plan.stages for joints in stage.joints]
    assert [order for order in device.told if order[0] == "arm"] == waypoints
    before = sum(len(stage.joints) for stage in trial.plan.stages if stage.stage in ("reach", "approach"))
    assert device.told.index(("close", None)) == before


def test_after_a_failed_try_the_hand_backs_off_and_the_part_is_measured_anew():
    device = Device(failing=1)
    localizer = Told(device)
    events, failure = picked_up(device, localizer)
    assert failure is None
    kinds = ["try" if isinstance(event, GraspTrial) else "stop" for event in events]
    assert kinds == ["try", "stop", "stop", "stop", "try"]
    assert localizer.asked == [1, 1, 2, 3]  # what was heard before the part was bumped is forgotten
    first = events[0].plan
    closed = device.told.index(("close", None))
    back = [("arm", tuple(joints)) for joints in first.approach[::-1]]
    assert device.told[closed + 1 : closed + 1 + len(back)] == back
    assert all(isinstance(event, FetchStep) for event in events[1:4])


def test_a_try_takes_the_time_of_its_motions_and_a_failed_one_that_of_the_way_back():
    device = Device(failing=1)
    (failed, *_, held), _ = picked_up(device, Told(device))
    for trial, backs in ((failed, 1), (held, 0)):
        seconds = {stage.stage: float(stage.times_s[-1]) for stage in trial.plan.stages}
        last = len(seconds) if trial is held else list(seconds).index("close") + 1
        expected_s = sum(list(seconds.values())[:last]) + backs * seconds["approach"]
        assert trial.spent.arm_s == pytest.approx(expected_s)
        assert trial.spent.total_s == trial.spent.arm_s > 0.0


def test_the_budget_of_tries_ends_with_the_last_reason():
    device = Device(failing=9)
    events, failure = picked_up(device, Told(device), max_tries=2)
    assert sum(isinstance(event, GraspTrial) for event in events) == 2
    assert failure.numbers == {"reason": "nothing_held", "tries": 2}


def test_a_part_beside_the_robot_is_driven_to_first():
    device = Device(0.9, 0.35, 1.2)
    events, failure = picked_up(device, Told(device))
    assert failure is None
    assert any(kind == "base" for kind, _ in device.told)
    assert events[-1].outcome.success


def test_without_an_orientation_there_is_no_grasp_and_the_looking_ends():
    device = Device()
    events, failure = picked_up(device, Told(device, theta=False), max_drives=1)
    assert not any(isinstance(event, GraspTrial) for event in events)
    assert (failure.kind, failure.numbers["reason"]) == ("GraspFailed", "orientation_unknown")


def test_a_part_that_is_too_heavy_is_left_alone():
    device = Device()
    fetch = Fetch(ROBOT, device, Told(device), START)
    fetch._joints = START.joints
    job = PickUp(fetch, PLANNER, replace(LEG, mass_kg=3.0))
    with pytest.raises(GraspFailed) as failure:
        list(job.events(next(fetch._stop("localise"))))
    assert failure.value.numbers["reason"] == "too_heavy"
    assert not device.told


def test_a_plan_without_certificates_is_not_carried_out():
    class Careless:
        def plan(self, part, estimate, world, start):
            return GraspPlan(start.joints, start.joints[None], start.joints[None], 0.07, 0.0)

    device = Device()
    fetch = Fetch(ROBOT, device, Told(device), START)
    fetch._joints = START.joints
    job = PickUp(fetch, Careless(), LEG)
    with pytest.raises(GraspFailed, match="no record of how the inverse kinematics was solved") as failure:
        list(job.events(next(fetch._stop("localise"))))
    assert failure.value.numbers["reason"] == "not_certified"
    assert not device.told
