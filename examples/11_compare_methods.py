"""Compare methods: the same reads, near and far, for every way to find a part.

A furnished room, nine tags on the robot, four on the leg, three stops with the hand over it. Once the antenna goes
along two walls, once along an L about the part. All methods hear the same; what differs is what they make of it.

You will see the centre's error of each, with the posterior's own idea of it, and get `methods.png`. Takes 10 s.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from rfcompass.errors import NoAnswer
from rfcompass.localization import ConsistencyLocalizer, PartitionLocalizer, PosteriorLocalizer
from rfcompass.studies.accuracy import RIGS, stops_over_part

METHODS = {
    "partition, ε schedule": PartitionLocalizer(centre="centroid"),
    "consistency": ConsistencyLocalizer(),
    "posterior, comparisons": PosteriorLocalizer(use="comparisons"),
    "posterior, distances": PosteriorLocalizer(),
}
SEED = 7


def main(fast: bool = False, out: Path = Path("runs/11_methods")) -> dict[str, dict[str, float]]:
    """Locate one part by all methods from far and near tracks; return the errors [cm], NaN for no answer."""
    found: dict[str, dict[str, float]] = {}
    for rig in ("far L", "near L"):
        stops = stops_over_part(RIGS[rig], "room_los", 4, np.random.default_rng(SEED))
        found[rig] = {}
        for name, method in METHODS.items():
            try:
                estimate = method.estimate(stops.observations)
            except NoAnswer as failure:
                found[rig][name] = np.nan
                print(f"{rig:<7} {name:<23} no answer: {failure.message.split(';')[0]}")
                continue
            found[rig][name] = 100 * float(np.linalg.norm(estimate.centre_m - stops.truths[-1].translation_m))
            sd_cm = 100 * np.sqrt(np.trace(estimate.covariance[:2, :2])) if estimate.probability else np.nan
            own = f" (says {sd_cm:.1f})" if np.isfinite(sd_cm) else ""
            print(f"{rig:<7} {name:<23} {found[rig][name]:5.1f} cm off{own}")
    figure = Figure(figsize=(7, 4), layout="constrained")
    axes = figure.add_subplot()
    for shift, (rig, errors) in zip((-0.2, 0.2), found.items(), strict=True):
        axes.bar(np.arange(len(METHODS)) + shift, list(errors.values()), 0.4, label=rig)
    axes.set_xticks(range(len(METHODS)), METHODS, rotation=15)
    axes.set(ylabel="centre error [cm]", title="One part, the same reads for all methods")
    axes.legend()
    out.mkdir(parents=True, exist_ok=True)
    figure.savefig(out / "methods.png", dpi=80 if fast else 150)
    print(f"picture: {out / 'methods.png'}")
    return found


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
