"""Where a tag is after something near it was moved: few more reads, and a place where it was; ours.

One straight way tells a tag's place on a ring about it. With the place where the tag was, that is enough to say whether
it is still there, and mostly where it is if not: it has not gone far.
"""

import numpy as np

from rfcompass.localization.confidence_box import confidence_box
from rfcompass.localization.reads_needed import require_reads
from rfcompass.localization.sar import KEPT_PEAKS, RESOLUTION_M, SarSurveyor
from rfcompass.rf.hologram import build_hologram
from rfcompass.rf.peak_search import highest_peak
from rfcompass.types.fixes import TagFix
from rfcompass.types.reads import ReadTrace
from rfcompass.types.volumes import SearchVolume

# Ours, chosen on piles of seeds below 10: a tag is followed so far along each axis [m].
REACH_M = 0.15


def follow_tag(
    trace: ReadTrace, fix: TagFix, volume: SearchVolume, surveyor: SarSurveyor, reach_m: float = REACH_M
) -> TagFix:
    """Say where a tag is now that was located before and may have been moved.

    It is still there if its old place is inside the region of almost the same power, P > 0.84 max P
    [Boroushaki2023], of what is heard now, over all places within reach: the old fix then stays. Else it is at the
    maximum. If that is on the border sideways, the tag has gone further, and the fix is not confident.

    Args:
        trace: Reads since then, of this tag alone, along one way or more.
        fix: Where it was.
        volume: Where it can be, in the frame of the antenna path.
        surveyor: How it was located.
        reach_m: How far it is followed along each axis [m].

    Returns:
        The old fix, or a new one. Its box ends at the border of what was searched, so it is `clipped` as a rule.

    Raises:
        TooFewReads: If the tag was heard at too few antenna positions.
    """
    require_reads(trace)
    was_m = np.clip(fix.point_m, volume.lower_m, volume.upper_m)
    lower_m, upper_m = np.maximum(was_m - reach_m, volume.lower_m), np.minimum(was_m + reach_m, volume.upper_m)
    near = SearchVolume(lower_m, upper_m)
    hologram = build_hologram(trace, near, surveyor.matching)
    peak = highest_peak(hologram.power, near, hologram.wavelength_m, keep=KEPT_PEAKS, resolution_m=RESOLUTION_M)
    if float(hologram.power(was_m[None])[0]) > surveyor.threshold * peak.power:
        return fix
    box = confidence_box(hologram.power, near, peak, surveyor.threshold)
    from_border_m = np.minimum(peak.point_m - lower_m, upper_m - peak.point_m)[:2]
    return TagFix(
        epc=fix.epc,
        point_m=peak.point_m,
        box_m=box.extent_m,
        confident=bool((from_border_m > 2 * RESOLUTION_M).all()),
        clipped=box.clipped,
        method="followed",
    )
