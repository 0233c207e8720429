"""Study: how many attempts does a hand need to grasp the part [Wang2013], Fig. 14 and 15?

One trial is one run: attempts until success, each with a freshly drawn pair of position and orientation error. All
rules and all hands judge the same draws.
"""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from rfcompass.errors import StudyError
from rfcompass.evaluation.error_pairs import RAYLEIGH_SHAPE, ErrorFamily, ErrorPairs, ErrorSource, weibull_shape
from rfcompass.evaluation.geometric_rule import GeometricRule, from_above
from rfcompass.evaluation.grasp_trials import (
    CAP,
    FactorBounds,
    GraspRule,
    ThresholdRule,
    draw_runs,
    factor_bounds,
    until_success,
)
from rfcompass.evaluation.records import MetricValue
from rfcompass.robots.hand import VERDICTS, Hand, hand_of
from rfcompass.studies.accuracy import leg, youbot
from rfcompass.studies.metric import SHARE, Metric
from rfcompass.studies.stored_errors import accuracy_run, stored_errors
from rfcompass.studies.study import Cell, PaperValue, Study

WIDTH_M = 0.05  # [Wang2013], section 5: legs 5 cm wide
OPENINGS_M = (0.075, 0.085, 0.10)  # [Wang2013], section 6.3
TAGS = (2, 4)
RULES = ("geometry", "half", "whole")
FACTORS = {"half": 0.5, "whole": 1.0}
HEIGHT_M = 0.005  # ours: tool frame over the part's centre, as in `docs/grasp.md`

# [Wang2013], section 6.2. The spread is printed for K = 1 only; that of K = 2 and 4 is taken to be the same share of
# the median.
SD_OVER_MEDIAN = 0.018 / 0.0403
MEDIAN_M = {2: 0.0276, 4: 0.0128}
MEDIAN_RAD = {2: float(np.radians(5.77)), 4: float(np.radians(3.3))}


class Stored(NamedTuple):
    """Rows of the study `accuracy`."""

    rig: str
    method: str
    share: float = 1.0  # of the trials, those of which the estimator itself was surest


class Family(NamedTuple):
    """A distribution with the paper's medians."""

    shape: float


SOURCES: dict[str, Stored | Family] = {
    "the paper's rig": Stored("the paper's, X4", "paper"),
    "ours, far tracks": Stored("far L", "posterior"),
    "ours, far tracks, surest half": Stored("far L", "posterior", 0.5),
    "ours, near tracks": Stored("near L", "posterior"),
    "ours, near tracks, surest half": Stored("near L", "posterior", 0.5),
    "the paper's medians": Family(weibull_shape(SD_OVER_MEDIAN)),
    "the paper's medians, Rayleigh": Family(RAYLEIGH_SHAPE),
}


def grasp_trial(cell: Cell, seed: int, rng: np.random.Generator) -> Mapping[str, MetricValue]:  # noqa: ARG001
    """Attempt until success, by every rule; and once more by geometry with the mean of all measurements so far."""
    source = error_source(str(cell["source"]), int(float(cell["tags"] or 0)))
    opening_m = float(cell["opening_m"] or 0.0)
    runs, geometry = draw_runs(source, rng, runs=1), geometric_rule(opening_m)
    verdict = int(geometry.verdicts(runs.attempts(np.zeros(1, dtype=np.int64), 0, 1))[0])
    found: dict[str, MetricValue] = {"first_verdict": VERDICTS[verdict]}
    found["pairs"] = float(len(source)) if isinstance(source, ErrorPairs) else None
    for name, rule in rules(opening_m).items():
        attempts = until_success(runs, rule)
        found[f"tries_{name}"] = attempts.mean
        found[f"first_{name}"] = attempts.first_share == 1.0
        found[f"given_up_{name}"] = not attempts.held[0]
    found["tries_combined"] = until_success(runs.combined(), geometry).mean
    return found


def rules(opening_m: float) -> dict[str, GraspRule]:
    """The three rules, beside each other."""
    thresholds = {name: ThresholdRule(opening_m, WIDTH_M, factor) for name, factor in FACTORS.items()}
    return {"geometry": geometric_rule(opening_m), **thresholds}


@cache
def geometric_rule(opening_m: float, along_m: float = 0.0) -> GeometricRule:
    """The youBot's hand with fingers mounted for this opening, over the leg.

    Args:
        opening_m: Opening of the hand [m].
        along_m: How far from the middle of the leg it grasps [m].
    """
    hand = _hand().with_opening(opening_m)
    return GeometricRule(hand, leg().shape, from_above(hand, HEIGHT_M, along_m))


@cache
def _hand() -> Hand:
    return hand_of(youbot("x4"))


def error_source(name: str, tags: int) -> ErrorSource:
    """What the errors of an attempt are drawn from.

    Raises:
        StudyError: If there is no run of `accuracy`, or it holds no trial with both a place and an orientation.
    """
    kind = SOURCES[name]
    if isinstance(kind, Family):
        return ErrorFamily(median_m=MEDIAN_M[tags], theta_median_rad=MEDIAN_RAD[tags], shape=kind.shape)
    run = _stored_run()
    if run is None:
        raise StudyError("there is no run of the study accuracy to draw errors from", source=name)
    pairs = stored_errors(run, kind.rig, kind.method, tags)
    return pairs if kind.share == 1.0 else pairs.surest(kind.share)


@cache
def _stored_run() -> Path | None:
    """Looked for once in a process, so that one that is missing is told once."""
    return accuracy_run()


def _is_there(cell: Cell, seed: int) -> bool:  # noqa: ARG001
    return isinstance(SOURCES[str(cell["source"])], Family) or _stored_run() is not None


def _metrics() -> tuple[Metric, ...]:
    titles = {"geometry": "hand's geometry", "half": "|e| ≤ (G - w)/2", "whole": "|e| ≤ G - w"}
    found = []
    for rule, title in titles.items():
        found += [
            Metric(f"tries_{rule}", ("mean", "median", "p90"), "float", f"{title}: attempts", "", 1.0, 2),
            Metric(f"first_{rule}", (SHARE,), "bool", f"{title}: first attempt holds", "%", 100.0),
            Metric(f"given_up_{rule}", (SHARE,), "bool", f"{title}: given up after {CAP}", "%", 100.0),
        ]
    combined = "hand's geometry, mean of all measurements so far: attempts"
    return (
        *found,
        Metric("tries_combined", ("mean", "median", "p90"), "float", combined, "", 1.0, 2),
        Metric("pairs", ("mean",), "float", "pairs to draw from", "", 1.0, 0),
        Metric("first_verdict", column="text"),
    )


class Printed(NamedTuple):
    """What the paper prints of one hand.

    Attributes:
        figure: Where.
        tags: Tags on the part, K.
        opening_m: Opening of the hand [m].
        metric: `"tries"` (their mean) or `"first"` (share of runs whose first attempt holds).
        value: The figure.
        chance: Chance of one attempt that it implies; attempts are geometric, so that is 1 / mean.
        words: As it is printed.
    """

    figure: str
    tags: int
    opening_m: float
    metric: str
    value: float
    chance: float
    words: str


PRINTED = (
    Printed("Fig. 14", 2, 0.075, "tries", 9.0, 1 / 9, "on average 9 times"),
    Printed("Fig. 14", 2, 0.085, "tries", 5.0, 1 / 5, "the average number of trials decreases to 5"),
    Printed("Fig. 14", 2, 0.10, "first", 0.80, 0.80, "on the first try in over 80 % of the time"),
    Printed("Fig. 15", 4, 0.075, "first", 0.90, 0.90, "almost 90 % of the time"),
)


def printed_factor_bounds() -> FactorBounds:
    """Between which values the c of |e| <= c (G - w) must lie, by the paper's chances and its median for K = 2."""
    return factor_bounds(MEDIAN_M[2], WIDTH_M, {one.opening_m: one.chance for one in PRINTED if one.tags == 2})


def _paper() -> tuple[PaperValue, ...]:
    differs = "errors are those of the authors' room; their simulator's rule of success is not printed"
    return tuple(
        PaperValue(
            f"{one.metric}_{rule}",
            "mean" if one.metric == "tries" else SHARE,
            one.value,
            f"[Wang2013] {one.figure}",
            f"printed: {one.words}; {differs}",
            {"tags": one.tags, "opening_m": one.opening_m},
        )
        for rule in RULES
        for one in PRINTED
    )


GRASP_TRIALS = Study(
    name="grasp-trials",
    title="Attempts until the part is grasped",
    kind="simulated",
    factors={"source": tuple(SOURCES), "tags": TAGS, "opening_m": OPENINGS_M},
    seeds=range(1000, 2000),
    tuning_seeds=range(20),
    trial=grasp_trial,
    metrics=_metrics(),
    paper=_paper(),
    applies=_is_there,
    note=(
        "Part 5 cm wide. Each attempt draws a pair of position and orientation error anew, uniformly from the trials "
        "of a run of `accuracy` (in sight, three stops) or from a Weibull family with the paper's medians; its spread "
        "is the paper's for K = 1 (1.8 cm of 4.03), a Rayleigh's is wider. Rows keep sizes of errors: direction and "
        "sign are drawn. Trials of `accuracy` without a place or an orientation are left out; the robot would measure "
        f"again. A run is given up after {CAP} attempts and counts as {CAP}, so its mean is a lower bound. Intervals "
        "are those of the 1000 runs; `docs/grasp_trials.md` has those of the errors drawn from. With the paper's "
        f"median for K = 2, any rule |e| ≤ c (G - w) needs {printed_factor_bounds().low:.2f} < c < "
        f"{printed_factor_bounds().high:.2f} to give its figures; no c is fitted here."
    ),
)  # fmt: skip
