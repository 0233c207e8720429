"""Draws items: sizes, materials and colours of each kind; all ranges are ours."""

import numpy as np

from rfcompass.simulation.piles.items import PileItem

# Smallest and largest edge of what a hand of 85 mm can mostly take [m].
_BOX_M, _ELLIPSOID_M = (0.03, 0.11), (0.04, 0.09)
_CYLINDER_M, _CYLINDER_LENGTH_M = (0.036, 0.07), (0.05, 0.12)
_CAPSULE_M, _CAPSULE_STRAIGHT_M = (0.036, 0.06), (0.03, 0.08)
_COVER_LENGTH_M, _COVER_WIDTH_M, _COVER_THICKNESS_M = (0.15, 0.24), (0.11, 0.18), (0.008, 0.012)
_CUSHION_M = ((0.09, 0.14), (0.06, 0.078), (0.04, 0.055))
# What each kind is made of, with its share.
_MATERIALS = {
    "box": (("card", 0.6), ("plastic", 0.3), ("metal", 0.1)),
    "cylinder": (("plastic", 0.45), ("card", 0.15), ("liquid", 0.2), ("metal", 0.2)),
    "capsule": (("plastic", 0.7), ("liquid", 0.3)),
    "ellipsoid": (("foam", 0.5), ("cloth", 0.5)),
    "cover": (("cloth", 1.0),),
    "cushion": (("cloth", 0.7), ("foam", 0.3)),
}
RIGID_KINDS = ("box", "cylinder", "capsule", "ellipsoid")
# Nothing but the target is red; a search may know it by that.
TARGET_RGB = (200, 25, 25)
_COLOURS = (
    (58, 110, 165), (90, 158, 111), (229, 193, 77), (140, 98, 160), (120, 120, 120),
    (205, 205, 196), (66, 66, 74), (110, 84, 62), (70, 170, 180), (165, 190, 90),
)  # fmt: skip


def draw_item(number: int, kind: str, rng: np.random.Generator) -> PileItem:
    """Draw an item of a kind.

    Args:
        number: Its number.
        kind: One of `items.KINDS`.
        rng: Source of size, material and colour.
    """
    stuffs = _MATERIALS.get(kind, (("plastic", 1.0),))
    material = str(rng.choice([name for name, _ in stuffs], p=[share for _, share in stuffs]))
    rgb = _COLOURS[int(rng.integers(len(_COLOURS)))]
    return PileItem(number, kind, _draw_size(kind, rng), material, rgb)


def draw_target(number: int, rng: np.random.Generator) -> PileItem:
    """Draw a target: a red box, cylinder or ellipsoid, 5 to 9 cm long, of plastic, card or foam."""
    kind = str(rng.choice(["box", "cylinder", "ellipsoid"]))
    longest, middle = rng.uniform(0.05, 0.09), rng.uniform(0.035, 0.05)
    size_m = {
        "box": [longest, middle, rng.uniform(0.03, 0.04)],
        "cylinder": [middle, middle, longest],
        "ellipsoid": [longest, middle, middle],
    }[kind]
    material = {"box": "card", "cylinder": "plastic", "ellipsoid": "foam"}[kind]
    return PileItem(number, kind, np.array(size_m), material, TARGET_RGB)


def draw_distractor(number: int, cover_share: float, rng: np.random.Generator, cushion_share: float = 0.0) -> PileItem:
    """Draw a cover or a cushion with their probabilities, otherwise one of the rigid kinds."""
    drawn = rng.random()
    if drawn < cover_share:
        kind = "cover"
    elif drawn < cover_share + cushion_share:
        kind = "cushion"
    else:
        kind = str(rng.choice(RIGID_KINDS))
    return draw_item(number, kind, rng)


def _draw_size(kind: str, rng: np.random.Generator) -> np.ndarray:
    if kind == "box":
        return np.sort(rng.uniform(*_BOX_M, 3))[::-1]
    if kind == "ellipsoid":
        return np.sort(rng.uniform(*_ELLIPSOID_M, 3))[::-1]
    if kind == "cylinder":
        across = rng.uniform(*_CYLINDER_M)
        return np.array([across, across, rng.uniform(*_CYLINDER_LENGTH_M)])
    if kind == "capsule":
        across = rng.uniform(*_CAPSULE_M)
        return np.array([across, across, across + rng.uniform(*_CAPSULE_STRAIGHT_M)])
    if kind == "cushion":
        return np.array([rng.uniform(*limits) for limits in _CUSHION_M])
    return np.array([rng.uniform(*limits) for limits in (_COVER_LENGTH_M, _COVER_WIDTH_M, _COVER_THICKNESS_M)])
