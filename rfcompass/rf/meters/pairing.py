"""What all meters share: who is compared with whom, and what to do about tags that were not heard."""

from collections.abc import Callable, Sequence

import numpy as np

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.errors import DuplicateEpc, ShapeError, TagNeverHeard
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.reads import ReadTrace, Scan

Distances = Callable[[Sequence[ReadTrace]], FloatArray]


def compare_tags(
    kind: str, distances: Distances, scan: Scan, targets: Sequence[str], anchors: Sequence[str] | None
) -> ProximityMatrix:
    """Arrange a meter's distances as targets by anchors and anchors by anchors.

    Args:
        kind: Name of the meter that is used.
        distances: Distance of every pair of traces of one scan, symmetric, shape (T, T).
        scan: Reads of one stop.
        targets: EPCs of the tags on the part (K).
        anchors: EPCs of the tags whose place is known (N); every other tag of the scan if None.

    Returns:
        m with NaN for pairs in which a tag was not heard, and of a tag with itself.

    Raises:
        TagNeverHeard: If none of the tags was heard.
        DuplicateEpc: If an EPC stands twice among the targets or among the anchors.
        ShapeError: If tags were not recorded along the same antenna path and channels.
    """
    if anchors is None:
        anchors = [epc for epc in scan.epcs if epc not in set(targets)]
    _check_unique(targets)
    _check_unique(anchors)
    heard = sorted({*targets, *anchors} & set(scan.epcs))
    if not heard:
        asked = ", ".join([*targets, *anchors]) or "none asked for"
        message = f"none of the tags was heard ({asked}; heard: {', '.join(scan.epcs) or 'none'})"
        raise TagNeverHeard(message, asked=[*targets, *anchors], heard=list(scan.epcs))
    traces = [scan.traces[epc] for epc in heard]
    _check_same_path(traces)

    square = np.full((len(heard) + 1, len(heard) + 1), np.nan)  # the last row and column: not heard
    square[:-1, :-1] = distances(traces)
    np.fill_diagonal(square, np.nan)
    k, i = _places(targets, heard), _places(anchors, heard)
    return ProximityMatrix(tuple(targets), tuple(anchors), square[np.ix_(k, i)], square[np.ix_(i, i)], kind)


def pairwise(count: int, distance: Callable[[int, int], float]) -> FloatArray:
    """Symmetric matrix of `distance(i, j)` for i < j, with 0 on the diagonal, shape (count, count)."""
    square = np.zeros((count, count))
    for i in range(count):
        for j in range(i + 1, count):
            square[i, j] = square[j, i] = distance(i, j)
    return square


def mean_of_known(squares: Sequence[FloatArray]) -> FloatArray:
    """Mean over several distances of the same pairs, leaving out NaN; NaN where all are, shape (T, T)."""
    stack = np.array(squares)
    known = np.isfinite(stack)
    count = known.sum(axis=0)
    return np.where(count > 0, np.where(known, stack, 0.0).sum(axis=0) / np.maximum(count, 1), np.nan)


def _check_unique(epcs: Sequence[str]) -> None:
    for epc in epcs:
        if list(epcs).count(epc) > 1:
            raise DuplicateEpc(f"EPC {epc} was asked for twice", epc=epc)


def _check_same_path(traces: Sequence[ReadTrace]) -> None:
    for other in traces[1:]:
        for name in ("antenna_positions_m", "frequencies_hz", "antenna_ports", "tx_positions_m"):
            if not np.array_equal(getattr(traces[0], name), getattr(other, name)):
                message = f"tags {traces[0].epc} and {other.epc} differ in {name}: only reads of one scan compare"
                raise ShapeError(message, name=name, epcs=[traces[0].epc, other.epc])


def _places(epcs: Sequence[str], heard: Sequence[str]) -> IntArray:
    place = {epc: index for index, epc in enumerate(heard)}
    return np.array([place.get(epc, -1) for epc in epcs], dtype=np.int64)
