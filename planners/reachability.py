"""Maps of the grasps that an arm can do: made by its inverse kinematics, checked for collisions, voxel by voxel.

An arm with a closed form is asked everywhere. Any other is first sampled by forward kinematics: random postures say
which voxels and directions are worth asking about, and where the optimisation starts. A True in the map is always an
answer of inverse kinematics that touches nothing; a False is, for sampled arms, only "not found". Random postures
rarely point straight down into a given voxel; `spread` therefore goes on from every answer to the tasks beside it.
"""

from collections import Counter, deque
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from planners.ik import InverseKinematics
from planners.task_map import TaskMap, ToolDirections
from rfcompass.arrays import FloatArray
from rfcompass.robots.touching_links import random_joints
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasp_task import Solution
from rfcompass.types.volumes import SearchVolume

# A task is asked about from so many of the answers beside it; ours.
_ASKED_FROM = 2
# A sampled posture whose tool points this near to a direction is a start for it [rad]; ours.
_NEAR_RAD = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class MapMaker:
    """Makes maps of one arm in one world.

    Attributes:
        ik: Solves the tasks; its world is what may be touched, its rules are the limits and the clearance.
        spacing_m: Edge of a voxel [m].
        samples: Random postures for an arm without a closed form.
        spread: For such an arm, ask about the tasks beside every answer too, beginning with its posture. Slow where
            much is in reach.
    """

    ik: InverseKinematics
    spacing_m: float = 0.02
    samples: int = 20_000
    spread: bool = False

    def make(
        self,
        volume: SearchVolume,
        directions: ToolDirections,
        start: Configuration,
        rng: np.random.Generator | None = None,
    ) -> TaskMap:
        """Ask for every voxel and direction.

        Args:
            volume: Where, in the base frame; voxels are centred on its lower corner and every spacing from there.
            directions: Which directions of the tool.
            start: Present posture: the hand's opening, and where a closed form has a choice.
            rng: Draws the postures for an arm without a closed form.

        Raises:
            ValueError: If such an arm gets no `rng`.
        """
        extent = volume.upper_m - volume.lower_m
        shape = np.floor(extent / self.spacing_m + 1 + 1e-9).astype(int)
        reached = np.zeros((*shape, len(directions.approach)), dtype=bool)
        empty = TaskMap(volume.lower_m, self.spacing_m, directions, reached)
        answers: dict[tuple[int, ...], Configuration] = {}
        for index, begin in self._candidates(empty, start, rng):
            if index not in answers and (answer := self._ask(empty, index, begin)) is not None:
                answers[index] = answer
        if self.spread and not self.ik.has_closed_form:
            self._spread(empty, answers)
        for index in answers:
            reached[index] = True
        return TaskMap(volume.lower_m, self.spacing_m, directions, reached)

    def _ask(self, empty: TaskMap, index: tuple[int, ...], begin: Configuration) -> Configuration | None:
        """The posture that does a task, begun with another; None if none was found."""
        point_m = empty.centres_m(np.array(index[:3]))
        answer = self.ik.solve(empty.directions.task(point_m, index[3]), begin)
        return answer.configuration if isinstance(answer, Solution) else None

    def _spread(self, empty: TaskMap, answers: dict[tuple[int, ...], Configuration]) -> None:
        """Ask beside every answer, also beside those that this finds."""
        waiting, asked = deque(answers), Counter[tuple[int, ...]]()
        while waiting:
            index = waiting.popleft()
            for beside in _beside(index, empty.reached.shape):
                if beside in answers or asked[beside] >= _ASKED_FROM:
                    continue
                asked[beside] += 1
                if (answer := self._ask(empty, beside, answers[index])) is not None:
                    answers[beside] = answer
                    waiting.append(beside)

    def _candidates(
        self, empty: TaskMap, start: Configuration, rng: np.random.Generator | None
    ) -> Iterator[tuple[tuple[int, ...], Configuration]]:
        """Voxel and direction to ask about, and the posture to begin with."""
        if self.ik.has_closed_form:
            yield from ((index, start) for index in self._within_limits(empty, start))
            return
        if rng is None:
            raise ValueError("an arm without a closed form is sampled: pass an rng")
        yield from self._sampled(empty, start, rng)

    def _within_limits(self, empty: TaskMap, start: Configuration) -> Iterator[tuple[int, ...]]:
        """Voxels and directions that the closed form reaches, touching or not; all of a direction at once."""
        shape, directions = empty.reached.shape[:3], empty.directions
        indices = np.array(list(np.ndindex(shape)))
        points_m = empty.centres_m(indices)
        for d in range(empty.reached.shape[3]):
            axes = np.concatenate([directions.approach[d], directions.closing[d]])
            tasks = np.column_stack([points_m, np.tile(axes, (len(points_m), 1))])
            yield from ((*map(int, index), d) for index in indices[self.ik.within_limits(tasks, start)])

    def _sampled(
        self, empty: TaskMap, start: Configuration, rng: np.random.Generator
    ) -> Iterator[tuple[tuple[int, ...], Configuration]]:
        robot, size = self.ik.robot, np.array(empty.reached.shape[:3])
        columns = [robot.joint_names.index(name) for name in robot.arm_joints]
        for draw in random_joints(robot, rng, self.samples):
            joints = start.joints.copy()
            joints[columns] = draw[columns]
            T = robot.tool_pose(Configuration(joints))
            voxel = np.round((T.translation - empty.origin_m) / empty.spacing_m).astype(int)
            if (voxel < 0).any() or (voxel >= size).any():
                continue
            for d in _near(empty.directions, T.rotation @ robot.tool.approach_axis):
                yield (*map(int, voxel), d), Configuration(joints)


def _near(directions: ToolDirections, approach: FloatArray) -> list[int]:
    """Directions whose approach is near to one."""
    return [int(d) for d in np.flatnonzero(directions.approach @ approach > np.cos(_NEAR_RAD))]


def _beside(index: tuple[int, ...], shape: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
    """The neighbours of a voxel, same direction, and the voxel's other directions."""
    for axis in range(3):
        for step in (-1, 1):
            moved = (*index[:axis], index[axis] + step, *index[axis + 1 :])
            if 0 <= moved[axis] < shape[axis]:
                yield moved
    yield from ((*index[:3], d) for d in range(shape[3]) if d != index[3])
