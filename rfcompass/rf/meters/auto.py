"""`auto`: the meter to use if one does not want to choose."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from rfcompass.interfaces import ProximityMeter
from rfcompass.rf.meters.phase_rms import PhaseRmsMeter
from rfcompass.rf.meters.sar_nearfield import SarNearfieldMeter
from rfcompass.rf.path_legs import spans_two_directions
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.reads import Scan


@dataclass(frozen=True, kw_only=True)
class AutoMeter:
    """Use the meter that orders distances best on the antenna path of the scan.

    That is `sar_nearfield` where the path spans two directions. A straight path sees little of the range, and its
    images err along it; there `phase_rms` orders distances best on measured sweeps. The result names the meter that
    was used, never `auto`.
    """

    kind: ClassVar[str] = "auto"

    def measure(
        self, scan: Scan, *, targets: Sequence[str] = (), anchors: Sequence[str] | None = None
    ) -> ProximityMatrix:
        """Compare the tags; see `ProximityMeter.measure`."""
        return best_meter(scan).measure(scan, targets=targets, anchors=anchors)


def best_meter(scan: Scan) -> ProximityMeter:
    """Meter for the antenna path of a scan."""
    path_m = next((trace.antenna_positions_m for trace in scan.traces.values()), None)
    return SarNearfieldMeter() if path_m is not None and spans_two_directions(path_m) else PhaseRmsMeter()
