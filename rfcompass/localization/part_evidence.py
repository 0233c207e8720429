"""What all stops say about the place of each part tag, as tables for `tag_kernels`."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.localization.noise_model import NoiseModel
from rfcompass.localization.placed_stop import OdometrySpread, PlacedComparisons, PlacedStop, place_labels
from rfcompass.localization.tag_kernels import COMPARISON_COLUMNS, RANGE_COLUMNS
from rfcompass.types.comparisons import Comparisons
from rfcompass.types.record import Record

_BIAS_CORRELATION = 0.25  # ours: of the biases of two tags of one part
_TAG_GRID_M = 1e-4  # tags of two stops whose places on the part differ by less are one tag


@dataclass(frozen=True, slots=True)
class PartEvidence(Record):
    """One table for each part tag that was heard.

    Attributes:
        ranges: Whether the tables hold distances or comparisons.
        points_m: The tags: x, y in the part frame, z in the base frame [m], shape (K, 3).
        tables: Rows of each tag, see `tag_kernels`, shapes (M_k, RANGE_COLUMNS or COMPARISON_COLUMNS).
        stops: Number of the stop of each row, for each tag, shapes (M_k,).
        bias_m: σ of the bias of a tag's place along one axis [m].
    """

    ranges: bool
    points_m: FloatArray
    tables: tuple[FloatArray, ...]
    stops: tuple[IntArray, ...]
    bias_m: float

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        set_, width = object.__setattr__, RANGE_COLUMNS if self.ranges else COMPARISON_COLUMNS
        set_(self, "points_m", read_only(self.points_m, "PartEvidence.points_m", (len(self.tables), 3)))
        set_(self, "tables", tuple(read_only(t, "PartEvidence.tables", (None, width)) for t in self.tables))
        set_(self, "stops", tuple(read_only(s, "PartEvidence.stops", (None,), np.int64) for s in self.stops))

    @property
    def rows(self) -> int:
        """Number of distances or comparisons, over all tags."""
        return sum(len(table) for table in self.tables)

    @property
    def stops_used(self) -> IntArray:
        """Stops that say anything, ascending, shape (S,)."""
        return np.unique(np.concatenate(self.stops)) if self.stops else np.zeros(0, dtype=np.int64)

    def without_stop(self, stop: int) -> "PartEvidence":
        """Return the same without the rows of one stop."""
        kept = [own != stop for own in self.stops]
        tables = [table[rows] for table, rows in zip(self.tables, kept, strict=True)]
        stops = [own[rows] for own, rows in zip(self.stops, kept, strict=True)]
        return _heard(self.ranges, self.points_m, tables, stops, self.bias_m)

    def noisier(self, factor: float) -> "PartEvidence":
        """Return the same with the noise of distances, α and β, larger by a factor."""
        wider = np.ones(RANGE_COLUMNS)
        wider[4:6] = factor**2
        return replace(self, tables=tuple(table * wider for table in self.tables))

    def with_lapse(self, lapse: float) -> "PartEvidence":
        """Return the same with another lapse rate λ of comparisons."""
        at = np.arange(COMPARISON_COLUMNS) == 8
        return replace(self, tables=tuple(np.where(at, lapse, table) for table in self.tables))

    def lifted(self, lift_m: float) -> "PartEvidence":
        """Return the same with all part tags higher by so much [m]."""
        lower = np.zeros(RANGE_COLUMNS if self.ranges else COMPARISON_COLUMNS)
        lower[[2] if self.ranges else [2, 5]] = lift_m
        tables = tuple(table - lower for table in self.tables)
        return replace(self, tables=tables, points_m=self.points_m + np.array([0.0, 0.0, lift_m]))


def distance_evidence(stops: Sequence[PlacedStop], noise: Mapping[str, NoiseModel]) -> PartEvidence:
    """Collect distances r = m / c of every part tag to every anchor.

    What the tags of a part share is counted as if independent, but larger (ours):

    - An anchor's own error is in the distances of all K tags. It is half of s², which was fitted on pairs of
      anchors, so s² is taken K / 2 times, but no less than once.
    - Tags of one part see much the same reflections: their biases correlate, ρ = 1/4, so that the mean bias has the
      variance σ² (1 + (K - 1) ρ) / K; σ² is taken 1 + (K - 1) ρ times.
    - Odometry displaces all anchors of a stop together. Its variance v is taken n K times for n anchors: the
      information Σ u uᵀ / (n K v) of all of them is then at most 1 / v along any direction, as it should be.

    An anchor that did not move between stops counts once, with the mean of its distances: reflections are the same
    in every scan, so that only the receiver's noise would average out.

    Args:
        stops: Stops, newest last.
        noise: What the numbers of each meter are worth, by its kind.
    """
    tags, of_stop = _tags([stop.part_points_m for stop in stops])
    label = place_labels(np.vstack([stop.anchors_m for stop in stops]))
    split = np.split(label, np.cumsum([len(stop.anchors_m) for stop in stops])[:-1])
    tables, numbers = [], []
    for k in range(len(tags)):
        parts = [_distances(stop, noise[stop.kind], own == k) for stop, own in zip(stops, of_stop, strict=True)]
        rows = np.vstack(parts)
        number = np.repeat(np.arange(len(stops)), [len(part) for part in parts])
        place = np.concatenate([_repeat(own, of == k) for own, of in zip(split, of_stop, strict=True)])
        heard = np.isfinite(rows[:, 3])
        rows, number = _once(rows[heard], number[heard], place[heard])
        rows[:, 2] -= tags[k, 2]
        tables.append(rows)
        numbers.append(number)
    heard_tags = max(1, sum(len(table) > 0 for table in tables))
    for table, number in zip(tables, numbers, strict=True):
        table[:, 4:6] *= max(1.0, heard_tags / 2.0)
        table[:, 6:8] *= (heard_tags * np.bincount(number, minlength=len(stops))[number])[:, None]
    bias_m = max(model.bias_m for model in noise.values())
    return _heard(True, tags, tables, numbers, _shared_bias_m(bias_m, heard_tags))


def comparison_evidence(compared: Sequence[PlacedComparisons], noise: NoiseModel, tempering: float) -> PartEvidence:
    """Collect comparisons of every part tag; a pair of anchors that did not move counts once, as heard last.

    Comparisons of one tag share its anchors' errors, so each enters with the power γ of its likelihood, and with
    γ / (K / 2) if more than two tags share them. Odometry displaces all anchors of a stop together; for M comparisons
    its variance is taken γ M / 4 times, which bounds their information Σ γ / (4 s²) as in `distance_evidence`.

    Args:
        compared: Stops, newest last.
        noise: What a comparison is worth.
        tempering: γ in (0, 1].
    """
    tags, of_stop = _tags([one.part_points_m for one in compared])
    label = place_labels(np.vstack([one.anchors_m for one in compared]))
    split = np.split(label, np.cumsum([len(one.anchors_m) for one in compared])[:-1])
    rows, target, number, keys = [], [], [], []
    for s, (anchors_m, _, chosen, odometry) in enumerate(compared):
        rows.append(_comparisons(anchors_m, chosen, odometry, noise, tempering))
        target.append(of_stop[s][chosen.target])
        number.append(np.full(len(chosen), s))
        i, j = split[s][chosen.nearer], split[s][chosen.farther]
        keys.append((target[-1] * label.size + np.minimum(i, j)) * label.size + np.maximum(i, j))
    newest_first = np.concatenate(keys)[::-1]
    once = newest_first.size - 1 - np.unique(newest_first, return_index=True)[1]
    table, of, stop = np.vstack(rows)[once], np.concatenate(target)[once], np.concatenate(number)[once]
    table[:, 10:12] *= tempering / 4.0 * np.bincount(stop, minlength=len(compared))[stop][:, None]
    table[:, [2, 5]] -= tags[of, 2][:, None]
    heard_tags = max(1, np.unique(of).size)
    table[:, 9] /= max(1.0, heard_tags / 2.0)
    tables = [table[of == k] for k in range(len(tags))]
    return _heard(
        False, tags, tables, [stop[of == k] for k in range(len(tags))], _shared_bias_m(noise.bias_m, heard_tags)
    )


def _shared_bias_m(bias_m: float, tags: int) -> float:
    """Standard deviation of a tag's bias, as if those of the part's tags were independent."""
    return bias_m * float(np.sqrt(1.0 + (tags - 1) * _BIAS_CORRELATION))


def _tags(points_m: Sequence[FloatArray]) -> tuple[FloatArray, list[IntArray]]:
    """All tags of all stops, each once and in the order of their places, and which of them each stop has."""
    every = np.vstack(points_m)
    _, first, which = np.unique(np.round(every / _TAG_GRID_M), axis=0, return_index=True, return_inverse=True)
    return every[first], np.split(which.ravel(), np.cumsum([len(one) for one in points_m])[:-1])


def _distances(stop: PlacedStop, noise: NoiseModel, rows: FloatArray) -> FloatArray:
    """Rows of one tag at one stop, heights not yet taken off."""
    m = stop.m[rows].ravel()
    anchors_m = np.tile(stop.anchors_m, (int(rows.sum()), 1))
    fixed = np.array([noise.alpha_m**2, noise.beta**2, *stop.odometry.row])
    return np.column_stack([anchors_m, m / noise.scale, np.tile(fixed, (m.size, 1))])


def _comparisons(
    anchors_m: FloatArray, chosen: Comparisons, odometry: OdometrySpread, noise: NoiseModel, tempering: float
) -> FloatArray:
    i_m, j_m = anchors_m[chosen.nearer], anchors_m[chosen.farther]
    apart_m = np.linalg.norm(i_m - j_m, axis=1)
    fixed = np.array([noise.comparison_m**2, noise.lapse, tempering, *odometry.row])
    return np.column_stack([i_m, j_m, apart_m, np.tile(fixed, (len(chosen), 1))])


def _repeat(label: IntArray, rows: FloatArray) -> IntArray:
    return np.tile(label, int(rows.sum()))


def _once(rows: FloatArray, number: IntArray, place: IntArray) -> tuple[FloatArray, IntArray]:
    """Merge rows to anchors in one place: mean distance, all else from the newest of them."""
    _, which, count = np.unique(place, return_inverse=True, return_counts=True)
    newest = np.zeros(count.size, dtype=np.int64)
    newest[which] = np.arange(which.size)
    merged = rows[newest]
    merged[:, 3] = np.bincount(which, rows[:, 3], minlength=count.size) / np.maximum(count, 1)
    return merged, number[newest]


def _heard(
    ranges: bool, points_m: FloatArray, tables: Sequence[FloatArray], stops: Sequence[IntArray], bias_m: float
) -> PartEvidence:
    """Leave out tags that nothing was heard of."""
    heard = [k for k, table in enumerate(tables) if len(table)]
    return PartEvidence(
        ranges, points_m[heard], tuple(tables[k] for k in heard), tuple(stops[k] for k in heard), bias_m
    )  # fmt: skip
