"""How often the posterior's 90 % regions hold the part on the physical channel, and how large they are.

Nine robot tags (the default layout), K tags on the leg, furnished room, near-field images. The hand goes to five places
over the part while the base stands. Near tracks are two legs of 3 m, 1.2 m from where the part is believed to be, which
is known to 15 cm. For one, three and five stops: share of sets of poses (x, y, θ), and of regions of the centre, that
hold the truth, with the 95 % interval of Clopper and Pearson, and BELOW or ABOVE where all of it lies beside the 88 to
98 % that are aimed at; radius of a disc as large as the region; error of the centre, median and 90 %; median error of
θ, if all scenes tell one.
Then the same errors of the other localizers on the same scans, after one and three stops.

Seeds 1000 to 1059 are reported, to 1199 for some cells; 0 to 59 were used while the posterior was made.
Run `python -m benchmarks.posterior_calibration --tracks near --tags 4`; about three minutes for each number of tags.
"""

import argparse
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from planners.hand_over import hand_over
from rfcompass.errors import NoAnswer
from rfcompass.evaluation.metrics import angle_error_rad
from rfcompass.evaluation.statistics import exact_interval
from rfcompass.geometry import Pose2, polygon_area_m2, polygon_contains
from rfcompass.interfaces import Localizer
from rfcompass.localization import (
    ConsistencyLocalizer,
    NearestTagLocalizer,
    PartitionLocalizer,
    PosteriorLocalizer,
    SarLocalizer,
    measure_proximities,
)
from rfcompass.localization.noise_model import LEAST_BIAS_M
from rfcompass.rf import meter
from rfcompass.simulation import RIG_PAPER, PlaneRoom, Scatterers, SimulatedRobot
from rfcompass.simulation.radio_sensing import Leg
from rfcompass.simulation.reader_noise import NOISES
from rfcompass.studies.comparisons import robot_and_part
from rfcompass.studies.radio_scan import HAND_HEIGHT_M, HAND_M, room_with_hand_over_part
from rfcompass.studies.radio_setup import RadioSetup
from rfcompass.studies.study import trial_rng
from rfcompass.types import Observation, Scan

SWEEP = (
    (0.0, 0.0, 0.0), (-0.02, -0.12, np.pi / 3), (0.02, 0.12, -np.pi / 3), (0.03, 0.0, np.pi / 2),
    (-0.03, -0.12, -np.pi / 3),
)  # fmt: skip
AFTER = (1, 3, 5)
AIM = (0.88, 0.98)  # of what claims 90 %
OTHERS: dict[str, Localizer] = {
    "posterior": PosteriorLocalizer(),
    "sar": SarLocalizer(),
    "consistency": ConsistencyLocalizer(),
    "partition": PartitionLocalizer(centre="centroid"),
    "posterior of comparisons": PosteriorLocalizer(use="comparisons"),
    "nearest_tag": NearestTagLocalizer(),
}
Judged = tuple[bool, bool, float, float, float]


def stops_of(
    seed: int, scene: str, noise: str, near: bool, metal: bool, tags: int, stops: int = AFTER[-1]
) -> tuple[list[Observation], Pose2]:
    """Stops with their proximities, and where the part truly lies in the base frame."""
    ear = meter("sar_nearfield")
    heard, truth = scans_of(seed, scene, noise, near, metal, tags, stops)
    return [replace(one, proximity=measure_proximities(one, ear), scan=Scan()) for one in heard], truth


def scans_of(
    seed: int, scene: str, noise: str, near: bool, metal: bool, tags: int, stops: int = AFTER[-1]
) -> tuple[list[Observation], Pose2]:
    """The first of five stops with what was read at each, and where the part truly lies in the base frame."""
    rng, (robot, part) = trial_rng("posterior", seed), robot_and_part()
    room = room_with_hand_over_part(rng)
    radio = RadioSetup(scene=scene, rig=replace(RIG_PAPER, noise=NOISES[noise]))
    if near:
        radio = replace(radio, legs_m=near_legs(room, rng))
    sensor = radio.sensor(room, robot.layout, part.layout(tags), rng)
    if not metal:
        sensor = replace(sensor, body=Scatterers.none())
    start, heard = robot.posture("scan"), []
    joints = [
        hand_over(robot, start, np.array([HAND_M[0] + dx, HAND_M[1] + dy, HAND_HEIGHT_M]), yaw).joints
        for dx, dy, yaw in SWEEP
    ]
    device = SimulatedRobot(robot, part, part.layout(tags), room, rng, joints[0], sensor)
    for posture in joints[:stops]:
        device.move_arm(posture)
        heard.append(device.scan())
    return heard, device.true_pose_in_base()


def near_legs(room: PlaneRoom, rng: np.random.Generator) -> Sequence[Leg]:
    """Two legs of 3 m at right angles, 1.2 m from where the part is believed to be, inside the room."""
    x, y = room.T_room_part.translation_m + 0.15 * rng.normal(size=2)
    across, along = np.clip(x, 2.0, 4.0), np.clip(y, 1.9, 3.1)
    return (
        ((across - 1.5, y - 1.2, 0.3), (across + 1.5, y - 1.2, 0.3)),
        ((x - 1.2, along - 1.5, 0.3), (x - 1.2, along + 1.5, 0.3)),
    )


def judged(stops: Sequence[Observation], truth: Pose2, localizer: PosteriorLocalizer | None = None) -> Judged | None:
    """Whether pose and centre are held, radius and error of the centre [m], error of θ [rad]; None without answer."""
    try:
        posterior = (localizer or PosteriorLocalizer()).infer(stops).posterior
    except NoAnswer:
        return None
    region_m, theta_rad = posterior.region(0.9), posterior.theta_rad
    turned = np.nan if theta_rad is None else float(np.asarray(angle_error_rad(theta_rad, truth.theta_rad)))
    return (
        posterior.level(truth) <= 0.9,
        bool(polygon_contains(region_m, truth.translation_m[None])[0]),
        float(np.sqrt(polygon_area_m2(region_m) / np.pi)),
        float(np.hypot(*(posterior.mean_m - truth.translation_m))),
        turned,
    )


def line(name: str, found: Sequence[Judged | None]) -> str:
    """One row of the table."""
    poses, centres, radius, error, turned = np.array([one for one in found if one is not None], dtype=float).T
    theta = f"{np.degrees(np.median(turned)):.1f}°" if np.isfinite(turned).all() else "-"
    return (
        f"{name}: poses {share(poses)}, centres {share(centres)}, radius {100 * np.median(radius):.1f} cm, "
        f"error {100 * np.median(error):.2f} / {100 * np.percentile(error, 90):.2f} cm, {theta}, "
        f"{len(found) - len(poses)} of {len(found)} without answer"
    )


def share(held: Sequence[float]) -> str:
    """A share with its 95 % interval, and whether all of that lies beside the aim."""
    within = exact_interval(int(np.sum(held)), len(held))
    verdict = " BELOW" if within.high < AIM[0] else " ABOVE" if within.low > AIM[1] else ""
    return f"{np.mean(held):.3f} ({within.low:.3f} … {within.high:.3f}){verdict}"


def beside(localizer: Localizer, scenes: Sequence[tuple[Sequence[Observation], Pose2]]) -> str:
    """Centre errors of one localizer, median / 90 %, and how often it has no answer."""
    errors_m = []
    for stops, truth in scenes:
        try:
            errors_m.append(float(np.hypot(*(localizer.estimate(stops).centre_m - truth.translation_m))))
        except NoAnswer:
            continue
    median, late = 100 * np.percentile(errors_m, [50, 90])
    return f"{median:.1f} / {late:.1f} cm, {len(scenes) - len(errors_m)} of {len(scenes)} without answer"


def main(argv: Sequence[str] | None = None) -> int:
    """Print the rows for one kind of track and one number of tags."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scene", default="room_los")
    parser.add_argument("--noise", choices=list(NOISES), default="usrp", help="what the reader adds")
    parser.add_argument("--tracks", choices=("near", "far"), default="near")
    parser.add_argument("--tags", type=int, choices=(1, 2, 4), default=4)
    parser.add_argument("--no-metal", action="store_true", help="a robot that does not scatter")
    parser.add_argument("--seeds", type=int, default=60, help="how many, from 1000")
    parser.add_argument("--stops", type=int, choices=AFTER, default=AFTER[-1], help="stop there")
    parser.add_argument("--floor-mm", type=float, default=1e3 * LEAST_BIAS_M, help="floor of the bias")
    parser.add_argument("--alone", action="store_true", help="without the other localizers")
    chosen = parser.parse_args(argv)
    near, metal = chosen.tracks == "near", not chosen.no_metal
    ours = PosteriorLocalizer(least_bias_m=1e-3 * chosen.floor_mm)
    scenes = [
        stops_of(1000 + n, chosen.scene, chosen.noise, near, metal, chosen.tags, chosen.stops)
        for n in range(chosen.seeds)
    ]
    after = [count for count in AFTER if count <= chosen.stops]
    for count in after:
        print(line(f"{count} stops", [judged(stops[:count], truth, ours) for stops, truth in scenes]), flush=True)
    for count in () if chosen.alone else after[:2]:
        for name, localizer in OTHERS.items():
            print(f"{count} stops, {name}: {beside(localizer, [(stops[:count], truth) for stops, truth in scenes])}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
