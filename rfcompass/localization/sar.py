"""Locate a tag with the matched filter of synthetic aperture radar [Boroushaki2023], section 4.2."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.localization.confidence_box import MAX_BOX_M, THRESHOLD, ConfidenceBox, confidence_box, is_confident
from rfcompass.localization.reads_needed import require_reads
from rfcompass.rf.hologram import Hologram, Matching, build_hologram
from rfcompass.rf.peak_search import Peak, grid_points, highest_peak
from rfcompass.types.fixes import TagFix
from rfcompass.types.piles import VoxelGrid
from rfcompass.types.reads import ReadTrace
from rfcompass.types.volumes import SearchVolume

RESOLUTION_M = 0.001
KEPT_PEAKS = 8
# Ours, for a wrist half a metre above a table. Height is the weak axis of a level path, hence the larger threshold; the
# box is measured 20 cm beyond the search volume, since boxes of tags on the table reach through it.
WRIST_MAX_BOX_M = (0.10, 0.10, 0.25)
WRIST_BOX_MARGIN_M = 0.20


@dataclass(frozen=True, kw_only=True)
class SarSurveyor:
    """Take the highest peak of the hologram as the tag's position [Boroushaki2023], Eq. 2.

    Attributes:
        matching: How the cells are combined, see `rfcompass.rf.hologram`.
        threshold: Share of the peak's power that bounds the confidence box.
        max_box_m: A fix is confident if its box is smaller than this along x, y, z [m] (the paper's τ) and not clipped.
        box_margin_m: How far beyond the search volume the box is measured [m]. With 0 the box ends at the border, and
            a tag whose region touches it is clipped.
    """

    method: ClassVar[str] = "sar"
    matching: Matching = field(default_factory=Matching)
    threshold: float = THRESHOLD
    max_box_m: tuple[float, float, float] = MAX_BOX_M
    box_margin_m: float = 0.0

    def locate(self, trace: ReadTrace, volume: SearchVolume) -> TagFix:
        """Find the tag inside a volume; see `Surveyor.locate`."""
        require_reads(trace)
        wide = _widened(volume, self.box_margin_m)
        hologram = build_hologram(trace, wide, self.matching)
        peak = highest_peak(hologram.power, volume, hologram.wavelength_m, keep=KEPT_PEAKS, resolution_m=RESOLUTION_M)
        box = confidence_box(hologram.power, wide, peak, self.threshold)
        return TagFix(
            epc=trace.epc,
            point_m=peak.point_m,
            box_m=box.extent_m,
            confident=is_confident(box, self.max_box_m),
            clipped=box.clipped,
            method=self.method,
        )

    def box_at(self, trace: ReadTrace, volume: SearchVolume, point_m: FloatArray) -> ConfidenceBox:
        """Measure the box about a point that is taken for the peak [m], shape (3,), inside the volume."""
        wide = _widened(volume, self.box_margin_m)
        hologram = build_hologram(trace, wide, self.matching)
        peak = Peak(point_m, float(hologram.power(point_m[None])[0]))
        return confidence_box(hologram.power, wide, peak, self.threshold)


# The wrist of [Boroushaki2023]: a software radio, whose channels add up as complex numbers (Eq. 1 as it is printed).
WRIST_SAR = SarSurveyor(
    matching=Matching(coherent=True, amplitude=True), max_box_m=WRIST_MAX_BOX_M, box_margin_m=WRIST_BOX_MARGIN_M
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


def _widened(volume: SearchVolume, margin_m: float) -> SearchVolume:
    """The volume with a margin on both sides of each axis that is searched."""
    return SearchVolume(volume.lower_m - margin_m * volume.free_axes, volume.upper_m + margin_m * volume.free_axes)


def _slab(hologram: Hologram, x_m: float, y_m: FloatArray, z_m: FloatArray) -> FloatArray:
    points_m = np.minimum(grid_points((np.array([x_m]), y_m, z_m)), hologram.volume.upper_m)
    return hologram.power(points_m).reshape(y_m.size, z_m.size)
