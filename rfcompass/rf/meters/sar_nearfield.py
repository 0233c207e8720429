"""`sar_nearfield`: distance between the places where two tags are seen in near-field images."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.rf.image_frame import ImageFrame, frame_of_path, given_frame
from rfcompass.rf.image_slopes import climb_to_top
from rfcompass.rf.meters.pairing import compare_tags, pairwise
from rfcompass.rf.near_field import near_field_image
from rfcompass.rf.peak_search import STEPS_PER_WAVELENGTH, highest_peak
from rfcompass.rf.runs import LEAST_DIFFERENCES, phase_differences
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.reads import ReadTrace, Scan
from rfcompass.types.volumes import SearchVolume

STEPS_PER_FRINGE = 4  # coarse grid: λ/8 where the antenna sends as well, λ/4 where only the receiver moves
KEPT_PEAKS = 6
RESOLUTION_M = 0.004  # of the grids; the top itself is found in double precision


@dataclass(frozen=True, kw_only=True)
class SarNearfieldMeter:
    """Compare two tags by the distance between the peaks of their near-field images.

    m(a, b) = | p_a - p_b |,     p_t = argmax_p Π_l B_l(p)     (see `rfcompass.rf.near_field`),

    a length in metres that is meant to be the true distance. What bends the image of one tag, a leg that is not where
    the robot believes, a wall, a wrong speed of the carrier, bends that of its neighbour alike, and drops out of the
    difference.

    A tag whose height is known (`Scan.heights_m`, counted from where the antenna positions count theirs) is sought in
    its own plane, and m is the distance in space. Otherwise see `rfcompass.rf.image_frame`. With a transmitter that
    stands still its distance to the tag is part of the unknown phase constant; several take turns as further looks.

    No standard errors are given: what is left of the phase noise is far below what reflections do, and those cannot be
    told from one scan of one tag. The robot's own tags tell (`rfcompass.rf.self_check`).

    Attributes:
        volume: Where tags may be, in the scan's frame; by default chosen from the antenna path.
        reach_m: How far from the path tags may be if there is no volume [m]; by default 4 m in a plane, 1.5 m in space.
        split_legs: Multiply the images of the straight legs; otherwise keep the phase around corners.
        sub_apertures: Cut each leg into as many parts, whose images are multiplied.
        coherent: Add channels as complex numbers; needs a reader without phase constants.
        amplitude: Weigh cells by |h|.
    """

    kind: ClassVar[str] = "sar_nearfield"
    volume: SearchVolume | None = None
    reach_m: float | None = None
    split_legs: bool = True
    sub_apertures: int = 1
    coherent: bool = False
    amplitude: bool = True

    def measure(
        self, scan: Scan, *, targets: Sequence[str] = (), anchors: Sequence[str] | None = None
    ) -> ProximityMatrix:
        """Compare the tags; see `ProximityMeter.measure`. m in metres; NaN for a tag with too few reads."""
        heights_m = _heights(scan)
        return compare_tags(self.kind, lambda traces: self.distances(traces, heights_m), scan, targets, anchors)

    def distances(self, traces: Sequence[ReadTrace], heights_m: Mapping[str, float] | None = None) -> FloatArray:
        """Distance between every pair of traces of one scan [m], shape (T, T); known heights by EPC."""
        known = heights_m or {}
        points_m = [self.place(trace, known.get(trace.epc)) for trace in traces]
        return pairwise(len(traces), lambda i, j: float(np.linalg.norm(points_m[i] - points_m[j])))

    def place(self, trace: ReadTrace, height_m: float | None = None) -> FloatArray:
        """Peak of one tag's image in the scan's frame [m], shape (3,); NaN if it was heard too little.

        On a straight path without heights this is a place in the half-plane that stands for the circle of all places.

        Args:
            trace: Reads of one tag.
            height_m: Height of the tag in the scan's frame [m]; None if it is not known.
        """
        if phase_differences(trace) < LEAST_DIFFERENCES:
            return np.full(3, np.nan)
        frame = self._frame(trace, height_m)
        image = near_field_image(
            _moved(trace, frame),
            frame.volume,
            split_legs=self.split_legs,
            sub_apertures=self.sub_apertures,
            coherent=self.coherent,
            amplitude=self.amplitude,
        )
        coarse_m = image.fringe_m * STEPS_PER_WAVELENGTH / STEPS_PER_FRINGE
        peak = highest_peak(image.power, frame.volume, coarse_m, keep=KEPT_PEAKS, resolution_m=RESOLUTION_M)
        return frame.back(climb_to_top(image.log_slopes, frame.volume, peak.point_m, image.fringe_m))

    def _frame(self, trace: ReadTrace, height_m: float | None) -> ImageFrame:
        if self.volume is not None:
            return given_frame(self.volume, height_m)
        return frame_of_path(trace.antenna_positions_m, height_m, self.reach_m)


def _heights(scan: Scan) -> dict[str, float]:
    """Known heights; in a scan of two dimensions all tags are as high as the antennas."""
    if scan.dimensions == 3 or not scan.traces:
        return dict(scan.heights_m)
    level_m = float(next(iter(scan.traces.values())).antenna_positions_m[:, 2].mean())
    return {**dict.fromkeys(scan.epcs, level_m), **scan.heights_m}


def _moved(trace: ReadTrace, frame: ImageFrame) -> ReadTrace:
    tx_m = trace.tx_positions_m
    return replace(
        trace,
        antenna_positions_m=frame.into(trace.antenna_positions_m),
        tx_positions_m=None if tx_m is None else frame.into(tx_m),
    )
