"""One scan with the hand over the part: what studies of the radio repeat."""

from dataclasses import dataclass

import numpy as np

from planners.hand_over import hand_over
from rfcompass.arrays import FloatArray
from rfcompass.geometry.pose2 import Pose2
from rfcompass.robots import Robot
from rfcompass.simulation import PlaneRoom, RoomState, SimulatedRobot
from rfcompass.studies.radio_setup import DRIVE_AREA_M, RadioSetup
from rfcompass.types.observation import Observation
from rfcompass.types.parts import Part
from rfcompass.types.tags import TagLayout

# Ours, as in the pilot study: the part lies 1.5 to 3.5 m from both legs of the antenna's track, and its centre within
# 25 cm of the place where the hand works.
PART_AREA_M = ((2.2, 2.2), (4.2, 4.0))
HAND_M = (0.42, 0.0)
HAND_HEIGHT_M = 0.10
DISC_M = 0.25


@dataclass(frozen=True, slots=True)
class ScannedStop:
    """One stop, and the truth behind it.

    Attributes:
        observation: What an estimator sees.
        truth: Where every tag was.
    """

    observation: Observation
    truth: RoomState

    @property
    def distances_m(self) -> FloatArray:
        """True distance of each part tag to each anchor [m], shape (K, N)."""
        gaps_m = self.truth.targets.points_m[:, None] - self.truth.anchors.points_m[None]
        return np.asarray(np.linalg.norm(gaps_m, axis=2))


def scan_over_part(
    robot: Robot, part: Part, layout: TagLayout, radio: RadioSetup, rng: np.random.Generator
) -> ScannedStop:
    """Put robot and part somewhere in the room, hold the hand over the part and scan once.

    Args:
        robot: The robot; its posture "scan" is where the arm starts.
        part: What lies on the floor.
        layout: Which of its tags are on.
        radio: Room, track and reader.
        rng: Source of everything.
    """
    room = room_with_hand_over_part(rng)
    start = robot.posture("scan")
    joints = hand_over(robot, start, np.array([*HAND_M, HAND_HEIGHT_M]), 0.0).joints
    sensor = radio.sensor(room, robot.layout, layout, rng)
    device = SimulatedRobot(robot, part, layout, room, rng, joints, sensor)
    return ScannedStop(device.scan(), device.true_state())


def room_with_hand_over_part(rng: np.random.Generator) -> PlaneRoom:
    """Lay the part somewhere in the middle of the room, and the robot so that its hand can be about over it."""
    lower_m, upper_m = np.array(DRIVE_AREA_M)
    while True:
        x_m, y_m = rng.uniform(*PART_AREA_M)
        theta_rad, heading_rad, angle_rad = rng.uniform(-np.pi, np.pi, 3)
        radius_m = DISC_M * np.sqrt(rng.uniform())
        off_m = np.array(HAND_M) + radius_m * np.array([np.cos(angle_rad), np.sin(angle_rad)])
        base = Pose2(x_m, y_m, heading_rad) @ Pose2(-off_m[0], -off_m[1], 0.0)
        if (base.translation_m >= lower_m).all() and (base.translation_m <= upper_m).all():
            return PlaneRoom(T_room_base=base, T_room_part=Pose2(x_m, y_m, theta_rad))
