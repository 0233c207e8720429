"""From what was heard of each part tag to the probability of every pose: maps of tags, then poses that join them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import Infeasible
from rfcompass.localization.part_evidence import PartEvidence
from rfcompass.localization.pose_posterior import PosePosterior
from rfcompass.localization.pose_search import MapStack, pose_cells, rigid_start, stack_maps
from rfcompass.localization.tag_kernels import tag_cells
from rfcompass.localization.tag_maps import smeared_map
from rfcompass.types.record import Record

# All ours. [side of the first cells [m], smallest side [m], log likelihood below the best that counts as nothing,
# cells over which a tag must spread].
_TAG_LIMITS = np.array([0.32, 1.25e-3, 12.0, 20.0])
_MAX_TAG_CELLS = 4000
# [log density below the best that counts as nothing, cells over which the pose must spread, smallest and largest side
# of a cell [m]].
_POSE_LIMITS = np.array([8.5, 45.0, 2e-4, 0.04])
_MAX_POSE_CELLS = 16000
_PITCH_PER_BIAS = 0.7  # a normal density sampled at 0.7 σ keeps its sums to 1e-8
_MAX_MAP_POINTS = 30_000


@dataclass(frozen=True, slots=True)
class SeenTag(Record):
    """Where one part tag seems to be: equal squares that hold its likelihood.

    Attributes:
        cells_m: Middles [m], shape (C, 2).
        log_likelihood: In the middles, shape (C,).
        side_m: Side of a square [m].
    """

    cells_m: FloatArray
    log_likelihood: FloatArray
    side_m: float

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        object.__setattr__(self, "cells_m", read_only(self.cells_m, "SeenTag.cells_m", (None, 2)))
        shape = (len(self.cells_m),)
        object.__setattr__(self, "log_likelihood", read_only(self.log_likelihood, "SeenTag.log_likelihood", shape))

    @property
    def best_m(self) -> FloatArray:
        """Likeliest place [m], shape (2,)."""
        return np.asarray(self.cells_m[self.log_likelihood.argmax()])

    @property
    def top_m(self) -> FloatArray:
        """Likeliest place, between squares: mean over the best one and its neighbours [m], shape (2,)."""
        near = np.abs(self.cells_m - self.best_m).max(axis=1) < 1.5 * self.side_m
        weight = np.exp(self.log_likelihood[near] - self.log_likelihood.max())
        return np.asarray(weight @ self.cells_m[near] / weight.sum())

    @property
    def log_mass(self) -> float:
        """Log of the integral of the likelihood over the plane [log m²]."""
        top = float(self.log_likelihood.max())
        return top + float(np.log(np.exp(self.log_likelihood - top).sum() * self.side_m**2))


def see_tags(evidence: PartEvidence, bounds_m: FloatArray) -> tuple[SeenTag, ...]:
    """Find where each part tag seems to be, by its own distances or comparisons alone.

    Args:
        evidence: What was heard.
        bounds_m: Where the part's centre may lie [m], [[xmin, xmax], [ymin, ymax]]; a tag lies within its lever of
            that.
    """
    seen = []
    for point_m, table in zip(evidence.points_m, evidence.tables, strict=True):
        lever_m = float(np.hypot(*point_m[:2]))
        box_m = bounds_m + np.array([-lever_m, lever_m])
        seen.append(SeenTag(*tag_cells(evidence.ranges, table, box_m, _TAG_LIMITS, _MAX_TAG_CELLS)))
    return tuple(seen)


def infer_pose(evidence: PartEvidence, seen: Sequence[SeenTag], bounds_m: FloatArray) -> PosePosterior:
    """Join the places of all tags to poses of the part.

    With M_k the log density of the true place of tag k (its seeming place, smeared with the density of its bias),

        log p(x, y, θ | everything) = Σ_k M_k(p_k(x, y, θ)) + constant     inside the bounds.

    Args:
        evidence: What was heard.
        seen: Where each tag seems to be, of the same evidence.
        bounds_m: Where the part's centre may lie [m], [[xmin, xmax], [ymin, ymax]].

    Raises:
        Infeasible: If no pose inside the bounds has any probability.
    """
    stack = _stacked(evidence, seen)
    cells, value, half = pose_cells(stack, bounds_m, _POSE_LIMITS, _MAX_POSE_CELLS)
    if not value.size:
        message = f"no place inside {bounds_m.tolist()} m fits what was heard"
        raise Infeasible(message, bounds_m=bounds_m.tolist(), rows=evidence.rows)
    weight = np.exp(value - value.max())
    volume = 8.0 * half[0] ** 2 * half[1] / (2.0 * np.pi * float(np.prod(np.ptp(bounds_m, axis=1))))
    log_evidence = float(value.max() + np.log(weight.sum() * volume)) + sum(tag.log_mass for tag in seen)
    start = rigid_start(stack)
    return PosePosterior(cells, weight / weight.sum(), half, stack.hub_m, log_evidence=log_evidence, rigid=start)


def _stacked(evidence: PartEvidence, seen: Sequence[SeenTag]) -> MapStack:
    """Maps of all tags, the one that is known best first."""
    maps, firsts, pitches = [], [], []
    order = np.argsort([tag.cells_m.shape[0] * tag.side_m**2 for tag in seen], kind="stable")
    for tag in (seen[k] for k in order):
        pitch_m = _pitch_m(tag, evidence.bias_m)
        values, first_m = smeared_map(tag.cells_m, tag.log_likelihood, pitch_m, evidence.bias_m)
        maps.append(values)
        firsts.append(first_m)
        pitches.append(pitch_m)
    return stack_maps(maps, firsts, pitches, evidence.points_m[order, :2])


def _pitch_m(tag: SeenTag, bias_m: float) -> float:
    """Double the side of the tag's squares as far as the bias is still resolved, or the map becomes too large."""
    pitch_m = tag.side_m
    extent_m2 = float(np.prod(np.ptp(tag.cells_m, axis=0) + 18.0 * bias_m))
    while 2.0 * pitch_m <= _PITCH_PER_BIAS * bias_m or extent_m2 / pitch_m**2 > _MAX_MAP_POINTS:
        pitch_m *= 2.0
    return pitch_m
