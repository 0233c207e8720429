"""The posterior over the part's pose: where it is, how sure that is, and what cannot be told."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import Infeasible, InputError, TagNeverHeard
from rfcompass.interfaces import ProximityMeter
from rfcompass.localization.compared_stop import ComparedStop
from rfcompass.localization.comparing import compare_proximities
from rfcompass.localization.evidence_trust import TrustedEvidence, trust
from rfcompass.localization.noise_model import LEAST_BIAS_M, NoiseModel, fit_noise
from rfcompass.localization.part_evidence import PartEvidence, comparison_evidence, distance_evidence
from rfcompass.localization.placed_stop import OdometrySpread, PlacedComparisons, PlacedStop, place_stops
from rfcompass.localization.pose_fit import PoseFit, judge
from rfcompass.localization.pose_inference import infer_pose
from rfcompass.localization.pose_posterior import PosePosterior
from rfcompass.localization.problem import BOUNDS_MARGIN_M, bounds_about, check_bounds
from rfcompass.localization.unknown_height import infer_lifted, lifts_between, mixed, raised
from rfcompass.types.estimate import DiagnosticValue, PartEstimate
from rfcompass.types.observation import Observation
from rfcompass.types.record import Record

Use = Literal["auto", "distances", "comparisons"]
HEIGHT_STEP_M = 0.02  # ours
IMAGED = frozenset({"sar_nearfield"})  # meters that take stated heights for granted
IMAGE_STEP_M = 0.05  # ours: a tag seems to move by 1 to 3 mm when its height is stated that much lower
LARGEST_BORDER_SHARE = 0.45  # ours; 0.36 where nothing is known
LARGEST_MARGIN_M = 10.0  # ours, the size of a room; bounds follow distances up to here
TEMPERING = 0.5  # ours, between the 0.4 and 1.0 that calibrated comparisons from one stop in a simulated room


@dataclass(frozen=True, slots=True)
class Inference(Record):
    """A posterior, and what led to it.

    Attributes:
        posterior: Probability of every pose.
        trusted: The evidence that was used.
        noise: What the numbers of the meter are worth.
        why: Why comparisons were used, or `"distances"`.
    """

    posterior: PosePosterior
    trusted: TrustedEvidence
    noise: NoiseModel
    why: str

    @property
    def diagnostics(self) -> dict[str, DiagnosticValue]:
        """What a `PartEstimate` says about all this."""
        posterior, trusted, noise = self.posterior, self.trusted, self.noise
        mode, modes = posterior.mode, posterior.modes
        return {
            "evidence": "distances" if trusted.evidence.ranges else "comparisons",
            "why": self.why,
            "rows": trusted.evidence.rows,
            "mode_x_m": float(mode[0]),
            "mode_y_m": float(mode[1]),
            "mode_theta_rad": None if posterior.theta_rad is None else float(mode[2]),
            "modes": len(modes),
            "largest_mode": float(modes[0]),
            "orientation_norm": abs(posterior.theta_mean),
            "theta_information_nat": posterior.theta_information,
            "log_evidence": posterior.log_evidence,
            "lift_m": posterior.mean_lift_m,
            "lift_sd_m": posterior.lift_sd_m,
            "rigid_fit_sd": posterior.rigid_distance_sd if trusted.evidence.ranges else None,
            "dropped_stops": len(trusted.dropped),
            "noise_factor": trusted.noise_factor,
            "wrong_share": trusted.wrong_share,
            "scale": noise.scale,
            "alpha_m": noise.alpha_m,
            "beta": noise.beta,
            "bias_m": trusted.evidence.bias_m,
            "comparison_m": noise.comparison_m,
            "lapse": noise.lapse,
            "anchor_pairs": noise.pairs,
            "rank_correlation": noise.rank_correlation,
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class PosteriorLocalizer:
    """Probability of every pose (x, y, θ) of the part, given what was heard.

    A proximity m_ki stands for a distance, m = c (d + s(d) t) with Student-4 noise t and s² = α² + β² d²; c, α and β
    are fitted on the robot's own pairs of tags, whose distances are known. Where these show that m orders distances
    too badly, comparisons are used instead: the nearer of two anchors wins with probability
    λ/2 + (1 - λ) / (1 + exp(-Δd / s)). Reflections shift the seeming place of a tag alike in every scan; this bias is
    marginalised. Anchors that stay where they are count once, odometry adds its own covariance.
    See docs/posterior.md; the equations are ours, [Wang2013] takes a point from a convex program.

    Attributes:
        use: `"distances"`, `"comparisons"`, or `"auto"`: distances where the robot's own tags vouch for them.
        tempering: Power γ in (0, 1] of a comparison's likelihood; comparisons of one tag share its errors.
        bounds_m: Where the centre may lie, newest base frame [m], [[xmin, xmax], [ymin, ymax]]. If None, 3 m about
            all anchors, or farther if the distances are longer.
        lift_range_m: How much higher than stated the part may lie, (lowest, highest) [m]; None if its height is known.
            `sar_nearfield` takes the stated heights for granted: from scans it then measures anew at heights 5 cm
            apart, all as likely in the end as beforehand. Proximities of it that are ready-made cannot be helped.
        least_bias_m: Floor of the standard deviation of a tag's bias [m]. 3 mm makes regions half as wide beside near
            tracks where the robot does not scatter; see docs/posterior.md.
        probability: Probability of the region that the estimate carries.
        sample_count: Number of samples that the estimate carries.
        meter: Measures proximities where an observation does not bring its own; `auto` if None.
    """

    use: Use = "auto"
    tempering: float = TEMPERING
    bounds_m: FloatArray | None = None
    lift_range_m: tuple[float, float] | None = None
    least_bias_m: float = LEAST_BIAS_M
    probability: float = 0.9
    sample_count: int = 500
    meter: ProximityMeter | None = None

    def estimate(self, observations: Sequence[Observation]) -> PartEstimate:
        """Estimate the pose of the part in the newest base frame.

        Args:
            observations: Stops, newest last; all are used, as far as they do not contradict the newest.

        Returns:
            Mean pose, θ None if its resultant is shorter than a half; covariance, region and samples of the
            posterior. `diagnostics` hold the mode, the modes' number and the largest one's probability, what is known
            about θ, the fitted noise, what was left out, and how far the rigid fit lies from the mean.

        Raises:
            InputError: If there is no stop.
            DegenerateAnchors: If a stop has fewer than two anchors, or all in one place.
            TagNeverHeard: If no tag of the part was heard.
            Infeasible: If no pair of anchors could be compared, no pose within the bounds has any probability, or most
                of it gathers along their border: then what was heard points elsewhere, or is altogether wrong.
        """
        inference = self.infer(observations)
        posterior, newest = inference.posterior, observations[-1]
        height_m = float((newest.part_tag_heights_m - newest.part.points_m[:, 2]).mean())
        return PartEstimate(
            newest.part.body, posterior.mean_m, posterior.theta_rad, "posterior",
            len(observations) - len(inference.trusted.dropped), height_m + posterior.mean_lift_m, posterior.covariance,
            posterior.region(self.probability), self.probability, posterior.samples(self.sample_count),
            diagnostics=inference.diagnostics,
        )  # fmt: skip

    def infer(self, observations: Sequence[Observation]) -> Inference:
        """Find the posterior itself, with all regions, modes and samples; see `estimate`."""
        self._check()
        stops = place_stops(observations, self.meter)
        if self.lift_range_m is not None and _can_be_imaged_anew(observations, stops):
            return self._infer_imaged(observations, self.lift_range_m)
        if all(np.isnan(stop.m).all() for stop in stops):
            epcs = observations[-1].part.epcs
            raise TagNeverHeard(f"no tag of {observations[-1].part.body} was heard", epc=list(epcs), heard=0)
        by_kind = {kind: [stop for stop in stops if stop.kind == kind] for kind in {s.kind for s in stops}}
        noise = {kind: fit_noise(same, self.least_bias_m) for kind, same in by_kind.items()}
        why = self._why_not_distances(noise)
        if why is None:
            worst, bounds_m = max(noise.values(), key=lambda one: one.alpha_m), _bounds_of_distances(stops, noise)
            return self._solve(distance_evidence(stops, noise), worst, "distances", bounds_m)
        model = max(noise.values(), key=lambda one: one.comparison_m)
        compared = [
            PlacedComparisons(stop.anchors_m, stop.part_points_m, compare_proximities(stop.m), stop.odometry)
            for stop in stops
        ]
        return self._compare(compared, _no_better_than_comparisons(model), why)

    def fit(self, stops: Sequence[ComparedStop]) -> PoseFit:
        """Find the pose from comparisons whose quality nobody measured; odometry counts as exact.

        Raises:
            InputError: If there is no stop.
            Infeasible: If there is no comparison, or as in `estimate`.
        """
        inference = self.infer_from_comparisons(stops)
        posterior, theta_rad = inference.posterior, inference.posterior.theta_rad
        turn = posterior.theta_mean
        z = posterior.mean_m if theta_rad is None else np.array([*posterior.mean_m, turn.real, turn.imag])
        verdict = judge(stops, z, theta_rad)
        return PoseFit(
            z, theta_rad, verdict.relaxed, verdict.met, verdict.total, posterior.region(self.probability),
            posterior.theta_interval(self.probability), posterior.covariance, verdict.broken,
            diagnostics={"probability": self.probability, **inference.diagnostics},
        )  # fmt: skip

    def infer_from_comparisons(self, stops: Sequence[ComparedStop], noise: NoiseModel | None = None) -> Inference:
        """Find the posterior itself, with all regions, modes and samples, from comparisons alone; see `fit`.

        Args:
            stops: Stops, newest last.
            noise: How far comparisons can be trusted, and the bias of a tag's place, if that is known.
        """
        self._check()
        if not stops:
            raise InputError("no stop was given", stops=0)
        exact = OdometrySpread()
        compared = [
            PlacedComparisons(stop.anchors_newest_m, stop.part_points_m, stop.comparisons, exact) for stop in stops
        ]
        if noise is None:
            noise, why = _no_better_than_comparisons(NoiseModel()), "there are only comparisons"
        else:
            why = "there are only comparisons, of known quality"
        return self._compare(compared, noise, why)

    def _compare(self, compared: Sequence[PlacedComparisons], model: NoiseModel, why: str) -> Inference:
        if not any(len(one.comparisons) for one in compared):
            abstained = sum(one.comparisons.abstained for one in compared)
            raise Infeasible("no pair of anchors could be compared", rows=0, abstained=abstained)
        bounds_m = bounds_about(np.vstack([one.anchors_m for one in compared]))
        return self._solve(comparison_evidence(compared, model, self.tempering), model, why, bounds_m)

    def _solve(self, evidence: PartEvidence, noise: NoiseModel, why: str, bounds_m: FloatArray) -> Inference:
        bounds_m = bounds_m if self.bounds_m is None else check_bounds(self.bounds_m)
        if self.lift_range_m is not None:
            posterior, trusted = infer_lifted(evidence, bounds_m, lifts_between(*self.lift_range_m, HEIGHT_STEP_M))
        else:
            trusted = trust(evidence, bounds_m)
            posterior = infer_pose(trusted.evidence, trusted.seen, bounds_m)
        # Comparisons leave a far part's distance open, so that bounds which the caller gives are what ends it.
        open_ended = self.bounds_m is not None and not evidence.ranges
        if not open_ended and (share := posterior.border_share(bounds_m)) > LARGEST_BORDER_SHARE:
            message = f"{share:.0%} of the probability gathers along the border of {bounds_m.tolist()} m"
            raise Infeasible(message, bounds_m=bounds_m.tolist(), border_share=share, rows=evidence.rows)
        return Inference(posterior, trusted, noise, why)

    def _infer_imaged(self, observations: Sequence[Observation], lift_range_m: tuple[float, float]) -> Inference:
        """Measure anew at each height that the part may have, and join what that tells."""
        known, found, lifts_m = replace(self, lift_range_m=None), [], []
        for lift_m in lifts_between(*lift_range_m, IMAGE_STEP_M):
            try:
                found.append(known.infer(raised(observations, float(lift_m))))
                lifts_m.append(float(lift_m))
            except Infeasible:
                continue
        if not found:
            message = f"nothing that was heard fits a part {lift_range_m[0]} to {lift_range_m[1]} m higher than stated"
            raise Infeasible(message, low_m=lift_range_m[0], high_m=lift_range_m[1])
        least_amiss = min(found, key=lambda one: (len(one.trusted.dropped), one.trusted.noise_factor))
        return replace(least_amiss, posterior=mixed([one.posterior for one in found], lifts_m))

    def _why_not_distances(self, noise: Mapping[str, NoiseModel]) -> str | None:
        if self.use != "auto":
            return None if self.use == "distances" else "asked for"
        for kind, model in noise.items():
            if not model.measures_distance:
                return (
                    f"{kind} orders the robot's {model.pairs} pairs of tags with a rank correlation of "
                    f"{model.rank_correlation:.2f}"
                )
        return None

    def _check(self) -> None:
        if self.use not in get_args(Use):
            raise InputError(f"use = {self.use!r}; one of {', '.join(get_args(Use))}", use=self.use)
        if not 0.0 < self.tempering <= 1.0:
            raise InputError(f"tempering = {self.tempering} lies outside (0, 1]", tempering=self.tempering)
        if not self.least_bias_m > 0.0:
            raise InputError(f"least_bias_m = {self.least_bias_m} is not above 0", least_bias_m=self.least_bias_m)
        if not 0.0 < self.probability < 1.0:
            raise InputError(f"probability = {self.probability} lies outside (0, 1)", probability=self.probability)
        if self.sample_count < 0:
            raise InputError(f"sample_count = {self.sample_count} is below 0", sample_count=self.sample_count)


def _can_be_imaged_anew(observations: Sequence[Observation], stops: Sequence[PlacedStop]) -> bool:
    """True if stated heights are in what was measured, and the scans are there to measure at others."""
    return all(stop.proximity is None for stop in observations) and any(stop.kind in IMAGED for stop in stops)


def _bounds_of_distances(stops: Sequence[PlacedStop], noise: Mapping[str, NoiseModel]) -> FloatArray:
    """As far about the anchors as one and a half of the median distance, and at least 3 m."""
    r_m = np.concatenate([(stop.m / noise[stop.kind].scale).ravel() for stop in stops])
    margin_m = float(np.clip(1.5 * np.nanmedian(r_m), BOUNDS_MARGIN_M, LARGEST_MARGIN_M))
    return bounds_about(np.vstack([stop.anchors_m for stop in stops]), margin_m)


def _no_better_than_comparisons(model: NoiseModel) -> NoiseModel:
    """The place of a tag is known no better than what its comparisons can tell apart."""
    return replace(model, bias_m=max(LEAST_BIAS_M, model.comparison_m))
