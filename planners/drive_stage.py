"""The drive before a grasp, planned, put into time and certified like every other stage."""

from dataclasses import dataclass

import numpy as np

from planners.certificates import certify
from planners.grasp_worlds import start_failure
from planners.motion_check import MotionChecker
from planners.navigation import plan_drive
from planners.path_search import SearchRules
from planners.path_timing import in_time
from rfcompass.geometry.pose2 import Pose2
from rfcompass.robots import CollisionModel, FclCollisions, QuickCollisions, Robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasps import Failure
from rfcompass.types.motions import DRIVE, StageCertificate, TimedPath
from rfcompass.types.record import Record
from rfcompass.types.world import World


@dataclass(frozen=True, slots=True)
class DriveStage(Record):
    """A way of the base.

    Attributes:
        timed: The way in time.
        certificate: What it was checked against.
    """

    timed: TimedPath
    certificate: StageCertificate


def plan_drive_stage(
    robot: Robot, world: World, start: Configuration, goal: Pose2, rng: np.random.Generator, rules: SearchRules
) -> DriveStage | Failure:
    """Plan a drive in the present base frame, the arm held as it is.

    Links of the robot that overlap as it stands may do so all the way, since the arm does not move.

    Args:
        robot: A robot that drives.
        world: Floor and bodies.
        start: Joints.
        goal: Pose of the base to drive to.
        rng: Seeds the search.
        rules: How hard to look.
    """
    quick = QuickCollisions(CollisionModel(robot, world))
    touching = quick.touching(start)
    if (failure := start_failure(robot, touching)) is not None:
        return failure
    if touching:
        model = CollisionModel(robot, world, allowed=[(row.first, row.second) for row in touching])
        quick = QuickCollisions(model)
    found = plan_drive(MotionChecker(quick), start, goal, rng, rules)
    if isinstance(found, Failure):
        return found
    certificate = certify(FclCollisions(quick.model), DRIVE, found.path, found.report)
    return DriveStage(in_time(robot, DRIVE, found.path), certificate)
