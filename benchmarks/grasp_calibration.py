"""Does a grasp hold as often as predicted? Predicted success probability against an oracle, decile by decile.

Each grasp: an estimate whose errors are two normal distributions of different width and place (so neither round nor
centred), the true pose one more draw of the same, a hand sent to where its mean is or beside it, half a hand's width
at most. The planner sees the samples, the stated spread of the arm and of friction, and the compiled judge; the oracle
draws one true pose, one pose of the hand and one coefficient, and asks the readable judge. What is tested is the
integration and the agreement of both judges; that the estimate's own samples are honest is the matter of
`benchmarks.posterior_calibration`.

Run `python -m benchmarks.grasp_calibration`; some minutes. Seed 4000; 0 was used while this was made.
"""

import argparse
from dataclasses import dataclass

import numpy as np

from planners.success import part_frames, success_probability
from rfcompass import YouBot
from rfcompass.arrays import FloatArray
from rfcompass.geometry import Pose2
from rfcompass.recordings import PartDatabase
from rfcompass.robots import hand_of
from rfcompass.simulation import PartOracle
from rfcompass.types import Part
from rfcompass.types.grasp_noise import GraspNoise
from rfcompass.types.hands import Hand

OPENINGS_M = (0.075, 0.085, 0.10)
TIP_M = 0.010  # height of the finger tips over the floor


@dataclass(frozen=True, slots=True)
class Tried:
    """One grasp: predicted with the stated spread, predicted without, and whether it held."""

    predicted: float
    without_noise: float
    held: bool


def draw_poses(rng: np.random.Generator, count: int) -> FloatArray:
    """Poses x, y, θ about a leg in front of the robot: a narrow and a wide normal distribution, (count, 3)."""
    mean = np.array([0.42, 0.0, rng.uniform(-np.pi, np.pi)])
    narrow = np.array([*np.exp(rng.uniform(np.log(0.002), np.log(0.02), 2)), np.exp(rng.uniform(-4.5, -1.8))])
    beside = rng.normal(0.0, 1.0, 3) * narrow
    wide = rng.random(count) < 0.3
    return np.asarray(
        mean + rng.normal(size=(count, 3)) * np.where(wide[:, None], 2 * narrow, narrow) + wide[:, None] * beside
    )


def hand_over(samples: FloatArray, rng: np.random.Generator) -> FloatArray:
    """The tool over the mean of samples or beside it, straight down, jaws across the leg or nearly; (4, 4)."""
    x, y, theta = samples.mean(axis=0)
    off_x, off_y, turned = rng.uniform(-0.1, 0.1), rng.uniform(-0.02, 0.02), rng.normal(0.0, 0.15)
    down, half_turn = np.eye(4), np.pi * rng.integers(2)
    c, s = np.cos(turned + half_turn), np.sin(turned + half_turn)
    down[:3, :3] = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ np.diag([1.0, -1.0, -1.0])
    down[:3, 3] = off_x, off_y, TIP_M
    return np.asarray(np.linalg.inv(part_frames(np.array([[x, y, theta]]), 0.0)[0]) @ down)


def try_once(hand: Hand, part: Part, count: int, rng: np.random.Generator) -> Tried:
    """Predict one grasp and have it judged."""
    noise = GraspNoise()
    drawn = draw_poses(rng, count + 1)
    samples, true = drawn[:-1], Pose2(*drawn[-1])
    T_base_hand, height_m = hand_over(samples, rng), part.resting_height_m
    predicted = [
        success_probability(hand, part, T_base_hand, samples, height_m, draws=draws).probability
        for draws in (noise.draw(count, rng), None)
    ]
    oracle = PartOracle(hand, part, true, rng, noise)
    return Tried(predicted[0], predicted[1], oracle.judge(T_base_hand, hand.greatest_m).success)


def table(predicted: FloatArray, held: FloatArray) -> list[str]:
    """Rows of a Markdown table, one for each tenth of the predicted probability."""
    rows = ["| predicted | grasps | mean predicted | held | difference |", "|---|---:|---:|---:|---:|"]
    for tenth in range(10):
        inside = np.minimum((predicted * 10).astype(int), 9) == tenth
        if not inside.any():
            continue
        mean, share = 100 * predicted[inside].mean(), 100 * held[inside].mean()
        name = f"{10 * tenth}..{10 * tenth + 10} %"
        rows.append(f"| {name} | {inside.sum()} | {mean:.1f} % | {share:.1f} % | {share - mean:+.1f} |")
    return rows


def main() -> None:
    """Try grasps and print both tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--grasps", type=int, default=8000)
    parser.add_argument("--samples", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=4000)
    asked = parser.parse_args()
    rng, part, own = np.random.default_rng(asked.seed), PartDatabase(":memory:").part("table_leg_3"), hand_of(YouBot())
    hands = [own.with_opening(opening_m) for opening_m in OPENINGS_M]
    tries = [try_once(hands[i % len(hands)], part, asked.samples, rng) for i in range(asked.grasps)]
    held = np.array([row.held for row in tries], dtype=float)
    for title, values in (
        ("with the spread of arm and friction", [row.predicted for row in tries]),
        ("without it", [row.without_noise for row in tries]),
    ):
        predicted = np.array(values)
        print(f"\n{title}: Brier score {np.mean((predicted - held) ** 2):.4f}\n")
        print("\n".join(table(predicted, held)))


if __name__ == "__main__":
    main()
