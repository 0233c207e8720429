"""A robot and a part in an empty room, with distances that are known up to noise.

The first world of the whole job: no radio yet. A tag pair's proximity is its true distance times a random
factor, so that comparisons go wrong where distances are nearly equal, as they do on a real channel. The wheels
slip: the robot believes what it commanded.
"""

from dataclasses import dataclass, field

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError
from rfcompass.geometry.pose2 import Pose2
from rfcompass.robots.robot import Robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasps import Failure, GraspOutcome
from rfcompass.types.observation import Observation
from rfcompass.types.parts import Part
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.tags import TagLayout, TagPositions


@dataclass(frozen=True, slots=True, kw_only=True)
class RoomNoise:
    """How much worse than ideal the plane room is. All values are ours; the paper prints none.

    Attributes:
        distance_sigma: Standard deviation of log m; 0.05 makes about 2 % of all comparisons wrong.
        slip_m: Standard deviation of the base's position error after each move, along x and y [m].
        slip_rad: Standard deviation of its heading error after each move [rad].
    """

    distance_sigma: float = 0.05
    slip_m: float = 0.004
    slip_rad: float = float(np.deg2rad(0.5))

    def __post_init__(self) -> None:
        """Refuse noise that cannot be."""
        for name in ("distance_sigma", "slip_m", "slip_rad"):
            if not (np.isfinite(value := getattr(self, name)) and value >= 0):
                raise InputError(f"RoomNoise.{name}: {value} is not a finite number >= 0", name=name)


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaneRoom:
    """Where everything truly is at the start. This record is truth.

    Attributes:
        T_room_base: Pose of the robot's base.
        T_room_part: Pose of the part, which lies on the floor.
    """

    T_room_base: Pose2
    T_room_part: Pose2

    @classmethod
    def draw(cls, rng: np.random.Generator, distance_m: tuple[float, float] = (2.0, 6.0)) -> "PlaneRoom":
        """Draw start and part in the paper's 6 x 5 m area, as far apart as its runs were (2 to 6 m).

        Args:
            rng: Source of both poses.
            distance_m: Smallest and largest distance between them [m].
        """
        while True:
            x, y = rng.uniform((0.5, 0.5), (5.5, 4.5), (2, 2)).T  # ours: half a metre from the walls
            if distance_m[0] <= np.hypot(np.diff(x), np.diff(y))[0] <= distance_m[1]:
                headings = rng.uniform(-np.pi, np.pi, 2)
                return cls(
                    T_room_base=Pose2(x[0], y[0], headings[0]), T_room_part=Pose2(x[1], y[1], headings[1])
                )  # fmt: skip


@dataclass(slots=True)
class SimulatedRobot:
    """A robot in a plane room, behind the protocols of a real one (`Scanner`, `MobileManipulator`).

    Args:
        robot: The robot's description and kinematics.
        part: What lies on the floor.
        layout: Which of the part's tags are on.
        room: True poses at the start.
        rng: Source of all noise.
        noise: How much of it.
        joints: Joint values at the start, shape (Q,).
    """

    robot: Robot
    part: Part
    layout: TagLayout
    room: PlaneRoom
    rng: np.random.Generator
    joints: FloatArray
    noise: RoomNoise = field(default_factory=RoomNoise)
    _believed: Pose2 = field(init=False, default_factory=Pose2)
    _covariance: FloatArray = field(init=False)
    _true: Pose2 = field(init=False)
    _stop: int = field(init=False, default=-1)

    def __post_init__(self) -> None:
        """Stand at the start; odometry begins at zero there."""
        self._true = self.room.T_room_base
        self._covariance = np.zeros((3, 3))

    @property
    def configuration(self) -> Configuration:
        """What the robot believes about itself: odometry and joint sensors."""
        return self.robot.configuration(self.joints, self._believed)

    def scan(self) -> Observation:
        """Compare every tag with every other one from here."""
        self._stop += 1
        anchors = self.robot.tag_positions(self.configuration)
        return Observation(
            stop_id=self._stop,
            anchors=anchors,
            part=self.layout,
            part_tag_heights_m=self.layout.points_m[:, 2] + self.part.resting_height_m,
            proximity=self._proximity(anchors),
            base_pose=self._believed,
            base_covariance=self._covariance,
        )

    def move_base(self, T_base_goal: Pose2) -> Pose2:
        """Drive; the wheels slip, and the robot believes that it arrived."""
        slip_m, slip_rad = self.rng.normal(0.0, self.noise.slip_m, 2), self.rng.normal(0.0, self.noise.slip_rad)
        self._covariance = self._grown_covariance(T_base_goal)
        self._true = self._true @ T_base_goal @ Pose2(slip_m[0], slip_m[1], slip_rad)
        self._believed = self._believed @ T_base_goal
        return T_base_goal

    def move_arm(self, joints: FloatArray) -> None:
        """Move the joints; refuses values outside the limits."""
        self.robot.check_limits(self.robot.configuration(joints, self._believed))
        self.joints = np.array(joints, dtype=np.float64)

    def close_hand(self) -> GraspOutcome:
        """Nothing to close on yet: grasping comes with the grasp planner."""
        return GraspOutcome(False, Failure("not_simulated", "this room simulates no contact"))

    def true_pose_in_base(self) -> Pose2:
        """Pose of the part in the true base frame: for evaluation only."""
        return self._true.inverse() @ self.room.T_room_part

    def true_pose_in_room(self) -> Pose2:
        """True base pose in the room: for evaluation only."""
        return self._true

    def _proximity(self, anchors: TagPositions) -> ProximityMatrix:
        heights_m = self.layout.points_m[:, 2] + self.part.resting_height_m
        targets_m = np.column_stack([self.true_pose_in_base().apply(self.layout.points_m[:, :2]), heights_m])
        anchor_m = self._noisy_distances(anchors.points_m, anchors.points_m)
        anchor_m = np.triu(anchor_m, 1) + np.triu(anchor_m, 1).T
        np.fill_diagonal(anchor_m, np.nan)
        m = self._noisy_distances(targets_m, anchors.points_m)
        return ProximityMatrix(self.layout.epcs, anchors.epcs, m, anchor_m, "noisy_distance")

    def _noisy_distances(self, a_m: FloatArray, b_m: FloatArray) -> FloatArray:
        """M = d exp(σ n), n ~ N(0, 1)."""
        d = np.linalg.norm(a_m[:, None, :] - b_m[None, :, :], axis=2)
        return np.asarray(d * np.exp(self.rng.normal(0.0, self.noise.distance_sigma, d.shape)))

    def _grown_covariance(self, motion: Pose2) -> FloatArray:
        """Covariance of the believed pose after one more move, to first order."""
        x, y = self._believed.rotation @ motion.translation_m
        J = np.array([[1.0, 0.0, -y], [0.0, 1.0, x], [0.0, 0.0, 1.0]])
        step = np.diag([self.noise.slip_m**2, self.noise.slip_m**2, self.noise.slip_rad**2])
        return np.asarray(J @ self._covariance @ J.T + step)
