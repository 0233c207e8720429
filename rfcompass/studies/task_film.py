"""Collects what happens in a task for its film."""

from dataclasses import dataclass, field, replace

import numpy as np

from planners.deliver import PutDown
from planners.fetch import FetchStep
from planners.pick_up import GraspTrial
from rfcompass.arrays import FloatArray
from rfcompass.geometry.pose2 import as_pose2
from rfcompass.robots import Robot
from rfcompass.studies.fetch_job import ReportedStep
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasps import GraspPlan
from rfcompass.types.parts import Part
from rfcompass.viz.live_task import LiveTask
from rfcompass.viz.overlay import StageMark
from rfcompass.viz.played_motion import homogeneous, play
from rfcompass.viz.task_film import Film, FilmedPart, FilmedStop

# Ours: time from stop to stop and for each way of a delivery [s]; grasps take the time of their plan.
STOP_S, CARRY_S = 1.0, 1.0


@dataclass(slots=True)
class FilmReel:
    """What has happened so far; everything is as the robot believes it.

    Args:
        robot: Who does the task.
        screen: Shows it while it happens; None if nobody looks.
    """

    robot: Robot
    screen: LiveTask | None = None
    _now_s: float = field(init=False, default=0.0)
    _times_s: list[float] = field(init=False, default_factory=list)
    _pictures: list[Configuration] = field(init=False, default_factory=list)
    _stops: list[FilmedStop] = field(init=False, default_factory=list)
    _parts: list[FilmedPart] = field(init=False, default_factory=list)
    _marks: list[StageMark] = field(init=False, default_factory=list)

    @property
    def film(self) -> Film:
        """The film of what has happened so far."""
        seen = tuple(one for one in self._parts if one.poses)
        return Film(tuple(self._times_s), tuple(self._pictures), tuple(self._stops), seen, tuple(self._marks))

    def event(self, event: ReportedStep | GraspTrial) -> None:
        """Whatever a fetch or a pick-up tells of."""
        if isinstance(event, GraspTrial):
            self.grasp(event)
        else:
            self.stop(event.step)

    def begin(self, part: Part, tags_m: FloatArray) -> None:
        """The robot is sent for a part, with these tags in use [m], shape (K, 3)."""
        self._parts.append(FilmedPart(part, tags_m, (), ()))
        self._marks.append(StageMark(part.part_id, self._now_s))

    def stop(self, step: FetchStep) -> None:
        """The robot has scanned and localised."""
        base, estimate = step.configuration.base, step.estimate
        self._picture(step.configuration)
        self._end_stop()
        self._stops.append(FilmedStop(self._now_s, self._now_s + STOP_S, base, estimate))
        if self.screen is not None:
            self.screen.known(estimate, base)
        if estimate.theta_rad is not None:
            lies = base @ as_pose2([*estimate.centre_m, estimate.theta_rad])
            self._part_at(homogeneous(lies, self._parts[-1].part.resting_height_m))
        self._now_s += STOP_S

    def grasp(self, trial: GraspTrial) -> None:
        """The hand has closed; a failed try is shown up to its end as planned, without the part."""
        base, began_s = self._pictures[-1].base, self._now_s
        self._end_stop()
        played = play(trial.plan, self.robot)
        for time_s, at, T_base_part in zip(played.times_s, played.configurations, played.parts, strict=True):
            self._now_s = began_s + time_s
            self._picture(Configuration(at.joints, base @ at.base))
            if trial.outcome.success:
                self._part_at(homogeneous(base) @ T_base_part)
        self._now_s += STOP_S

    def put_down(self, plan: GraspPlan, put: PutDown) -> None:
        """The part was carried and put down."""
        there, T_hand_part = self._pictures[-1].base, np.linalg.inv(plan.T_part_hand)
        up, down = put.carry.joints[-1], plan.retreat[0]
        for joints, base in ((up, there), (up, put.T_odom_base), (down, put.T_odom_base)):
            at = Configuration(joints, base)
            self._picture(at)
            self._part_at(homogeneous(base) @ self.robot.tool_pose(at).homogeneous @ T_hand_part)
            self._now_s += CARRY_S
        for joints in (plan.approach[-1], plan.approach[0]):
            self._picture(Configuration(joints, put.T_odom_base))
            self._now_s += CARRY_S / 2

    def _picture(self, at: Configuration) -> None:
        self._times_s.append(self._now_s)
        self._pictures.append(at)
        if self.screen is not None:
            self.screen.robot_at(at)

    def _end_stop(self) -> None:
        """What was known at the last stop is shown until now."""
        if self._stops:
            self._stops[-1] = replace(self._stops[-1], until_s=min(self._now_s, self._stops[-1].time_s + 2 * STOP_S))

    def _part_at(self, T_odom_part: FloatArray) -> None:
        one = self._parts[-1]
        moved = replace(one, times_s=(*one.times_s, self._now_s), poses=(*one.poses, T_odom_part))
        self._parts[-1] = moved
        if self.screen is not None:
            self.screen.part_at(one.part, one.tags_m, T_odom_part)
