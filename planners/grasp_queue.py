"""Which grasp next? The most likely one, without computing every chance to the end.

A chance over S poses costs S judgements. So all are first computed over a few of the poses, drawn at random, and only
those that may be the best are taken further: a grasp that held n of N times may have a chance of up to

    p̃ + 3 √(p̃ (1 - p̃) / N),    p̃ = (n + 1) / (N + 2),

and the next to try is one that was computed to the end and that no other may exceed. That is wrong once in some hundred
times, and then by little; three standard errors are ours.
"""

import heapq
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from planners.success import GraspChance

# Ours: shares of the poses that chances are computed over, one after the other.
_SHARES = (0.1, 0.4, 1.0)
_ERRORS = 3.0

Weigh = Callable[[int, int], GraspChance]
# Minus the highest chance, not final, minus the score, number, step, chance: sorted, the next to look at comes first.
_Row = tuple[float, bool, float, int, int, GraspChance]


def most_likely_first(scores: Sequence[float], count: int, weigh: Weigh) -> Iterator[tuple[int, GraspChance]]:
    """Yield grasps and their chances, the most likely before the others; equals by their scores.

    Args:
        scores: Preference among equally likely grasps, one for each.
        count: Poses that a chance is computed over in the end.
        weigh: Chance of a grasp, by its number, over that many of the poses.
    """
    steps = sorted({max(1, int(np.ceil(share * count))) for share in _SHARES})
    heap: list[_Row] = []
    for i, score in enumerate(scores):
        _push(heap, i, score, 0, steps, weigh)
    while heap:
        _, _, score, i, step, chance = heapq.heappop(heap)
        if step == len(steps) - 1:
            yield i, chance
        else:
            _push(heap, i, -score, step + 1, steps, weigh)


def _push(heap: list[_Row], i: int, score: float, step: int, steps: Sequence[int], weigh: Weigh) -> None:
    chance = weigh(i, steps[step])
    is_final = step == len(steps) - 1
    most = chance.probability if is_final else highest(chance.probability, steps[step])
    heapq.heappush(heap, (-most, not is_final, -score, i, step, chance))


def highest(probability: float, count: int) -> float:
    """How large a chance may be that was found over a few poses."""
    smoothed = (probability * count + 1) / (count + 2)
    return float(min(1.0, smoothed + _ERRORS * np.sqrt(smoothed * (1 - smoothed) / count)))
