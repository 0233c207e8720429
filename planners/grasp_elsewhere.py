"""Where the base must drive first, for a part that the arm does not get to from here.

With a map of what the arm can do the first place comes from `best_base_pose`, which weighs the whole estimate. After
that, and without a map, the inverse kinematics lets the base drive along, for the grasps of the part that its shape
speaks for most. Grasps where something stands in the place of the hand are left out: they can be done from nowhere.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from planners.base_placement import BasePlacement, PartGrasp, best_base_pose
from planners.grasp_question import GraspQuestion
from planners.hand_blocked import hand_blocked
from planners.ik import IkRules, InverseKinematics
from planners.task_map import TaskMap
from rfcompass.geometry.pose2 import Pose2
from rfcompass.robots import CollisionModel, QuickCollisions, Robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasp_task import GraspTask, Solution
from rfcompass.types.grasps import GraspCandidate

# Ours: grasps from above that places are looked for.
_GRASPS = 3
# Ours: starts of the optimisation for each; where the first fail, things stand in the way, and the rest takes seconds.
_STARTS = 8


def places_to_drive_to(
    robot: Robot,
    question: GraspQuestion,
    listed: Sequence[GraspCandidate],
    task_map: TaskMap | None,
    opened: Configuration,
    rng: np.random.Generator,
) -> Iterator[Pose2]:
    """Offer poses of the base, in the present base frame, from which the part may be in reach.

    Args:
        robot: A robot that drives.
        question: What is asked.
        listed: Grasps of the part by its shape.
        task_map: What the arm can do; None if nobody made a map.
        opened: Joints while it drives, hand open.
        rng: Thins the samples of the estimate.
    """
    model = CollisionModel(robot, question.world)
    blocked = hand_blocked(model, opened, question.part.part_id)
    above = [
        row
        for row in sorted((row for row in listed if _is_from_above(row, robot)), key=_score, reverse=True)
        if blocked(question.T_base_part @ row.T_part_hand) is None
    ][:_GRASPS]
    if not above:
        return
    if task_map is not None:
        grasps = [_part_grasp(row, robot, question.estimate.height_m) for row in above]
        found = best_base_pose(
            question.estimate, task_map, grasps, rng=rng, posture=opened, checker=QuickCollisions(model)
        )  # fmt: skip
        if isinstance(found, BasePlacement):
            yield found.base
    ik = InverseKinematics(robot, model=model, rules=IkRules(certify=False, explain=False, starts=_STARTS))
    tool = robot.tool
    for row in above:
        T = question.T_base_part @ row.T_part_hand
        task = GraspTask.of_pose(T, tool.approach_axis, tool.closing_axis)
        answer = ik.solve(task, opened, base_free=True)
        if isinstance(answer, Solution):
            yield answer.configuration.base


def _is_from_above(row: GraspCandidate, robot: Robot) -> bool:
    return row.rejection is None and float(row.T_part_hand[2, :3] @ robot.tool.approach_axis) < -1 + 1e-9


def _score(row: GraspCandidate) -> float:
    return row.score or 0.0


def _part_grasp(row: GraspCandidate, robot: Robot, height_m: float) -> PartGrasp:
    closing = row.T_part_hand[:3, :3] @ robot.tool.closing_axis
    u, v, w = row.T_part_hand[:3, 3]
    return PartGrasp(np.array([u, v]), float(np.arctan2(closing[1], closing[0])), height_m + float(w))
