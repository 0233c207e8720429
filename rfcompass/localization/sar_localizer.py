"""The part laid through the places where its tags seem to be: what positions alone give, without a posterior."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import TagNeverHeard
from rfcompass.interfaces import ProximityMeter
from rfcompass.localization.noise_model import fit_noise
from rfcompass.localization.part_evidence import distance_evidence
from rfcompass.localization.placed_stop import PlacedStop, place_stops, same_tags
from rfcompass.localization.pose_inference import see_tags
from rfcompass.localization.problem import BOUNDS_MARGIN_M, bounds_about
from rfcompass.localization.rigid_fit import fit_rigid_part, spatial_median
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.observation import Observation


@dataclass(frozen=True, slots=True, kw_only=True)
class SarLocalizer:
    """Rigid fit of the part through the positions of its tags: a baseline and a cross-check, without comparisons.

    At every stop the place of a part tag is where its distances to the robot's tags are likeliest, m = c (d + noise)
    as in `PosteriorLocalizer`; with near-field images this lays the images of the robot's tags over their true places.
    The spatial median over stops, in the newest base frame, stands for the tag, and the part is laid through its tags.

    It takes moves for independent and biases for noise, so its covariance is too small where reflections are strong,
    and its region claims no probability.

    Attributes:
        margin_m: How far beyond the robot's tags a part tag may lie [m].
        meter: Measures proximities where an observation does not bring its own; `auto` if None.
    """

    margin_m: float = BOUNDS_MARGIN_M
    meter: ProximityMeter | None = None

    def estimate(self, observations: Sequence[Observation]) -> PartEstimate:
        """Estimate the pose of the part in the newest base frame; θ is None for a part with one tag.

        Args:
            observations: Stops, newest last; all are used.

        Raises:
            InputError: If there is no stop.
            DegenerateAnchors: If a stop has fewer than two anchors, or all in one place.
            TagNeverHeard: If no tag of the part was heard, or one only of several: its other end may be anywhere.
        """
        stops = place_stops(observations, self.meter)
        seen = np.array([self._places(stop, stops[-1].part_points_m) for stop in stops])
        heard = np.isfinite(seen[:, :, 0]).any(axis=0)
        part = observations[-1].part
        if heard.sum() < min(2, heard.size):
            missing = [epc for epc, known in zip(part.epcs, heard, strict=True) if not known]
            raise TagNeverHeard(
                f"{len(missing)} of {heard.size} tags of {part.body} were not heard", epc=missing, heard=0
            )
        places_m = np.array([spatial_median(own[np.isfinite(own[:, 0])]) for own in seen[:, heard].swapaxes(0, 1)])
        fit = fit_rigid_part(part.points_m[heard, :2], places_m)
        return fit.to_estimate(observations, "sar", {"stops_with_fixes": int(np.isfinite(seen).any(axis=(1, 2)).sum())})

    def _places(self, stop: PlacedStop, tags_m: FloatArray) -> FloatArray:
        """Where each of the newest stop's tags seems to be at one stop, NaN if it was not heard there, shape (K, 2)."""
        evidence = distance_evidence([stop], {stop.kind: fit_noise([stop])})
        seen = see_tags(evidence, bounds_about(stop.anchors_m, self.margin_m))
        places_m = np.array([*(tag.top_m for tag in seen), [np.nan, np.nan]])
        return places_m[same_tags(tags_m, evidence.points_m)] if len(seen) else np.full((len(tags_m), 2), np.nan)
