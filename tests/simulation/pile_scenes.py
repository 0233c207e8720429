"""Small piles for tests: things stood on a table by hand, and tiny families that are made in a second."""

import colorsys
from functools import cache

import numpy as np
import pytest

from rfcompass.simulation.piles import PileFamily, PileItem, PileWorld, flat_state, make_pile

pytest.importorskip("mujoco", reason="the extra `piles` is not installed")

TINY = PileFamily("tiny", "covered", (4,))
TINY_POURED = PileFamily("tiny_poured", "poured", (5, 4))
RED, BLUE = (200, 25, 25), (58, 110, 165)


def item(number, kind="box", size_m=(0.08, 0.05, 0.04), material="card", rgb=BLUE):
    return PileItem(number, kind, np.array(size_m), material, rgb)


def at(x_m, y_m, z_m):
    T = np.eye(4)
    T[:3, 3] = x_m, y_m, z_m
    return T


def world_of(*placed):
    """A world of (item, pose) pairs, covers spread out."""
    return PileWorld([thing for thing, _ in placed], {thing.number: flat_state(thing, T) for thing, T in placed})


def one_of_each():
    """A box, a cylinder, a capsule, an ellipsoid and a cover beside each other, each 1 mm above the table."""
    sizes = {
        "box": (0.08, 0.05, 0.04),
        "cylinder": (0.05, 0.05, 0.09),
        "capsule": (0.04, 0.04, 0.1),
        "ellipsoid": (0.08, 0.06, 0.05),
        "cover": (0.2, 0.14, 0.01),
    }
    things = [item(n, kind, size_m) for n, (kind, size_m) in enumerate(sizes.items(), start=1)]
    return world_of(*((thing, at(0.2 * n - 0.5, 0.0, thing.size_m[2] / 2 + 1e-3)) for n, thing in enumerate(things)))


@cache
def tiny(target_class="hidden", seed=1):
    return make_pile(TINY, seed, target_class)


@cache
def tiny_poured():
    return make_pile(TINY_POURED, 1, "partly")


def inside(thing, points_m):
    """Whether points of the item frame are inside an item, by its equation; negative inside, (N, 3) to (N,)."""
    half = thing.panel_size_m / 2
    if thing.kind in ("box", "cover", "cushion"):
        return (np.abs(points_m) - half).max(axis=1)
    if thing.kind == "ellipsoid":
        return np.linalg.norm(points_m / half, axis=1) - 1
    along = np.abs(points_m[:, 2])
    across = np.linalg.norm(points_m[:, :2], axis=1)
    if thing.kind == "cylinder":
        return np.maximum(across - half[0], along - half[2])
    beyond = np.maximum(along - (half[2] - half[0]), 0)
    return np.hypot(across, beyond) - half[0]


def is_red(rgb):
    """The paper's rule for a target, as its baseline's code applies it: hue, saturation and value of OpenCV."""
    hue, saturation, value = colorsys.rgb_to_hsv(*(v / 255 for v in rgb))
    return (hue * 180 <= 10 or hue * 180 >= 170) and saturation * 255 >= 120 and value * 255 >= 70


def lowest_m(world, thing):
    """Height of the lowest point of an item's true shape, by its support function."""
    half, heights = thing.panel_size_m / 2, []
    for T in world.panel_poses(thing.number):
        x, y, z = np.abs(T[2, :3])
        reach = {
            "cylinder": half[0] * np.hypot(x, y) + half[2] * z,
            "capsule": half[0] + (half[2] - half[0]) * z,
            "ellipsoid": np.linalg.norm(half * [x, y, z]),
        }.get(thing.kind, half @ [x, y, z])
        heights.append(T[2, 3] - reach)
    return min(heights)
