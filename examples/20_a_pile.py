"""Pour a pile of things on a table and look at it: what a depth camera on the wrist sees, and what it cannot see.

One red item is buried. You will see how the eight views of a scan compare with the truth, how far things creep when
nobody touches them, and what is left when the topmost item is taken away; and get `views.png` with colour and depth of
all eight views, `pile.html` to turn the pile in a browser (the target shines through), and `pile.json`, the scene file
that gives the same pile again. Needs MuJoCo (`pip install -c constraints.txt '.[piles]'`). Takes 15 s.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from rfcompass.simulation.piles import (
    PileCamera,
    PileFamily,
    PileScene,
    PileWorld,
    drawn_shapes,
    make_pile,
    open_pile,
    scan_poses,
    sights,
    tag_items,
    write_pile,
)
from rfcompass.types import DepthView
from rfcompass.viz.meshcat_page import write_scene
from rfcompass.viz.robot_scene import RobotScene

SMALL = PileFamily("small", "covered", (4,))


def scanned(world: PileWorld, rng: np.random.Generator) -> list[DepthView]:
    """Take the eight views of a scan."""
    camera, views = PileCamera(world, rng), []
    for T_world_camera in scan_poses():
        camera.move_to(T_world_camera)
        views.append(camera.view())
    return views


def topmost(world: PileWorld, besides: int) -> int:
    """Number of the item whose middle is highest, other than the target."""
    return max((item.number for item in world.items if item.number != besides), key=lambda n: world.pose(n)[2, 3])


def draw(views: list[DepthView]) -> Figure:
    """Draw colour over depth for each view."""
    figure = Figure(figsize=(14, 8), layout="constrained")
    axes = figure.subplots(4, 4)
    for index, view in enumerate(views):
        above, below = axes[2 * (index // 4) : 2 * (index // 4) + 2, index % 4]
        above.imshow(view.colour.astype(np.uint8))
        above.set_title(f"view {index + 1}", loc="left")
        below.imshow(view.depth_m, cmap="viridis_r", vmin=0.4, vmax=0.72)
        above.axis("off")
        below.axis("off")
    return figure


def page(scene: PileScene, world: PileWorld, path: Path) -> None:
    """Write the pile as a page, with the target shining through."""
    drawing = RobotScene()
    drawing.look_at(np.array([0.0, 0.0, 0.05]), np.array([0.25, -0.25, 0.3]))
    drawing.draw_shapes("pile", drawn_shapes(world, opacity=0.25, solid=(scene.target,)))
    write_scene(path, drawing.window, f"{scene.family}, seed {scene.seed}")


def main(fast: bool = False, out: Path = Path("runs/20_pile")) -> PileScene:
    """Pour, look, take one item; return the scene."""
    out.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(0)
    scene = make_pile(SMALL if fast else "poured_1p10", seed=3, target_class="hidden")
    world = scene.world()
    print(f"{len(scene.items)} items after {scene.tries} tries; the target is {world.item(scene.target).name}")

    views = scanned(world, rng)
    draw(views).savefig(out / "views.png", dpi=60 if fast else 110)
    sight = sights(world, [scene.target], scan_poses())[scene.target]
    lost = np.mean([np.isnan(view.depth_m).mean() for view in views])
    print(f"pixels of the target in each view: {sight.seen_px.tolist()}, of {sight.alone_px.tolist()} if it lay alone")
    print(f"depth is missing in {100 * lost:.1f} % of all pixels")
    moved_mm = 1e3 * np.array(list(world.creep_m().values()))
    print(
        f"left alone for two seconds, items move {np.median(moved_mm):.2f} mm (median), {moved_mm.max():.2f} mm (worst)"
    )

    tags = tag_items(scene, "any", 2, rng)
    for size in tags.sizes:
        print(f"tagged: {size.name}, {' x '.join(f'{100 * edge:.1f}' for edge in size.size_m)} cm, EPC {size.epc}")
    page(scene, world, out / "pile.html")
    write_pile(scene, out / "pile.json")
    print(f"pictures: {out / 'views.png'}, {out / 'pile.html'}; scene: {out / 'pile.json'}")

    taken = world.remove(topmost(world, scene.target))
    rest = world.settle()
    left = sights(world, [scene.target], scan_poses())[scene.target]
    print(f"{taken.name} taken; after {rest.passed_s:.2f} s {'all rests' if rest.at_rest else 'something creeps'}")
    print(f"pixels of the target now: {left.seen_px.tolist()}")
    return open_pile(out / "pile.json")


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
