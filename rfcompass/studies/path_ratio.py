"""Study: how much longer than the straight line is the base's way to the part [Wang2013], Fig. 10 and 11?

Only the first phase is run, until the robot takes the part to be in reach. Every way of finding the part starts from
the same poses; furniture is known and driven around.
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from planners.time_account import TimeSpent
from rfcompass.arrays import FloatArray
from rfcompass.errors import NoAnswer
from rfcompass.evaluation.records import MetricValue
from rfcompass.evaluation.shortest_way import outlines_m, shortest_way_m
from rfcompass.geometry.pose2 import Pose2
from rfcompass.robots import CollisionModel, FclCollisions, Robot
from rfcompass.robots.youbot import BASE_WIDTH_M
from rfcompass.studies.comparisons import SCENES, robot_and_part
from rfcompass.studies.fetch_modes import Mode, fetch_mode
from rfcompass.studies.fetching import SCAN_POSTURE, FetchTask, JudgedStep, SimulatedFetch
from rfcompass.studies.metric import SHARE, Metric
from rfcompass.studies.path_pictures import draw_path_ratio
from rfcompass.studies.radio_setup import LYING_HEIGHT_M
from rfcompass.studies.study import Cell, PaperValue, Study
from rfcompass.types.configuration import Configuration
from rfcompass.types.scene import Scene
from rfcompass.types.world import world_of_scene

TAGS = 2
CAMERAS = "motion capture"
WAYS = ("best", "paper", CAMERAS)
# Ours: the robot truly has the part in reach if it is no further than this; the rule of the loop plus a hand's width.
TRULY_M = 0.7
_LOOK_M = 0.02  # between two looks at whether the true way touches anything


def path_task(cell: Cell, seed: int) -> FetchTask:
    """What is fetched in a trial, and with what."""
    way = str(cell["way"])
    how = fetch_mode(Mode.PAPER if way == "paper" else Mode.BEST).in_scene(scene=SCENES[str(cell["sight"])])
    robot, part = robot_and_part()
    return FetchTask(
        robot=robot, part=part, tags=TAGS, localizer=how.localizer, seed=seed, radio=how.radio, meter=how.meter,
        near=how.near, cameras=way == CAMERAS,
        map_pose="cameras" if way == CAMERAS else how.map_pose,
    )  # fmt: skip


def path_trial(cell: Cell, seed: int, rng: np.random.Generator) -> Mapping[str, MetricValue]:  # noqa: ARG001
    """Navigate once. A run that ends with a typed reason has no ratio."""
    task, steps, ended = path_task(cell, seed), list[JudgedStep](), "in reach"
    job = SimulatedFetch(task)
    try:
        steps.extend(job.navigate())
    except NoAnswer as failure:
        ended = failure.kind
    way_m = np.array([pose.translation_m for pose in job.true_way])
    spent = sum((judged.step.spent for judged in steps), TimeSpent())
    end_m = job.part_away_m
    reached = ended == "in reach" and end_m <= TRULY_M
    return {
        **_lengths(way_m, job.scene if reached else None),
        "reached": reached,
        "clear": not touches(task.robot, job.scene, job.true_way),
        "end_m": end_m if ended == "in reach" else None,
        "drive_s": spent.drive_s if reached else None,
        "total_s": spent.total_s if reached else None,
        "stops": float(len(steps)) if reached else None,
        "way_x_m": way_m[:, 0].tolist(),
        "way_y_m": way_m[:, 1].tolist(),
        "ended": ended,
    }


def length_m(way_m: FloatArray) -> float:
    """Length of a polyline, shape (T, 2) [m]."""
    return float(np.linalg.norm(np.diff(way_m, axis=0), axis=1).sum())


def touches(robot: Robot, scene: Scene | None, way: Sequence[Pose2]) -> bool:
    """Whether the robot, with its arm as for a scan, touches anything on its true way, looked at every 2 cm."""
    if scene is None:
        return False
    checker, joints = FclCollisions(CollisionModel(robot, world_of_scene(scene))), robot.posture(SCAN_POSTURE).joints
    poses = [way[0]]
    for one, other in pairwise(way):
        move = one.inverse() @ other
        looks = int(np.ceil((np.hypot(move.x_m, move.y_m) + 0.3 * abs(move.theta_rad)) / _LOOK_M)) + 1
        poses += [one @ Pose2(t * move.x_m, t * move.y_m, t * move.theta_rad) for t in np.linspace(0, 1, looks)[1:]]
    return any(checker.collides(Configuration(joints, pose)) for pose in poses)


def _lengths(way_m: FloatArray, scene: Scene | None) -> dict[str, MetricValue]:
    """Ratios to the straight line and to the shortest way; None where the part was not reached or there was no need."""
    straight_m = float(np.linalg.norm(way_m[-1] - way_m[0]))
    if scene is None or straight_m == 0.0:
        return {"ratio": None, "ratio_around": None, "straight_m": None}
    things = outlines_m(scene.obstacles, LYING_HEIGHT_M, BASE_WIDTH_M / 2)
    shortest_m = shortest_way_m(way_m[0], way_m[-1], things)
    driven_m = length_m(way_m)
    return {
        "ratio": driven_m / straight_m,
        "ratio_around": None if shortest_m is None else driven_m / shortest_m,
        "straight_m": straight_m,
    }


def _paper(sight: str, figure: int, mean: float, largest: float) -> list[PaperValue]:
    differs = "measured, ten runs; their largest, not the median of the largest of ten"
    source = f"[Wang2013] Fig. {figure}"
    rows = [("mean", mean), ("max10", largest)]
    found = [
        PaperValue("ratio", summary, value, source, differs, {"sight": sight, "way": way})
        for way in ("best", "paper")
        for summary, value in rows
    ]
    if sight == "in sight":  # hidden, their cameras fail: no ratio
        cell = {"sight": sight, "way": CAMERAS}
        found += [PaperValue("ratio", summary, 1.0, source, differs, cell) for summary, _ in rows]
    return found


PATH_RATIO = Study(
    name="path-ratio",
    title="The way of the base to the part, beside the straight line",
    kind="simulated",
    factors={"sight": tuple(SCENES), "way": WAYS},
    seeds=range(1000, 1100),
    tuning_seeds=range(20),
    trial=path_trial,
    metrics=(
        Metric("reached", (SHARE,), "bool", "runs that end with the part in reach", "%", 100.0, 0),
        Metric("ratio", ("mean", "median", "max10"), "float", "way over straight line", "", 1.0, 3),
        Metric("ratio_around", ("mean", "max10"), "float", "way over shortest way around furniture", "", 1.0, 3),
        Metric("clear", (SHARE,), "bool", "runs that touch nothing", "%", 100.0, 0),
        Metric("straight_m", ("mean",), "float", "straight line", "m", 1.0, 2),
        Metric("end_m", ("mean",), "float", "part from the base's centre at the end", "m", 1.0, 2),
        Metric("stops", ("mean",), "float", "stops", "", 1.0, 1),
        Metric("drive_s", ("mean",), "float", "time of driving", "s", 1.0, 0),
        Metric("total_s", ("mean",), "float", "time with scans, antenna at 0.2 m/s", "s", 1.0, 0),
        Metric("way_x_m", column="samples"),
        Metric("way_y_m", column="samples"),
        Metric("ended", column="text"),
    ),
    paper=(*_paper("in sight", 10, 1.06, 1.16), *_paper("hidden", 11, 1.05, 1.12)),
    note=(
        "Two part tags, nine robot tags. Start and part are drawn 2 to 5.3 m apart, what the area between the tracks "
        "of a 6 x 5 m room allows. The straight line leads from start to end of the way. The shortest way is that of "
        "a disc as wide as the base, around what reaches the floor: a lower bound. Nothing stops the base but the "
        "border of its area; `runs that touch nothing` says how often nothing would have. Ratios are of runs that end "
        "with the part within 0.7 m. `best` sees from its own tags where it is on the map, `paper` is told at the "
        "start. Motion capture: eight cameras of unlimited view under the ceiling, four markers on the part; it looks "
        "under a chair that is open below, unlike the paper's, which found no hidden part."
    ),
    draws=draw_path_ratio,
)
