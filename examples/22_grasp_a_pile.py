"""Where can a hand close on a pile, and does it hold? Rate grasps in a depth image, and execute the best one.

You will see one picture: what the camera sees; how likely the best grasp at each pixel holds; and the pile after the
hand has gone down, closed and lifted at the pixel that promises most, three times. Needs MuJoCo
(`pip install -c constraints.txt '.[piles]'`). Takes 20 s, and half a minute more when it compiles for the first time.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from planners import AntipodalQuality
from planners.grasp_at_pixel import grasp_at_pixel
from rfcompass.simulation.piles import ExecutedGrasp, PileCamera, PileFamily, grasp_item, look_down, make_pile
from rfcompass.types import DepthView
from rfcompass.viz.grasp_maps import draw_grasps

SMALL = PileFamily("small", "covered", (4,))


def draw_colours(axis: Axes, view: DepthView, title: str) -> None:
    """Draw what the camera sees."""
    axis.imshow(view.colour.astype(np.uint8))
    axis.set_title(title, loc="left")
    axis.axis("off")


def main(fast: bool = False, out: Path = Path("runs/22_grasp")) -> list[ExecutedGrasp]:
    """Look, rate, grasp; return what came of it."""
    out.mkdir(parents=True, exist_ok=True)
    scene = make_pile(SMALL if fast else "poured_1p10", seed=3, target_class="hidden")
    names = {item.number: item.name for item in scene.items}
    world, quality, done = scene.world(), AntipodalQuality(), []
    camera = PileCamera(world, np.random.default_rng(0))
    camera.move_to(look_down(0.0, 0.0, 0.55))

    tries = 1 if fast else 3
    figure = Figure(figsize=(11, 3.2 * tries), layout="constrained")
    axes = figure.subplots(tries, 2, squeeze=False)
    for left, right in axes:
        view = camera.view()
        maps = quality.quality(view)
        row, column = np.unravel_index(np.argmax(maps.quality), maps.quality.shape)
        draw_grasps(right, view, maps, [(int(row), int(column))])
        right.set_title(f"best: {maps.quality[row, column]:.2f}", loc="left")
        T_world_hand, aperture_m = grasp_at_pixel(view, maps, int(row), int(column))
        grasp = grasp_item(world, T_world_hand, aperture_m)
        draw_colours(left, view, f"{len(world.items) + len(grasp.taken)} things; then {grasp.outcome}")
        taken = ", ".join(names[number] for number in grasp.taken) or "nothing"
        print(
            f"chance {maps.quality[row, column]:.2f}, jaws {100 * aperture_m:.1f} cm apart: {grasp.outcome}, "
            f"{taken} taken; at most {grasp.force_n:.0f} N on the way down"
        )
        done.append(grasp)
    figure.savefig(out / "grasps.png", dpi=60 if fast else 110)
    print(f"picture: {out / 'grasps.png'}")
    return done


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
