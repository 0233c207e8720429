"""Grasp trials from your own errors: which hand is wide enough for what your localiser does?

A hand goes where the part is believed to be. Each attempt draws one of your errors, position and orientation together,
and asks three rules whether the part would be held: the hand's own geometry, |e| <= (G - w)/2 and |e| <= G - w.

    python examples/15_grasp_trials.py my_errors.csv      # columns: docs/grasp_trials.md

You will see attempts and chances for four hands, and which c of |e| <= c (G - w) the geometry is worth, and get
`attempts.png`. Without a file the example makes one up, `errors.csv`, of a localiser that is better across the part
than along it. Takes 5 s.
"""

import sys
from pathlib import Path

import numpy as np

from rfcompass import PartDatabase, YouBot
from rfcompass.evaluation.error_pairs import read_error_csv
from rfcompass.evaluation.geometric_rule import GeometricRule, from_above
from rfcompass.evaluation.grasp_trials import ThresholdRule, chance_of, draw_runs, implied_factor, until_success
from rfcompass.robots.hand import hand_of
from rfcompass.viz.attempt_figures import draw_attempts

OPENINGS_M = (0.065, 0.075, 0.085, 0.10)
ATTEMPTS_SHOWN = 40


def main(
    fast: bool = False, out: Path = Path("runs/15_grasp_trials"), errors: Path | None = None
) -> dict[float, float]:
    """Try every hand; return the chance of one attempt by the hand's geometry, by its opening [m]."""
    out.mkdir(parents=True, exist_ok=True)
    pairs = read_error_csv(errors or make_up(out / "errors.csv"))
    median_cm = 100 * pairs.distance_quantile_m(0.5)
    print(
        f"{len(pairs)} pairs, median {median_cm:.1f} cm, {np.rad2deg(np.median(np.abs(pairs.theta_rad))):.1f} degrees"
    )
    leg, hand = PartDatabase(":memory:").part("table_leg_3"), hand_of(YouBot())
    width_m = float(leg.shape.size_m[1])

    drawn = draw_runs(pairs, np.random.default_rng(0), runs=200 if fast else 1000)
    found: dict[float, float] = {}
    curves: dict[str, dict[str, np.ndarray]] = {}
    print("hand      rule             chance (95 %)         mean attempts   first attempt   worth c =")
    for opening_m in OPENINGS_M:
        wide = hand.with_opening(opening_m)
        rules = {
            "hand's geometry": GeometricRule(wide, leg.shape, from_above(wide, height_m=0.005)),
            "|e| <= (G - w)/2": ThresholdRule(opening_m, width_m, 0.5),
            "|e| <= G - w": ThresholdRule(opening_m, width_m, 1.0),
        }
        for name, rule in rules.items():
            chance, attempts = chance_of(pairs, rule), until_success(drawn, rule)
            low_high = chance.interval(np.random.default_rng(0))
            between = f"({low_high.low:.2f} ... {low_high.high:.2f})"
            fits = isinstance(rule, GeometricRule) and 0.0 < chance.value < 1.0
            factor = f"{implied_factor(pairs, opening_m, width_m, chance.value):.2f}" if fits else ""
            print(
                f"{100 * opening_m:4.1f} cm   {name:<16} {chance.value:.2f} {between}   {attempts.mean:13.2f}   "
                f"{attempts.first_share:13.2f}   {factor:>9}"
            )
            curves.setdefault(name, {})[f"{100 * opening_m:.1f} cm"] = attempts.cdf(ATTEMPTS_SHOWN)
        found[opening_m] = chance_of(pairs, rules["hand's geometry"]).value
    draw_attempts(curves).savefig(out / "attempts.png", dpi=80 if fast else 150)
    print(f"picture: {out / 'attempts.png'}")
    return found


def make_up(path: Path) -> Path:
    """Write sixty errors: 3 cm (1 sd) along the part, 1.2 cm across it, and 4 degrees."""
    rng = np.random.default_rng(15)
    errors = rng.normal(0.0, [0.03, 0.012, np.deg2rad(4.0)], (60, 3))
    header = "x_error_m,y_error_m,theta_error_rad"
    np.savetxt(path, errors, delimiter=",", header=header, comments="", fmt="%.5f")
    return path


if __name__ == "__main__":
    files = [Path(argument) for argument in sys.argv[1:] if argument != "--fast"]
    main(fast="--fast" in sys.argv, errors=files[0] if files else None)
