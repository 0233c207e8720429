"""One simulated fetch from its seed: room, robot, noise, loop. What the command line runs and studies repeat."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from planners.fetch import Fetch, FetchRules, FetchStep
from rfcompass.evaluation.metrics import angle_error_rad, position_error_m
from rfcompass.geometry.pose2 import Pose2
from rfcompass.interfaces import Localizer
from rfcompass.robots import Robot
from rfcompass.simulation import PlaneRoom, RoomNoise, SimulatedRobot
from rfcompass.studies.study import trial_rng
from rfcompass.types.parts import Part

SCAN_POSTURE = "scan"


@dataclass(frozen=True, slots=True, kw_only=True)
class FetchTask:
    """What to fetch, with what, and how hard the world makes it.

    Attributes:
        robot: The robot; its posture "scan" is where it starts.
        part: What lies on the floor.
        tags: Number of tags on the part, K.
        spacing: Which placement of K tags.
        localizer: Finds the part.
        seed: Start poses and all noise follow from it.
        rules: When the loop does what.
        noise: How much worse than ideal the room is.
    """

    robot: Robot
    part: Part
    tags: int
    localizer: Localizer
    seed: int
    spacing: str = "ends"
    rules: FetchRules = field(default_factory=FetchRules)
    noise: RoomNoise = field(default_factory=RoomNoise)


@dataclass(frozen=True, slots=True)
class JudgedStep:
    """A step of the loop, and how far off it was: only a simulation can say.

    Attributes:
        step: What the robot knows.
        centre_error_m: Distance between estimated and true centre [m].
        theta_error_rad: Angle between estimated and true orientation [rad]; None if none was estimated.
        T_room_base: True pose of the base.
    """

    step: FetchStep
    centre_error_m: float
    theta_error_rad: float | None
    T_room_base: Pose2


def simulate_fetch(task: FetchTask) -> Iterator[JudgedStep]:
    """Run the loop in a plane room and judge every step.

    Raises:
        NoAnswer: If the loop ends without the part; the subclass says why.
    """
    rng = trial_rng("fetch", task.seed)
    start = task.robot.posture(SCAN_POSTURE)
    layout = task.part.layout(task.tags, task.spacing)
    room = PlaneRoom.draw(rng)
    device = SimulatedRobot(task.robot, task.part, layout, room, rng, start.joints, task.noise)
    for step in Fetch(task.robot, device, task.localizer, start, task.rules).steps():
        truth = device.true_pose_in_base()
        theta_rad = step.estimate.theta_rad
        yield JudgedStep(
            step,
            float(position_error_m(step.estimate.centre_m, truth.translation_m)),
            None if theta_rad is None else float(np.asarray(angle_error_rad(theta_rad, truth.theta_rad))),
            device.true_pose_in_room(),
        )
