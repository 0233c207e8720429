"""The naive policy of Table 3 [Boroushaki2023], section 8.2.3: it knows no objects."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planners.extraction.candidates import tried_before
from planners.extraction.clusters import highest_voxel_m
from planners.extraction.mask_policy import Scene, scene_of, take
from planners.extraction.scores import TAU
from planners.grasp_at_pixel import grasp_at_pixel
from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError
from rfcompass.types import DepthView, ExtractionAction, GraspMaps, InstanceMasks, VoxelGrid
from rfcompass.types.record import Record

REACH_M = 0.05  # [Boroushaki2023], section 8.2.3


@dataclass(frozen=True, slots=True, kw_only=True)
class NaivePolicy(Record):
    """Selects the voxel of highest probability and performs the best grasp within 5 cm of its projection on the pile.

    The distance is taken in the plane; masks only say what is no table. Where no grasp so near is any good, the paper
    says nothing. Ours: the nearest one that is; where there is none at all, across the nearest object. Any good is
    a quality above 0; with the gate, above τ as long as there is such a one.

    Attributes:
        gate: Whether to ask for τ; the paper's naive policy does not.
        tau: τ.
        remembers: Believe less in grasps near those that have failed; ours.
        reach_m: How far the grasp may be from the projection [m].
    """

    gate: bool = False
    tau: float = TAU
    remembers: bool = True
    reach_m: float = REACH_M

    def __post_init__(self) -> None:
        """Check the ranges."""
        if not (0 <= self.tau <= 1 and self.reach_m > 0):
            raise InputError(f"{self}: out of range", got=[self.tau, self.reach_m])

    def choose(
        self,
        grid: VoxelGrid,
        view: DepthView,
        masks: InstanceMasks,
        grasps: GraspMaps,
        failed_m: Sequence[FloatArray] = (),
    ) -> ExtractionAction:
        """Choose one removal; see `rfcompass.interfaces.ExtractionPolicy`."""
        scene = scene_of(grid, view, masks, grasps, failed_m, remembers=self.remembers)
        failed_m = failed_m if self.remembers else ()
        off_m = _distance_to_peak_m(scene)
        quality = np.where(np.isfinite(off_m), grasps.quality * tried_before(scene.points_m, masks, failed_m), 0.0)
        least = self.tau if self.gate and (quality > self.tau).any() else 0.0
        good = quality > least
        if not good.any():
            nearest = masks.labels.ravel()[off_m.argmin()]
            labels = scene.candidates.labels
            return take(scene, int(np.flatnonzero(labels == nearest)[0]), np.zeros(len(labels)))
        near = good & (off_m <= self.reach_m)
        best = np.where(near, quality, -1.0).argmax() if near.any() else np.where(good, off_m, np.inf).argmin()
        row, column = (int(i) for i in np.unravel_index(int(best), quality.shape))
        T_world_hand, aperture_m = grasp_at_pixel(view, grasps, row, column)
        return ExtractionAction(int(masks.labels[row, column]), T_world_hand, aperture_m, float(quality[row, column]))


def _distance_to_peak_m(scene: Scene) -> FloatArray:
    """Level distance of each pixel of an object to the map's highest voxel, infinite elsewhere, shape (H, W)."""
    at_m = highest_voxel_m(scene.grid)
    off_m = np.hypot(scene.points_m[..., 0] - at_m[0], scene.points_m[..., 1] - at_m[1])
    return np.where((scene.masks.labels > 0) & np.isfinite(off_m), off_m, np.inf)
