"""Wrong comparisons: one answer in ten is the other way round, as in Fig. 8 of RF-Compass.

Six tags on the robot, two on the part; the hand goes to seven places. The convex program of the paper needs all rows to
hold and can only drop those with the smallest margin; flipped rows have any. The pose that meets the most rows, and the
posterior, in which any answer may be wrong, live with them.

You will see what each of three methods answers after one, three and seven stops, and get `wrong.png`. Takes 5 s.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from rfcompass.errors import NoAnswer
from rfcompass.localization import ConsistencyLocalizer, PartitionLocalizer, PosteriorLocalizer, bounds_about
from rfcompass.studies.hand_moves import sweep_configurations
from rfcompass.studies.resolution import compare_at, draw_part, part_points_m, robot_with

FLIPS, STOPS = 0.1, (1, 3, 7)
PRIOR_M = bounds_about(np.array([[0.42, 0.0, 0.0]]), 0.3)  # the part is somewhere about the hand
METHODS = {
    "partition": PartitionLocalizer(bounds_m=PRIOR_M),
    "consistency": ConsistencyLocalizer(bounds_m=PRIOR_M),
    "posterior": PosteriorLocalizer(use="comparisons", bounds_m=PRIOR_M),
}


def main(fast: bool = False, out: Path = Path("runs/10_wrong")) -> dict[str, list[float]]:
    """Ask all methods after some stops; return their errors [cm], NaN for no answer."""
    rng, robot, points_m = np.random.default_rng(8), robot_with("skew6"), part_points_m()
    truth = draw_part(points_m, rng)
    stops = [compare_at(robot, now, truth, points_m, FLIPS, rng) for now in sweep_configurations(robot)[: STOPS[-1]]]
    errors_cm: dict[str, list[float]] = {name: [] for name in METHODS}
    for count in STOPS:
        wrong = sum(int((~stop.satisfied(truth, 0.0)).sum()) for stop in stops[:count])
        total = sum(len(stop.comparisons) for stop in stops[:count])
        print(f"{count} stop(s): {wrong} of {total} comparisons are wrong")
        for name, method in METHODS.items():
            try:
                fit = method.fit(stops[:count])
                errors_cm[name].append(100 * float(np.linalg.norm(fit.z[:2] - truth.translation_m)))
                called = f", calls {len(fit.outliers)} comparisons wrong" if name == "consistency" else ""
                print(f"  {name:<12} {errors_cm[name][-1]:5.1f} cm off{called}")
            except NoAnswer as failure:
                errors_cm[name].append(np.nan)
                print(f"  {name:<12} no answer: {failure.message.split(';')[0]}")
    figure = Figure(figsize=(6, 4), layout="constrained")
    axes = figure.add_subplot()
    for name, errors in errors_cm.items():
        axes.plot(STOPS, errors, "o-", label=name)
    axes.set(
        xlabel="stops of the hand", ylabel="centre error [cm]", title="One comparison in ten is wrong", ylim=(0, None)
    )
    axes.legend()
    out.mkdir(parents=True, exist_ok=True)
    figure.savefig(out / "wrong.png", dpi=80 if fast else 150)
    print(f"picture: {out / 'wrong.png'}")
    return errors_cm


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
