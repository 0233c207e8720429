"""Choose where a robot carries its tags: the places with the least expected error, and room between them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray
from rfcompass.errors import InputError, NoRoomForTags
from rfcompass.localization.layout_error import LayoutError, Seen
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class DesignedLayout(Record):
    """The chosen places.

    Attributes:
        chosen: Indices of the candidates, ascending.
        error_m: Mean expected error over all poses [m].
        rounds: Rounds of exchange until nothing improved.
    """

    chosen: tuple[int, ...]
    error_m: float
    rounds: int


def design_layout(
    error: LayoutError,
    count: int,
    *,
    spacing_m: float,
    kept: Sequence[int] = (),
    max_rounds: int = 20,
) -> DesignedLayout:
    """Choose places one by one, then exchange each for a better one until none is.

    That ends in a layout that no exchange of a single tag improves; it need not be the best of all.

    Args:
        error: Candidates, part and poses.
        count: How many tags.
        spacing_m: Least distance between two tags, at every stop [m].
        kept: Candidates that must be among them, such as the tags beside the jaws.
        max_rounds: Rounds of exchange at most.

    Raises:
        InputError: If `count` is below 2, or smaller than what is kept.
        NoRoomForTags: If the candidates leave no room for so many tags.
    """
    if count < 2 or len(kept) > count:
        raise InputError(f"{count} tags, {len(kept)} of them given: at least 2, and no fewer than given", tags=count)
    seen, clash = error.seen(), _clashes(error.anchors_m, spacing_m)
    chosen = list(kept)
    while len(chosen) < count:
        chosen.append(_best_addition(error, seen, chosen, clash))
    value = _mean_m(error, seen, chosen)
    rounds, before = 0, np.inf
    while rounds < max_rounds and value < before - 1e-9:
        rounds, before = rounds + 1, value
        for place in range(len(kept), count):
            others = chosen[:place] + chosen[place + 1 :]
            better = _best_addition(error, seen, others, clash)
            if (tried := _mean_m(error, seen, [*others, better])) < value - 1e-9:
                chosen, value = [*others[:place], better, *others[place:]], tried
    return DesignedLayout(tuple(sorted(chosen)), value, rounds)


def _best_addition(error: LayoutError, seen: Seen, chosen: list[int], clash: BoolArray) -> int:
    free = np.flatnonzero(~clash[chosen].any(axis=0)) if chosen else np.arange(len(clash))
    free = np.setdiff1d(free, chosen)
    if not free.size:
        message = f"no place is left for tag {len(chosen) + 1} that keeps its distance"
        raise NoRoomForTags(message, placed=len(chosen), candidates=len(clash))
    if not chosen:  # one tag alone compares nothing: begin where the tags are nearest to the part
        return int(free[seen.d[:, :, :, free].mean(axis=(0, 1, 2)).argmin()])
    values = [_mean_m(error, seen, [*chosen, int(one)]) for one in free]
    return int(free[int(np.argmin(values))])


def _mean_m(error: LayoutError, seen: Seen, chosen: list[int]) -> float:
    return float(error.errors_m(np.array(chosen), seen).mean())


def _clashes(anchors_m: FloatArray, spacing_m: float) -> BoolArray:
    """Whether two candidates come too near each other at any stop, shape (C, C)."""
    C = anchors_m.shape[1]
    clash = np.zeros((C, C), dtype=bool)
    for stop_m in anchors_m:
        clash |= np.linalg.norm(stop_m[:, None] - stop_m[None], axis=2) < spacing_m - 1e-9
    return clash
