"""Maps of a pile in a workspace of 1 x 0.8 x 0.4 m, beside what one would write with numpy and scipy.

The peers do the same work: all voxels into the depth image at once with matrix products and masks, every kernel by
`np.exp` over its own block of voxels, `scipy.signal.fftconvolve` over the whole grid in double precision.

    OMP_NUM_THREADS=1 python -m benchmarks.bench_mapping [--fast]
"""

import resource
import sys

import numpy as np
from scipy.signal import fftconvolve

from benchmarks.timing import Timing, best_of, show
from rfcompass.mapping import VisualMap, fuse_maps, gaussian_target, map_views, occupancy_map, rf_certainty_map
from rfcompass.mapping.box_kernels import box_kernels, convolve_boxes
from rfcompass.mapping.view_kernels import FREE, OUTSIDE, SURFACE, UNOBSERVED
from rfcompass.types import DepthView, LocatedItem, TagFix, Workspace

HEAPS = ((-0.2, 0.05, 0.12, 0.15), (0.22, -0.08, 0.09, 0.12))  # x, y, height, radius of each, as cones [m]
TAGS = 8


def camera(x_m: float, y_m: float, height_m: float = 0.7) -> np.ndarray:
    """Pose of a camera that looks straight down."""
    T = np.diag([1.0, -1.0, -1.0, 1.0])
    T[:3, 3] = x_m, y_m, height_m
    return T


def depth_view(T: np.ndarray, shape: tuple[int, int] = (240, 320)) -> DepthView:
    """Heaps seen from straight above: the height map where each pixel's ray meets it, by eight steps of iteration."""
    focal = 0.8 * shape[1]
    K = np.array([[focal, 0, (shape[1] - 1) / 2], [0, focal, (shape[0] - 1) / 2], [0, 0, 1]])
    v, u = np.indices(shape)
    depth = np.full(shape, T[2, 3])
    for _ in range(8):
        x, y = T[0, 3] + (u - K[0, 2]) / focal * depth, T[1, 3] - (v - K[1, 2]) / focal * depth
        tops = [h * np.clip(1 - np.hypot(x - a, y - b) / r, 0, 1) for a, b, h, r in HEAPS]
        depth = T[2, 3] - np.max(tops, axis=0)
    return DepthView(depth, K, T)


def numpy_view(workspace: Workspace, view: DepthView) -> np.ndarray:
    """State of each voxel after one view, all voxels at once."""
    points = np.stack(np.meshgrid(*workspace.axes_m(), indexing="ij"), axis=-1).reshape(-1, 3)
    R, t = view.T_world_camera[:3, :3], view.T_world_camera[:3, 3]
    p = (points - t) @ R
    z = p[:, 2]
    pixels = np.floor(p @ view.intrinsics.T / z[:, None] + 0.5).astype(np.int64)
    H, W = view.depth_m.shape
    u, v = pixels[:, 0], pixels[:, 1]
    inside = (z > 0) & (u >= 0) & (u < W) & (v >= 0) & (v < H)
    ahead = view.depth_m[np.clip(v, 0, H - 1), np.clip(u, 0, W - 1)] - z
    half = workspace.spacing_m * np.abs(R[:, 2]).sum() * 0.4999
    seen = np.where(ahead >= half, FREE, np.where(ahead > -half, SURFACE, UNOBSERVED))
    return np.where(inside, seen, OUTSIDE).reshape(workspace.shape).astype(np.uint8)


def numpy_radio(workspace: Workspace, items: list[LocatedItem]) -> np.ndarray:
    """Sum of the rigid kernels, block by block."""
    values, axes = np.zeros(workspace.shape), workspace.axes_m()
    for item in items:
        spans = [np.flatnonzero(np.abs(a - p) <= item.longest_m) for a, p in zip(axes, item.point_m, strict=True)]
        block = tuple(slice(span[0], span[-1] + 1) for span in spans)
        q = [a[s] - p for a, s, p in zip(axes, block, item.point_m, strict=True)]
        r2 = q[0][:, None, None] ** 2 + q[1][:, None] ** 2 + q[2] ** 2
        values[block] -= np.exp(-r2 / (2 * (item.shortest_m / 2) ** 2)) * (r2 <= item.longest_m**2)
    return values


def tagged_items() -> list[LocatedItem]:
    """Rigid items of 6 to 16 cm with tags in the heaps."""
    rng = np.random.default_rng(0)
    places_m = rng.uniform([-0.35, -0.25, 0.01], [0.35, 0.25, 0.12], (TAGS, 3))
    return [
        LocatedItem(TagFix(str(n), point_m, np.full(3, 0.05), True), f"item {n}", 0.06, 0.16)
        for n, point_m in enumerate(places_m)
    ]


def differ(ours: np.ndarray, peers: np.ndarray) -> float:
    """Largest difference, relative to the largest value."""
    return float(np.abs(ours - peers).max() / np.abs(peers).max())


def grid_timings(spacing_m: float, shape: tuple[int, int], repeats: int) -> list[Timing]:
    """Time one size of voxels."""
    workspace = Workspace.between(np.array([-0.5, -0.4, 0.0]), np.array([0.5, 0.4, 0.4]), spacing_m)
    views = [depth_view(camera(x, y), shape) for x in (-0.22, 0.22) for y in (-0.22, 0.22)]
    name, items, empty = f"{1000 * spacing_m:.0f} mm", tagged_items(), VisualMap.empty(workspace)
    target = gaussian_target(0.06, 0.16, spacing_m)
    seen = map_views(workspace, views)
    fused = fuse_maps(seen.uncertainty(), rf_certainty_map(items, workspace).grid)
    occupancy_map(fused, target)

    view_s, one = best_of(repeats, lambda: empty.with_views(views[:1]))
    view_peer_s, one_peer = best_of(2, lambda: numpy_view(workspace, views[0]))
    cube = Workspace.between(np.array([-0.25, 0.0, 0.03]), np.array([-0.15, 0.1, 0.13]), spacing_m)
    cube_s, again = best_of(repeats, lambda: seen.refreshed(views[:1], cube.lower_m + 0.05))
    cube_peer_s, cube_peer = best_of(2, lambda: numpy_view(cube, views[0]))
    radio_s, radio = best_of(repeats, lambda: rf_certainty_map(items, workspace).grid.values)
    radio_peer_s, radio_peer = best_of(2, lambda: numpy_radio(workspace, items))
    blur_s, blurred = best_of(repeats, lambda: occupancy_map(fused, target).values)
    blur_peer_s, blurred_peer = best_of(2, lambda: fftconvolve(fused.values, target.values, mode="same"))

    wrong = float((one.state != one_peer).mean())
    low = workspace.indices(cube.lower_m[None] + spacing_m / 2)[0]
    block = tuple(slice(a, a + n) for a, n in zip(low, cube.shape, strict=True))
    cube_wrong = float((np.where(cube_peer == OUTSIDE, seen.state[block], cube_peer) != again.state[block]).mean())
    return [
        Timing(f"one view of 320 x 240, {name}", view_s, "numpy, all voxels", view_peer_s, wrong),
        Timing(f"10 cm cube again, {name}", cube_s, "numpy, cube alone", cube_peer_s, cube_wrong),
        Timing(f"{TAGS} kernels, {name}", radio_s, "numpy, block by block", radio_peer_s, differ(radio, radio_peer)),
        Timing(f"convolution, {name}", blur_s, "scipy fftconvolve", blur_peer_s, differ(blurred, blurred_peer)),
    ]  # fmt: skip


def box_timing(repeats: int, shape: tuple[int, int, int] = (100, 73, 27)) -> Timing:
    """Time all orientations of a box over a block of voxels, as the posterior map sums them."""
    values = np.random.default_rng(0).uniform(0.0, 12.0, shape)
    kernels = box_kernels(np.array([0.08, 0.05, 0.035]), 0.01, 4)
    ours_s, ours = best_of(repeats, lambda: np.stack(list(convolve_boxes(values, kernels))))
    shares = [kernel.values for kernel in kernels]
    peer_s, peer = best_of(2, lambda: np.stack([fftconvolve(values, share, mode="same") for share in shares]))
    name = f"{len(kernels)} boxes, {' x '.join(map(str, shape))} voxels"
    return Timing(name, ours_s, "scipy fftconvolve", peer_s, differ(ours, peer))


def run(fast: bool = False) -> list[Timing]:
    """Time both sizes of voxels."""
    sizes, repeats = (0.01,) if fast else (0.01, 0.005), 2 if fast else 7
    timings = [row for spacing_m in sizes for row in grid_timings(spacing_m, (240, 320), repeats)]
    timings.append(box_timing(repeats))
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1e6 if sys.platform == "darwin" else 1e3)
    print(f"largest memory of the process, with the peers: {peak_mb:.0f} MB", file=sys.stderr)
    return timings


def main(argv: list[str]) -> None:
    """Print the table."""
    show(run("--fast" in argv))


if __name__ == "__main__":
    main(sys.argv[1:])
