"""`auto`: the meter to use if one does not want to choose."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from rfcompass.rf.meters.phase_rms import PhaseRmsMeter
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.reads import Scan


@dataclass(frozen=True, kw_only=True)
class AutoMeter:
    """Use the meter that orders distances best on measured sweeps: `phase_rms`.

    The result names the meter that was used, never `auto`.
    """

    kind: ClassVar[str] = "auto"

    def measure(
        self, scan: Scan, *, targets: Sequence[str] = (), anchors: Sequence[str] | None = None
    ) -> ProximityMatrix:
        """Compare the tags; see `ProximityMeter.measure`."""
        return PhaseRmsMeter().measure(scan, targets=targets, anchors=anchors)
