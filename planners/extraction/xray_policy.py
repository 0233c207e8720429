"""X-Ray as the baseline [Boroushaki2023], section 7.2: the object with the most 2-D probability within its mask."""

from dataclasses import dataclass

import numpy as np

from planners.extraction.mask_policy import MaskPolicy, Scene
from planners.extraction.projection import project_masks
from planners.extraction.scores import columns_by_label
from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import ShapeError
from rfcompass.mapping.xray import xray_occupancy
from rfcompass.types import DepthView

# Ours: the distribution is smooth; a quarter of the pixels of a camera of 320 x 180 tells it as well, in a quarter of
# the time.
_EVERY = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class XRayPolicy(MaskPolicy):
    """Sums X-Ray's distribution for the one image over each mask; it never looks at the map.

    Attributes:
        gate: The paper's X-Ray has none.
        target_m: Edges of the target [m], shape (3,).
    """

    gate: bool = False
    target_m: FloatArray

    def __post_init__(self) -> None:
        """Freeze the edges; they are lengths."""
        MaskPolicy.__post_init__(self)
        target_m = read_only(self.target_m, "XRayPolicy.target_m", (3,))
        object.__setattr__(self, "target_m", target_m)
        if not (target_m > 0).all():
            raise ShapeError(f"XRayPolicy.target_m: {target_m.tolist()} m are no lengths", name="target_m")

    def values(self, scene: Scene) -> FloatArray:
        """Share of the distribution within each candidate's mask, shape (K,)."""
        coarse = scene.masks.labels[::_EVERY, ::_EVERY]
        image = xray_occupancy(every_pixel(scene.view, _EVERY), self.target_m, scene.table_m)
        return np.array([image[coarse == label].sum() for label in scene.candidates.labels])


def every_pixel(view: DepthView, step: int) -> DepthView:
    """The image of a camera that has only every so manieth row and column of another's pixels."""
    K = np.array(view.intrinsics)
    K[:2] /= step
    colour = None if view.colour is None else view.colour[::step, ::step]
    return DepthView(view.depth_m[::step, ::step], K, view.T_world_camera, colour)


@dataclass(frozen=True, slots=True, kw_only=True)
class MapMassPolicy(MaskPolicy):
    """Sums the map over the columns under each mask, however deep; with `xray_map` as the map, X-Ray of many views.

    Attributes:
        gate: As for `XRayPolicy`.
    """

    gate: bool = False

    def values(self, scene: Scene) -> FloatArray:
        """Mass of the map under each candidate, shape (K,)."""
        labels = scene.candidates.labels
        columns = project_masks(scene.grid, scene.view, scene.masks, scene.points_m)
        owned, group = columns_by_label(columns, labels)
        masses = np.bincount(group, scene.grid.values[owned].sum(axis=1), len(labels))
        return np.asarray(masses, dtype=np.float64)
