"""Trace-driven grasp trials [Wang2013], section 6.3: how many attempts does a hand need, given the errors?

Each attempt draws a pair of position and orientation error; a *rule* says whether the hand would grasp. Draws are
independent, as after a new measurement, so the number of attempts is geometric with the chance p of one of them,

    P(T <= t) = 1 - (1 - p)^t,    mean 1 / p.

The paper prints no rule but a part, hands and "a margin of 2.5 cm". Three are offered, none is fitted: the hand's own
geometry, and thresholds |e| <= c (G - w) on the position error e, opening G and width w, with c = 1/2 and c = 1.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, IntArray, read_only
from rfcompass.errors import InputError
from rfcompass.evaluation.error_pairs import Draws, ErrorPairs, ErrorSource
from rfcompass.evaluation.statistics import Interval, bootstrap_interval
from rfcompass.types.record import Record

CAP = 1000  # ours: attempts after which a run is given up
DIRECTIONS = 90  # directions, each with both signs of the turn, over which the chance of a pair is averaged
# Attempts judged at a time, the first ones in small numbers because most runs end there.
_FIRST_BLOCK, _LARGEST_BLOCK = 8, 128


@runtime_checkable
class GraspRule(Protocol):
    """Says which attempts hold the part."""

    def holds(self, draws: Draws) -> BoolArray:
        """Whether the hand grasps, for each draw, shape (S,)."""
        ...


@dataclass(frozen=True, slots=True)
class ThresholdRule(Record):
    """|e| <= c (G - w); orientation does not matter.

    Attributes:
        opening_m: Opening of the hand G [m].
        width_m: Width of the part w [m].
        factor: c.
    """

    opening_m: float
    width_m: float
    factor: float

    def __post_init__(self) -> None:
        """Check the sizes; a part wider than the hand is never grasped, which is an answer."""
        for name in ("opening_m", "width_m", "factor"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0.0):
                raise InputError(f"ThresholdRule.{name}: {getattr(self, name)} is not above 0", name=name)

    def holds(self, draws: Draws) -> BoolArray:
        """Whether the position error is small enough, shape (S,)."""
        return np.asarray(draws.distance_m <= self.factor * (self.opening_m - self.width_m))


@dataclass(frozen=True, slots=True)
class Attempts(Record):
    """How many attempts each of many runs needed.

    Attributes:
        tries: Attempts up to and with the first that held; `cap` where none did, shape (R,).
        held: Whether one of them held, shape (R,).
        cap: Attempts after which a run was given up.
    """

    tries: IntArray
    held: BoolArray
    cap: int

    def __post_init__(self) -> None:
        """Freeze the arrays and check that they fit."""
        object.__setattr__(self, "tries", read_only(self.tries, "Attempts.tries", (None,), np.int64))
        object.__setattr__(self, "held", read_only(self.held, "Attempts.held", self.tries.shape, np.bool_))

    @property
    def first_share(self) -> float:
        """Share of the runs whose first attempt held."""
        return float(((self.tries == 1) & self.held).mean())

    @property
    def mean(self) -> float:
        """Mean number of attempts; a lower bound where runs were given up."""
        return float(self.tries.mean())

    def cdf(self, count: int) -> FloatArray:
        """Share of the runs that ended with success within 1, 2, … `count` attempts, shape (count,)."""
        ends = np.bincount(self.tries[self.held], minlength=count + 1)[: count + 1]
        return np.asarray(np.cumsum(ends)[1:] / len(self.tries))


@dataclass(frozen=True, slots=True)
class Runs(Record):
    """Errors of all attempts of many runs, as drawn before any hand judges them.

    Attributes:
        offset_m: Estimated centres in the frame of the true part [m], R runs of at most T attempts, shape (R, T, 2).
        theta_rad: Estimated orientations [rad], shape (R, T).
    """

    offset_m: FloatArray
    theta_rad: FloatArray

    def __post_init__(self) -> None:
        """Freeze the arrays and check that they fit."""
        object.__setattr__(self, "theta_rad", read_only(self.theta_rad, "Runs.theta_rad", (None, None)))
        shape = (*self.theta_rad.shape, 2)
        object.__setattr__(self, "offset_m", read_only(self.offset_m, "Runs.offset_m", shape))

    def combined(self) -> "Runs":
        """The same measurements where each attempt uses the mean of all of its run so far, not the newest alone.

        For parts that a failed attempt does not move, and for errors that a new measurement draws anew: a bias that
        all measurements share does not average out.
        """
        count = np.arange(1, self.theta_rad.shape[1] + 1)
        sine, cosine = (wave(self.theta_rad).cumsum(axis=1) for wave in (np.sin, np.cos))
        return Runs(self.offset_m.cumsum(axis=1) / count[:, None], np.arctan2(sine, cosine))

    def attempts(self, run: IntArray, start: int, end: int) -> Draws:
        """Attempts of some runs, one run after the other.

        Args:
            run: Which runs, shape (S,).
            start: First attempt, from 0.
            end: The attempt after the last.
        """
        return Draws(self.offset_m[run, start:end].reshape(-1, 2), self.theta_rad[run, start:end].ravel())


def draw_runs(source: ErrorSource, rng: np.random.Generator, *, runs: int = 1000, cap: int = CAP) -> Runs:
    """Draw the errors of all attempts, each independent of all others [Wang2013], section 6.3.

    Args:
        source: Where the error of each attempt comes from.
        rng: Source of all draws.
        runs: Number of runs.
        cap: Attempts after which a run is given up.

    Raises:
        InputError: If there is no run or no attempt.
    """
    if runs < 1 or cap < 1:
        raise InputError(f"{runs} runs of at most {cap} attempts: at least one each", runs=runs, cap=cap)
    draws = source.draw(runs * cap, rng)
    return Runs(draws.offset_m.reshape(runs, cap, 2), draws.theta_rad.reshape(runs, cap))


def until_success(runs: Runs, rule: GraspRule) -> Attempts:
    """Attempt until the part is held; only runs that still go on are judged, in blocks."""
    count, cap = runs.theta_rad.shape
    tries, held = np.full(count, cap), np.zeros(count, dtype=np.bool_)
    start, block = 0, _FIRST_BLOCK
    while start < cap and not held.all():
        going, end = np.flatnonzero(~held), min(start + block, cap)
        success = rule.holds(runs.attempts(going, start, end)).reshape(len(going), end - start)
        ended = success.any(axis=1)
        held[going[ended]] = True
        tries[going[ended]] = start + 1 + success[ended].argmax(axis=1)
        start, block = end, min(2 * block, _LARGEST_BLOCK)
    return Attempts(tries, held, cap)


@dataclass(frozen=True, slots=True)
class Chance(Record):
    """Chance that one attempt holds, of errors that are themselves a sample.

    Attributes:
        by_pair: Chance given each pair of errors, over directions where they are unknown, shape (P,).
    """

    by_pair: FloatArray

    def __post_init__(self) -> None:
        """Freeze the array."""
        object.__setattr__(self, "by_pair", read_only(self.by_pair, "Chance.by_pair", (None,)))

    @property
    def value(self) -> float:
        """Chance of an attempt whose pair is drawn uniformly."""
        return float(self.by_pair.mean())

    @property
    def mean_tries(self) -> float:
        """Mean of the geometric number of attempts, without a cap; infinite if no pair ever holds."""
        return 1.0 / self.value if self.value > 0.0 else np.inf

    def interval(self, rng: np.random.Generator) -> Interval:
        """95 % bootstrap interval of the chance over the pairs; more runs do not make it narrower."""
        return bootstrap_interval(self.by_pair, "mean", rng)


def chance_of(pairs: ErrorPairs, rule: GraspRule) -> Chance:
    """Chance of one attempt, computed rather than drawn: every pair, in all directions if none is known."""
    directions = 1 if pairs.heading_rad is not None else DIRECTIONS
    signs = 1 if pairs.heading_rad is not None else 2
    turn = np.repeat((np.arange(directions) + 0.5) / directions, signs)
    flip = np.tile(np.arange(signs) == 1, directions)
    row = np.repeat(np.arange(len(pairs)), len(turn))
    held = rule.holds(pairs.turned(row, np.tile(turn, len(pairs)), np.tile(flip, len(pairs))))
    return Chance(held.reshape(len(pairs), -1).mean(axis=1))


def implied_factor(source: ErrorSource, opening_m: float, width_m: float, share: float) -> float:
    """The c of |e| <= c (G - w) with which this share of the draws would hold.

    Args:
        source: Errors.
        opening_m: Opening of the hand G [m].
        width_m: Width of the part w [m].
        share: Chance of one attempt, for example 1/9 for nine attempts in the mean.

    Raises:
        InputError: If the part is as wide as the hand, or the share is not between 0 and 1.
    """
    if not opening_m > width_m or not 0.0 < share < 1.0:
        message = f"an opening of {opening_m} m, a width of {width_m} m and a share of {share} imply no factor"
        raise InputError(message, opening_m=opening_m, width_m=width_m, share=share)
    return source.distance_quantile_m(share) / (opening_m - width_m)


@dataclass(frozen=True, slots=True)
class FactorBounds(Record):
    """Between which values c must lie, whatever the distribution of errors.

    Attributes:
        low: c is above this; 0 if nothing bounds it.
        high: c is below this; infinite if nothing bounds it.
    """

    low: float
    high: float


def factor_bounds(median_m: float, width_m: float, share_by_opening_m: Mapping[float, float]) -> FactorBounds:
    """Bound the c of any rule |e| <= c (G - w) by the median error alone.

    A hand that holds less than half of all draws has its threshold below the median, one that holds more above it:

        c (G - w) < median  if share < 1/2,      c (G - w) > median  if share > 1/2.

    Args:
        median_m: Median position error [m].
        width_m: Width of the part w [m].
        share_by_opening_m: Chance of one attempt by opening of the hand G.
    """
    ratio = {opening_m: median_m / (opening_m - width_m) for opening_m in share_by_opening_m}
    above = [ratio[opening_m] for opening_m, share in share_by_opening_m.items() if share > 0.5]
    below = [ratio[opening_m] for opening_m, share in share_by_opening_m.items() if share < 0.5]
    return FactorBounds(max(above, default=0.0), min(below, default=np.inf))
