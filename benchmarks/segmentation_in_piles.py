"""How well `DepthSegmenter` tells things in piles apart: the eight views of a scan beside true ids.

For each item of which at least 100 pixels of a view are seen: the overlap (intersection over union) of its pixels with
the object that fits it best; whether it is cut (two objects or more take 10 % of it each); and for each object whether
it is a blend (10 % of it each belong to two items or more).

    RFCOMPASS_PILE_SCENES=FOLDER python -m benchmarks.segmentation_in_piles [--scenes 10 --seed 1000]
"""

import argparse

import numpy as np

from benchmarks.segmentation_overlap import LEAST_PIXELS, overlaps
from rfcompass.arrays import IntArray
from rfcompass.mapping import DepthSegmenter
from rfcompass.simulation.piles import PileCamera, scan_poses
from rfcompass.studies.pile_scenes import FAMILIES, pile_scene

PART = 0.10  # share of pixels that counts


def shared(of: IntArray, among: IntArray) -> list[bool]:
    """Whether two labels of `among` or more take a part of each label of `of` that is large enough."""
    found = []
    for label in np.unique(of[of > 0]):
        own = among[of == label]
        if own.size >= LEAST_PIXELS:
            counts = np.bincount(own[own > 0], minlength=1)
            found.append(bool((counts >= PART * own.size).sum() > 1))
    return found


def main() -> None:
    """Print a line for each family."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--scenes", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1000, help="First seed; those below 1000 are for tuning.")
    asked = parser.parse_args()
    for family in FAMILIES:
        shares: list[float] = []
        cut: list[bool] = []
        blended: list[bool] = []
        for seed in range(asked.seed, asked.seed + asked.scenes):
            camera = PileCamera(pile_scene(family, seed).world(), np.random.default_rng(seed))
            for T_world_camera in scan_poses():
                camera.move_to(T_world_camera)
                view, truth = camera.view_and_masks()
                labels = DepthSegmenter().segment(view).labels
                shares += overlaps(labels, truth.labels)
                cut += shared(truth.labels, labels)
                blended += shared(labels, truth.labels)
        half, most = (np.mean(np.array(shares) >= share) for share in (0.5, 0.75))
        told = f"mean overlap {np.mean(shares):.2f}, at least 0.5: {half:.2f}, at least 0.75: {most:.2f}"
        print(f"{family}: {len(shares)} items in views, {told}, cut {np.mean(cut):.2f}, blends {np.mean(blended):.2f}")


if __name__ == "__main__":
    main()
