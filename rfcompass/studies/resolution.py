"""Study: how fine do comparisons cut the plane, move by move [Wang2013], Fig. 7 and 8?

Six tags on the robot, two on the part, no radio: comparisons are exact, or a share of them is flipped, wherever it
falls. One trial makes ten stops and asks three methods after 1, 2, 3, 5, 7 and 10 of them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import NoAnswer
from rfcompass.evaluation.metrics import angle_error_rad
from rfcompass.evaluation.records import MetricValue
from rfcompass.geometry.pose2 import Pose2
from rfcompass.localization import (
    ComparedStop,
    ConsistencyLocalizer,
    NoiseModel,
    PartitionLocalizer,
    PosteriorLocalizer,
    compare_proximities,
)
from rfcompass.recordings import PartDatabase
from rfcompass.robots import Robot, YouBot
from rfcompass.studies.error_pictures import draw_resolution
from rfcompass.studies.hand_moves import SWEEP, HandMoves, on_body
from rfcompass.studies.metric import Metric
from rfcompass.studies.study import Cell, PaperValue, Study
from rfcompass.types.comparisons import Comparisons
from rfcompass.types.configuration import Configuration

TAGS = 2
DISC_M = 0.25  # [Wang2013], section 6.2: the part is within 25 cm of the hand
PRIOR_M = 0.30  # ours: every method is told that the part lies in a box of twice this side about the first hand pose
AFTER = (1, 2, 3, 5, 7, 10)
THREE = ("median", "p10", "p90")
METHODS = ("paper", "consistency", "posterior")
# Layout and policy. The full grid would tell little more.
ARMS = {
    "skew, sweep": ("skew6", "sweep"),
    "skew, random": ("skew6", "random"),
    "skew, active": ("skew6", "active"),
    "from the text, sweep": ("text6", "sweep"),
    "from the text, active": ("text6", "active"),
    "designed, sweep": ("designed6", "sweep"),
    "designed, active": ("designed6", "active"),
}
MAIN_ARM = "skew, sweep"
SIDE_SEEDS = 1200  # the other arms stop there
SURE = NoiseModel(comparison_m=0.002, lapse=0.01, bias_m=0.002)  # of exact comparisons; a posterior wants some doubt
HAND_M = np.array(SWEEP[0][:2])


@dataclass(slots=True)
class Measured:
    """Stops made so far, and what the posterior makes of them; holds no truth.

    Attributes:
        noise: What comparisons are worth, as if the robot's own tags had told.
        configurations: Where the robot was; base poses in the frame of the first.
        stops: What was compared there, as if that stop were the newest.
    """

    noise: NoiseModel
    configurations: list[Configuration] = field(default_factory=list)
    stops: list[ComparedStop] = field(default_factory=list)

    def in_newest_frame(self) -> list[ComparedStop]:
        """All stops, placed in the newest base frame."""
        T_newest_first = self.configurations[-1].base.inverse()
        return [
            replace(stop, T_newest_stop=T_newest_first @ one.base)
            for stop, one in zip(self.stops, self.configurations, strict=True)
        ]

    def bounds_m(self) -> FloatArray:
        """Box about the first hand pose in the newest base frame [m], shape (2, 2)."""
        centre_m = self.configurations[-1].base.inverse().apply(HAND_M)
        return np.column_stack([centre_m - PRIOR_M, centre_m + PRIOR_M])

    def poses(self) -> FloatArray:
        """Samples of the posterior, for choosing the next stop; of the prior where it has no answer."""
        bounds_m = self.bounds_m()
        try:
            found = _posterior(bounds_m).infer_from_comparisons(self.in_newest_frame(), self.noise)
        except NoAnswer:
            rng = np.random.default_rng(0)
            places_m = rng.uniform(bounds_m[:, 0], bounds_m[:, 1], (200, 2))
            return np.column_stack([places_m, rng.uniform(-np.pi, np.pi, 200)])
        return found.posterior.samples(200)


def resolution_trial(cell: Cell, seed: int, rng: np.random.Generator) -> Mapping[str, MetricValue]:  # noqa: ARG001
    """Make ten stops; ask every method after some of them."""
    layout, policy = ARMS[str(cell["arm"])]
    flips, robot, points_m = float(cell["flips"] or 0.0), robot_with(layout), part_points_m()
    truth = draw_part(points_m, rng)
    measured = Measured(replace(SURE, lapse=max(SURE.lapse, 2.0 * flips)))
    moves = HandMoves(robot, policy, points_m, measured.noise)
    found: dict[str, MetricValue] = {}
    for count, now in enumerate(moves.configurations(truth, measured, rng), start=1):
        measured.configurations.append(now)
        measured.stops.append(compare_at(robot, now, truth, points_m, flips, rng))
        if count in AFTER:
            T_newest_part = now.base.inverse() @ truth
            for method in METHODS:
                found |= _judged(method, measured, T_newest_part, count)
        if count == AFTER[-1]:
            return found
    return found


@cache
def robot_with(layout: str) -> Robot:
    """The youBot with six tags."""
    return YouBot(layout)


@cache
def part_points_m() -> FloatArray:
    """The leg's two tags: x, y in the part frame, z over the floor [m], shape (2, 3)."""
    part = PartDatabase(":memory:").part("table_leg_3")
    return part.layout(TAGS).points_m + np.array([0.0, 0.0, part.resting_height_m])


def draw_part(points_m: FloatArray, rng: np.random.Generator) -> Pose2:
    """Lay the part within 25 cm of the hand, turned anyhow, not under the robot."""
    while True:
        radius_m, angle_rad = DISC_M * np.sqrt(rng.uniform()), rng.uniform(-np.pi, np.pi)
        x_m, y_m = HAND_M + radius_m * np.array([np.cos(angle_rad), np.sin(angle_rad)])
        pose = Pose2(float(x_m), float(y_m), float(rng.uniform(-np.pi, np.pi)))
        if not on_body(pose, points_m):
            return pose


def compare_at(
    robot: Robot, now: Configuration, truth: Pose2, points_m: FloatArray, flips: float, rng: np.random.Generator
) -> ComparedStop:
    """Compare all pairs of robot tags at one stop, and flip a share of the answers.

    Args:
        robot: The robot.
        now: Where it is; base pose in the frame of `truth`.
        truth: Where the part is.
        points_m: Tags of the part [m], shape (K, 3).
        flips: Probability that an answer is the other way round.
        rng: Source of the flips.
    """
    anchors_m = robot.tag_positions(now).points_m
    tags_m = (now.base.inverse() @ truth).apply(points_m)
    exact = compare_proximities(np.linalg.norm(tags_m[:, None] - anchors_m[None], axis=2))
    flip = rng.uniform(size=len(exact)) < flips
    nearer, farther = np.where(flip, exact.farther, exact.nearer), np.where(flip, exact.nearer, exact.farther)
    return ComparedStop(anchors_m, points_m, Comparisons(exact.target, nearer, farther, exact.margin))


def _posterior(bounds_m: FloatArray) -> PosteriorLocalizer:
    return PosteriorLocalizer(use="comparisons", tempering=1.0, bounds_m=bounds_m, sample_count=200)


def _judged(method: str, measured: Measured, truth: Pose2, count: int) -> Mapping[str, MetricValue]:
    """Errors of one method after so many stops; None where it has no answer."""
    names = (f"{method}_centre_{count}_m", f"{method}_theta_{count}_rad")
    try:
        centre_m, theta_rad = _asked(method, measured)
    except NoAnswer:
        return dict.fromkeys(names)
    off_m = float(np.linalg.norm(centre_m - truth.translation_m))
    off_rad = None if theta_rad is None else float(angle_error_rad([theta_rad], truth.theta_rad)[0])
    return dict(zip(names, (off_m, off_rad), strict=True))


def _asked(method: str, measured: Measured) -> tuple[FloatArray, float | None]:
    bounds_m, stops = measured.bounds_m(), measured.in_newest_frame()
    if method == "posterior":
        posterior = _posterior(bounds_m).infer_from_comparisons(stops, measured.noise).posterior
        return posterior.mean_m, posterior.theta_rad
    localizer = (PartitionLocalizer if method == "paper" else ConsistencyLocalizer)(bounds_m=bounds_m)
    fit = localizer.fit(stops)
    return fit.z[:2], fit.theta_rad


def _metrics() -> tuple[Metric, ...]:
    found = []
    for method in METHODS:
        for count in AFTER:
            shown = f"{method} after {count}"
            found += [
                Metric(f"{method}_centre_{count}_m", THREE, "float", f"{shown}: centre", "cm", 100.0),
                Metric(f"{method}_theta_{count}_rad", ("median", "p90"), "float", f"{shown}, θ", "°", 180.0 / np.pi),
            ]  # fmt: skip
    return tuple(found)


def _figure_8(metric: str, summary: str, value: float) -> PaperValue:
    differs = "number of moves, policy and tag places are not printed"
    return PaperValue(metric, summary, value, "[Wang2013] Fig. 8", differs, {"arm": MAIN_ARM, "flips": 0.1})


RESOLUTION = Study(
    name="resolution",
    title="How fine do comparisons cut the plane?",
    kind="simulated",
    factors={"flips": (0.0, 0.1), "arm": tuple(ARMS)},
    seeds=range(1000, 2000),
    tuning_seeds=range(20),
    trial=resolution_trial,
    metrics=_metrics(),
    paper=(
        PaperValue(
            "paper_centre_1_m", "median", 0.04, "[Wang2013] Fig. 7, read off", "policy and tag places are not printed",
            {"arm": MAIN_ARM, "flips": 0.0},
        ),
        _figure_8("consistency_centre_7_m", "median", 0.0096),
        _figure_8("consistency_centre_7_m", "p90", 0.025),
        _figure_8("consistency_theta_7_rad", "median", float(np.radians(3.1))),
        _figure_8("consistency_theta_7_rad", "p90", float(np.radians(10.0))),
    ),
    applies=lambda cell, seed: cell["arm"] == MAIN_ARM or seed < SIDE_SEEDS,
    note=(
        "Six robot tags, two part tags, no odometry error. Comparisons are exact, or flipped at random wherever they "
        "fall; a radio errs on near ties. Every method is told the first hand pose, within 30 cm. `paper` is Eq. 8 "
        "with the schedule of ε and the analytic centre; `consistency` is what the paper calls the aim of outlier "
        "rejection; `posterior` uses comparisons only, and is told what share of them is wrong. A run without an "
        "answer has no error."
    ),
    draws=draw_resolution,
)  # fmt: skip
