"""How sure is it? The region of a convex program says what is possible, a posterior what is probable.

A youBot holds its hand over a table leg in a room full of echoes and scans once, by radio. The comparisons of the
leg's tags leave a polygon; its size says nothing about errors, and with a wrong comparison the part may lie outside.
The posterior takes the noise from the robot's own tags, and its regions hold the part as often as they say.
Then all but the tag at one end of the leg fall silent: the posterior shows the ring that is left, and says that
the orientation is not known, instead of guessing.

You will see both answers with their errors, and get `how_sure.png`. Takes 15 s.
"""

import sys
from dataclasses import replace
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rfcompass import Observation, PartDatabase, PartEstimate, PartitionLocalizer, Pose2, YouBot
from rfcompass.localization import PosteriorLocalizer, measure_proximities
from rfcompass.rf import meter
from rfcompass.studies.radio_scan import scan_over_part
from rfcompass.studies.radio_setup import RadioSetup

matplotlib.use("Agg")
HALF_PICTURE_M = 0.35


def scan(seed: int) -> tuple[Observation, Pose2]:
    """One scan by radio with its proximities, and where the leg truly lies in the base frame."""
    leg = PartDatabase(":memory:").part("table_leg_3")
    stop = scan_over_part(YouBot(), leg, leg.layout(4), RadioSetup(), np.random.default_rng(seed))
    matrix = measure_proximities(stop.observation, meter("sar_nearfield"))
    T_room_base, tags_m = stop.truth.T_room_base, stop.truth.targets.points_m
    in_base_m = T_room_base.inverse().apply(tags_m[:, :2])
    along_m = in_base_m[-1] - in_base_m[0]
    points_m = stop.observation.part.points_m
    turn = np.arctan2(*along_m[::-1]) - np.arctan2(*(points_m[-1] - points_m[0])[1::-1])
    centre_m = in_base_m.mean(axis=0) - Pose2(0.0, 0.0, turn).apply(points_m[:, :2].mean(axis=0))
    return replace(stop.observation, proximity=matrix), Pose2(*centre_m, turn)


def silenced(observation: Observation, heard: int) -> Observation:
    """The same scan, with only one tag of the part heard."""
    matrix = measure_proximities(observation)
    m = matrix.m.copy()
    m[np.arange(len(m)) != heard] = np.nan
    return replace(observation, proximity=replace(matrix, m=m))


def show(name: str, estimate: PartEstimate, truth: Pose2) -> None:
    """Print an answer beside the truth."""
    error_cm = 100 * np.linalg.norm(estimate.centre_m - truth.translation_m)
    theta = "not observable" if estimate.theta_rad is None else f"{np.degrees(estimate.theta_rad):6.1f}°"
    sd_cm = 100 * np.sqrt(np.trace(estimate.covariance[:2, :2])) if estimate.covariance is not None else np.nan
    print(f"{name:<26} centre {error_cm:5.1f} cm off (says {sd_cm:4.1f} cm), orientation {theta}")


def draw(axes: Axes, title: str, truth: Pose2, estimates: list[PartEstimate]) -> None:
    """Draw regions, samples and the true leg."""
    for estimate, colour in zip(estimates, ("tab:blue", "tab:orange", "tab:red"), strict=False):
        axes.plot(*estimate.samples[:, :2].T, ".", ms=2, alpha=0.4, color=colour)
        share = "" if estimate.probability is None else f", {estimate.probability:.0%}"
        axes.fill(*estimate.region_m.T, fill=False, color=colour, label=estimate.method + share)
        axes.plot(*estimate.centre_m, "+", ms=10, color=colour)
    axes.plot(*truth.apply(np.array([[-0.2, 0.0], [0.2, 0.0]])).T, "k-", lw=4, alpha=0.5, label="the leg")
    x_m, y_m = truth.translation_m
    axes.set(
        title=title, aspect="equal", xlabel="x [m]", ylabel="y [m]",
        xlim=(x_m - HALF_PICTURE_M, x_m + HALF_PICTURE_M), ylim=(y_m - HALF_PICTURE_M, y_m + HALF_PICTURE_M),
    )  # fmt: skip
    axes.legend(loc="lower left", fontsize=7)


def main(fast: bool = False, out: Path = Path("runs/09_how_sure")) -> tuple[PartEstimate, PartEstimate]:
    """Localise once with all tags and once with one; return both posteriors' estimates."""
    observation, truth = scan(seed=23)
    half, most = PosteriorLocalizer(probability=0.5, sample_count=0), PosteriorLocalizer(probability=0.9)
    partition, posterior = PartitionLocalizer(centre="centroid").estimate([observation]), most.estimate([observation])
    one_end = silenced(observation, heard=0)
    ring = most.estimate([one_end])
    show("partition, four tags", partition, truth)
    show("posterior, four tags", posterior, truth)
    show("posterior, one end only", ring, truth)

    figure = Figure(figsize=(10, 5), layout="constrained")
    left, right = figure.subplots(1, 2)
    draw(left, "four tags", truth, [posterior, half.estimate([observation]), partition])
    draw(right, "one end of the leg only", truth, [ring, half.estimate([one_end])])
    out.mkdir(parents=True, exist_ok=True)
    figure.savefig(out / "how_sure.png", dpi=80 if fast else 150)
    print(f"picture: {out / 'how_sure.png'}")
    return posterior, ring


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
