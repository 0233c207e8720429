"""Which sign does a reader give its phase? The one with which its tags come into focus.

With the wrong sign an image must put a wave front that curves one way onto tags that curve it the other way. Each tag's
hologram (`rfcompass.rf.hologram`), phases only, is searched for its peak twice, as it stands and with the phases
reversed; the peak is given as a share of what perfect agreement would give.
"""

from dataclasses import dataclass, replace

import numpy as np

from rfcompass.errors import NotFocused, TagNeverHeard
from rfcompass.localization.search_volume import default_volume
from rfcompass.rf.hologram import Matching, build_hologram
from rfcompass.rf.peak_search import highest_peak
from rfcompass.rf.runs import LEAST_DIFFERENCES, phase_differences, runs
from rfcompass.types.reads import ReadTrace, Scan
from rfcompass.types.volumes import SearchVolume

# Ours. On 35 measured sweeps of three rigs the right sign has 1.5 to 6 times the focus of the wrong one.
CLEAR_RATIO = 1.2
_KEPT_PEAKS = 8
_RESOLUTION_M = 0.004


@dataclass(frozen=True, slots=True)
class PhaseSign:
    """What the images of a scan say about the sign that it was read with.

    Attributes:
        reversed: True if the phases must be reversed: the stated `phase_sign` is the wrong one.
        focus: Median focus of the tags as the scan stands, between 0 and 1.
        focus_reversed: The same with reversed phases.
        tags: Number of tags that were asked.
    """

    reversed: bool
    focus: float
    focus_reversed: float
    tags: int


def detect_phase_sign(scan: Scan, volume: SearchVolume | None = None) -> PhaseSign:
    """Tell whether the phases of a scan have the sign that its loader assumed.

    Args:
        scan: Reads of one stop, antenna positions known, tags somewhere in the volume.
        volume: Where the tags may be; by default as `survey` looks for them.

    Raises:
        TagNeverHeard: If no tag was heard often enough.
        NotFocused: If neither sign is clearly better, as with a short path far from the tags; carries both figures.
    """
    traces = [trace for trace in scan.traces.values() if phase_differences(trace) >= LEAST_DIFFERENCES]
    if not traces:
        raise TagNeverHeard("no tag was heard at enough positions to tell the sign of its phase", heard=list(scan.epcs))
    where = volume or default_volume(scan)
    focus = float(np.median([_focus(trace, where) for trace in traces]))
    turned = float(np.median([_focus(replace(trace, channel=trace.channel.conj()), where) for trace in traces]))
    if max(focus, turned) < CLEAR_RATIO * min(focus, turned):
        message = f"the sign of the phase cannot be told: focus {focus:.2f} as it stands, {turned:.2f} reversed"
        raise NotFocused(message, focus=focus, focus_reversed=turned, needed=CLEAR_RATIO)
    return PhaseSign(turned > focus, focus, turned, len(traces))


def _focus(trace: ReadTrace, volume: SearchVolume) -> float:
    """Height of the highest peak as a share of what perfect agreement gives."""
    hologram = build_hologram(trace, volume, Matching())
    peak = highest_peak(
        hologram.power, volume, hologram.wavelength_m, keep=_KEPT_PEAKS, resolution_m=_RESOLUTION_M
    )  # fmt: skip
    perfect = sum(float((trace.mask[rows].sum(axis=0) ** 2).sum()) for rows in runs(trace))
    return peak.power / perfect
