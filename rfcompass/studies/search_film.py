"""Collects what happened in a simulated search for its film and its report."""

from collections.abc import Iterator

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.mapping.camera import points_image
from rfcompass.simulation.piles import PileWorld, drawn_shapes
from rfcompass.studies.searching import SearchRun
from rfcompass.types import Configuration, SearchResult, SearchStep
from rfcompass.types.motions import APPROACH, LIFT, RETREAT
from rfcompass.viz.search_film import FilmedCarry, FilmedGrasp, FilmedPile, SearchFilm

_OPACITY = 0.75  # of items, so that the map shows through
_EVERY = 2  # pixels of an image whose points are drawn


def film_of(run: SearchRun, result: SearchResult) -> SearchFilm:
    """Make the film of a search that has ended; the pile in it is the simulated truth."""
    times_s, pictures = [0.0], [run.robot.arm.resting]
    for start_s, motion in run.robot.motions:
        now_s = start_s
        for stage in motion.stages:
            for time_s, joints in zip(stage.times_s[1:], stage.joints[1:], strict=True):
                if now_s + time_s > times_s[-1]:
                    times_s.append(now_s + float(time_s))
                    pictures.append(Configuration(joints))
            now_s += stage.duration_s + (motion.waiting_s if stage.stage == APPROACH else 0.0)
    return SearchFilm(
        run.robot.arm.T_world_base,
        tuple(times_s),
        tuple(pictures),
        tuple(_piles(run)),
        tuple(_grasps(result)),
        tuple(_carried(run)),
    )


def _piles(run: SearchRun) -> list[FilmedPile]:
    scene, filmed = run.task.scene, []
    for time_s, states in run.robot.tables:
        items = [item for item in scene.items if item.number in states]
        shapes = drawn_shapes(PileWorld(items, states, scene.physics), opacity=_OPACITY, solid=(scene.target,))
        filmed.append(FilmedPile(time_s, tuple(shapes)))
    return filmed


def _carried(run: SearchRun) -> Iterator[FilmedCarry]:
    """What each grasp took off, on its way to the drop zone."""
    arm, scene = run.robot.arm, run.task.scene
    robot = arm.ik.robot
    fetches = [(start_s, motion) for start_s, motion in run.robot.motions if motion.stages[-1].stage in (LIFT, RETREAT)]
    for (start_s, motion), (_, before), (_, after) in zip(
        fetches, run.robot.tables[:-1], run.robot.tables[1:], strict=True
    ):
        gone = [item for item in scene.items if item.number in before and item.number not in after]
        if not gone:
            continue
        shapes = drawn_shapes(PileWorld(gone, {item.number: before[item.number] for item in gone}, scene.physics))
        times_s, poses = [start_s + motion.closed_s], [motion.T_world_link]
        now_s = times_s[0]
        for stage in motion.stages:
            if stage.stage in (LIFT, RETREAT):
                times_s += [now_s + float(time_s) for time_s in stage.times_s[1:]]
                poses += [
                    arm.T_world_base @ robot.tool_pose(Configuration(row)).homogeneous for row in stage.joints[1:]
                ]
                now_s += stage.duration_s
        yield FilmedCarry(tuple(times_s), tuple(poses), tuple(shape for shape in shapes if shape.link != "table"))


def _grasps(result: SearchResult) -> list[FilmedGrasp]:
    return [
        FilmedGrasp(
            max(step.elapsed_s - step.attempt.duration_s, 0.0),
            step.elapsed_s,
            step.action.T_world_hand,
            step.grid,
            step.attempt.outcome,
            step.attempt.success,
            *_scored(step),
        )
        for step in result.steps
    ]


def _scored(step: SearchStep) -> tuple[FloatArray, FloatArray]:
    """Points on the objects of an image, and the share of the best score that each object has, -1 for none."""
    labels, points_m = step.masks.labels[::_EVERY, ::_EVERY], points_image(step.view)[::_EVERY, ::_EVERY]
    shown = (labels > 0) & np.isfinite(points_m).all(axis=2)
    scores, best = step.action.scores, max(step.action.scores.values(), default=0.0)
    share = np.full(int(labels.max()) + 1, -1.0)
    for label, score in scores.items():
        if best > 0 and label < len(share):
            share[label] = max(score / best, 0.0)
    return points_m[shown], share[labels[shown]]
