"""Each part tag is where the nearest robot tags are: the rule of [PinIt2013], the simplest there is."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError, TagNeverHeard
from rfcompass.interfaces import ProximityMeter
from rfcompass.localization.placed_stop import PlacedStop, place_stops, same_tags
from rfcompass.localization.rigid_fit import LEAST_SD_M, fit_rigid_part
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.observation import Observation


@dataclass(frozen=True, slots=True, kw_only=True)
class NearestTagLocalizer:
    """Places of the robot's tags that seem nearest, averaged: a baseline [PinIt2013].

    p_k = Σ_i w_i a_i / Σ_i w_i over the n anchors with the smallest m_ki of all stops, w_i = 1 / m_ki, and the part is
    laid through the p_k. Never outside the hull of the robot's tags, and hardly ever nearer than their spacing; where
    all tags of the part have the same neighbours, its orientation is not observable.

    Attributes:
        neighbours: n.
        meter: Measures proximities where an observation does not bring its own; `auto` if None.
    """

    neighbours: int = 3
    meter: ProximityMeter | None = None

    def estimate(self, observations: Sequence[Observation]) -> PartEstimate:
        """Estimate the pose of the part in the newest base frame.

        Args:
            observations: Stops, newest last; all are used, odometry counts as exact.

        Raises:
            InputError: If there is no stop, or `neighbours` is below 1.
            DegenerateAnchors: If a stop has fewer than two anchors, or all in one place.
            TagNeverHeard: If no tag of the part was heard.
        """
        if self.neighbours < 1:
            raise InputError(f"neighbours = {self.neighbours} is below 1", neighbours=self.neighbours)
        stops, part = place_stops(observations, self.meter), observations[-1].part
        places = [self._place(stops, k) for k in range(len(part.epcs))]
        heard = [k for k, place in enumerate(places) if place is not None]
        if not heard:
            raise TagNeverHeard(f"no tag of {part.body} was heard", epc=list(part.epcs), heard=0)
        found = np.array([place for place in places if place is not None])
        fit = fit_rigid_part(part.points_m[heard, :2], found[:, :2], max(LEAST_SD_M, float(found[:, 2].mean())))
        return fit.to_estimate(observations, "nearest_tag", {"neighbours": self.neighbours})

    def _place(self, stops: Sequence[PlacedStop], k: int) -> FloatArray | None:
        """Place of one part tag, and the spread of its neighbours along one axis [m], shape (3,); None if unheard."""
        tag_m = stops[-1].part_points_m[[k]]
        m = np.concatenate(
            [np.pad(s.m, ((0, 1), (0, 0)), constant_values=np.nan)[same_tags(tag_m, s.part_points_m)[0]] for s in stops]
        )
        nearest = np.argsort(m, kind="stable")[: min(self.neighbours, int(np.isfinite(m).sum()))]
        if not nearest.size:
            return None
        near_m = np.vstack([stop.anchors_m for stop in stops])[nearest, :2]
        weight = 1.0 / np.maximum(m[nearest], 1e-12)
        mean_m = weight @ near_m / weight.sum()
        return np.append(mean_m, np.sqrt(weight @ ((near_m - mean_m) ** 2).mean(axis=1) / weight.sum()))
