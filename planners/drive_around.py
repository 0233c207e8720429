"""Drives of the base around what stands on a map.

Map frame: any in which somebody knows both the obstacles and, about, where the base stands; that of the antenna's track
serves, since the robot's own tags are seen from it (`RadioPose`). The way is planned in it, for the whole robot, with
all bodies grown by a margin, and handed back in the present base frame.

First the shortest way past corners is asked for (`planners.corner_ways`); one to the part may end on any side of it.
Where there is none, OMPL searches (`planners.short_drive`). A goal that is not free is then moved to the nearest place
that is: half of the way to the part may end in a desk.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np

from planners.corner_ways import AreaM, way_past_corners
from planners.drive_ends import facing, near_goals
from planners.grasp_question import pose_of
from planners.map_pose import MapPose
from planners.margins import grown
from planners.motion_check import RESOLUTION_M, MotionChecker
from planners.path_search import GOAL_BLOCKED, SearchRules
from planners.short_drive import first_part, plan_short_drive, shortened
from rfcompass.arrays import FloatArray
from rfcompass.geometry.pose2 import Pose2
from rfcompass.robots import CollisionModel, QuickCollisions, Robot
from rfcompass.robots.collision_model import homogeneous
from rfcompass.types.configuration import Configuration
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.grasps import Failure
from rfcompass.types.observation import Observation
from rfcompass.types.parts import Part
from rfcompass.types.record import Record
from rfcompass.types.shapes import Box
from rfcompass.types.world import Body, World

Path: TypeAlias = tuple[Configuration, ...]

# Ours: what the base keeps from things on the map, which covers the errors of where it stands and of its wheels [m].
CLEAR_M = 0.05
# Ours: touches of a grown body may be missed if they are shallower than this share of the margin, which saves time.
_RESOLUTION = 0.2
# Ours: so many places are tried at most in place of one that is not free.
_TRIED_GOALS = 4
# Ours: ends of a way to the part that face it, or nearly, where none is free as far from it as is asked for [m, rad].
_NEARER_M = (0.35, 0.45)
_ASIDE_RAD = (0.0, np.pi / 4, -np.pi / 4)
_SHORTCUTS = 60
RULES = SearchRules(most_checks=5000)
PART_CLEAR_M = 0.02  # ours: what the base keeps from the part that is sought, which the hand has to come near to [m]
NEAR_M = 1.5  # ours: what is further from the robot than this is in no grasp's way, even after a short drive [m]
# Ours: what stopped a drive is taken to be a box of this size [m], and the nearest of these places before the robot's
# middle at which it touches nothing; a drive with less than this left does not tell where that is.
BUMP_SIZE_M = (0.02, 0.2, 0.05)
_BUMPS_M = np.arange(0.1, 1.0, 0.01)
_TOLD_M = 0.01
# Ours: a bump so near to where the part seems to lie [m] is the part's (half its length and a hand); one so near to a
# body of the map is that body's.
AT_PART_M = 0.35
AT_BODY_M = 0.15
# A corner of a grown box is this much further out than the margin.
_AT_CORNERS = np.sqrt(3.0)


@dataclass(frozen=True, slots=True)
class Approach(Record):
    """A drive towards the part, of which the beginning is enough.

    Attributes:
        part_m: Where the part seems to be, base frame [m], shape (2,).
        reach_m: A place this near to it, or nearer, is better than any further away, if the goal is not free [m].
        at_most_m: Stop after so much of driving [m].
    """

    part_m: FloatArray
    reach_m: float
    at_most_m: float


@dataclass(slots=True)
class DriveAround:
    """Plans the drives of a loop around known obstacles.

    Args:
        robot: A robot that drives.
        world: What stands there, in the map frame.
        where: Knows where the base stands on the map.
        rng: Seeds the searches.
        area_m: Lower and upper corner of where the base's centre may be, map frame [m]; None for everywhere.
        clear_m: What to keep from things, where the robot is not nearer already [m].
        rules: How hard to look for a way.
        part: What is sought; None to drive over it.
        bumps: What the bumper has found that the map does not show.
        wary: Names of bodies that it has found where it should not.
    """

    robot: Robot
    world: World
    where: MapPose
    rng: np.random.Generator
    area_m: AreaM | None = None
    clear_m: float = CLEAR_M
    rules: SearchRules = RULES
    part: Part | None = None
    bumps: list[Body] = field(default_factory=list)
    wary: set[str] = field(default_factory=set)

    def way(
        self,
        observation: Observation,
        joints: FloatArray,
        T_base_goal: Pose2,
        approach: Approach | None = None,
        beside: PartEstimate | None = None,
        stands: Pose2 | None = None,
    ) -> tuple[Pose2, ...]:
        """Find where to drive straight to, one pose after the other.

        Args:
            observation: The newest stop. All poses are in the base frame as it was there.
            joints: How the arm is held while driving, shape (Q,).
            T_base_goal: Where to.
            approach: The part, if the drive leads to it.
            beside: Where the part seems to be, if the drive is to pass beside it.
            stands: Where the base is by now; where the stop was if None.

        Returns:
            Poses, the last one the goal, or the nearest free place to it that a way leads
            to; the goal alone if nobody knows where the base stands; none if no way leads anywhere near.
        """
        T_map_stop, stands = self.where.base_pose(observation), stands or Pose2()
        if T_map_stop is None:
            T_map_stop, path = Pose2(), tuple(self.robot.configuration(joints, T) for T in (stands, T_base_goal))
        else:
            start = self.robot.configuration(joints, T_map_stop @ stands)
            near = beside is not None and np.linalg.norm(stands.translation_m - beside.centre_m) <= NEAR_M
            lying = (self._lying(self.part, T_map_stop, beside),) if near and beside and self.part else ()
            if approach is not None:
                approach = replace(approach, part_m=T_map_stop.apply(approach.part_m))
            path = self._path(self._checker(start, lying), start, T_map_stop @ T_base_goal, approach)
        if approach is not None and path:
            path = first_part(path, approach.at_most_m)
        T_stop_map = T_map_stop.inverse()
        return tuple(T_stop_map @ configuration.base for configuration in path[1:])

    def bumped(
        self, observation: Observation, joints: FloatArray, stands: Pose2, rest: Pose2, part_m: FloatArray | None = None
    ) -> bool:
        """Learn from what has stopped a drive.

        Beside a thing of the map it is that thing: from now on twice the distance is kept from it. Elsewhere it is put
        on the map: something narrow and low, just before the robot.

        Args:
            observation: The newest stop.
            joints: How the arm is held, shape (Q,).
            stands: Where the base came to stand, in the base frame of the stop.
            rest: What is left of the drive, in the base frame now; one that only turns tells no place.
            part_m: Where the part seems to be [m], shape (2,), if that is where the drive led; frame of the stop.

        Returns:
            Whether to look for another way; False beside the part, and where nothing was learnt.
        """
        T_map_stop, length_m = self.where.base_pose(observation), float(np.hypot(rest.x_m, rest.y_m))
        if T_map_stop is None or length_m < _TOLD_M:
            return False
        start = self.robot.configuration(joints, T_map_stop @ stands)
        bump = self._before(start, float(np.arctan2(rest.y_m, rest.x_m)))
        if bump is None:
            return False
        place_m = bump.T_parent_body[:2, 3]
        if part_m is not None and np.linalg.norm(T_map_stop.apply(part_m) - place_m) <= AT_PART_M:
            return False
        known = [body.name for body in self.world.bodies if _beside_m(body, place_m) <= AT_BODY_M]
        if known:
            self.wary.update(known)
        else:
            self.bumps.append(bump)
        return True

    def _before(self, start: Configuration, direction_rad: float) -> Body | None:
        """A narrow box before the robot, as near as it touches nothing; None if there is no such place."""
        ahead = start.base @ Pose2(0.0, 0.0, direction_rad)
        for off_m in _BUMPS_M.tolist():
            T = homogeneous(ahead @ Pose2(off_m, 0.0, 0.0))
            T[2, 3] = BUMP_SIZE_M[2] / 2
            body = Body(f"bump_{len(self.bumps) + 1}", Box(np.array(BUMP_SIZE_M)), T)
            if not QuickCollisions(CollisionModel(self.robot, World((body,), floor_m=None))).touching(start):
                return body
        return None

    def where_now(self, observation: Observation) -> Pose2 | None:
        """Pose of the frame of odometry on the map as of the newest stop; None if that is not known."""
        T_map_base = self.where.base_pose(observation)
        return None if T_map_base is None else T_map_base @ observation.base_pose.inverse()

    def seen_from_base(self, observation: Observation, joints: FloatArray) -> World:
        """What stands within reach, in the present base frame, over a floor.

        The pose on the map has errors: what the robot seems to overlap where it stands is left out.

        Args:
            observation: The newest stop.
            joints: How the arm is held, shape (Q,).
        """
        T_map_base = self.where.base_pose(observation)
        if T_map_base is None:
            return World()
        back = homogeneous(T_map_base.inverse())
        _, nearest_m = self._standing(self.robot.configuration(joints, T_map_base), self.world)
        bodies = [body for body in self.world.bodies if 0.0 < nearest_m[body.name] < NEAR_M]
        return World(tuple(replace(body, T_parent_body=back @ body.T_parent_body) for body in bodies))

    def _path(self, checker: MotionChecker, start: Configuration, T_map_goal: Pose2, approach: Approach | None) -> Path:
        """Configurations on the map, from the start; empty if no way leads anywhere near the goal.

        The part of the approach is on the map by now.
        """
        goal = self._inside(T_map_goal)
        for goals in self._ends(start, goal, approach):
            past = way_past_corners(checker, start, goals, self.area_m)
            if past:
                return shortened(checker, past, self.rng, _SHORTCUTS)
        found = plan_short_drive(checker, start, goal, self.rng, self.rules)
        if isinstance(found, Failure) and found.kind == GOAL_BLOCKED:
            for near in self._free_goals(checker, start, goal, approach):
                found = plan_short_drive(checker, start, near, self.rng, self.rules)
                if not isinstance(found, Failure):
                    break
        return () if isinstance(found, Failure) else found

    def _ends(self, start: Configuration, goal: Pose2, approach: Approach | None) -> Iterator[list[Pose2]]:
        """Where the way may end: at the goal, or as near to the part as the goal is, or else within its reach."""
        if approach is None:
            yield [goal]
            return
        towards = approach.part_m - start.base.translation_m
        first_rad, far_m = float(np.arctan2(towards[1], towards[0])), _apart_m(goal, approach.part_m)
        about = facing(approach.part_m, (far_m,), first_rad)
        yield [goal, *(end for end in about if self._inside(end) == end)]
        near = facing(approach.part_m, (*_NEARER_M, approach.reach_m), first_rad, _ASIDE_RAD)
        yield [goal, *(end for end in near if self._inside(end) == end)]

    def _inside(self, goal: Pose2) -> Pose2:
        """The goal, moved into the area."""
        if self.area_m is None:
            return goal
        x_m, y_m = np.clip(goal.translation_m, *self.area_m).tolist()
        return Pose2(x_m, y_m, goal.theta_rad)

    def _free_goals(
        self, checker: MotionChecker, start: Configuration, goal: Pose2, approach: Approach | None
    ) -> Iterator[Pose2]:
        """Free goals for one that is not: the nearest to it, but first those, near the robot, that reach the part."""
        goals, count = near_goals(goal), 0
        if approach is not None:
            part_m, robot_m = approach.part_m, start.base.translation_m
            reaching = [near for near in goals if _apart_m(near, part_m) <= approach.reach_m]
            reaching.sort(key=lambda near: round(_apart_m(near, robot_m), 9))
            goals = [*reaching, *(near for near in goals if _apart_m(near, part_m) > approach.reach_m)]
        for near in goals:
            if self._inside(near) == near and not checker.checker.collides(replace(start, base=near)):
                yield near
                if (count := count + 1) == _TRIED_GOALS:
                    return

    def _checker(self, start: Configuration, lying: Sequence[Body]) -> MotionChecker:
        """Checks in the grown world; what the robot is near already is not grown, what it overlaps may be touched.

        It can only seem to overlap a thing: by the error of where it stands.
        """
        standing = self.world.with_bodies(*self.bumps)
        plain, nearest_m = self._standing(start, standing.with_bodies(*lying))
        bodies = [
            replace(body, shape=grown(body.shape, self._clear_m(body)))
            if nearest_m[body.name] > _AT_CORNERS * self._clear_m(body)
            else body
            for body in standing.bodies
        ]
        allowed = [(row.first, row.second) for row in plain.touching(start)]
        world = World((*bodies, *lying), self.world.floor_m)
        quick = QuickCollisions(CollisionModel(self.robot, world, allowed=allowed))
        return MotionChecker(quick, resolution_m=_RESOLUTION * self.clear_m + RESOLUTION_M)

    def _clear_m(self, body: Body) -> float:
        return (2.0 if body.name in self.wary else 1.0) * self.clear_m

    def _standing(self, start: Configuration, world: World) -> tuple[QuickCollisions, dict[str, float]]:
        """Checks in a world as it is, and how near each body is to the robot [m], below 0 where they overlap."""
        plain = QuickCollisions(CollisionModel(self.robot, world))
        nearest_m = {body.name: np.inf for body in world.bodies}
        for pair, distance_m in zip(plain.pair_names, plain.distances(start), strict=True):
            for name in nearest_m.keys() & set(pair):
                nearest_m[name] = min(nearest_m[name], float(distance_m))
        return plain, nearest_m

    @staticmethod
    def _lying(part: Part, T_map_base: Pose2, seen: PartEstimate) -> Body:
        """The part that is sought, wider than it is but no higher: the hand may pass over it, the base not."""
        shape = Box(part.size_m + np.array([2 * PART_CLEAR_M, 2 * PART_CLEAR_M, 0.0]))
        return Body(part.part_id, shape, homogeneous(T_map_base) @ pose_of(seen))


def _apart_m(pose: Pose2, point_m: FloatArray) -> float:
    return float(np.linalg.norm(pose.translation_m - point_m))


def _beside_m(body: Body, point_m: FloatArray) -> float:
    """Distance of a point of the floor from the outline of an upright body's bounding box [m]."""
    T = body.T_parent_body
    own_m = T[:2, :2].T @ (point_m - T[:2, 3])
    return float(
        np.linalg.norm(np.maximum(0.0, np.maximum(body.shape.lower_m[:2] - own_m, own_m - body.shape.upper_m[:2])))
    )
