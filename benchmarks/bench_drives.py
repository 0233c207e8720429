"""Drives around furniture beside OMPL, in one run on one thread, with one collision checker.

Both look for a way of the whole robot, arm held as for a scan, from where a fetch starts to half a metre from the part,
in furnished rooms of tuning seeds where the straight drive is not free. Ours is the shortest way past corners, its
corners cut; OMPL's are RRT-Connect with its path simplifier, as a user would call it, and BIT* with as much time as we
took, at least half a second. Ways are compared by their length, turns counted as in our search, 5 cm for a radian, and
only where a check without gaps finds both free.

Both are at home here: ways past corners come first, because they are shorter, and OMPL's RRT-Connect is the last resort
(`planners.navigation`), there with a check without gaps after the search and a smaller step where that finds a touch.

Run `python -m benchmarks.bench_drives`; about four minutes, half a minute with `--fast`. Times are CPU times, but
OMPL is given wall time: with anything else on the core BIT* gets less than we took.
"""

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import ompl.base as ob
import ompl.geometric as og
import ompl.util as ou

from benchmarks.timing import Timing, show
from planners.corner_ways import M_PER_RAD, way_past_corners
from planners.motion_check import MotionChecker
from planners.short_drive import shortened
from rfcompass.arrays import FloatArray
from rfcompass.geometry.pose2 import Pose2
from rfcompass.robots import CollisionModel, QuickCollisions
from rfcompass.studies.fetching import SCAN_POSTURE, SimulatedFetch
from rfcompass.studies.path_ratio import CAMERAS, path_task
from rfcompass.studies.radio_setup import DRIVE_AREA_M
from rfcompass.types.configuration import Configuration
from rfcompass.types.world import world_of_scene

BESIDE_M = 0.5  # from the part's middle to the end of the way
TURNS_RAD = np.radians([0, 20, -20, 40, -40, 60, -60, 90, -90, 120, -120, 150, -150, 180])
LOOK_M = 0.05  # OMPL looks so often along a drive
GIVE_UP_S = 10.0
CUTS = 100
Way = Sequence[Configuration]


@dataclass(frozen=True, slots=True)
class Question:
    """A drive that is asked for.

    Attributes:
        checker: What must not be touched.
        start: Where the robot stands, and how it holds its arm.
        goal: Where to.
    """

    checker: MotionChecker
    start: Configuration
    goal: Pose2


def run(fast: bool = False) -> list[Timing]:
    """Ask all rooms of both sights; where the straight drive is free there is nothing to compare."""
    ou.RNG.setSeed(1)
    ou.setLogLevel(ou.LOG_NONE)
    asked = [found for seed in ((0, 2) if fast else range(20)) for sight in ("in sight", "hidden")
             if (found := question(sight, seed)) is not None]  # fmt: skip
    ours = [_timed(lambda q=q: past_corners(q)) for q in asked]
    connect = [_timed(lambda q=q: by_rrt_connect(q)) for q in asked]
    informed = [_timed(lambda q=q, t=t: by_bit_star(q, max(0.5, t))) for q, (t, _) in zip(asked, ours, strict=True)]
    return [
        _compared("RRT-Connect, simplified", ours, connect, asked),
        _compared("BIT*, our time", ours, informed, asked),
    ]


def question(sight: str, seed: int) -> Question | None:
    """The first drive of a fetch, if something stands in its way; None else."""
    job = SimulatedFetch(path_task({"sight": sight, "way": CAMERAS}, seed))
    if job.scene is None:
        raise AssertionError("a room with cameras is furnished")
    model = CollisionModel(job.robot, world_of_scene(job.scene))
    checker = MotionChecker(QuickCollisions(model))
    start = Configuration(job.robot.posture(SCAN_POSTURE).joints, job.true_way[0])
    first_rad = float(np.arctan2(*(job.true_part_m - start.base.translation_m)[::-1]))
    goals = (_facing(job.true_part_m, first_rad + turn_rad) for turn_rad in TURNS_RAD.tolist())
    free = (goal for goal in goals if not checker.checker.collides(Configuration(start.joints, goal)))
    goal = next(free, None)
    if goal is None or checker.checker.collides(start) or checker.check(start, Configuration(start.joints, goal)).free:
        return None
    return Question(checker, start, goal)


def _facing(part_m: FloatArray, heading_rad: float) -> Pose2:
    """Before the part, facing it."""
    x_m, y_m = part_m - BESIDE_M * np.array([np.cos(heading_rad), np.sin(heading_rad)])
    return Pose2(float(x_m), float(y_m), heading_rad)


def past_corners(asked: Question) -> Way:
    """Ours."""
    way = way_past_corners(asked.checker, asked.start, [asked.goal], DRIVE_AREA_M)
    return shortened(asked.checker, way, np.random.default_rng(0), CUTS) if way else ()


def by_rrt_connect(asked: Question) -> Way:
    """OMPL's usual answer: a random tree from both ends, simplified as long as it gets shorter."""
    setup = _setup(asked)
    setup.setPlanner(og.RRTConnect(setup.getSpaceInformation()))
    if not setup.solve(GIVE_UP_S):
        return ()
    setup.simplifySolution(1.0)
    return _way(asked, setup)


def by_bit_star(asked: Question, seconds: float) -> Way:
    """OMPL's informed trees, for as long as it is given."""
    setup = _setup(asked)
    setup.setPlanner(og.BITstar(setup.getSpaceInformation()))
    return _way(asked, setup) if setup.solve(seconds) and setup.haveExactSolutionPath() else ()


def _setup(asked: Question) -> og.SimpleSetup:
    space = ob.SE2StateSpace()
    bounds = ob.RealVectorBounds(2)
    for axis in range(2):
        bounds.setLow(axis, DRIVE_AREA_M[0][axis])
        bounds.setHigh(axis, DRIVE_AREA_M[1][axis])
    space.setBounds(bounds)
    space.setSubspaceWeight(1, M_PER_RAD)
    setup = og.SimpleSetup(space)
    joints, collides = asked.start.joints, asked.checker.checker.collides
    setup.setStateValidityChecker(lambda s: not collides(Configuration(joints, Pose2(s.getX(), s.getY(), s.getYaw()))))
    setup.getSpaceInformation().setStateValidityCheckingResolution(LOOK_M / space.getMaximumExtent())
    ends = []
    for pose in (asked.start.base, asked.goal):
        state = space.allocState()
        state.setX(pose.x_m)
        state.setY(pose.y_m)
        state.setYaw(float(np.arctan2(np.sin(pose.theta_rad), np.cos(pose.theta_rad))))
        ends.append(state)
    setup.setStartAndGoalStates(*ends)
    return setup


def _way(asked: Question, setup: og.SimpleSetup) -> Way:
    states = setup.getSolutionPath().getStates()
    return [Configuration(asked.start.joints, Pose2(s.getX(), s.getY(), s.getYaw())) for s in states]


def length_m(way: Way) -> float:
    """Length of a way, 5 cm for each radian of turning; infinite for none [m]."""
    moves = [one.base.inverse() @ other.base for one, other in pairwise(way)]
    return sum(np.hypot(m.x_m, m.y_m) + M_PER_RAD * abs(m.theta_rad) for m in moves) if moves else float("inf")


def is_free(asked: Question, way: Way) -> bool:
    """Whether our check without gaps finds nothing on a way."""
    return bool(way) and asked.checker.check_path(way).free


def _timed(plan: Callable[[], Way]) -> tuple[float, Way]:
    began_s = time.process_time()
    way = plan()
    return time.process_time() - began_s, way


def _compared(
    peer: str, ours: Sequence[tuple[float, Way]], theirs: Sequence[tuple[float, Way]], asked: Sequence[Question]
) -> Timing:
    """Time for all questions; lengths where both ways are free go to stderr, with how many are."""
    free = [[is_free(q, way) for q, (_, way) in zip(asked, side, strict=True)] for side in (ours, theirs)]
    both = [(length_m(a), length_m(b)) for (_, a), (_, b), *fine in zip(ours, theirs, *free, strict=True) if all(fine)]
    ratios = np.array([b / a for a, b in both])
    if not len(ratios):
        raise AssertionError(f"{len(asked)} drives, and none that both sides found")
    quartiles = ", ".join(f"{value:.3f}" for value in np.quantile(ratios, [0.25, 0.5, 0.75]))
    print(
        f"{peer}: {len(asked)} drives, free ones ours {sum(free[0])}, theirs {sum(free[1])}; "
        f"their length over ours, of {len(both)}: mean {ratios.mean():.3f}, quartiles {quartiles}",
        file=sys.stderr,
    )
    ours_s, theirs_s = (sum(seconds for seconds, _ in side) for side in (ours, theirs))
    name = f"drives around furniture, {len(asked)}, lengths {ratios.mean():.2f}"
    return Timing(name, ours_s, f"OMPL {peer}", theirs_s, float(np.abs(ratios - 1.0).max()))


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fast", action="store_true", help="four rooms, to see that it works")
    show(run(parser.parse_args(argv).fast))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
