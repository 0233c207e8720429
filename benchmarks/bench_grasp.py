"""A whole grasp plan beside what one would write with trimesh, pinocchio and python-fcl, in one run on one thread.

Asked is the same: a table leg in front of the youBot, its pose known by 1000 samples (5 mm, 3 degrees), where to put
the hand. *Ours* lists the grasps, ranks them by chance, solves, plans and certifies every motion.

The peer is what threads on grasp planning show: points drawn on the surface with `trimesh.sample`, rays to the
opposite face, friction cones, eight approaches for each pair, damped least squares for the whole 6-D pose from the
present posture, python-fcl for collisions at the grasp, and the chance of those that are left over the same samples
with fcl, the hand's boxes swept down upon the part. It plans no motion and looks at no way there. Both grasps are then
judged by the same judge, with the hand exactly where it is sent.

The last row is a leg between walls and under a lid: how long until each says that there is no grasp.

    OMP_NUM_THREADS=1 python -m benchmarks.bench_grasp [--fast]
"""

import sys
import time
from collections.abc import Sequence

import fcl
import numpy as np
import trimesh

from benchmarks.bench_ik import damped_least_squares, whole
from benchmarks.timing import Timing, best_of, show
from planners.antipodal import tool_rotation, turn
from planners.grasp import GraspPlanner, GraspRules
from planners.grasp_question import pose_of
from planners.success import part_frames, success_probability
from rfcompass.arrays import FloatArray
from rfcompass.recordings import PartDatabase
from rfcompass.robots import CollisionModel, FclCollisions, YouBot
from rfcompass.robots.hand import hand_of
from rfcompass.types import Body, Box, GraspPlan, Part, PartEstimate, World

ROBOT = YouBot()
SCAN, HAND, TOOL = ROBOT.posture("scan"), hand_of(ROBOT), ROBOT.tool
POINTS, APPROACHES = 100, 8


def run(fast: bool = False, seed: int = 41) -> list[Timing]:
    """Time a warm plan; the names say how likely the chosen grasps hold, by the same judge."""
    with PartDatabase() as parts:
        leg = parts.part("table_leg_3")
    rows = []
    for name, place in (("across", (0.42, 0.03, 1.4)), ("at a slant", (0.45, 0.05, 0.9))):
        estimate = seen(leg, np.array(place), 100 if fast else 1000, seed)
        planner = GraspPlanner(ROBOT, rules=GraspRules(samples=len(estimate.samples)))
        planner.plan(leg, estimate)
        ours_s, plan = best_of(1 if fast else 10, lambda p=planner, e=estimate: p.plan(leg, e))
        start = time.process_time()
        theirs = peer(leg, estimate, np.random.default_rng(seed), 10 if fast else POINTS)
        peer_s = time.process_time() - start
        ours = judged(leg, estimate, plan.T_base_hand) if isinstance(plan, GraspPlan) else np.nan
        found = "no grasp" if theirs is None else f"holds {judged(leg, estimate, theirs):.2f}"
        rows.append(
            Timing(f"leg {name}, all motions: holds {ours:.2f}", ours_s, f"6-D IK + fcl: {found}", peer_s, np.nan)
        )
    return [*rows, blocked(leg, fast, seed)]


def blocked(leg: Part, fast: bool, seed: int) -> Timing:
    """Time until it is said that a leg between walls and a lid cannot be grasped; the peer finds nothing either."""
    estimate = seen(leg, np.array([0.42, 0.03, 1.4]), 100 if fast else 1000, seed)
    planner, world = GraspPlanner(ROBOT, rules=GraspRules(samples=len(estimate.samples))), enclosed(leg, estimate)
    planner.plan(leg, estimate, world)
    ours_s, failure = best_of(1 if fast else 10, lambda: planner.plan(leg, estimate, world))
    start = time.process_time()
    theirs = peer(leg, estimate, np.random.default_rng(seed), 10 if fast else POINTS, world)
    peer_s = time.process_time() - start
    ours = "a grasp" if isinstance(failure, GraspPlan) else failure.kind
    found = "no grasp" if theirs is None else "a grasp"
    return Timing(f"leg enclosed, also from elsewhere: {ours}", ours_s, f"6-D IK + fcl: {found}", peer_s, np.nan)


def enclosed(leg: Part, estimate: PartEstimate) -> World:
    """Four walls and a lid, each 1 cm from the leg: there is no grasp, from nowhere."""
    (length, width, height), gap, thick = map(float, leg.size_m), 0.01, 0.02
    long_m, wide_m, high_m = length + 2 * (gap + thick), width + 2 * (gap + thick), height + gap
    beside, before = (width + thick) / 2 + gap, (length + thick) / 2 + gap
    rows = [((long_m, thick, high_m), (0.0, side * beside, (high_m - height) / 2)) for side in (-1, 1)] + [
        ((thick, wide_m, high_m), (side * before, 0.0, (high_m - height) / 2)) for side in (-1, 1)
    ]
    rows.append(((long_m, wide_m, thick), (0.0, 0.0, gap + (height + thick) / 2)))
    bodies = []
    for i, (size_m, place) in enumerate(rows):
        T = np.eye(4)
        T[:3, 3] = place
        bodies.append(Body(f"wall {i}", Box(np.array(size_m)), pose_of(estimate) @ T))
    return World(tuple(bodies))


def seen(leg: Part, mean: FloatArray, count: int, seed: int) -> PartEstimate:
    """An estimate good to 5 mm and 3 degrees."""
    covariance = np.diag([5e-3**2, 5e-3**2, np.deg2rad(3) ** 2])
    samples = np.random.default_rng(seed).multivariate_normal(mean, covariance, count)
    return PartEstimate(
        leg.part_id, mean[:2], float(mean[2]), "told", 1, leg.resting_height_m, covariance, samples=samples
    )


def judged(leg: Part, estimate: PartEstimate, T_base_hand: FloatArray) -> float:
    """Chance of a grasp, without noise of the arm."""
    return success_probability(HAND, leg, T_base_hand, estimate.samples, estimate.height_m).probability


def peer(
    leg: Part, estimate: PartEstimate, rng: np.random.Generator, points: int, around: World | None = None
) -> FloatArray | None:
    """The pose of the hand that holds most of the samples, among those that can be reached; None if none can."""
    T_base_part = pose_of(estimate)
    body = Body(leg.part_id, leg.shape, T_base_part)
    judge = FclCollisions(CollisionModel(ROBOT, World((*(around or World()).bodies, body))))
    solve = damped_least_squares()
    reached = []
    for T_part_hand in sampled_grasps(leg, rng, points):
        T = T_base_part @ T_part_hand
        target = ROBOT.tool_pose(SCAN)
        target.translation, target.rotation = T[:3, 3], T[:3, :3]
        arm = solve(target, SCAN.joints[:5])
        off = ROBOT.tool_pose(whole(arm)).inverse() * target
        solved = np.linalg.norm(off.translation) < 1e-4 and abs(np.trace(off.rotation) - 3) < 1e-6
        if solved and not judge.collides(whole(arm)):
            reached.append(T)
    if not reached:
        return None
    chances = [share_that_holds(leg, estimate, T) for T in reached]
    return reached[int(np.argmax(chances))]


def sampled_grasps(leg: Part, rng: np.random.Generator, points: int) -> list[FloatArray]:
    """Antipodal grasps of a box as a mesh, in the part's frame."""
    mesh = trimesh.creation.box(np.asarray(leg.size_m))
    places, faces = trimesh.sample.sample_surface(mesh, points, seed=int(rng.integers(2**31)))
    normals = mesh.face_normals[faces]
    others, rays, hit = mesh.ray.intersects_location(places - 1e-5 * normals, -normals, multiple_hits=False)
    found = []
    for other, i, face in zip(others, rays, hit, strict=True):
        width = np.linalg.norm(places[i] - other)
        opposite = -mesh.face_normals[face] @ normals[i] > np.cos(np.arctan(HAND.friction))
        if width < HAND.greatest_m and opposite:
            found += [pose(places[i] / 2 + other / 2, normals[i], turned) for turned in range(APPROACHES)]
    return found


def pose(middle: FloatArray, closing: FloatArray, turned: int) -> FloatArray:
    """A hand that closes on a point from one of the directions across its closing axis, 1 cm beyond it."""
    first = np.cross(closing, [1.0, 0.0, 0.0] if abs(closing[0]) < 0.9 else [0.0, 1.0, 0.0])
    approach = turn(closing, 2 * np.pi * turned / APPROACHES) @ (first / np.linalg.norm(first))
    T = np.eye(4)
    T[:3, :3] = tool_rotation(TOOL, approach, closing)
    T[:3, 3] = middle + 0.01 * approach
    return T


def share_that_holds(leg: Part, estimate: PartEstimate, T_base_hand: FloatArray) -> float:
    """Share of the samples at which the open hand comes down beside the part and the part lies between the pads."""
    boxes = HAND.boxes_m()
    boxes[:, 0, 2] -= 0.5
    inside = np.array(
        [[-HAND.greatest_m / 2, *HAND.left.pads_m[-1, 0]], [HAND.greatest_m / 2, *HAND.left.pads_m[-1, 1]]]
    )
    part = fcl.CollisionObject(fcl.Box(*map(float, leg.size_m)), fcl.Transform())
    swept = [solid(box) for box in boxes]
    gap = solid(inside)
    held = 0
    for T in part_frames(estimate.samples, estimate.height_m) @ T_base_hand:
        R = T[:3, :3] @ HAND.R_tool_hand
        held += not any(touches(part, thing, R, T[:3, 3]) for thing in swept) and touches(part, gap, R, T[:3, 3])
    return held / len(estimate.samples)


def solid(corners: FloatArray) -> tuple[fcl.Box, FloatArray]:
    """A box of fcl and its centre, from corners (2, 3) in hand axes."""
    return fcl.Box(*map(float, corners[1] - corners[0])), corners.mean(axis=0)


def touches(part: fcl.CollisionObject, thing: tuple[fcl.Box, FloatArray], R: FloatArray, origin: FloatArray) -> bool:
    """True if a box of the hand touches the part."""
    box, centre = thing
    there = fcl.CollisionObject(box, fcl.Transform(R, origin + R @ centre))
    return bool(fcl.collide(part, there, fcl.CollisionRequest(), fcl.CollisionResult()) > 0)


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table."""
    show(run("--fast" in (sys.argv[1:] if argv is None else argv)))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
