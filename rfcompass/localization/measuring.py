"""From an observation to its proximities, with all that is known about heights."""

from dataclasses import replace

from rfcompass.interfaces import ProximityMeter
from rfcompass.rf import AutoMeter
from rfcompass.types.observation import Observation
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.reads import Scan


def measure_proximities(observation: Observation, meter: ProximityMeter | None = None) -> ProximityMatrix:
    """Return the ready-made proximities of a stop, or measure them.

    Args:
        observation: One stop.
        meter: Measures where the stop brings no proximities; `auto` if None.

    Raises:
        NoAnswer: If the meter has none; the subclass says why.
    """
    if observation.proximity is not None:
        return observation.proximity
    scan = with_known_heights(observation)
    return (meter or AutoMeter()).measure(scan, targets=observation.part.epcs, anchors=observation.anchors.epcs)


def with_known_heights(observation: Observation) -> Scan:
    """Return the scan with the heights that forward kinematics and the part's layout tell.

    The z axis of base frame and antenna frame both count from the floor. Heights that the scan brings itself stay.
    """
    anchors, part = observation.anchors, observation.part
    heights_m = dict(zip(anchors.epcs, anchors.points_m[:, 2].tolist(), strict=True))
    heights_m |= dict(zip(part.epcs, observation.part_tag_heights_m.tolist(), strict=True))
    return replace(observation.scan, heights_m={**heights_m, **observation.scan.heights_m})
