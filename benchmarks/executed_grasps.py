"""Whether grasps with a high quality hold: executed grasps in states of piles, several removals deep.

In each state the camera looks from 0.55 m at one pile. The best grasp on each of up to four things in sight is executed
in a copy of the pile, and as many at pixels drawn at random among those that have any grasp. Then one of the things
that were held is taken away for good, and the next state begins.

    RFCOMPASS_PILE_SCENES=FOLDER python -m benchmarks.executed_grasps --seeds 1000 1009 --out rows.npz
    python -m benchmarks.grasp_success rows.npz
"""

import argparse
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from planners.grasp_at_pixel import grasp_at_pixel
from planners.grasp_quality import AntipodalQuality
from planners.grasp_success import success_of
from rfcompass.arrays import FloatArray, IntArray
from rfcompass.errors import PileUnsettled
from rfcompass.simulation.piles import PileCamera, PileScene, PileWorld, grasp_item, look_down
from rfcompass.studies.pile_scenes import FAMILIES, pile_scene
from rfcompass.types import DepthView, GraspMaps
from rfcompass.types.search import HELD

STATES, MOST, LEAST_PIXELS, HEIGHT_M = 5, 4, 30, 0.55


class _Copy(PileWorld):
    """A pile that nobody looks at after the grasp."""

    def become(self, states: object, without: object = ()) -> None:
        """Stay as it was."""

    def settle(self, longest_s: float = 6.0) -> None:  # type: ignore[override]
        """Save the time."""


def rows_of(scene: PileScene, quality: AntipodalQuality, rng: np.random.Generator) -> Iterator[dict[str, object]]:
    """Execute grasps in the states of one scene; one row for each."""
    world = scene.world()
    camera = PileCamera(world, rng)
    for state in range(STATES):
        if len(world.items) < 2:
            return
        x_m, y_m, _ = world.pose(int(rng.choice([item.number for item in world.items])))[:3, 3]
        camera.move_to(look_down(x_m, y_m, HEIGHT_M))
        view, masks = camera.view_and_masks()
        seen = quality.evidence(view)
        maps = GraspMaps(success_of(seen.log_odds, seen.kind), seen.angle_rad, seen.width_m, seen.depth_m)
        kinds = {item.number: item.kind for item in world.items}
        held: list[int] = []
        for way, pixel in chosen(seen.log_odds, seen.kind, masks.labels, rng):
            row, column = pixel
            label = int(masks.labels[row, column])
            done = execute(_Copy(world.items, world.states, world.physics), view, maps, pixel)
            if done is None:
                continue
            if way == "best" and label in done[1]:
                held.append(label)
            yield {
                "state": state, "way": way, "kind": int(seen.kind[pixel]), "numbers": seen.numbers[pixel],
                "log_odds": float(seen.log_odds[pixel]), "label": label, "item": kinds.get(label, "table"),
                "outcome": done[0], "own": label in done[1], "force": done[2], "cpu_s": done[3],
                "depth": float(maps.depth_m[pixel]), "width": float(maps.width_m[pixel]),
            }  # fmt: skip
        go_on(world, held, rng)


def chosen(
    log_odds: FloatArray, kind: IntArray, labels: IntArray, rng: np.random.Generator
) -> list[tuple[str, tuple[int, int]]]:
    """Pixels to grasp at: the best of up to four things in sight, and as many at random."""
    numbers, counts = np.unique(labels[labels > 0], return_counts=True)
    there = [n for n in numbers[counts >= LEAST_PIXELS] if (kind[labels == n] > 0).any()]
    picked: list[tuple[str, tuple[int, int]]] = []
    for number in rng.permutation(there)[:MOST]:
        scores = np.where(labels == number, log_odds, -np.inf)
        picked.append(("best", divmod(int(np.argmax(scores)), labels.shape[1])))
    any_grasp = np.argwhere((kind > 0) & (labels > 0))
    drawn = rng.permutation(len(any_grasp))[: len(picked)]
    return picked + [("random", (int(row), int(column))) for row, column in any_grasp[drawn]]


def execute(
    world: PileWorld, view: DepthView, maps: GraspMaps, pixel: tuple[int, int]
) -> tuple[str, tuple[int, ...], float, float] | None:
    """Outcome, what was taken, force [N] and CPU time [s]; None if the simulation blew up."""
    T_world_hand, aperture_m = grasp_at_pixel(view, maps, *pixel)
    start = time.process_time()
    try:
        done = grasp_item(world, T_world_hand, aperture_m)
    except PileUnsettled:
        return None
    return done.outcome, done.taken, done.force_n, time.process_time() - start


def go_on(world: PileWorld, held: list[int], rng: np.random.Generator) -> None:
    """Take away something whose best grasp held, or anything."""
    try:
        world.remove(int(rng.choice(held or [item.number for item in world.items])))
        world.settle()
    except PileUnsettled:
        return


def gather(seeds: range, out: Path) -> None:
    """Execute grasps on all families and write the rows."""
    quality, rows = AntipodalQuality(), []
    for seed in seeds:
        for family in FAMILIES:
            start = time.process_time()
            scene = pile_scene(family, seed)
            made_s = time.process_time() - start
            rng = np.random.default_rng([seed, FAMILIES.index(family)])
            new = [{"family": family, "seed": seed, **row} for row in rows_of(scene, quality, rng)]
            rows += new
            np.savez(out, rows=np.array(rows, dtype=object))
            held = np.mean([row["outcome"] == HELD for row in new])
            took_s = time.process_time() - start
            print(
                f"{family} {seed}: {len(new)} grasps, {held:.2f} held, {made_s:.1f} + {took_s - made_s:.1f} s",
                flush=True,
            )


def main() -> None:
    """Gather rows."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", type=int, nargs=2, default=(1000, 1001))
    parser.add_argument("--out", type=Path, default=Path("executed_grasps.npz"))
    asked = parser.parse_args()
    gather(range(*asked.seeds), asked.out)


if __name__ == "__main__":
    main()
