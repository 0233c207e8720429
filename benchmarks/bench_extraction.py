"""One decision in front of three piles of 43 things, beside what one would write with numpy.

A decision: one more view into the map, the map of where the target can be, objects in the view, the choice. The peer
does the same work: all voxels into the image by matrix products, `scipy.signal.fftconvolve` over the whole grid, and
Eq. 4 with a loop over pixels for who is on top, and one over masks and columns. Grasps are given, but in one row of
ours; both sides segment alike. Of the 46 things that are drawn, some are buried.

    OMP_NUM_THREADS=1 python -m benchmarks.bench_extraction [--fast]
"""

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.signal import fftconvolve

from benchmarks.bench_mapping import camera, numpy_view
from benchmarks.timing import Timing, best_of, show
from planners.extraction import (
    FewestActionsPolicy,
    FuseBotPolicy,
    LargestMaskPolicy,
    MapMassPolicy,
    NaivePolicy,
    RandomPolicy,
    XRayPolicy,
    mask_scores,
    project_masks,
)
from planners.grasp_quality import AntipodalQuality
from planners.target_grasp import grasp_again
from rfcompass.arrays import FloatArray, IntArray
from rfcompass.interfaces import ExtractionPolicy
from rfcompass.mapping import (
    DepthSegmenter,
    TargetKernel,
    VisualMap,
    gaussian_target,
    map_views,
    occupancy_map,
    posterior_map,
)
from rfcompass.mapping.camera import points_image
from rfcompass.mapping.view_kernels import UNOBSERVED
from rfcompass.types import (
    DepthView,
    ExtractionAction,
    GraspMaps,
    InstanceMasks,
    ItemSize,
    TaggedItem,
    VoxelGrid,
    Workspace,
)

THINGS, PILES_M, HEIGHT_M, NEAR_M = 46, ((-0.25, 0.1), (0.25, 0.12), (0.0, -0.15)), 0.85, 0.60
TAGS = 8
TARGET = ItemSize("target", np.array([0.08, 0.05, 0.035]))
GAMMA = 0.7


@dataclass(frozen=True)
class Boxes:
    """Things on each other, as seen from above: middle, half edges, turn, top."""

    middle_m: FloatArray
    half_m: FloatArray
    yaw_rad: FloatArray
    top_m: FloatArray

    @classmethod
    def heaped(cls, seed: int = 0) -> "Boxes":
        """Draw boxes of 5 to 12 cm; each is 1.17 cm higher than the one before it in its pile."""
        rng = np.random.default_rng(seed)
        pile = np.arange(THINGS) % len(PILES_M)
        middle_m = np.array(PILES_M)[pile] + rng.normal(0, 0.075, (THINGS, 2))
        half_m = rng.uniform(0.025, 0.06, (THINGS, 2))
        return cls(
            middle_m, half_m, rng.uniform(0, np.pi, THINGS), 0.0333 + 0.0117 * (np.arange(THINGS) // len(PILES_M))
        )

    def tops(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, IntArray]:
        """Height and number of the highest thing at each point; 0 and 0 for the table."""
        height, number = np.zeros(x.shape), np.zeros(x.shape, dtype=np.int64)
        for n in range(THINGS):
            c, s = np.cos(self.yaw_rad[n]), np.sin(self.yaw_rad[n])
            a, b = x - self.middle_m[n, 0], y - self.middle_m[n, 1]
            inside = (np.abs(c * a + s * b) < self.half_m[n, 0]) & (np.abs(c * b - s * a) < self.half_m[n, 1])
            higher = inside & (self.top_m[n] > height)
            height[higher], number[higher] = self.top_m[n], n + 1
        return height, number

    def tagged(self, count: int) -> tuple[TaggedItem, ...]:
        """Some of them with a tag on top, known to 3 cm."""
        edges_m = np.column_stack([2 * self.half_m, np.full(THINGS, 0.04)])
        tops_m = np.column_stack([self.middle_m, self.top_m])
        return tuple(
            TaggedItem(ItemSize(f"box_{n}", edges_m[n], epc=f"{n:024x}"), tops_m[n], 0.03**2 * np.eye(3))
            for n in range(count)
        )

    def seen(self, T: FloatArray, shape: tuple[int, int] = (240, 320)) -> tuple[DepthView, InstanceMasks]:
        """View and true objects from straight above, by a few steps of iteration."""
        focal = 0.8 * shape[1]
        K = np.array([[focal, 0, (shape[1] - 1) / 2], [0, focal, (shape[0] - 1) / 2], [0, 0, 1]])
        v, u = np.indices(shape)
        depth, number = np.full(shape, T[2, 3]), np.zeros(shape, dtype=np.int64)
        for _ in range(6):
            height, number = self.tops(T[0, 3] + (u - K[0, 2]) / focal * depth, T[1, 3] - (v - K[1, 2]) / focal * depth)
            depth = T[2, 3] - height
        return DepthView(depth, K, T), InstanceMasks(number)


def numpy_scores(grid: VoxelGrid, view: DepthView, masks: InstanceMasks) -> dict[int, float]:
    """Eq. 4 of each mask, in plain numpy: the highest pixel of each column owns it, then voxel by voxel."""
    own = (masks.labels > 0) & np.isfinite(view.depth_m)
    points_m, labels = points_image(view)[own], masks.labels[own]
    columns = np.floor((points_m[:, :2] - grid.origin_m[:2]) / grid.spacing_m + 0.5).astype(int)
    inside = ((columns >= 0) & (columns < grid.values.shape[:2])).all(axis=1)
    owner, surface_m = np.zeros(grid.values.shape[:2], dtype=int), np.zeros(grid.values.shape[:2])
    last = np.lexsort((-np.arange(len(labels)), points_m[:, 2].round(9)))  # of pixels as high, the first one is on top
    for n in last[inside[last]]:
        owner[tuple(columns[n])], surface_m[tuple(columns[n])] = labels[n], points_m[n, 2]
    heights_m = grid.origin_m[2] + grid.spacing_m * np.arange(grid.values.shape[2])
    scores = {}
    for label in np.unique(labels):
        own = owner == label
        top_m = surface_m[own].max(initial=0.0)
        weights = np.where(heights_m <= top_m + 1e-9, GAMMA ** ((top_m - heights_m) / 0.025), 0.0)
        scores[int(label)] = sum(float(weights @ grid.values[i, j]) for i, j in np.argwhere(own))
    return scores


def our_scores(grid: VoxelGrid, view: DepthView, masks: InstanceMasks) -> dict[int, float]:
    """The same by ours."""
    labels = np.unique(masks.labels[masks.labels > 0])
    return dict(zip(labels.tolist(), mask_scores(grid, project_masks(grid, view, masks), labels, GAMMA), strict=True))


def policies() -> Mapping[str, ExtractionPolicy]:
    """All that are timed."""
    return {
        "random": RandomPolicy(),
        "largest mask": LargestMaskPolicy(),
        "naive": NaivePolicy(),
        "FuseBot": FuseBotPolicy(),
        "X-Ray, one image": XRayPolicy(target_m=TARGET.size_m),
        "mass of the map": MapMassPolicy(),
        "fewest actions": FewestActionsPolicy(target_m=TARGET.size_m),
    }


@dataclass(frozen=True)
class Scene:
    """What both sides are given."""

    table: Workspace
    before: VisualMap
    view: DepthView
    masks: InstanceMasks
    grasps: GraspMaps
    kernel: TargetKernel
    tagged: tuple[TaggedItem, ...]
    near: DepthView

    @classmethod
    def made(cls) -> "Scene":
        """Look at the heaps from six places, then from above."""
        boxes, table = Boxes.heaped(), Workspace.between(np.array([-0.5, -0.4, 0.0]), np.array([0.5, 0.4, 0.4]))
        view, masks = boxes.seen(camera(0.0, 0.0, HEIGHT_M))
        before = map_views(table, [boxes.seen(camera(x, y))[0] for x in (-0.2, 0.0, 0.2) for y in (-0.2, 0.2)])
        quality = np.random.default_rng(0).uniform(0, 1, view.depth_m.shape) * (masks.labels > 0)
        grasps = GraspMaps(quality, np.zeros_like(quality), np.full_like(quality, 0.05), np.full_like(quality, 0.02))
        kernel = gaussian_target(TARGET.shortest_m, TARGET.longest_m, table.spacing_m)
        near, _ = boxes.seen(camera(*PILES_M[0], NEAR_M))
        return cls(table, before, view, masks, grasps, kernel, boxes.tagged(TAGS), near)

    def paper(self) -> VoxelGrid:
        """The paper's map, without tags."""
        return occupancy_map(self.before.with_views([self.view]).uncertainty(), self.kernel)

    def decide(self, gate: bool = False) -> float:
        """One whole decision of the paper's."""
        masks = DepthSegmenter().segment(self.view)
        return FuseBotPolicy(gate=gate).choose(self.paper(), self.view, masks, self.grasps).score

    def decide_by_posterior(self, tags: int = 0) -> float:
        """One whole decision of the method `ours`, with some things tagged."""
        grid = posterior_map(self.before.with_views([self.view]), TARGET, self.tagged[:tags])
        masks = DepthSegmenter().segment(self.view)
        policy = FewestActionsPolicy(target_m=TARGET.size_m, gate=True, removals=1)
        return policy.choose(grid, self.view, masks, self.grasps).score

    def grasp_from_near(self) -> float:
        """The grasp of the chosen object anew, in an image from nearer; it is taken after a motion of the arm."""
        masks, grasps = DepthSegmenter().segment(self.near), AntipodalQuality().quality(self.near)
        first = ExtractionAction(1, camera(*PILES_M[0], 0.05), 0.06, 1.0)
        chosen = grasp_again(first, self.near, masks, grasps)
        return 0.0 if chosen is None else chosen.chance

    def with_grasps(self) -> "Scene":
        """Find the grasps of the view, in the place of the given ones."""
        return replace(self, grasps=AntipodalQuality().quality(self.view))

    def decide_in_numpy(self) -> float:
        """The paper's decision by the peer."""
        state = np.maximum(self.before.state, numpy_view(self.table, self.view))
        grid = self.table.grid(fftconvolve((state == UNOBSERVED).astype(float), self.kernel.values, mode="same"))
        return max(numpy_scores(grid, self.view, DepthSegmenter().segment(self.view)).values())


def run(fast: bool = False) -> list[Timing]:
    """Time Eq. 4 and a whole decision."""
    return timings_of(Scene.made(), 2 if fast else 7)


def timings_of(scene: Scene, repeats: int) -> list[Timing]:
    """Time Eq. 4 and a whole decision in front of one scene."""
    grid, view, masks = scene.paper(), scene.view, scene.masks
    our_scores(grid, view, masks), scene.decide()
    ours_s, ours = best_of(repeats, lambda: our_scores(grid, view, masks))
    peer_s, peer = best_of(2, lambda: numpy_scores(grid, view, masks))
    whole_s, best = best_of(repeats, scene.decide)
    slow_s, slow = best_of(2, scene.decide_in_numpy)
    differ = max(abs(ours[label] - value) for label, value in peer.items()) / max(peer.values())
    name = f"Eq. 4 of {masks.count} things, {view.depth_m.shape[1]} x {view.depth_m.shape[0]} pixels"
    return [
        Timing(name, ours_s, "numpy, loops", peer_s, differ),
        Timing("map, masks and choice, FuseBot", whole_s, "numpy, scipy, loops", slow_s, abs(1 - best / slow)),
    ]


def whole_decisions(scene: Scene) -> Mapping[str, Callable[[], float]]:
    """Decisions without a peer: view into the map, map, masks, choice."""
    return {
        "ours, grasps given": scene.decide_by_posterior,
        "ours, with grasps at all pixels": lambda: scene.with_grasps().decide_by_posterior(),
        f"ours, with grasps, {TAGS} tags": lambda: scene.with_grasps().decide_by_posterior(TAGS),
        "ours: its grasp again, from near": scene.grasp_from_near,
        "FuseBot, with grasps at all pixels": lambda: scene.with_grasps().decide(gate=True),
    }


def main() -> None:
    """Print both tables."""
    repeats, scene = 2 if "--fast" in sys.argv else 7, Scene.made()
    show(timings_of(scene, repeats))
    print()
    for what, decide in whole_decisions(scene).items():
        decide()
        took_s, _ = best_of(repeats, decide)
        print(f"{what:40s} {1e3 * took_s:.0f} ms")
    print("\nchoice alone:")
    asked = scene.paper(), scene.view, scene.masks, scene.grasps
    for name, policy in policies().items():
        policy.choose(*asked)
        took_s, _ = best_of(repeats, partial(policy.choose, *asked))
        print(f"  {name:20s} {1e3 * took_s:6.1f} ms")


if __name__ == "__main__":
    main()
