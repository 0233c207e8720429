"""How well `DepthSegmenter` tells boxes apart: heaps of level boxes, seen by a ray caster, with a camera's noise.

For each box of which at least 100 pixels are seen: the overlap (intersection over union) of its pixels with the object
that fits it best. Boxes lie level, so this is easier than a pile of bags and toys; no number here says how well
SD Mask R-CNN of the paper would do.

    python -m benchmarks.segmentation_overlap [--scenes 40 --seed 2000]
"""

import argparse
from dataclasses import replace

import numpy as np

from rfcompass.mapping import DepthSegmenter
from tests.box_scenes import Block, looking_down, see

BOXES, LEAST_PIXELS = 10, 100


def heap(rng: np.random.Generator) -> list[Block]:
    """Level boxes, each on the highest of those that it may touch."""
    blocks: list[Block] = []
    for _ in range(BOXES):
        size = rng.uniform([0.06, 0.06, 0.02], [0.16, 0.14, 0.10])
        x, y = rng.uniform([-0.2, -0.15], [0.2, 0.15])
        reach = np.hypot(size[0], size[1]) / 2
        under = [
            block.centre_m[2] + block.size_m[2] / 2
            for block in blocks
            if np.hypot(x - block.centre_m[0], y - block.centre_m[1]) < reach + np.hypot(*block.size_m[:2]) / 2
        ]
        blocks.append(Block((x, y, max(under, default=0.0) + size[2] / 2), tuple(size), rng.uniform(0.0, np.pi)))
    return blocks


def overlaps(labels: np.ndarray, truth: np.ndarray) -> list[float]:
    """Best overlap of each box that is seen well enough."""
    found = []
    for box in np.unique(truth[truth > 0]):
        own = truth == box
        if own.sum() >= LEAST_PIXELS:
            rivals = [labels == label for label in np.unique(labels[own]) if label]
            found.append(max(((own & other).sum() / (own | other).sum() for other in rivals), default=0.0))
    return found


def main() -> None:
    """Print a line for each noise of the camera."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--seed", type=int, default=2000, help="First seed; those below 1000 are for tuning.")
    asked = parser.parse_args()
    for noise_m in (0.0, 0.0015, 0.003):
        shares: list[float] = []
        for seed in range(asked.seed, asked.seed + asked.scenes):
            rng = np.random.default_rng(seed)
            view, truth = see(heap(rng), looking_down(0, 0, 0.8, rng.uniform(-0.25, 0.25)), shape=(240, 320))
            seen = replace(view, depth_m=view.depth_m + noise_m * rng.normal(size=view.depth_m.shape))
            shares += overlaps(DepthSegmenter().segment(seen).labels, truth)
        half, most = (np.mean(np.array(shares) >= share) for share in (0.5, 0.75))
        told = f"mean overlap {np.mean(shares):.2f}, at least 0.5: {half:.2f}, at least 0.75: {most:.2f}"
        print(f"noise {1000 * noise_m:.1f} mm: {len(shares)} boxes, {told}")


if __name__ == "__main__":
    main()
