"""The two ways of a fetch: the paper's rig and estimator end to end, and the best that we have."""

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

from rfcompass.interfaces import Localizer, ProximityMeter
from rfcompass.localization import ConsistencyLocalizer, PartitionLocalizer
from rfcompass.rf import meter
from rfcompass.studies.radio_setup import BEST_RADIO, PAPER_RADIO, RadioSetup

# In place of a meter: no radio, distances with noise.
NOISY_DISTANCE = "noisy_distance"


class Mode(StrEnum):
    """How a fetch is done.

    `paper`: one straight far track of a bistatic 920 MHz rig, PinIt's profiles and DTW, Eq. 8 with the ε schedule and
    its analytic centre, moves of D/2, a window of three motions and two metres [Wang2013]. `best`: the same radio
    along an L, near-field images, and the estimator that is best with them.
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
    """

    radio: RadioSetup | None
    meter: ProximityMeter | None
    localizer: Localizer

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
    own = PartitionLocalizer(centre="analytic") if paper else ConsistencyLocalizer()
    return FetchMode(
        radio=None if kind == NOISY_DISTANCE else PAPER_RADIO if paper else BEST_RADIO,
        meter=None if kind == NOISY_DISTANCE else meter(kind),
        localizer=localizer or own,
    )
