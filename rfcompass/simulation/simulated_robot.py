"""A robot in a simulated room, behind the protocols of a real one. Its wheels slip; it believes what it commanded."""

from dataclasses import dataclass, field, replace

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError
from rfcompass.geometry.pose2 import Pose2
from rfcompass.robots.collision_model import homogeneous
from rfcompass.robots.hand import hand_of, opening_at
from rfcompass.robots.robot import Robot
from rfcompass.simulation.bumper import until_touching
from rfcompass.simulation.grasp_oracle import GraspTry, PartOracle, Push
from rfcompass.simulation.inventory import Inventory
from rfcompass.simulation.inventory_averages import inventory_scan
from rfcompass.simulation.plane_room import LyingPart, PlaneRoom
from rfcompass.simulation.radio_sensing import RadioSensor
from rfcompass.simulation.room_sensing import NoisyDistances, RoomSensor, RoomState
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasp_noise import GraspNoise
from rfcompass.types.grasps import GraspOutcome
from rfcompass.types.hands import Hand
from rfcompass.types.observation import Observation
from rfcompass.types.parts import Part
from rfcompass.types.reads import Scan
from rfcompass.types.robot_state import RobotState
from rfcompass.types.tags import TagLayout, TagPositions
from rfcompass.types.world import Body, World


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelSlip:
    """Error of the base after each move. The values are ours; the paper prints none.

    Attributes:
        position_m: Standard deviation along x and y [m].
        heading_rad: Standard deviation of the heading [rad].
    """

    position_m: float = 0.004
    heading_rad: float = float(np.deg2rad(0.5))

    def __post_init__(self) -> None:
        """Refuse slip that cannot be."""
        for name in ("position_m", "heading_rad"):
            if not (np.isfinite(value := getattr(self, name)) and value >= 0):
                raise InputError(f"WheelSlip.{name}: {value} is not a finite number >= 0", name=name)


@dataclass(frozen=True, slots=True)
class RecordedStop:
    """One stop as robot and reader recorded it. Holds no truth.

    Attributes:
        observation: What an estimator sees.
        configuration: What the robot believed about itself.
        inventory: What the reader reported; None where the sensor is no radio.
    """

    observation: Observation
    configuration: Configuration
    inventory: Inventory | None


@dataclass(slots=True)
class SimulatedRobot:
    """A robot in a room (`Scanner`, `MobileManipulator`, `HandOpener`), and who carries the antenna (`AntennaCarrier`).

    It is after one part at a time: scans list that part's tags, and the hand closes on it. `seek` sends it for another
    one of the room. While a part is held it counts as where it was grasped: nothing scans before it is put down.

    Args:
        robot: The robot's description and kinematics.
        part: What lies on the floor.
        layout: Which of the part's tags are on.
        room: True poses at the start.
        rng: Source of all noise.
        joints: Joint values at the start, shape (Q,).
        sensor: What a scan brings.
        slip: How far the wheels slip.
        area_m: Lower and upper corner of where the base's centre can be in the room [m]; its bumper stops it at the
            border. Everywhere if None.
        solid: What stops a drive, in the room's frame. Parts that lie beside the one that is sought always do; the
            sought one only where this is given.
        hand: The hand, where it is not that of the robot's URDF.
        grasp_noise: How tries of one grasp differ.
        push: How far a failed try moves the part.
    """

    robot: Robot
    part: Part
    layout: TagLayout
    room: PlaneRoom
    rng: np.random.Generator
    joints: FloatArray
    sensor: RoomSensor = field(default_factory=NoisyDistances)
    slip: WheelSlip = field(default_factory=WheelSlip)
    area_m: tuple[tuple[float, float], tuple[float, float]] | None = None
    solid: World | None = None
    hand: Hand | None = None
    grasp_noise: GraspNoise = field(default_factory=GraspNoise)
    push: Push = field(default_factory=Push)
    _believed: Pose2 = field(init=False, default_factory=Pose2)
    _covariance: FloatArray = field(init=False)
    _true: Pose2 = field(init=False)
    _stops: list[RecordedStop] = field(init=False, default_factory=list)
    _tries: list[GraspTry] = field(init=False, default_factory=list)
    _driven: list[Pose2] = field(init=False, default_factory=list)
    _T_hand_held: FloatArray | None = field(init=False, default=None)
    _drop_m: float | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        """Stand at the start; odometry begins at zero there."""
        self._true = self.room.T_room_base
        self._driven.append(self._true)
        self._covariance = np.zeros((3, 3))

    @property
    def configuration(self) -> Configuration:
        """What the robot believes about itself: odometry and joint sensors."""
        return self.robot.configuration(self.joints, self._believed)

    def state(self) -> RobotState:
        """What the robot believes about itself, with how far the wheels may have slipped."""
        return RobotState(self.joints, self._believed, self._covariance)

    @property
    def stops(self) -> tuple[RecordedStop, ...]:
        """All stops so far."""
        return tuple(self._stops)

    def scan(self) -> Observation:
        """Inventory all tags from here."""
        configuration = self.configuration
        anchors = self.robot.tag_positions(configuration)
        heard = self.sensor.hear(self._state(anchors), self.rng)
        known = {*anchors.epcs, *self.layout.epcs}
        observation = Observation(
            stop_id=len(self._stops),
            anchors=anchors,
            part=self.layout,
            part_tag_heights_m=self._target_heights_m(),
            scan=Scan() if heard.inventory is None else inventory_scan(heard.inventory, known),
            proximity=heard.proximity,
            base_pose=self._believed,
            base_covariance=self._covariance,
        )
        self._stops.append(RecordedStop(observation, configuration, heard.inventory))
        return observation

    def move_base(self, T_base_goal: Pose2) -> Pose2:
        """Drive until the goal or the bumper; the wheels slip, and the robot believes its wheels."""
        motion = self._until_bumper(T_base_goal)
        motion = until_touching(self.robot, self._in_the_way(), Configuration(self.joints, self._true), motion)
        slip_m, slip_rad = self.rng.normal(0.0, self.slip.position_m, 2), self.rng.normal(0.0, self.slip.heading_rad)
        self._covariance = self._grown_covariance(motion)
        self._true = self._true @ motion @ Pose2(slip_m[0], slip_m[1], slip_rad)
        self._believed = self._believed @ motion
        self._driven.append(self._true)
        return motion

    def move_arm(self, joints: FloatArray) -> None:
        """Move the joints; refuses values outside the limits."""
        self.robot.check_limits(self.robot.configuration(joints, self._believed))
        self.joints = np.array(joints, dtype=np.float64)

    def use_legs(self, legs_m: FloatArray) -> None:
        """Let the antenna's carrier drive other legs from now on; frame: the room's.

        Raises:
            InputError: If nothing here carries an antenna.
        """
        if not isinstance(self.sensor, RadioSensor):
            raise InputError(f"a {type(self.sensor).__name__} hears without an antenna", name="legs_m")
        self.sensor = self.sensor.along(legs_m)

    def close_hand(self) -> GraspOutcome:
        """Come down to where the tool is, as far open as the fingers are, and close; a failed try moves the part.

        Raises:
            RobotModelError: If no hand was given and the robot's own is not of the kind that `hand_of` reads.
        """
        hand, configuration = self.hand or hand_of(self.robot), self.configuration
        oracle = PartOracle(
            hand, self.part, self.room.T_room_part, self.rng, self.grasp_noise, self.push
        )  # fmt: skip
        T_room_hand = homogeneous(self._true) @ self.robot.tool_pose(configuration).homogeneous
        outcome = oracle.judge(T_room_hand, opening_at(self.robot, hand, configuration))
        self.room = replace(self.room, T_room_part=oracle.T_world_part)
        self._tries += oracle.tries
        if outcome.success:
            T_room_part = homogeneous(self.room.T_room_part)
            T_room_part[2, 3] = self.part.resting_height_m
            self._T_hand_held = np.linalg.inv(T_room_hand) @ T_room_part
        return outcome

    def open_hand(self) -> None:
        """Let go of the part: it falls onto the floor under where the hand holds it, and keeps its heading."""
        if self._T_hand_held is None:
            return
        T_room_hand = homogeneous(self._true) @ self.robot.tool_pose(self.configuration).homogeneous
        T = T_room_hand @ self._T_hand_held
        end = Pose2(float(T[0, 3]), float(T[1, 3]), float(np.arctan2(T[1, 0], T[0, 0])))
        self._drop_m = float(T[2, 3]) - self.part.resting_height_m
        self._T_hand_held, self.room = None, replace(self.room, T_room_part=end)

    def seek(self, part_id: str) -> None:
        """Turn to another part of the room; the present one stays where it lies.

        Raises:
            InputError: If the room has no such part, or the hand still holds one.
        """
        if part_id == self.part.part_id:
            return
        if self._T_hand_held is not None:
            raise InputError(f"{self.part.part_id} is still in the hand", name="part_id", part=part_id)
        wanted = next((one for one in self.room.others if one.part.part_id == part_id), None)
        if wanted is None:
            raise InputError(f"no part {part_id} lies in the room", name="part_id", part=part_id)
        if isinstance(self.sensor, RadioSensor):
            self.sensor = self.sensor.seeking(wanted.layout.epcs, self.true_state())
        left = LyingPart(self.part, self.layout, self.room.T_room_part)
        others = tuple(left if one is wanted else one for one in self.room.others)
        self.room = replace(self.room, T_room_part=wanted.T_room_part, others=others)
        self.part, self.layout = wanted.part, wanted.layout

    def true_tries(self) -> tuple[GraspTry, ...]:
        """Every closing of the hand as it truly was: for evaluation only."""
        return tuple(self._tries)

    def true_drop_m(self) -> float | None:
        """How far the part fell when the hand last let go of one [m]; None before that: for evaluation only."""
        return self._drop_m

    def true_pose_in_base(self) -> Pose2:
        """Pose of the part in the true base frame: for evaluation only."""
        return self._true.inverse() @ self.room.T_room_part

    def true_pose_in_room(self) -> Pose2:
        """True base pose in the room: for evaluation only."""
        return self._true

    def true_part_in_room(self) -> Pose2:
        """True pose of the part in the room: for evaluation only."""
        return self.room.T_room_part

    def true_way_in_room(self) -> tuple[Pose2, ...]:
        """True base poses at the start and after each drive, which are straight in between: for evaluation only."""
        return tuple(self._driven)

    def true_state(self) -> RoomState:
        """Where every tag truly is now: for evaluation only."""
        return self._state(self.robot.tag_positions(self.configuration))

    def _state(self, anchors: TagPositions) -> RoomState:
        T_room_part = self.room.T_room_part
        in_part_m = np.column_stack([self.layout.points_m[:, :2], self._target_heights_m()])
        return RoomState(
            T_room_base=self._true,
            anchors=TagPositions("room", anchors.epcs, self._true.apply(anchors.points_m)),
            anchor_dipoles=_turned(self._true, self.robot.tag_dipoles(self.configuration)),
            targets=TagPositions("room", self.layout.epcs, T_room_part.apply(in_part_m)),
            target_dipoles=_turned(T_room_part, self.layout.dipoles),
        )

    def _target_heights_m(self) -> FloatArray:
        """Height of each part tag over the floor [m], shape (K,)."""
        return np.asarray(self.layout.points_m[:, 2] + self.part.resting_height_m)

    def _until_bumper(self, T_base_goal: Pose2) -> Pose2:
        """The part of a straight drive that stays inside the area; the robot still turns."""
        if self.area_m is None:
            return T_base_goal
        start_m, goal_m = self._true.translation_m, (self._true @ T_base_goal).translation_m
        lower_m, upper_m = np.array(self.area_m)
        drive_m = goal_m - start_m
        room_m = np.where(drive_m > 0, upper_m - start_m, lower_m - start_m)
        shares = np.divide(room_m, drive_m, out=np.ones(2), where=drive_m != 0)
        share = float(np.clip(shares.min(), 0.0, 1.0))
        return Pose2(share * T_base_goal.x_m, share * T_base_goal.y_m, T_base_goal.theta_rad)

    def _in_the_way(self) -> World:
        """All that is solid now; a part that hangs in the hand is in nobody's way."""
        lying = [(one.part, one.T_room_part) for one in self.room.others]
        if self.solid is not None and self._T_hand_held is None:
            lying.append((self.part, self.room.T_room_part))
        bodies = [] if self.solid is None else list(self.solid.bodies)
        for part, T_room_part in lying:
            T = homogeneous(T_room_part)
            T[2, 3] = part.resting_height_m
            bodies.append(Body(part.part_id, part.shape, T))
        return World(tuple(bodies))

    def _grown_covariance(self, motion: Pose2) -> FloatArray:
        """Covariance of the believed pose after one more move, to first order."""
        x, y = self._believed.rotation @ motion.translation_m
        J = np.array([[1.0, 0.0, -y], [0.0, 1.0, x], [0.0, 0.0, 1.0]])
        step = np.diag([self.slip.position_m**2, self.slip.position_m**2, self.slip.heading_rad**2])
        grown = J @ self._covariance @ J.T + step
        return np.asarray((grown + grown.T) / 2.0)  # symmetric to the last bit, as a trace keeps it


def _turned(pose: Pose2, directions: FloatArray) -> FloatArray:
    """Directions of a body's frame, seen from where the body stands, shape (N, 3)."""
    return Pose2(0.0, 0.0, pose.theta_rad).apply(directions)
