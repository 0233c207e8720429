"""Located tags as boxes to draw: each as large as its confidence box [Boroushaki2023], section 4.2."""

from collections.abc import Iterable

import numpy as np

from rfcompass.types.fixes import TagFix
from rfcompass.types.placed_shape import PlacedShape

_SURE, _UNSURE = (0.23, 0.43, 0.65, 0.35), (0.82, 0.29, 0.36, 0.35)
_LEAST_M = 0.002


def tag_boxes(fixes: Iterable[TagFix]) -> list[PlacedShape]:
    """A clear box about each fix, blue if it is confident, else red, and a small solid one at the fix itself."""
    shapes = []
    for fix in fixes:
        T, rgba = np.eye(4), np.array(_SURE if fix.confident else _UNSURE)
        T[:3, 3] = fix.point_m
        shapes.append(PlacedShape(f"box_{fix.epc}", "box", np.maximum(fix.box_m, _LEAST_M), T, rgba))
        shapes.append(PlacedShape(f"fix_{fix.epc}", "box", np.full(3, 0.012), T, np.array([*rgba[:3], 1.0])))
    return shapes
