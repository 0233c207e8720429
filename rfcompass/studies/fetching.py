"""One simulated fetch from its seed: room, robot, radio, loop. What the command line runs and studies repeat."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from planners.antenna_track import NearTrack
from planners.drive_around import DriveAround
from planners.fetch import Fetch, FetchStep
from planners.fetch_rules import FetchRules
from planners.final_stops import FinalStops
from planners.grasp import GraspPlanner
from planners.hand_stops import HandStops
from planners.map_pose import KnownStart, MapPose, RadioPose
from planners.motion_check import MotionChecker
from planners.near_antenna import NearAntenna
from planners.pick_up import GraspTrial, PickUp
from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError
from rfcompass.evaluation.metrics import angle_error_rad, position_error_m
from rfcompass.geometry.pose2 import Pose2
from rfcompass.interfaces import Localizer, ProximityMeter
from rfcompass.robots import CollisionModel, QuickCollisions, Robot
from rfcompass.simulation import (
    CameraRig,
    MotionCapture,
    NoisyDistances,
    PlaneRoom,
    RecordedStop,
    RoomSensor,
    SimulatedRobot,
    WheelSlip,
)
from rfcompass.simulation.motion_capture import NoReader
from rfcompass.simulation.radio_sensing import RadioSensor
from rfcompass.studies.fetch_job import ReportedStep
from rfcompass.studies.radio_setup import AREA_M, DRIVE_AREA_M, RadioSetup, standing_m
from rfcompass.studies.study import trial_rng
from rfcompass.types.parts import Part
from rfcompass.types.scene import Scene
from rfcompass.types.tags import TagLayout
from rfcompass.types.world import Body, World, world_of_scene

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
        radio: What it hears with; None for distances with noise, without any radio.
        meter: Measures proximities from the reads of a radio.
        sigma: Noise of the distances where there is no radio: standard deviation of log m.
        slip: How far the wheels slip.
        near: How the antenna's carrier comes near the part; None if it drives the radio's legs always.
        active_stops: Whether the last stops are chosen by what they would tell.
        map_pose: How the robot knows where it stands on a map of the room, to drive around what stands there:
            `"radio"` (its own tags), `"start"` (told at the start, then odometry), `"cameras"`; None to drive straight.
        solid: Whether furniture stops the base, and the part as well; else it is only there for radio, carrier and map.
        cameras: Find the part by motion capture in place of the radio, whose room it then is.
    """

    robot: Robot
    part: Part
    tags: int
    localizer: Localizer
    seed: int
    spacing: str = "ends"
    rules: FetchRules = field(default_factory=FetchRules)
    radio: RadioSetup | None = None
    meter: ProximityMeter | None = None
    sigma: float = 0.05
    slip: WheelSlip = field(default_factory=WheelSlip)
    near: NearTrack | None = None
    active_stops: bool = False
    map_pose: Literal["radio", "start", "cameras"] | None = None
    solid: bool = False
    cameras: bool = False

    def __post_init__(self) -> None:
        """Refuse a map or cameras without a furnished room, and a pose from cameras that are not there."""
        if self.radio is None and (self.cameras or self.map_pose is not None):
            raise InputError("only the room of a radio is furnished and mapped", name="radio")
        if self.map_pose == "cameras" and not self.cameras:
            raise InputError("the pose on the map is to come from cameras, and there are none", name="map_pose")


@dataclass(frozen=True, slots=True)
class JudgedStep(ReportedStep):
    """A step of the loop, and how far off it was: only a simulation can say.

    Attributes:
        centre_error_m: Distance between estimated and true centre [m].
        theta_error_rad: Angle between estimated and true orientation [rad]; None if none was estimated.
        T_room_base: True pose of the base.
    """

    centre_error_m: float
    theta_error_rad: float | None
    T_room_base: Pose2


@dataclass(frozen=True, slots=True)
class OtherParts:
    """What a robot knows about parts that it is not after now: obstacles.

    Attributes:
        where: Knows where the base stands on the map on which they are.
        bodies: The parts, where they seem to lie on that map.
    """

    where: MapPose
    bodies: tuple[Body, ...] = ()


class SimulatedFetch:
    """The loop in a simulated room, judged step by step.

    Args:
        task: What to fetch.
        device: The robot in a room that was furnished before; it is after the task's part. None for a room of the
            task's own.
        others: Other parts that it knows of; on the map of the room, if the task has one.
    """

    def __init__(self, task: FetchTask, device: SimulatedRobot | None = None, others: OtherParts | None = None) -> None:
        """Furnish the room and put the robot into it."""
        self._task = task
        self._device = furnish(task) if device is None else device
        self._first_stop = len(self._device.stops)
        heard = self._device.sensor
        self._scene = heard.scene.scene if isinstance(heard, RadioSensor) else None
        antenna = None if task.cameras else antenna_of(task, self._device)
        if task.cameras:
            self._device.sensor = NoReader()
        localizer, rules, where = task.localizer, task.rules, self._known_pose()
        if task.cameras:
            localizer, rules = self._capture(), replace(rules, tags_tell_reach=False)
        self._around = around = self._drives_around(others or (None if where is None else OtherParts(where)))
        start, final = task.robot.posture(SCAN_POSTURE), final_stops(task.robot) if task.active_stops else None
        self._loop = Fetch(task.robot, self._device, localizer, start, rules, task.meter, antenna, around, final)

    @property
    def scene(self) -> Scene | None:
        """The room and what stands in it; None where there is no radio."""
        return self._scene

    @property
    def true_way(self) -> tuple[Pose2, ...]:
        """True poses of the base in the room, at the start and after each straight drive."""
        return self._device.true_way_in_room()

    @property
    def device(self) -> SimulatedRobot:
        """The robot in its room: what a server puts behind a socket."""
        return self._device

    @property
    def around(self) -> DriveAround | None:
        """Plans the drives around what the robot knows of; None if it drives straight."""
        return self._around

    @property
    def robot(self) -> Robot:
        """The robot that fetches."""
        return self._task.robot

    @property
    def stops(self) -> tuple[RecordedStop, ...]:
        """All stops for this part so far, one whose localisation failed included."""
        return self._device.stops[self._first_stop :]

    @property
    def true_part_m(self) -> FloatArray:
        """True centre of the part in the room [m], shape (2,)."""
        return self._device.true_part_in_room().translation_m

    @property
    def part_away_m(self) -> float:
        """True distance of the part from the base's centre now [m]."""
        return float(np.linalg.norm(self._device.true_pose_in_base().translation_m))

    def steps(self) -> Iterator[JudgedStep]:
        """Run the loop and judge every step.

        Raises:
            NoAnswer: If the loop ends without the part; the subclass says why.
        """
        for step in self._loop.steps():
            yield self._judged(step)

    def navigate(self) -> Iterator[JudgedStep]:
        """Run the first phase only, until the robot takes the part to be in reach; raises as `steps` does."""
        for step in self._loop.navigate():
            yield self._judged(step)

    def pick_up(self, found: ReportedStep) -> Iterator[JudgedStep | GraspTrial]:
        """Grasp the part; judge the stops that are made in between.

        Args:
            found: The last step of `steps`.

        Raises:
            GraspFailed: If the part is not in the hand at the end; says why.
            NoAnswer: If the part is lost after a failed try.
            RobotModelError: If the robot has no hand of two fingers.
        """
        planner = GraspPlanner(self._task.robot)
        for event in PickUp(self._loop, planner, self._task.part).events(found.step):
            yield self._judged(event) if isinstance(event, FetchStep) else event

    def _drives_around(self, others: OtherParts | None) -> DriveAround | None:
        """Drives around the furniture, where there is a map of it, and around other parts."""
        if others is None:
            return None
        task, mapped = self._task, self._task.map_pose is not None and self._scene is not None
        room = world_of_scene(self._scene) if mapped and self._scene is not None else World()
        world, searches = room.with_bodies(*others.bodies), trial_rng("drive", task.seed)
        area_m = DRIVE_AREA_M if mapped else None
        return DriveAround(task.robot, world, others.where, searches, area_m, part=task.part)

    def _known_pose(self) -> MapPose | None:
        match self._task.map_pose:
            case "radio":
                return RadioPose()
            case "start":
                return KnownStart(self._device.true_pose_in_room())
            case "cameras":
                return self._capture()
        return None

    def _capture(self) -> MotionCapture:
        if self._scene is None or self._scene.room is None:
            raise InputError("cameras hang under the ceiling of a room, and there is none", name="cameras")
        return MotionCapture(
            CameraRig.under_ceiling(self._scene.room), self._scene, self._device, trial_rng("cameras", self._task.seed)
        )

    def _judged(self, step: FetchStep) -> JudgedStep:
        truth, theta_rad = self._device.true_pose_in_base(), step.estimate.theta_rad
        return JudgedStep(
            step,
            float(position_error_m(step.estimate.centre_m, truth.translation_m)),
            None if theta_rad is None else float(np.asarray(angle_error_rad(theta_rad, truth.theta_rad))),
            self._device.true_pose_in_room(),
        )


def final_stops(robot: Robot) -> FinalStops:
    """Hand poses without drives: the part stays under the hand."""
    proposer = HandStops(robot=robot, drive_m=0.0, turn_rad=0.0)
    return FinalStops(robot, proposer, MotionChecker(QuickCollisions(CollisionModel(robot, World()))))


def furnish(task: FetchTask, others: Sequence[Part] = ()) -> SimulatedRobot:
    """Furnish a room from the task's seed and put the robot into it.

    Args:
        task: What to fetch first.
        others: More parts that the robot will be sent for, with as many tags each.
    """
    rng = trial_rng("fetch", task.seed)
    layout = task.part.layout(task.tags, task.spacing)
    more = [(part, part.layout(task.tags, task.spacing)) for part in others]
    if task.radio is None:
        room = PlaneRoom.draw(rng).with_others(more, rng)
    else:
        room = PlaneRoom.draw(rng, area_m=AREA_M).with_others(more, rng, AREA_M)
    sensor = _sensor(task, room, layout, rng)
    start = task.robot.posture(SCAN_POSTURE)
    return SimulatedRobot(
        task.robot, task.part, layout, room, rng, start.joints, sensor, task.slip,
        None if task.radio is None else DRIVE_AREA_M, _solid(task, sensor),
    )  # fmt: skip


def antenna_of(task: FetchTask, device: SimulatedRobot) -> NearAntenna | None:
    """Who sends the antenna's carrier nearer in the task's room; None if it drives one track always."""
    if task.near is None or not isinstance(device.sensor, RadioSensor):
        return None
    return NearAntenna(device, task.near, keep_out_m=standing_m(device.sensor.scene))


def _solid(task: FetchTask, sensor: RoomSensor) -> World | None:
    """Furniture that stops the base; None if it does not."""
    if not (task.solid and isinstance(sensor, RadioSensor)):
        return None
    return world_of_scene(sensor.scene.scene)


def _sensor(task: FetchTask, room: PlaneRoom, layout: TagLayout, rng: np.random.Generator) -> RoomSensor:
    if task.radio is None:
        return NoisyDistances(task.sigma)
    return task.radio.sensor(room, task.robot.layout, layout, rng)
