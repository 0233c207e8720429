"""Rows that follow from other rows.

Bisector rows add up: the row of (i, j) plus the row of (j, l) is the row of (i, l), exactly. So among the
comparisons of one part tag at one stop, each one that is implied by a chain of others can go without changing the
set of poses. A full order of N anchors keeps N - 1 of its N (N - 1) / 2 rows. This holds for any comparisons
without a cycle, so also for those that some ε > 0 keeps; those with a cycle contradict each other and stay as
they are.
"""

import numpy as np

from rfcompass.arrays import BoolArray, IntArray
from rfcompass.types.comparisons import Comparisons


def implied_by_others(comparisons: Comparisons, epsilon: float = 0.0) -> BoolArray:
    """Tell which of one stop's comparisons follow from others that ε keeps, shape (M,).

    Of a comparison that is given several times, all but the first follow.
    """
    used = comparisons.used_at(epsilon)
    implied = np.zeros(len(comparisons), dtype=np.bool_)
    if not used.any():
        return implied
    k, i, j = comparisons.target, comparisons.nearer, comparisons.farther
    K, N = int(k.max()) + 1, int(max(i.max(), j.max())) + 1
    edge = np.zeros((K, N, N), dtype=np.bool_)
    edge[k[used], i[used], j[used]] = True
    chain = _chains(edge)
    acyclic = np.logical_not(np.diagonal(chain, axis1=1, axis2=2).any(axis=1))
    by_two_steps = (chain.astype(np.float32) @ chain.astype(np.float32)) > 0.0
    implied[used] = (by_two_steps[k, i, j] & acyclic[k])[used]
    return implied | _repeated((k * N + i) * N + j, used)


def _chains(edge: BoolArray) -> BoolArray:
    """Transitive closure of each graph (Warshall, 1962), shape (K, N, N)."""
    chain = edge.copy()
    for via in range(edge.shape[1]):
        chain |= chain[:, :, via, None] & chain[:, None, via, :]
    return chain


def _repeated(keys: IntArray, used: BoolArray) -> BoolArray:
    """All but the first of equal keys, among those that are used."""
    repeated = used.copy()
    _, first = np.unique(keys[used], return_index=True)
    repeated[np.flatnonzero(used)[first]] = False
    return repeated
