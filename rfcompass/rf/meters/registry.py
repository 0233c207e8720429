"""Meters by name."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from rfcompass.errors import InputError, UnknownMeter
from rfcompass.interfaces import ProximityMeter
from rfcompass.rf.meters.aoa import AoaMeter
from rfcompass.rf.meters.auto import AutoMeter
from rfcompass.rf.meters.phase_dtw import PhaseDtwMeter
from rfcompass.rf.meters.phase_l1 import PhaseL1Meter
from rfcompass.rf.meters.phase_rms import PhaseRmsMeter
from rfcompass.rf.meters.pinit_dtw import PinItDtwMeter
from rfcompass.rf.meters.profile_l1 import ProfileL1Meter
from rfcompass.rf.meters.rssi import RssiMeter
from rfcompass.rf.meters.sar_nearfield import SarNearfieldMeter

METERS: Mapping[str, type[ProximityMeter]] = MappingProxyType(
    {
        meter.kind: meter
        for meter in (
            AutoMeter,
            SarNearfieldMeter,
            PhaseRmsMeter,
            PhaseL1Meter,
            PhaseDtwMeter,
            PinItDtwMeter,
            ProfileL1Meter,
            AoaMeter,
            RssiMeter,
        )
    }
)


def meter(kind: str, **parameters: Any) -> ProximityMeter:  # noqa: ANN401 - the meter says what it takes
    """Make a meter.

    Args:
        kind: A key of `METERS`, for example `"auto"`.
        **parameters: Fields of that meter that shall differ from its defaults.

    Raises:
        UnknownMeter: If there is no such meter; lists those that exist.
        InputError: If the meter has no such parameter.
    """
    if kind not in METERS:
        raise UnknownMeter(f"no proximity meter {kind!r} (known: {', '.join(METERS)})", meter=kind, known=list(METERS))
    try:
        return METERS[kind](**parameters)
    except TypeError as error:
        raise InputError(f"meter {kind}: {error}", meter=kind, parameters=sorted(parameters)) from error
