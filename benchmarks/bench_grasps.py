"""Judging grasps in a batch, beside fcl asked pose by pose.

A leg, a rod and a turned leg, 1000 poses of the youBot's hand each, as samples of an estimate spread them. The kindest
peer only asks whether the open hand comes down free: one boolean for each of its boxes. The readable judge does the
whole; of its answers the share that differs is shown. Seed 33. Run `python -m benchmarks.bench_grasps`.
"""

import sys
from collections.abc import Sequence

import fcl
import numpy as np
import trimesh

from benchmarks.timing import Timing, best_of, show
from rfcompass import YouBot
from rfcompass.arrays import BoolArray, FloatArray
from rfcompass.robots import hand_of, judge_grasp, judge_grasps
from rfcompass.robots.grasp_batch import VERDICTS
from rfcompass.robots.grasp_judge import fcl_part
from rfcompass.types import Box, Cylinder, Failure, Mesh
from rfcompass.types.shapes import Shape

HAND = hand_of(YouBot())
SPREAD = (0.015, 0.008, 0.1)  # standard deviations along and across the part [m], and of the heading [rad]
FAR_M = 1.0


def poses(count: int) -> FloatArray:
    """Tool straight down over the middle of a part that lies somewhere about, (count, 4, 4)."""
    x, y, theta = (np.random.default_rng(33).normal(size=(count, 3)) * SPREAD).T
    c, s = np.cos(theta), np.sin(theta)
    T = np.tile(np.diag([1.0, -1.0, -1.0, 1.0]), (count, 1, 1))
    T[:, 0, 0], T[:, 0, 1], T[:, 1, 0], T[:, 1, 1] = c, s, s, -c
    T[:, 0, 3], T[:, 1, 3], T[:, 2, 3] = x, y, -0.012
    return T


def turned_leg() -> Mesh:
    """A turned leg of rings and necks, lying along x, 2352 triangles."""
    along = np.linspace(-0.15, 0.15, 50)
    radius = 0.019 + 0.006 * np.cos(along * 2 * np.pi / 0.06)
    outline = np.column_stack([[0, *radius, 0], [along[0], *along, along[-1]]])
    solid = trimesh.creation.revolve(outline, sections=24)
    vertices_m = np.roll(np.asarray(solid.vertices), 1, axis=1)
    return Mesh(vertices_m, np.asarray(solid.faces, dtype=np.int64), (vertices_m,), "vhacd", np.eye(4))


def by_fcl(shape: Shape, T_part_hands: FloatArray) -> BoolArray:
    """Whether the open hand comes down free: a boolean for each of its boxes."""
    parts, R_tool_hand = fcl_part(shape), HAND.R_tool_hand
    boxes_m = HAND.boxes_m()
    boxes_m[:, 0, 2] = -FAR_M
    solids = [(fcl.Box(*(upper - lower)), (lower + upper) / 2) for lower, upper in boxes_m]
    request, free = fcl.CollisionRequest(), []
    for T in T_part_hands:
        R = T[:3, :3] @ R_tool_hand
        things = [fcl.CollisionObject(box, fcl.Transform(R, T[:3, 3] + R @ middle_m)) for box, middle_m in solids]
        hits = (fcl.collide(thing, part, request, fcl.CollisionResult()) for thing in things for part in parts)
        free.append(not any(hits))
    return np.array(free)


def time_shape(name: str, shape: Shape, count: int, judged: int) -> list[Timing]:
    """The batch beside both, for one shape; times are for `count` poses."""
    T = poses(count)
    judge_grasps(HAND, shape, T)
    ours_s, verdicts = best_of(5, lambda: judge_grasps(HAND, shape, T))
    peer_s, free = best_of(2, lambda: by_fcl(shape, T))
    slow_s, slow = best_of(1, lambda: [judge_grasp(HAND, shape, pose) for pose in T[:judged]])
    kinds = [answer.kind if isinstance(answer, Failure) else "holds" for answer in slow]
    hits = [VERDICTS.index(kind) for kind in ("hand_hits_part", "too_wide")]
    differ = float(np.mean([VERDICTS[v] != kind for v, kind in zip(verdicts, kinds, strict=False)]))
    title = f"{count} grasps of a {name}"
    return [
        Timing(title, ours_s, "python-fcl, coming down only", peer_s, float(np.mean(np.isin(verdicts, hits) == free))),
        Timing(title, ours_s, f"judge_grasp, x {judged}", slow_s * count / judged, differ),
    ]


def run(fast: bool = False) -> list[Timing]:
    """All timings; tiny sizes if `fast`."""
    count, judged = (20, 5) if fast else (1000, 200)
    shapes = {"leg": Box(np.array([0.40, 0.05, 0.05])), "rod": Cylinder(0.025, 0.4), "turned leg": turned_leg()}
    return [timing for name, shape in shapes.items() for timing in time_shape(name, shape, count, judged)]


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table."""
    show(run("--fast" in (sys.argv[1:] if argv is None else argv)))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
