"""A part that lies higher than stated, on the physical channel: what near-field images make of it.

The scenes of `posterior_calibration` in the furnished room, K = 4, one stop, metal on. The part is stated to lie 25 cm
lower than it does, and may lie up to 30 cm higher than stated. Beside each other, from the same reads: the height
known; the statement believed; images made anew at every height (`lift_range_m` with scans); images of the stated plane
only, then searched at every height (`lift_range_m` with ready-made proximities). For each the share of 90 % sets of
poses, and of regions of the centre, that hold the truth; radius of a disc as large as the region; error of the centre,
median and 90 %; the lift that it believes in, and its standard deviation, medians.

Seeds 1000 and on. Run `python -m benchmarks.unknown_height --tracks near`; about 10 s a seed.
"""

import argparse
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from benchmarks.posterior_calibration import scans_of
from rfcompass.errors import NoAnswer
from rfcompass.geometry import Pose2, polygon_area_m2, polygon_contains
from rfcompass.localization import PosteriorLocalizer, measure_proximities
from rfcompass.rf import meter
from rfcompass.types import Observation, Scan

LIFT_M, RANGE_M = 0.25, (0.0, 0.3)
EAR = meter("sar_nearfield")
Row = tuple[bool, bool, float, float, float, float]


def judged(localizer: PosteriorLocalizer, stops: Sequence[Observation], truth: Pose2) -> Row | None:
    """Whether pose and centre are held, radius and error [m], lift and its deviation [m]; None without an answer."""
    try:
        posterior = localizer.infer(stops).posterior
    except NoAnswer:
        return None
    region_m = posterior.region(0.9)
    return (
        posterior.level(truth) <= 0.9,
        bool(polygon_contains(region_m, truth.translation_m[None])[0]),
        float(np.sqrt(polygon_area_m2(region_m) / np.pi)),
        float(np.hypot(*(posterior.mean_m - truth.translation_m))),
        posterior.mean_lift_m,
        posterior.lift_sd_m,
    )


def rows_of(seed: int, near: bool) -> dict[str, Row | None]:
    """What each makes of one scene."""
    stops, truth = scans_of(seed, "room_los", "usrp", near, True, 4)
    stops = stops[:1]
    low = [replace(one, part_tag_heights_m=one.part_tag_heights_m - LIFT_M) for one in stops]
    ready = [replace(one, proximity=measure_proximities(one, EAR), scan=Scan()) for one in low]
    known, free = PosteriorLocalizer(meter=EAR), PosteriorLocalizer(meter=EAR, lift_range_m=RANGE_M)
    return {
        "height known": judged(known, stops, truth),
        "statement believed": judged(known, low, truth),
        "images at every height": judged(free, low, truth),
        "images of the stated plane": judged(free, ready, truth),
    }


def line(name: str, found: Sequence[Row | None]) -> str:
    """One row of the table."""
    poses, centres, radius, error, lift, sd = np.array([one for one in found if one is not None], dtype=float).T
    return (
        f"{name}: poses {poses.mean():.2f}, centres {centres.mean():.2f}, radius {100 * np.median(radius):.1f} cm, "
        f"error {100 * np.median(error):.2f} / {100 * np.percentile(error, 90):.2f} cm, "
        f"lift {100 * np.median(lift):.1f} +- {100 * np.median(sd):.1f} cm, "
        f"{len(found) - len(poses)} of {len(found)} without answer"
    )


def main(argv: Sequence[str] | None = None) -> int:
    """Print the rows for one kind of track."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tracks", choices=("near", "far"), default="near")
    parser.add_argument("--seeds", type=int, default=40, help="how many, from 1000")
    chosen = parser.parse_args(argv)
    found = [rows_of(1000 + n, chosen.tracks == "near") for n in range(chosen.seeds)]
    for name in found[0]:
        print(line(name, [rows[name] for rows in found]))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
