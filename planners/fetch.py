"""The closed loop of RF-Compass: scan, localise, drive half the way, and measure with the hand over the part.

    navigate   scan → localise → in reach? → drive D/2 towards the estimate → scan …
    localise   drive so that the hand can be over the part → move the hand, scan, localise, a few times

[Wang2013], sections 3.2 and 4.2.B. The loop acts on estimates and on what the robot believes about itself. Grasping
follows in `planners.pick_up`.
"""

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from planners.beside_part import over_the_part, way_beside
from planners.drive_around import Approach, DriveAround
from planners.fetch_rules import FetchRules
from planners.final_stops import FinalStops
from planners.guided_drive import GuidedDrive, whole
from planners.hand_over import hand_over
from planners.looks import Look, confirmed, surest
from planners.near_antenna import NearAntenna
from planners.time_account import TimeAccount, TimeSpent
from planners.worth_driving import doubt_m
from rfcompass.arrays import FloatArray
from rfcompass.errors import NoAnswer, OutOfReach, RobotLinkError, TagNeverHeard, TooFewReads
from rfcompass.geometry.pose2 import Pose2
from rfcompass.interfaces import Localizer, MobileManipulator, ProximityMeter, Scanner
from rfcompass.localization import in_reach_by_base_end, measure_proximities, next_goal
from rfcompass.robots import Robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.observation import Observation
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.world import World

# Ours. By how much the base is turned about the part from where its long side lies across, try after try: a leg that
# points at the robot more than this would lie under its base.
TURNS_RAD = np.radians([0.0, 180.0, 35.0, -35.0, 145.0, -145.0])
LEAST_PROGRESS = 0.5  # ours: a drive that ends before this share of its length was stopped by a wall


class Device(Scanner, MobileManipulator, Protocol):
    """A robot that scans, drives and moves its arm."""


@dataclass(frozen=True, slots=True)
class FetchStep:
    """One stop of the loop.

    Attributes:
        phase: `"navigate"` or `"localise"`.
        observation: What was heard.
        proximity: What it says about distances: as heard, or as measured from the reads.
        configuration: Believed pose and joints of the robot at this stop.
        estimate: Where the part is, in the base frame of this stop.
        in_reach: Whether the robot decided that the part is in reach.
        spent: Time since the stop before.
    """

    phase: str
    observation: Observation
    proximity: ProximityMatrix
    configuration: Configuration
    estimate: PartEstimate
    in_reach: bool = False
    spent: TimeSpent = field(default_factory=TimeSpent)

    @property
    def doubt_m(self) -> float:
        """How far off the centre may be; see `planners.worth_driving`."""
        return doubt_m(self.estimate, self.proximity, self.observation.anchors)

    @property
    def measured(self) -> Observation:
        """The observation with its proximities, as the localizer saw it."""
        return replace(self.observation, proximity=self.proximity)


@dataclass(slots=True)
class Fetch:
    """Runs the loop; iterate over `steps()`.

    Args:
        robot: Kinematics of the robot, for placing the hand.
        device: The robot, real or simulated.
        localizer: Finds the part from the stops so far.
        start: Joints at the start.
        rules: When to do what.
        meter: Measures the proximities of each stop once, where the device brings none.
        antenna: Comes near the part; None if the antenna drives the same track always.
        around: Plans drives around known obstacles; None to drive straight, as where no map is known.
        final: Chooses the last stops, and says when they are enough; None for the places of `rules.hand_sweep`.
    """

    robot: Robot
    device: Device
    localizer: Localizer
    start: Configuration
    rules: FetchRules = field(default_factory=FetchRules)
    meter: ProximityMeter | None = None
    antenna: NearAntenna | None = None
    around: DriveAround | None = None
    final: FinalStops | None = None
    _time: TimeAccount = field(init=False, default_factory=TimeAccount)
    _observations: list[Observation] = field(init=False, default_factory=list)
    _joints: FloatArray = field(init=False)
    _doubts: bool = field(init=False, default=True)

    def steps(self) -> Iterator[FetchStep]:
        """Do the whole job, stop by stop.

        Raises:
            OutOfReach: If the part is not in reach after `max_moves` moves, or the hand cannot get over it.
            NoAnswer: If the meter or the localizer has no answer; what it said, with the stop's number.
        """
        step = yield from self.navigate()
        step = yield from self._line_up(step)
        for place in self.rules.hand_sweep[1:]:
            if self.final is not None and self.final.is_enough(step.estimate):
                return
            step = yield from self._final_stop(step, place)

    def measure_anew(self, *, part_moved: bool) -> Generator[FetchStep, None, FetchStep]:
        """Make the first hand stops again.

        Args:
            part_moved: Forget all older stops: the hand has bumped the part.
        """
        if part_moved:
            self._observations.clear()
        for place in self.rules.hand_sweep[: self.rules.stops_anew]:
            step = yield from self._hand_stop(*place)
        return step

    def surroundings(self, step: FetchStep) -> World | None:
        """What stands around at the newest stop, in its base frame; None where no map is known."""
        return None if self.around is None else self.around.seen_from_base(step.observation, self._joints)

    def looks_from_another_side(self, step: FetchStep) -> bool:
        """Send the antenna to other sides of the part, where reflections are others; False if there is none left.

        Args:
            step: The newest stop.
        """
        return self.antenna is not None and self.antenna.changes_sides(step.observation, step.estimate)

    def navigate(self) -> Generator[FetchStep, None, FetchStep]:
        """Do the first phase only: until the part is in reach.

        Returns:
            The stop at which it is.

        Raises:
            As for `steps`.
        """
        self._joints = self.start.joints
        for _ in range(self.rules.max_moves + 1):
            step = yield from self._stop("navigate")
            if step.in_reach:
                return step
            self._approach(step)
        D = step.estimate.distance_m
        message = f"the part is {D:.2f} m away after {self.rules.max_moves} moves"
        raise OutOfReach(message, distance_m=D, moves=self.rules.max_moves)

    def _approach(self, step: FetchStep) -> None:
        """Drive D/2 towards the part; around obstacles, as far along the way to it."""
        if self.around is None:
            goal = self._half_way(step.estimate)
            if _length_m(self.drive(step.observation, goal)) < LEAST_PROGRESS * _length_m(goal):
                self._looks_from_elsewhere()  # the part does not lie behind a wall: what was heard was an echo
            return
        D, rules = step.estimate.distance_m, self.rules
        nearby = next_goal(step.estimate, max(0.5, 1.0 - rules.stand_off_m / D))
        near_m = 0.95 * rules.reach_m  # the wheels slip, and the next estimate is another
        approach = Approach(step.estimate.centre_m, near_m, min(D / 2, rules.max_step_m))
        guided = GuidedDrive(self.device, self.around)
        self._time.drove(guided.drive(step.observation, self._joints, [nearby], approach))

    def drive(self, observation: Observation, T_base_goal: Pose2) -> Pose2:
        """Drive to a pose in the base frame of the newest stop, or as near as known obstacles allow.

        Args:
            observation: That stop.
            T_base_goal: Where to.

        Returns:
            How far the robot got, as it believes.
        """
        if self.around is None:
            moved = self.device.move_base(T_base_goal)
            self._time.drove([moved])
            return moved
        made = GuidedDrive(self.device, self.around).drive(observation, self._joints, [T_base_goal])
        self._time.drove(made)
        return whole(made)

    def stand_over(self, step: FetchStep) -> None:
        """Drive so that the part lies under the hand, its long side across the base if θ is known.

        Where a wall stops the robot, it tries the other sides of the part.

        Args:
            step: The newest stop.
        """
        estimate, stands = step.estimate, Pose2()
        goals = [
            over_the_part(estimate.centre_m, estimate.theta_rad, self.rules.hand_point_m, turn_rad)
            for turn_rad in TURNS_RAD.tolist()
        ]
        if self.around is not None:
            self._drive_around_part(self.around, step, goals)
            return
        for goal in goals:
            stands = stands @ self._drive_beside(stands.inverse() @ goal, stands.inverse().apply(estimate.centre_m))
            if _length_m(stands.inverse() @ goal) <= self.rules.lined_up_m:
                return

    def drive_to(self, step: FetchStep, T_base_goal: Pose2) -> None:
        """Drive to a pose beside the part, in the base frame of the newest stop, around the part and what is known."""
        if self.around is None:
            self._drive_beside(T_base_goal, step.estimate.centre_m)
        else:
            self._drive_around_part(self.around, step, [T_base_goal])

    def _drive_around_part(self, around: DriveAround, step: FetchStep, goals: Sequence[Pose2]) -> None:
        """Drive to the first of these poses beside the part that a way around all that is known leads to."""
        drive = GuidedDrive(self.device, around)
        self._time.drove(drive.drive(step.observation, self._joints, goals, beside=step.estimate))

    def _drive_beside(self, T_base_goal: Pose2, part_m: FloatArray) -> Pose2:
        """Drive to a pose around the part, whose centre is at `part_m` (2,) [m], both in the frame of the base now.

        Returns:
            How far the robot got, as it believes; it gives up where a wall stops it.
        """
        stands = Pose2()
        for pose in way_beside(T_base_goal, part_m):
            moved = self.device.move_base(stands.inverse() @ pose)
            self._time.drove([moved])
            stands = stands @ moved
            if _length_m(stands.inverse() @ pose) > self.rules.lined_up_m:
                break
        return stands

    def _line_up(self, step: FetchStep) -> Generator[FetchStep, None, FetchStep]:
        """Drive until the hand is over the part at the first place of the sweep, as far as one can tell."""
        for _ in range(self.rules.max_line_ups):
            self.stand_over(step)
            step = yield from self._hand_stop(*self.rules.hand_sweep[0])
            if np.linalg.norm(step.estimate.centre_m - self.rules.hand_point_m) <= self.rules.lined_up_m:
                break
        return step

    def _final_stop(self, step: FetchStep, place: tuple[float, float, float]) -> Generator[FetchStep, None, FetchStep]:
        """Stop where it would tell most; at a place of the sweep if nobody chooses."""
        chosen = None
        if self.final is not None:
            chosen = self.final.choose(step.configuration, step.estimate, step.observation.part)
        if chosen is None:
            return (yield from self._hand_stop(*place))
        if chosen.base != step.configuration.base:
            self.drive(step.observation, step.configuration.base.inverse() @ chosen.base)
        return (yield from self._stop_with(chosen.joints))

    def _hand_stop(self, dx_m: float, dy_m: float, yaw_rad: float) -> Generator[FetchStep, None, FetchStep]:
        """Move the hand to a place of the sweep and stop there."""
        x_m, y_m = self.rules.hand_point_m
        point_m = np.array([x_m + dx_m, y_m + dy_m, self.rules.hand_height_m])
        posture = hand_over(self.robot, self.robot.configuration(self._joints), point_m, yaw_rad)
        return (yield from self._stop_with(posture.joints))

    def _stop_with(self, joints: FloatArray) -> Generator[FetchStep, None, FetchStep]:
        """Move the arm and stop."""
        self._time.moved_arm(self.robot, [self._joints, joints])
        self._joints = joints
        self.device.move_arm(joints)
        return (yield from self._stop("localise"))

    def _stop(self, phase: str) -> Generator[FetchStep, None, FetchStep]:
        """Scan and localise; again from nearer, if the antenna can come nearer."""
        step = self._found(phase)
        yield step
        for _ in range(self.rules.max_antenna_moves):
            if self.antenna is None or not self.antenna.comes_nearer(step.observation, step.estimate):
                break
            self._observations.clear()
            step = self._found(phase)
            yield step
        return step

    def _found(self, phase: str) -> FetchStep:
        """Scan until there is an answer to act on, from wherever the antenna can hear; else the surest of all looks."""
        looks, believed = list[Look](), None
        while believed is None:
            answer = self._answered(phase)
            if isinstance(answer, FetchStep):
                looks.append(Look(answer, tuple(self._observations)))
                believed = confirmed(looks) if self._doubts else looks[-1] if looks[-1].is_sure else None
            if believed is None and not self._looks_from_elsewhere():
                break
        if isinstance(answer, NoAnswer) and not looks:
            raise answer
        best = believed or surest(looks)
        self._observations = list(best.observations)
        self._doubts = self._doubts and believed is None
        if self.antenna is not None and best.is_sure:
            self.antenna.found()
        return replace(best.step, spent=sum((look.step.spent for look in looks), TimeSpent()))

    def _answered(self, phase: str) -> FetchStep | NoAnswer:
        """Scan once."""
        try:
            return self._scanned(phase)
        except RobotLinkError:
            raise  # no tag was missed: the robot itself is not there, and nothing may move on its account
        except NoAnswer as failure:
            return failure

    def _looks_from_elsewhere(self) -> bool:
        """Send the antenna to where it has not looked from yet, and forget the older stops; False if it cannot."""
        if self.antenna is None or not self.antenna.looks_from_elsewhere():
            return False
        self._observations.clear()
        return True

    def _scanned(self, phase: str) -> FetchStep:
        observation = self.device.scan()
        self._time.scanned(observation)
        try:
            matrix = measure_proximities(observation, self.meter)
            if self.rules.tags_tell_reach:  # where they do not, something else than tags guides the robot
                _check_heard(matrix, observation)
            self._observations.append(replace(observation, proximity=matrix))
            estimate = self.localizer.estimate(self._observations)
        except NoAnswer as error:
            raise error.with_numbers(stop=observation.stop_id, phase=phase) from error
        configuration = self.robot.configuration(self._joints, observation.base_pose)
        in_reach = self._in_reach(matrix, estimate)
        return FetchStep(phase, observation, matrix, configuration, estimate, in_reach, self._time.close())

    def _in_reach(self, matrix: ProximityMatrix, estimate: PartEstimate) -> bool:
        """Near by the estimate and by what the tags say: comparisons alone hardly see the distance of a far part."""
        if estimate.distance_m > self.rules.reach_m:
            return False
        try:
            return not self.rules.tags_tell_reach or in_reach_by_base_end(matrix, self.robot.layout)
        except TooFewReads:  # the tags abstain, and the estimate decides
            return True

    def _half_way(self, estimate: PartEstimate) -> Pose2:
        """Drive D/2 in the direction φ of the part and face it [Wang2013], section 4.2.B."""
        return next_goal(estimate, min(0.5, self.rules.max_step_m / estimate.distance_m))


def _length_m(drive: Pose2) -> float:
    return float(np.hypot(drive.x_m, drive.y_m))


def _check_heard(matrix: ProximityMatrix, observation: Observation) -> None:
    """Nothing of the part: no localizer need be asked, and what to do is to listen from elsewhere."""
    if np.isnan(matrix.m).all():
        raise TagNeverHeard(f"no tag of {observation.part.body} was heard", epc=list(observation.part.epcs), heard=0)
