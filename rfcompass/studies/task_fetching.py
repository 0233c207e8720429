"""Several parts fetched one after the other in one simulated room: one robot, one odometry, one set of tags."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planners.deliver import Delivery, PutDown
from planners.fetch import FetchStep
from planners.guided_drive import GuidedDrive
from planners.map_pose import KnownStart, MapPose, RadioPose
from planners.worth_driving import is_placed, is_worth_driving
from rfcompass.errors import NoAnswer
from rfcompass.evaluation.metrics import position_error_m
from rfcompass.geometry.pose2 import Pose2
from rfcompass.localization import measure_proximities
from rfcompass.robots.collision_model import homogeneous
from rfcompass.simulation import NoisyDistances
from rfcompass.simulation.radio_sensing import RadioSensor
from rfcompass.studies.fetching import SCAN_POSTURE, FetchTask, OtherParts, SimulatedFetch, antenna_of, furnish
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.grasps import GraspPlan
from rfcompass.types.observation import Observation
from rfcompass.types.parts import Part
from rfcompass.types.world import Body

SURVEY_LOOKS = 4  # ours: from so many other places the antenna looks for parts that the first scan did not place


@dataclass(frozen=True, slots=True)
class JudgedPutDown:
    """A delivery, and where the part truly ended: only a simulation can say.

    Attributes:
        put: What the robot believes.
        T_odom_part: Where the part truly lies, in a frame that begins where the odometry began.
        centre_error_m: Distance of its centre from the goal [m].
        theta_error_rad: Angle between its x axis and the goal's, up to half a turn [rad].
        drop_m: How far it fell when the hand opened [m]; below 0 where it was pressed onto the floor.
    """

    put: PutDown
    T_odom_part: Pose2
    centre_error_m: float
    theta_error_rad: float
    drop_m: float


class SimulatedTask:
    """A room with several parts, and the robot that is sent for one after the other.

    Parts that were not fetched yet, and those that were delivered, are tags that are heard as well, and they stop the
    base and the arm while it drives. The robot knows of them what a survey from the start has told, and where it has
    put them: it drives around them and plans grasps beside them. What a hand would do to a part beside the one that it
    grasps is not simulated.

    Args:
        task: How to fetch; its part is the first.
        others: The parts that come after it.
        silent: Names of parts whose tags are broken.
    """

    def __init__(self, task: FetchTask, others: Sequence[Part], silent: Collection[str] = ()) -> None:
        """Furnish the room."""
        self._task = task
        self._device = furnish(task, others)
        self._T_room_odom = self._device.true_pose_in_room()
        told = self._T_room_odom if task.map_pose == "start" else Pose2()  # without a map, odometry is the map
        self._where: MapPose = RadioPose() if task.map_pose == "radio" else KnownStart(told)
        self._known: dict[str, Body] = {}
        self._fetch: SimulatedFetch | None = None
        broken = [epc for part in (task.part, *others) if part.part_id in silent for epc in part.tags.epcs]
        self._silence(broken)

    def survey(self, parts: Sequence[Part]) -> dict[str, PartEstimate]:
        """Ask from the start where each part seems to lie, so that all are known obstacles.

        Args:
            parts: Parts in the room.

        Returns:
            What was found, by name; parts that are not heard, or could be anywhere, are left out.
        """
        found: dict[str, PartEstimate] = {}
        antenna = antenna_of(self._task, self._device)
        for _ in range(1 + SURVEY_LOOKS):
            for part in parts:
                if part.part_id not in found and (estimate := self._placed_from_here(part)) is not None:
                    found[part.part_id] = estimate
            if len(found) == len(parts) or antenna is None or not antenna.looks_from_elsewhere():
                break
        return found

    def _placed_from_here(self, part: Part) -> PartEstimate | None:
        """Where a part seems to lie, put on the map; None if it is not heard, or could be anywhere."""
        self._device.seek(part.part_id)
        observation = self._device.scan()
        try:
            matrix = measure_proximities(observation, self._task.meter)
            estimate = self._task.localizer.estimate([replace(observation, proximity=matrix)])
        except NoAnswer:
            return None
        if not (is_placed(estimate) and is_worth_driving(estimate, matrix, observation.anchors)):
            return None
        self._notes(part, observation, estimate)
        return estimate

    def task_for(self, part: Part) -> FetchTask:
        """The task of fetching one of the parts."""
        return replace(self._task, part=part)

    def send_for(self, part: Part) -> SimulatedFetch:
        """Send the robot for a part: arm and antenna begin as they began with the first.

        Raises:
            InputError: If the part is not in the room, or the hand still holds another.
        """
        self._device.seek(part.part_id)
        self._device.move_arm(self._task.robot.posture(SCAN_POSTURE).joints)
        if self._task.radio is not None:
            self._device.use_legs(np.array(self._task.radio.legs_m))
        others = tuple(body for name, body in self._known.items() if name != part.part_id)
        self._fetch = SimulatedFetch(self.task_for(part), self._device, OtherParts(self._where, others))
        return self._fetch

    def left(self, part: Part, last: FetchStep | None) -> None:
        """Note where a part seems to lie that was not grasped; nothing new if no stop had an answer."""
        if last is not None and is_placed(last.estimate):
            self._notes(part, last.observation, last.estimate)

    def deliver(self, part: Part, plan: GraspPlan, goal: Pose2) -> JudgedPutDown:
        """Carry the part in the hand to its goal, put it down and judge where it ended.

        Args:
            part: What is in the hand.
            plan: The grasp that holds it.
            goal: Where it is to end, in the odometry frame.
        """
        delivery = Delivery(self._task.robot, self._device, drive=self._drive)
        put = delivery.put_down(part, plan, self._device.configuration.base, goal)
        if (T_map_odom := self._T_map_odom()) is not None:
            self._known[part.part_id] = _lying(part, T_map_odom @ put.T_odom_part)
        end = self._T_room_odom.inverse() @ self._device.room.T_room_part
        error_rad = (end.theta_rad - goal.theta_rad + np.pi / 2) % np.pi - np.pi / 2
        error_m = float(position_error_m(end.translation_m, goal.translation_m))
        return JudgedPutDown(put, end, error_m, abs(float(error_rad)), self._device.true_drop_m() or 0.0)

    def true_poses(self) -> dict[str, Pose2]:
        """Where every part truly lies now, by name, in a frame that begins where the odometry began."""
        room, sought = self._device.room, self._device.part.part_id
        lying = {sought: room.T_room_part, **{one.part.part_id: one.T_room_part for one in room.others}}
        return {name: self._T_room_odom.inverse() @ pose for name, pose in sorted(lying.items())}

    def check_delivered(self, judged: JudgedPutDown) -> None:
        """Refuse a delivery that ended short of its goal.

        Raises:
            DeliveryFailed: With how far it is short, as the robot believes.
        """
        Delivery(self._task.robot, self._device).check_reached(judged.put)

    def _notes(self, part: Part, observation: Observation, seen: PartEstimate) -> None:
        """Put a part on the map, where it seems to lie; unless nobody knows where the base stands on it."""
        T_map_base = self._where.base_pose(observation)
        if T_map_base is not None:
            x_m, y_m = seen.centre_m.tolist()
            self._known[part.part_id] = _lying(part, T_map_base @ Pose2(x_m, y_m, seen.theta_rad or 0.0))

    def _T_map_odom(self) -> Pose2 | None:
        """Pose of the frame of odometry on the map, as of the newest stop."""
        stops = self._device.stops
        if self._fetch is None or self._fetch.around is None or not stops:
            return None
        return self._fetch.around.where_now(stops[-1].observation)

    def _drive(self, T_base_goal: Pose2) -> Sequence[Pose2]:
        """Drive with a part in the hand; the drives since the newest stop are known from odometry."""
        T_map_odom, fetch, here = self._T_map_odom(), self._fetch, self._device.configuration
        if T_map_odom is None or fetch is None or fetch.around is None:
            return [self._device.move_base(T_base_goal)]
        around = replace(fetch.around, where=KnownStart(T_map_odom), area_m=None)
        observation = replace(self._device.stops[-1].observation, base_pose=here.base)
        return GuidedDrive(self._device, around).drive(observation, here.joints, [T_base_goal])

    def _silence(self, epcs: Sequence[str]) -> None:
        sensor = self._device.sensor
        if isinstance(sensor, RadioSensor):
            self._device.sensor = sensor.silenced(epcs)
        elif isinstance(sensor, NoisyDistances):
            self._device.sensor = replace(sensor, silent=frozenset(epcs))


def _lying(part: Part, T_map_part: Pose2) -> Body:
    """A part on the floor of a map."""
    T = homogeneous(T_map_part)
    T[2, 3] = part.resting_height_m
    return Body(part.part_id, part.shape, T)
