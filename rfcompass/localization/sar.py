"""Locate a tag with the matched filter of synthetic aperture radar [Boroushaki2023], section 4.2."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.localization.confidence_box import MAX_BOX_M, THRESHOLD, confidence_box, is_confident
from rfcompass.localization.reads_needed import require_reads
from rfcompass.rf.hologram import Hologram, Matching, build_hologram
from rfcompass.rf.peak_search import grid_points, highest_peak
from rfcompass.types.fixes import TagFix
from rfcompass.types.piles import VoxelGrid
from rfcompass.types.reads import ReadTrace
from rfcompass.types.volumes import SearchVolume

RESOLUTION_M = 0.001
KEPT_PEAKS = 8


@dataclass(frozen=True, kw_only=True)
class SarSurveyor:
    """Take the highest peak of the hologram as the tag's position [Boroushaki2023], Eq. 2.

    Attributes:
        matching: How the cells are combined, see `rfcompass.rf.hologram`.
        threshold: Share of the peak's power that bounds the confidence box.
        max_box_m: A fix is confident if its box is smaller than this along x, y, z [m] (the paper's τ) and not clipped.
    """

    method: ClassVar[str] = "sar"
    matching: Matching = field(default_factory=Matching)
    threshold: float = THRESHOLD
    max_box_m: tuple[float, float, float] = MAX_BOX_M

    def locate(self, trace: ReadTrace, volume: SearchVolume) -> TagFix:
        """Find the tag inside a volume; see `Surveyor.locate`."""
        require_reads(trace)
        hologram = build_hologram(trace, volume, self.matching)
        peak = highest_peak(hologram.power, volume, hologram.wavelength_m, keep=KEPT_PEAKS, resolution_m=RESOLUTION_M)
        box = confidence_box(hologram.power, volume, peak, self.threshold)
        return TagFix(
            epc=trace.epc,
            point_m=peak.point_m,
            box_m=box.extent_m,
            confident=is_confident(box, self.max_box_m),
            clipped=box.clipped,
            method=self.method,
        )


def sar_image(
    trace: ReadTrace, volume: SearchVolume, *, spacing_m: float = 0.01, matching: Matching | None = None
) -> VoxelGrid:
    """Compute the hologram of a tag on a full grid [Boroushaki2023], Eq. 1.

    Args:
        trace: Reads of one tag.
        volume: What to show, in the frame of the antenna path; an axis of zero extent gives one layer.
        spacing_m: Edge of a voxel [m]; the last voxel of an axis may fall short of the border.
        matching: How the cells are combined; default as in `SarSurveyor`.

    Raises:
        TooFewReads: If the tag was heard at too few antenna positions.
    """
    require_reads(trace)
    counts = np.floor((volume.upper_m - volume.lower_m) / spacing_m + 1e-9).astype(int) + 1
    x, y, z = (low + spacing_m * np.arange(n) for low, n in zip(volume.lower_m, counts, strict=True))
    hologram = build_hologram(trace, volume, matching or Matching())
    values = np.stack([_slab(hologram, plane, y, z) for plane in x])
    return VoxelGrid(volume.lower_m, spacing_m, values)


def _slab(hologram: Hologram, x_m: float, y_m: FloatArray, z_m: FloatArray) -> FloatArray:
    points_m = np.minimum(grid_points((np.array([x_m]), y_m, z_m)), hologram.volume.upper_m)
    return hologram.power(points_m).reshape(y_m.size, z_m.size)
