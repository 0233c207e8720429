"""Collects what happened in a simulated search for its film and its report."""

from rfcompass.simulation.piles import PileWorld, drawn_shapes
from rfcompass.studies.searching import SearchRun
from rfcompass.types import Configuration, SearchResult
from rfcompass.viz.search_film import FilmedGrasp, FilmedPile, SearchFilm

_OPACITY = 0.75  # of items, so that the map shows through


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
            now_s += stage.duration_s
    return SearchFilm(
        run.robot.arm.T_world_base, tuple(times_s), tuple(pictures), tuple(_piles(run)), tuple(_grasps(result))
    )


def _piles(run: SearchRun) -> list[FilmedPile]:
    scene, filmed = run.task.scene, []
    for time_s, states in run.robot.tables:
        items = [item for item in scene.items if item.number in states]
        shapes = drawn_shapes(PileWorld(items, states, scene.physics), opacity=_OPACITY, solid=(scene.target,))
        filmed.append(FilmedPile(time_s, tuple(shapes)))
    return filmed


def _grasps(result: SearchResult) -> list[FilmedGrasp]:
    return [
        FilmedGrasp(
            max(step.elapsed_s - step.attempt.duration_s, 0.0),
            step.elapsed_s,
            step.action.T_world_hand,
            step.grid,
            step.attempt.outcome,
            step.attempt.success,
        )
        for step in result.steps
    ]
