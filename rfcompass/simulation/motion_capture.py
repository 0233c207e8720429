"""Motion capture with infrared cameras: the baseline of [Wang2013], section 5, that sees to a millimetre or not at all.

Cameras hang under the ceiling and see reflecting markers on robot and part. A camera sees a marker if no obstacle of
the scene lies between them; a marker has a place if two cameras see it, a body has a pose if three of its markers have
one. The pose is the rigid fit of their measured places, in the plane.

For the baseline: the cameras' field of view, resolution and range are unlimited, their calibration is perfect, and the
robot hides nothing.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numba
import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, read_only
from rfcompass.errors import InputError, NotInView, SceneError
from rfcompass.geometry.pose2 import Pose2
from rfcompass.geometry.registration import fit_pose2
from rfcompass.robots.youbot import BASE_LENGTH_M, BASE_WIDTH_M
from rfcompass.simulation.occlusion import obstacle_table, pass_obstacles
from rfcompass.simulation.room_sensing import Heard, RoomState
from rfcompass.simulation.simulated_robot import SimulatedRobot
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.observation import Observation
from rfcompass.types.parts import Part
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.record import Record
from rfcompass.types.scene import Material, Room, Scene

# What a pose needs; the paper's rig is a product whose rules it does not print. Ours, and what geometry asks for.
LEAST_MARKERS, LEAST_CAMERAS = 3, 2
# Ours: how far cameras hang from walls and ceiling [m], and the error of a marker's place along each axis [m].
CAMERA_INSET_M = 0.1
MARKER_SIGMA_M = 0.001
# [Wang2013] has ten markers on the robot and four on the part; where they sit is ours. On the robot: around the edge of
# the deck, as shares of half its length and width. On the part: on top, as shares of half its sides, so that it does
# not look the same after half a turn.
_ON_DECK = ((1, 1), (1, 0.2), (1, -1), (0.5, 1), (0.4, -1), (-0.3, 1), (-0.5, -1), (-1, 1), (-1, -0.3), (-1, -1))
_ON_PART = ((-0.9, 0.6), (-0.3, -0.6), (0.5, 0.6), (0.9, -0.6))
_DECK_HEIGHT_M = 0.15

METHOD = "motion_capture"


def robot_markers_m() -> FloatArray:
    """Places of ten markers on a youBot, base frame [m], shape (10, 3)."""
    half_m = np.array([BASE_LENGTH_M / 2, BASE_WIDTH_M / 2])
    return np.column_stack([np.array(_ON_DECK) * half_m, np.full(len(_ON_DECK), _DECK_HEIGHT_M)])


def part_markers_m(part: Part) -> FloatArray:
    """Places of four markers on a part that lies on the floor, part frame but z from the floor [m], shape (4, 3)."""
    low_m, high_m = part.shape.lower_m, part.shape.upper_m
    middle_m, half_m = (low_m + high_m)[:2] / 2, (high_m - low_m)[:2] / 2
    height_m = part.resting_height_m + high_m[2]
    return np.column_stack([middle_m + np.array(_ON_PART) * half_m, np.full(len(_ON_PART), height_m)])


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraRig(Record):
    """Cameras at known places.

    Attributes:
        cameras_m: Their places in the scene [m], shape (C, 3).
        sigma_m: Standard deviation of a marker's measured place along each axis [m].
    """

    cameras_m: FloatArray
    sigma_m: float = MARKER_SIGMA_M

    def __post_init__(self) -> None:
        """Freeze the places; refuse noise that cannot be."""
        object.__setattr__(self, "cameras_m", read_only(self.cameras_m, "CameraRig.cameras_m", (None, 3)))
        if not (np.isfinite(self.sigma_m) and self.sigma_m >= 0):
            raise InputError(f"CameraRig.sigma_m: {self.sigma_m} is not a finite number >= 0", name="sigma_m")

    @classmethod
    def under_ceiling(cls, room: Room, inset_m: float = CAMERA_INSET_M, sigma_m: float = MARKER_SIGMA_M) -> "CameraRig":
        """Hang eight cameras under the ceiling: in the four corners, and in the middle of each wall.

        Args:
            room: Its walls and ceiling.
            inset_m: How far from both [m].
            sigma_m: See the attributes.

        Raises:
            SceneError: If the room is too small for the inset.
        """
        if not 0 <= 2 * inset_m < room.size_m.min():
            raise SceneError(f"no cameras {inset_m} m from the walls of a room of {room.size_m.tolist()} m", key="room")
        low_m, high_m = np.full(2, inset_m), room.size_m[:2] - inset_m
        shares = [(u, v) for u in (0.0, 0.5, 1.0) for v in (0.0, 0.5, 1.0) if (u, v) != (0.5, 0.5)]
        planes_m = low_m + np.array(shares) * (high_m - low_m)
        heights_m = np.full(len(shares), room.size_m[2] - inset_m)
        return cls(cameras_m=np.column_stack([planes_m, heights_m]), sigma_m=sigma_m)

    def views(self, scene: Scene, markers_m: FloatArray) -> BoolArray:
        """Which camera sees which marker, shape (C, M). Every obstacle stops light, whatever waves make of it.

        Args:
            scene: What stands in the way.
            markers_m: Places of markers in the scene [m], shape (M, 3).
        """
        return np.asarray(_in_view(self.cameras_m, np.ascontiguousarray(markers_m), _opaque(scene)))

    def capture(
        self, name: str, scene: Scene, in_body_m: FloatArray, T_room_body: Pose2, rng: np.random.Generator
    ) -> Pose2:
        """Measure the pose of a body on the floor.

        Args:
            name: What it is called in an error.
            scene: What stands in the way.
            in_body_m: Its markers, z from the floor [m], shape (M, 3).
            T_room_body: Where it truly is.
            rng: Source of the noise.

        Raises:
            NotInView: If fewer than three of its markers are seen by two cameras each.
        """
        markers_m = T_room_body.apply(in_body_m)
        placed = self.views(scene, markers_m).sum(axis=0) >= LEAST_CAMERAS
        if (count := int(placed.sum())) < LEAST_MARKERS:
            message = f"{count} of {len(placed)} markers of the {name} are in view, {LEAST_MARKERS} are needed"
            raise NotInView(message, body=name, markers=count, needed=LEAST_MARKERS)
        seen_m = markers_m[placed, :2] + rng.normal(0.0, self.sigma_m, (count, 2))
        return fit_pose2(in_body_m[placed, :2], seen_m)


@dataclass(frozen=True, slots=True)
class MotionCapture:
    """Stands where a `Localizer` stands in the loop, and looks with cameras in place of listening.

    Unlike a localizer it looks at the world as it is when asked: it must be asked at the newest stop, and two answers
    differ by the cameras' noise. It only lives in simulated rooms, since it needs their truth.

    Args:
        rig: The cameras.
        scene: What stands in the way.
        device: The robot in its room.
        rng: Source of the noise.
        robot_markers_m: Places of the robot's markers, base frame [m], shape (M, 3).
    """

    rig: CameraRig
    scene: Scene
    device: SimulatedRobot
    rng: np.random.Generator
    robot_markers_m: FloatArray = field(default_factory=robot_markers_m)

    def estimate(self, observations: Sequence[Observation]) -> PartEstimate:
        """Pose of the part in the base frame, from both bodies' poses in the room.

        Raises:
            NotInView: If the cameras have lost one of them.
        """
        part = self.device.part
        T_room_part = self._captured("part", part_markers_m(part), self.device.true_part_in_room)
        T_room_base = self._captured("robot", self.robot_markers_m, self.device.true_pose_in_room)
        T_base_part = T_room_base.inverse() @ T_room_part
        return PartEstimate(
            part.part_id, T_base_part.translation_m, T_base_part.theta_rad, METHOD, len(observations),
            height_m=part.resting_height_m,
        )  # fmt: skip

    def base_pose(self, observation: Observation) -> Pose2 | None:  # noqa: ARG002 - cameras need no reads
        """Where the robot is in the room; None if the cameras have lost it."""
        try:
            return self._captured("robot", self.robot_markers_m, self.device.true_pose_in_room)
        except NotInView:
            return None

    def _captured(self, name: str, in_body_m: FloatArray, pose: Callable[[], Pose2]) -> Pose2:
        return self.rig.capture(name, self.scene, in_body_m, pose(), self.rng)


@dataclass(frozen=True, slots=True)
class NoReader:
    """A scan without any reader: every proximity is missing. What a robot hears that only cameras guide."""

    def hear(self, state: RoomState, rng: np.random.Generator) -> Heard:  # noqa: ARG002
        """Hear nothing."""
        K, N = len(state.targets.epcs), len(state.anchors.epcs)
        m, anchor_m = np.full((K, N), np.nan), np.full((N, N), np.nan)
        return Heard(proximity=ProximityMatrix(state.targets.epcs, state.anchors.epcs, m, anchor_m, "none"))


def _opaque(scene: Scene) -> FloatArray:
    """Table of all obstacles, each of which costs something: also those that a wave does not notice."""
    materials = {name: Material(name, surface_loss_db=1.0) for name in scene.materials}
    return obstacle_table(Scene(scene.name, scene.room, scene.obstacles, materials))


@numba.njit(cache=True, error_model="numpy")
def _in_view(cameras_m: FloatArray, markers_m: FloatArray, table: FloatArray) -> BoolArray:
    """Whether no obstacle lies between each camera and each marker, shape (C, M)."""
    seen = np.empty((len(cameras_m), len(markers_m)), dtype=np.bool_)
    for c in range(len(cameras_m)):
        for m in range(len(markers_m)):
            start = (cameras_m[c, 0], cameras_m[c, 1], cameras_m[c, 2])
            x, y, z = markers_m[m, 0] - start[0], markers_m[m, 1] - start[1], markers_m[m, 2] - start[2]
            length_m = np.sqrt(x * x + y * y + z * z)
            if length_m == 0.0:
                seen[c, m] = True
                continue
            loss_db, _ = pass_obstacles(start, (x / length_m, y / length_m, z / length_m), length_m, table)
            seen[c, m] = loss_db == 0.0
    return seen
