"""How well the part is located from comparisons alone, near tracks, three stops, by ways to move and to estimate.

The world of `study run accuracy`, in sight, "near L": nine robot tags, K on the part, robot's metal, wheels that slip.
`sweep` are the three hand places of the study, `active` the stops that tell most under the posterior of comparisons,
out of 70, half of them after a short drive. Ways to estimate: the posterior with the power γ of a comparison's
likelihood at 1/2, as shipped, and at 1; the pose that meets the most comparisons; the posterior of distances, for which
the same scans are enough. Prints the error of the centre, median / 90 %, and the median of θ if every trial tells one.

Run `python -m benchmarks.comparisons_only --tags 2`; about two minutes. Seeds from 1000; nothing was tuned.
"""

import argparse
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from planners.hand_stops import HandStops
from planners.next_stop import choose_next_stop
from rfcompass.arrays import FloatArray
from rfcompass.errors import NoAnswer
from rfcompass.evaluation.metrics import angle_error_rad
from rfcompass.geometry import Pose2
from rfcompass.interfaces import Localizer
from rfcompass.localization import (
    ConsistencyLocalizer,
    NoiseModel,
    PosteriorLocalizer,
    bounds_about,
    measure_proximities,
    noise_of,
)
from rfcompass.rf import meter
from rfcompass.simulation import SimulatedRobot
from rfcompass.studies.accuracy import NUDGE, STOPS, _legs_m, leg, youbot
from rfcompass.studies.hand_moves import HAND_HEIGHT_M, sweep_configurations
from rfcompass.studies.radio_scan import HAND_M, room_with_hand_over_part
from rfcompass.studies.radio_setup import DRIVE_AREA_M, RadioSetup
from rfcompass.studies.study import trial_rng
from rfcompass.types import Configuration, Observation

POLICIES = ("sweep", "active")
PRIOR_M = 0.35  # as in the study: the part is near the hand of the first stop
POSES = 200
Trial = tuple[list[Observation], Pose2]


def trial(policy: str, tags: int, seed: int) -> Trial:
    """Three stops with their proximities, and where the part is from the last of them."""
    rng, robot, part, ear = trial_rng("accuracy", seed), youbot("x4"), leg(), meter("sar_nearfield")
    room, layout = room_with_hand_over_part(rng), part.layout(tags)
    radio = RadioSetup(scene="room_los", legs_m=_legs_m("near", room.T_room_part, rng))
    sensor, now = radio.sensor(room, robot.layout, layout, rng), sweep_configurations(robot)[0]
    device = SimulatedRobot(robot, part, layout, room, rng, now.joints, sensor, area_m=DRIVE_AREA_M)
    heard: list[Observation] = []
    for index in range(STOPS):
        if index:
            wanted = _next(policy, index, now, heard)
            device.move_base(now.base.inverse() @ wanted.base)
            device.move_arm(wanted.joints)
            now = wanted
        scan = device.scan()
        heard.append(replace(scan, proximity=measure_proximities(scan, ear)))
    return heard, device.true_pose_in_base()


def _next(policy: str, index: int, now: Configuration, heard: Sequence[Observation]) -> Configuration:
    """Where to stand next, told from what was heard."""
    robot = youbot("x4")
    if policy == "sweep":
        nudge = NUDGE if index % 2 else NUDGE.inverse()
        return replace(sweep_configurations(robot)[index], base=now.base @ nudge)
    points_m = np.column_stack([heard[-1].part.points_m[:, :2], heard[-1].part_tag_heights_m])
    poses, noise = _known(heard)
    proposer = HandStops(robot=robot, height_m=HAND_HEIGHT_M)
    return choose_next_stop(robot, now, proposer, poses, points_m, noise).configuration


def _known(heard: Sequence[Observation]) -> tuple[FloatArray, NoiseModel]:
    """Poses in question under the comparisons so far, or all that were possible where these give no answer."""
    bounds_m = _bounds_m(heard)
    try:
        estimate = PosteriorLocalizer(use="comparisons", bounds_m=bounds_m, sample_count=POSES).estimate(heard)
    except NoAnswer:
        rng = np.random.default_rng(0)
        places_m = rng.uniform(bounds_m[:, 0], bounds_m[:, 1], (POSES, 2))
        return np.column_stack([places_m, rng.uniform(-np.pi, np.pi, POSES)]), NoiseModel()
    return estimate.samples, noise_of(estimate) or NoiseModel()


def _bounds_m(heard: Sequence[Observation]) -> FloatArray:
    """Box about the hand of the first stop, from the base of the last one."""
    hand_m = (heard[-1].base_pose.inverse() @ heard[0].base_pose).apply(np.array([[*HAND_M, 0.0]]))
    return bounds_about(hand_m, PRIOR_M)


def _localizers(bounds_m: FloatArray) -> dict[str, Localizer]:
    return {
        "posterior, γ = 1/2": PosteriorLocalizer(use="comparisons", bounds_m=bounds_m),
        "posterior, γ = 1": PosteriorLocalizer(use="comparisons", bounds_m=bounds_m, tempering=1.0),
        "consistency": ConsistencyLocalizer(bounds_m=bounds_m),
        "distances": PosteriorLocalizer(bounds_m=bounds_m),
    }


def errors(trials: Sequence[Trial]) -> dict[str, FloatArray]:
    """Errors of centre [m] and θ [rad] of each way to estimate, NaN where there is none, shape (T, 2)."""
    found: dict[str, list[tuple[float, float]]] = {}
    for heard, truth in trials:
        for name, localizer in _localizers(_bounds_m(heard)).items():
            found.setdefault(name, []).append(_error(localizer, heard, truth))
    return {name: np.array(rows) for name, rows in found.items()}


def _error(localizer: Localizer, heard: Sequence[Observation], truth: Pose2) -> tuple[float, float]:
    try:
        estimate = localizer.estimate(heard)
    except NoAnswer:
        return np.nan, np.nan
    turned = np.nan if estimate.theta_rad is None else float(angle_error_rad(estimate.theta_rad, truth.theta_rad))
    return float(np.hypot(*(estimate.centre_m - truth.translation_m))), turned


def main(argv: Sequence[str] | None = None) -> int:
    """Print a line for each way to move and to estimate."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tags", type=int, choices=(1, 2, 3, 4), default=2)
    parser.add_argument("--seeds", type=int, default=30, help="how many, from 1000")
    chosen = parser.parse_args(argv)
    for policy in POLICIES:
        trials = [trial(policy, chosen.tags, 1000 + n) for n in range(chosen.seeds)]
        for name, off in errors(trials).items():
            median, late = 100.0 * np.nanpercentile(off[:, 0], [50, 90])
            theta = f"{np.degrees(np.median(off[:, 1])):.1f}°" if np.isfinite(off[:, 1]).all() else "-"
            missing = int(np.isnan(off[:, 0]).sum())
            print(f"{policy}, {name}: {median:.1f} / {late:.1f} cm, {theta}, {missing} without answer", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
