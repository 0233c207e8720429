"""The two ways of a fetch: the paper's rig and estimator end to end, and the best that we have."""

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any, Literal

from planners.antenna_track import NearTrack
from rfcompass.interfaces import Localizer, ProximityMeter
from rfcompass.localization import ConsistencyLocalizer, PartitionLocalizer, PosteriorLocalizer
from rfcompass.rf import meter
from rfcompass.studies.radio_setup import BEST_RADIO, PAPER_RADIO, RadioSetup

# In place of a meter: no radio, distances with noise.
NOISY_DISTANCE = "noisy_distance"


class Mode(StrEnum):
    """How a fetch is done.

    `paper`: one straight far track of a bistatic 920 MHz rig, PinIt's profiles and DTW, Eq. 8 with the ε schedule and
    its analytic centre, moves of D/2, a window of three motions and two metres [Wang2013]. `best`: the same radio
    along legs that come near the part once the robot has come near it, near-field images, the posterior, and last stops
    where they tell most.
    """

    PAPER = "paper"
    BEST = "best"


@dataclass(frozen=True, slots=True, kw_only=True)
class FetchMode:
    """Everything that a mode decides.

    Attributes:
        radio: Antenna track and reader; None for distances with noise.
        meter: Measures proximities; None where there is no radio.
        localizer: Finds the part.
        near: How the antenna comes near the part; None if it drives one track always.
        active_stops: Whether the last stops are chosen by what they would tell.
        map_pose: How the robot knows where it stands on a map, if it is to have one; None where there is no radio.
    """

    radio: RadioSetup | None
    meter: ProximityMeter | None
    localizer: Localizer
    near: NearTrack | None = None
    active_stops: bool = False
    map_pose: Literal["radio", "start"] | None = None

    def in_scene(self, **changes: Any) -> "FetchMode":  # noqa: ANN401 - fields of the radio
        """Return the mode with other fields of its radio, such as the scene."""
        return self if self.radio is None else replace(self, radio=replace(self.radio, **changes))


def fetch_mode(mode: Mode, proximity: str | None = None, localizer: Localizer | None = None) -> FetchMode:
    """Look up a mode.

    Args:
        mode: Which one.
        proximity: Meter in place of the mode's own, or `"noisy_distance"` for no radio at all.
        localizer: Localizer in place of the mode's own.

    Raises:
        UnknownMeter: If there is no such meter.
    """
    paper = mode is Mode.PAPER
    kind = proximity or ("pinit_dtw" if paper else "auto")
    if kind == NOISY_DISTANCE:
        own = PartitionLocalizer(centre="analytic") if paper else ConsistencyLocalizer()
        return FetchMode(radio=None, meter=None, localizer=localizer or own)
    if paper:
        own = PartitionLocalizer(centre="analytic")
        # A robot under one straight track hardly sees from its tags where it stands; it is told at the start.
        return FetchMode(radio=PAPER_RADIO, meter=meter(kind), localizer=localizer or own, map_pose="start")
    return FetchMode(
        radio=BEST_RADIO,
        meter=meter(kind),
        localizer=localizer or PosteriorLocalizer(),
        near=NearTrack(),
        active_stops=True,
        map_pose="radio",
    )
