"""A multipath profile, and what dynamic time warping makes of it.

RF-Compass compares tags by their multipath profiles: how much power reaches a sliding antenna from each angle.
Warping (DTW) forgives stretched profiles. Unbounded, it also forgives the shift of the peak, and in line of
sight the place of the peak is all that tells two tags apart.

You will see, for tags 20 and 60 cm from the first one, that free warping finds both about equally near, that a
10 degree band does not, and what unwrapped phase says; and get `profiles.png`. Takes 10 s the first time.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from rfcompass import Scan
from rfcompass.recordings import AntennaPoses, Trace, TraceMeta, reads_table
from rfcompass.rf import AngularProfile, PhaseRmsMeter, PinItDtwMeter
from rfcompass.simulation import SweepScene, simulate_sweep

NAMES = ("tag at 0.2 m", "tag at 0.4 m", "tag at 0.8 m")


def listen(fast: bool) -> Scan:
    """Let a simulated reader slide 1 m along three tags, 0.7 m away, a wall behind them."""
    rail_m = np.column_stack([np.linspace(0.0, 1.0, 30 if fast else 60), *np.zeros((2, 30 if fast else 60))])
    scene = SweepScene(
        tags_m={name: np.array([x_m, 0.7, 0.0]) for name, x_m in zip(NAMES, (0.2, 0.4, 0.8), strict=True)},
        antenna_positions_m=rail_m,
        frequencies_hz=np.array([920.625e6]),
    )
    reads = simulate_sweep(scene, np.random.default_rng(4))
    return Trace(TraceMeta(frame="rail", dimensions=2), reads_table(reads), AntennaPoses.along(rail_m)).scan()


def main(fast: bool = False, out: Path = Path("runs/01_profiles")) -> dict[str, float]:
    """Compare the three tags; return m(first, far) / m(first, near) for each meter: above 1 is right."""
    scan = listen(fast)
    meters = {
        "PinIt, free warp": PinItDtwMeter(),
        "PinIt, 10° band": PinItDtwMeter(band_rad=np.radians(10.0)),
        "phase along the path": PhaseRmsMeter(),
    }
    ratios = {}
    print("m(0.2, 0.8) / m(0.2, 0.4); the tags are 60 and 20 cm apart")
    for name, meter in meters.items():
        m = meter.measure(scan, anchors=NAMES).anchor_m
        ratios[name] = float(m[0, 2] / m[0, 1])
        print(f"  {name:<22} {ratios[name]:5.2f}")

    profile = AngularProfile()
    figure = Figure(figsize=(8, 4), layout="constrained")
    axes = figure.add_subplot()
    for name in NAMES:
        axes.plot(np.degrees(profile.angles_rad()), profile.of(scan.trace(name))[0], label=name)
    axes.set_xlabel("angle to the antenna's path [deg]")
    axes.set_ylabel("power, mean = 1")
    axes.legend(frameon=False)
    out.mkdir(parents=True, exist_ok=True)
    figure.savefig(out / "profiles.png", dpi=80 if fast else 150)
    print(f"picture: {out / 'profiles.png'}")
    return ratios


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
