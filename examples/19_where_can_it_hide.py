"""Where can it hide? FuseBot's four maps of two piles, from depth images and from tags on items that it does not seek.

Two piles of boxes stand on a table, made up here and seen by a ray caster of a few lines. A red target lies hidden in
the right pile. Cameras on a square look down; three items carry tags, one of them soft, one not located well enough.
The tags' places have errors of the size that the paper reports (3.6 cm in the median).

You will see how much space no camera looked into, what the tags take away, where the target most likely is, and how
many of the places that are left are likelier than the true one; and get `maps.png` (as the paper's Fig. 3),
`kernels.png` (Fig. 6), `maps.html` and `occupancy.ply`. Takes 5 s.
"""

import sys
from pathlib import Path

import numpy as np

from rfcompass.mapping import (
    RfKernels,
    box_target,
    find_visible_target,
    fuse_maps,
    gaussian_target,
    map_views,
    occupancy_map,
    rf_certainty_map,
)
from rfcompass.types import DepthView, LocatedItem, TagFix, VoxelGrid, Workspace
from rfcompass.viz.meshcat_page import write_scene
from rfcompass.viz.overlay import Overlay
from rfcompass.viz.robot_scene import RobotScene
from rfcompass.viz.voxel_figures import draw_kernels, draw_maps
from rfcompass.viz.voxel_layers import draw_voxels
from rfcompass.viz.voxel_ply import write_ply

GREY, RED = (130, 130, 130), (210, 20, 30)
TARGET_M, TARGET_SIZE_M = np.array([0.24, -0.02, 0.03]), np.array([0.10, 0.08, 0.06])
# Lowest and highest corner of every box [m], and its colour; the target last.
BOXES = [
    ([-0.36, -0.14, 0.00], [-0.12, 0.10, 0.09], GREY),
    ([-0.32, -0.08, 0.09], [-0.18, 0.06, 0.13], GREY),
    ([0.12, -0.16, 0.08], [0.38, 0.12, 0.11], GREY),
    ([0.12, 0.04, 0.00], [0.36, 0.12, 0.08], GREY),
    ([0.12, -0.16, 0.00], [0.18, 0.04, 0.08], GREY),
    (list(TARGET_M - TARGET_SIZE_M / 2), list(TARGET_M + TARGET_SIZE_M / 2), RED),
]
# Tagged items: name, true place of the tag, shortest and longest edge [m], soft, located confidently.
TAGGED = [
    ("toy", [-0.28, -0.02, 0.05], 0.10, 0.16, False, True),
    ("glove", [-0.17, 0.03, 0.04], 0.08, 0.18, True, True),
    ("mug", [0.15, -0.10, 0.04], 0.08, 0.10, False, False),
]
SIGMA_M = 0.0234  # of a tag's place along each axis: 3.6 cm in the median of the distance


def look_down(x_m: float, y_m: float, height_m: float, pixels: tuple[int, int]) -> DepthView:
    """What a camera sees that looks straight down: the nearest box along each ray, else the table."""
    T = np.diag([1.0, -1.0, -1.0, 1.0])
    T[:3, 3] = x_m, y_m, height_m
    focal = 0.8 * pixels[1]
    K = np.array([[focal, 0, (pixels[1] - 1) / 2], [0, focal, (pixels[0] - 1) / 2], [0, 0, 1]])
    v, u = np.indices(pixels)
    rays = np.stack([u, v, np.ones(pixels)], axis=-1) @ np.linalg.inv(K).T @ T[:3, :3].T
    depth, colour = -height_m / rays[..., 2], np.full((*pixels, 3), 200)
    for low_m, high_m, paint in BOXES:
        with np.errstate(divide="ignore", invalid="ignore"):
            a, b = (low_m - T[:3, 3]) / rays, (high_m - T[:3, 3]) / rays
        enter, leave = np.fmin(a, b).max(axis=-1), np.fmax(a, b).min(axis=-1)
        hit = (enter <= leave) & (enter < depth)
        depth[hit], colour[hit] = enter[hit], paint
    return DepthView(depth, K, T, colour)


def locate(rng: np.random.Generator) -> list[LocatedItem]:
    """Stand in for the survey from the wrist (example 08): true places with an error."""
    items = []
    for name, point_m, d_s, d_l, soft, sure in TAGGED:
        fix = TagFix(f"tag of the {name}", point_m + SIGMA_M * rng.normal(size=3), np.full(3, 0.06), sure)
        items.append(LocatedItem(fix, name, d_s, d_l, soft))
    return items


def tell_place(title: str, grid: VoxelGrid, workspace: Workspace) -> float:
    """Print the likeliest place, and how much of the map is likelier than the true one."""
    best = np.unravel_index(grid.values.argmax(), grid.values.shape)
    off_cm = 100 * np.linalg.norm(grid.origin_m + grid.spacing_m * np.array(best) - TARGET_M)
    truth = grid.values[tuple(workspace.indices(TARGET_M[None])[0])]
    likely = grid.values > 0.05 * grid.values.max()
    ahead = float((grid.values[likely] > truth).mean())
    print(f"  {title:<34} peak {off_cm:4.1f} cm off, {100 * ahead:3.0f} % of {likely.sum()} voxels are likelier")
    return ahead


def main(fast: bool = False, out: Path = Path("runs/19_hide")) -> float:
    """Map, fuse, draw; return the share of the map that is likelier than the true place."""
    workspace = Workspace.between([-0.5, -0.4, 0.0], [0.5, 0.4, 0.3], 0.02 if fast else 0.01)
    pixels, steps = ((120, 160) if fast else (240, 320)), (-0.22, 0.0, 0.22)
    views = [look_down(x, y, 0.7, pixels) for x in steps for y in steps if (x, y) != (0.0, 0.0)]
    print(f"target in sight: {any(find_visible_target(view) is not None for view in views)}")

    seen = map_views(workspace, views)
    print(f"{1000 * seen.unobserved_m3:.1f} litres that no camera looked into")
    items = locate(np.random.default_rng(0))
    radio = rf_certainty_map(items, workspace, heights_m=seen.heights_m())
    for epc, reason in radio.left_out.items():
        print(f"{epc} left out: {reason}")
    for epc, alpha in radio.alphas.items():
        print(f"{epc} counts, pressed to {100 * alpha:.0f} % of its height")

    visual, fused = seen.uncertainty(), fuse_maps(seen.uncertainty(), radio.grid)
    gaussian = gaussian_target(TARGET_SIZE_M.min(), TARGET_SIZE_M.max(), workspace.spacing_m)
    print("where the target can be")
    tell_place("cameras alone", occupancy_map(visual, gaussian), workspace)
    occupancy = occupancy_map(fused, gaussian)
    ahead = tell_place("with tags", occupancy, workspace)
    boxed = occupancy_map(fused, box_target(TARGET_SIZE_M, workspace.spacing_m))
    tell_place("with tags, the target's own shape", boxed, workspace)

    out.mkdir(parents=True, exist_ok=True)
    maps = {"C: not observed": visual, "R: tagged items": radio.grid, "C + R": fused, "occupancy": occupancy}
    marks = {item.item: item.point_m for item in items} | {"target": TARGET_M}
    draw_maps(maps, marks, y_m=TARGET_M[1]).savefig(out / "maps.png", dpi=70 if fast else 130)
    glove = items[1]
    soft = {"taken for rigid": RfKernels().kernel(glove, 1.0), "pressed": RfKernels().kernel(glove, 0.4)}
    drawn = {title: kernel.sampled(0.18, 0.005) for title, kernel in soft.items()}
    draw_kernels(drawn, np.zeros(3), np.array([0.18, 0.04])).savefig(out / "kernels.png", dpi=70 if fast else 130)
    scene = RobotScene()
    scene.look_at(np.array([0.0, 0.0, 0.05]), np.array([0.3, -0.9, 0.7]))
    layers = [
        draw_voxels(scene, f"map_{n}", name, grid, share=0.5, shown=n == 3)
        for n, (name, grid) in enumerate(maps.items())
    ]
    write_scene(out / "maps.html", scene.window, "Where can it hide?", Overlay("Where can it hide?", (), tuple(layers)))
    write_ply(out / "occupancy.ply", occupancy, share=0.2)
    for name in ("maps.png", "kernels.png", "maps.html"):
        print(f"picture: {out / name}")
    return ahead


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
