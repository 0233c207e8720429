"""What executed grasps say about the quality: its weights from tuning rows, its tables from report rows.

    python -m benchmarks.grasp_success --fit tuning.npz [...]
    python -m benchmarks.grasp_success report.npz [...]

Rows come from `benchmarks.executed_grasps`. A grasp held if anything rose with the hand; beside that the tables say how
often the thing did that its pixel showed (own). Weights are fitted to the first. Intervals are bootstrap percentiles
over scenes, 95 %: grasps in one scene are not independent.
"""

import argparse
import itertools
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from planners.grasp_number_kernels import CLOSING, PINCHING
from planners.grasp_success import CLOSING_WEIGHTS, PINCHING_WEIGHTS, success_of
from rfcompass.arrays import BoolArray, FloatArray
from rfcompass.types.search import HELD

WAYS = {1: CLOSING, 2: PINCHING}
SHIPPED = {1: CLOSING_WEIGHTS, 2: PINCHING_WEIGHTS}
NAMES = {1: "closings", 2: "pinches"}
BINS = (0.0, 0.1, 0.25, 0.5, 0.75, 0.9, 1.0)
SHRINK, DRAWS = 1.0, 2000  # ridge penalty on the weights; bootstrap draws

Row = dict[str, object]


def auc(scores: FloatArray, held: BoolArray) -> float:
    """Probability that a grasp that held has a higher score than one that did not; ties count half."""
    good, bad = scores[held], scores[~held]
    if not (len(good) and len(bad)):
        return float("nan")
    return float(((good[:, None] > bad).sum() + 0.5 * (good[:, None] == bad).sum()) / (len(good) * len(bad)))


def interval(scenes: np.ndarray, measure: Callable[[np.ndarray], float]) -> tuple[float, float]:
    """95 % interval of a measure of row indices, scenes drawn with replacement; NaN where it is never defined."""
    rng, names = np.random.default_rng(0), np.unique(scenes)
    of = {name: np.flatnonzero(scenes == name) for name in names}
    drawn = [measure(np.concatenate([of[name] for name in rng.choice(names, len(names))])) for _ in range(DRAWS)]
    low, high = (np.nan, np.nan) if np.isnan(drawn).all() else np.nanpercentile(drawn, [2.5, 97.5])
    return float(low), float(high)


def fitted(numbers: FloatArray, held: BoolArray) -> FloatArray:
    """Weights of a logistic regression, the constant last; numbers (N, K)."""
    X, y = np.c_[numbers, np.ones(len(numbers))], held.astype(float)

    def loss(w: FloatArray) -> float:
        z = X @ w
        return float(np.sum(np.logaddexp(0, z) - y * z) + SHRINK / 2 * np.sum(w[:-1] ** 2))

    return np.asarray(minimize(loss, np.zeros(X.shape[1])).x)


def left_out(numbers: FloatArray, held: BoolArray, scenes: np.ndarray) -> FloatArray:
    """Log-odds of each row under weights that its scene had no part in."""
    z = np.zeros(len(held))
    for name in np.unique(scenes):
        own = scenes == name
        z[own] = np.c_[numbers[own], np.ones(own.sum())] @ fitted(numbers[~own], held[~own])
    return z


def columns(rows: list[Row]) -> tuple[FloatArray, BoolArray, np.ndarray]:
    """Numbers, whether held, and scene, of rows."""
    numbers = np.array([row["numbers"] for row in rows])
    held = np.array([row["outcome"] == HELD for row in rows])
    return numbers, held, np.array([f"{row['family']} {row['seed']}" for row in rows])


def fit(rows: list[Row]) -> None:
    """Print weights, calibrated on scenes left out, for `planners.grasp_success`."""
    for kind, names in WAYS.items():
        mine = [row for row in rows if row["kind"] == kind]
        numbers, held, scenes = columns(mine)
        numbers = numbers[:, : len(names)]
        z = left_out(numbers, held, scenes)
        slope, shift = fitted(z[:, None], held)
        weights = slope * fitted(numbers, held) + np.append(np.zeros(len(names)), shift)
        print(f"{NAMES[kind]}: {len(mine)}, held {held.mean():.2f}, AUC on scenes left out {auc(z, held):.2f}")
        print("   slope there", round(float(slope), 2), "weights", tuple(float(w) for w in weights.round(2)))
        now = np.c_[numbers, np.ones(len(held))] @ np.array(SHIPPED[kind])
        slope, shift = fitted(now[:, None], held)
        print(f"   shipped weights: AUC {auc(now, held):.2f}, to be scaled by {slope:.2f}, shifted by {shift:.2f}")


def rose(rows: list[Row]) -> dict[str, BoolArray]:
    """Whether anything rose with the hand, and whether what was meant did, shape (N,) each."""
    _, held, _ = columns(rows)
    return {"held": held, "own": held & np.array([bool(row["own"]) for row in rows])}


def report(rows: list[Row]) -> None:
    """Print the tables."""
    kinds = np.array([row["kind"] for row in rows])
    quality = success_of(np.array([row["log_odds"] for row in rows]), kinds)
    best = np.array([row["way"] == "best" for row in rows])
    _, _, scenes = columns(rows)
    ends = rose(rows)
    shares = ", ".join(f"{end} {which.mean():.3f}" for end, which in ends.items())
    print(f"{len(rows)} grasps in {len(np.unique(scenes))} scenes: {shares}")
    groups = {
        "all": np.ones(len(rows), dtype=bool),
        "best of a thing": best,
        "random": ~best,
        "closings": kinds == 1,
        "pinches": kinds == 2,
    }
    for family in dict.fromkeys(str(row["family"]) for row in rows):
        groups[family] = np.array([row["family"] == family for row in rows])
    for name, which in groups.items():
        show_aucs(name, np.flatnonzero(which), quality, ends, scenes)
    for low, high in itertools.pairwise(BINS):
        inside = np.flatnonzero((quality >= low) & (quality < high))
        show(f"quality {low:.2f}..{high:.2f}", inside, quality, ends, scenes)
    show("best grasp of a state", best_of_states(rows, quality), quality, ends, scenes)
    for item in sorted({str(row["item"]) for row in rows}):
        print(f"  {item:10s}", dict(Counter(str(row["outcome"]) for row in rows if row["item"] == item)))


def show_aucs(
    name: str, which: np.ndarray, quality: FloatArray, ends: dict[str, BoolArray], scenes: np.ndarray
) -> None:
    """Print how well the quality of some grasps tells which of them rose, of each kind of end."""
    if not len(which):
        return
    told = f"{name:16s} N {len(which):5d} expected {quality[which].mean():.2f}"
    for end, there in ends.items():
        q, h = quality[which], there[which]
        low, high = interval(scenes[which], lambda i, q=q, h=h: auc(q[i], h[i]))  # type: ignore[misc]
        told += f" | {end} {h.mean():.2f} AUC {auc(q, h):.2f} [{low:.2f}, {high:.2f}]"
    print(told)


def show(name: str, which: np.ndarray, quality: FloatArray, ends: dict[str, BoolArray], scenes: np.ndarray) -> None:
    """Print how often some grasps rose, of each kind of end, beside what their quality said."""
    if not len(which):
        return
    told = f"{name:24s} N {len(which):4d} expected {quality[which].mean():.2f}"
    for end, there in ends.items():
        low, high = interval(scenes[which], lambda i, h=there[which]: float(h[i].mean()))  # type: ignore[misc]
        told += f" | {end} {there[which].mean():.2f} [{low:.2f}, {high:.2f}]"
    print(told)


def best_of_states(rows: list[Row], quality: FloatArray) -> np.ndarray:
    """Rows with the highest quality of those that were best on their thing, one for each state."""
    top: dict[tuple[object, ...], int] = {}
    for index, row in enumerate(rows):
        key = row["family"], row["seed"], row["state"]
        if row["way"] == "best" and (key not in top or quality[index] > quality[top[key]]):
            top[key] = index
    return np.array(list(top.values()))


def main() -> None:
    """Fit or report."""
    parser = argparse.ArgumentParser()
    parser.add_argument("files", type=Path, nargs="+")
    parser.add_argument("--fit", action="store_true", help="Print weights instead of tables.")
    asked = parser.parse_args()
    rows = [row for file in asked.files for row in np.load(file, allow_pickle=True)["rows"]]
    (fit if asked.fit else report)(rows)


if __name__ == "__main__":
    main()
