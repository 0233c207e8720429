"""Several parts fetched one after the other in one simulated room: one robot, one odometry, one set of tags."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planners.deliver import Delivery, PutDown
from rfcompass.evaluation.metrics import position_error_m
from rfcompass.geometry.pose2 import Pose2
from rfcompass.simulation import NoisyDistances
from rfcompass.simulation.radio_sensing import RadioSensor
from rfcompass.studies.fetching import SCAN_POSTURE, FetchTask, SimulatedFetch, furnish
from rfcompass.types.grasps import GraspPlan
from rfcompass.types.parts import Part


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

    Parts that were not fetched yet, and those that were delivered, are tags that are heard as well. What the hand or
    the base would do to them on the way is not simulated, as nothing of the furniture is.

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
        broken = [epc for part in (task.part, *others) if part.part_id in silent for epc in part.tags.epcs]
        self._silence(broken)

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
        return SimulatedFetch(self.task_for(part), self._device)

    def deliver(self, part: Part, plan: GraspPlan, goal: Pose2) -> JudgedPutDown:
        """Carry the part in the hand to its goal, put it down and judge where it ended.

        Args:
            part: What is in the hand.
            plan: The grasp that holds it.
            goal: Where it is to end, in the odometry frame.
        """
        delivery = Delivery(self._task.robot, self._device)
        put = delivery.put_down(part, plan, self._device.configuration.base, goal)
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

    def _silence(self, epcs: Sequence[str]) -> None:
        sensor = self._device.sensor
        if isinstance(sensor, RadioSensor):
            self._device.sensor = sensor.silenced(epcs)
        elif isinstance(sensor, NoisyDistances):
            self._device.sensor = replace(sensor, silent=frozenset(epcs))
