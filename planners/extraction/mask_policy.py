"""What policies that judge whole objects have in common: the gate, the memory of failures, the action."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planners.extraction.candidates import Candidates, failed_place, find_candidates, pixels_of
from planners.extraction.projection import check_same_place
from planners.extraction.scores import TAU, gated_literally, passes
from planners.grasp_at_pixel import grasp_across, grasp_at_pixel
from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError
from rfcompass.mapping.camera import points_image
from rfcompass.types import DepthView, ExtractionAction, GraspMaps, InstanceMasks, VoxelGrid
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class Scene(Record):
    """All that a policy is told, and what can be grasped in it.

    Attributes:
        grid: Where the target may be.
        view: What the camera sees.
        masks: Objects in it.
        grasps: The best grasp at each pixel.
        points_m: Point of the world that each pixel shows [m], NaN where none, shape (H, W, 3).
        candidates: Objects that could be taken.
        failures: How many failed grasps since the last success the policy was told of.
    """

    grid: VoxelGrid
    view: DepthView
    masks: InstanceMasks
    grasps: GraspMaps
    points_m: FloatArray
    candidates: Candidates
    failures: int

    @property
    def table_m(self) -> float:
        """Height of the table, on which the map stands [m]."""
        return float(self.grid.origin_m[2]) - self.grid.spacing_m / 2


@dataclass(frozen=True, slots=True, kw_only=True)
class MaskPolicy(Record, ABC):
    """Gives each object a value and takes the one of most value among those that can be grasped.

    Of equal values, the better grasp is taken, then the object that the image shows first.

    Attributes:
        gate: Compare only objects with a grasp better than `tau`, as long as there is one.
        literal_gate: Multiply by the ceiling as printed instead (`scores`).
        tau: τ; ours.
        remembers: Believe less in grasps near those that have failed, and value their objects less; ours. The paper
            has no such memory: do not tell it of failures, or switch this off.
    """

    gate: bool = True
    literal_gate: bool = False
    tau: float = TAU
    remembers: bool = True

    def __post_init__(self) -> None:
        """Check τ."""
        if not 0 <= self.tau <= 1:
            raise InputError(f"{type(self).__name__}.tau: {self.tau} is not in [0, 1]", got=self.tau)

    @abstractmethod
    def values(self, scene: Scene) -> FloatArray:
        """Value of taking each candidate, shape (K,)."""

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
        values = self.judged(scene)
        quality = scene.candidates.quality
        best = int(np.lexsort((np.arange(len(values)), -quality, -values))[0])
        return take(scene, best, values)

    def judged(self, scene: Scene) -> FloatArray:
        """Value of each candidate after memory and gate; -inf for those that the gate bars, shape (K,)."""
        tried, values = scene.candidates.tried, self.values(scene)
        return self.gated(scene, np.where(values > 0, values * tried, values / tried))

    def gated(self, scene: Scene, values: FloatArray) -> FloatArray:
        """Values after the gate, shape (K,)."""
        quality = scene.candidates.quality
        if not self.gate:
            return values
        if self.literal_gate:
            return gated_literally(values, quality, self.tau)
        return np.where(passes(quality, self.tau), values, -np.inf)


def scene_of(
    grid: VoxelGrid,
    view: DepthView,
    masks: InstanceMasks,
    grasps: GraspMaps,
    failed_m: Sequence[FloatArray] = (),
    *,
    remembers: bool = True,
) -> Scene:
    """Find what can be grasped; arguments as for `find_candidates`; `remembers`: whether failures count.

    Raises:
        InputError: If the view shows nothing of what the map is of: the two are in different frames.
        NothingToGrasp: As `find_candidates` does.
        ShapeError: Likewise.
    """
    points_m, failed_m = points_image(view), [failed_place(point_m) for point_m in failed_m]
    candidates = find_candidates(view, masks, grasps, points_m, failed_m if remembers else ())
    check_same_place(grid, points_m)
    return Scene(grid, view, masks, grasps, points_m, candidates, len(failed_m))


def take(scene: Scene, chosen: int, values: FloatArray) -> ExtractionAction:
    """Take a candidate by its best grasp; across its middle where it has none, as the paper takes it regardless.

    Args:
        scene: What there is.
        chosen: Which candidate.
        values: Value of each, -inf for those that were not to be had, shape (K,).
    """
    candidates, view = scene.candidates, scene.view
    label, (row, column) = int(candidates.labels[chosen]), candidates.pixels[chosen]
    if candidates.quality[chosen] > 0:
        T_world_hand, aperture_m = grasp_at_pixel(view, scene.grasps, int(row), int(column))
    else:
        T_world_hand, aperture_m = grasp_across(view, pixels_of(scene.masks, label), scene.table_m)
    scores = {int(key): float(value) for key, value in zip(candidates.labels, values, strict=True) if value > -np.inf}
    return ExtractionAction(label, T_world_hand, aperture_m, float(values[chosen]), scores)
