"""From proximities to comparisons: which of two anchors is a part tag nearer to? [Wang2013], section 4.3.A."""

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import ShapeError
from rfcompass.types.comparisons import Comparisons


def compare_proximities(m: FloatArray, epsilon: float = 0.0) -> Comparisons:
    """Compare every pair of anchors for every part tag [Wang2013], section 4.3.A.

    Tag k is nearer to anchor i than to anchor j iff m_ki <= (1 - ε) m_kj. Each answer keeps its margin
    1 - m_ki / m_kj, the largest ε at which it still holds, so that ε can be raised later without asking again.

    Args:
        m: Proximity of part tag k to anchor i, NaN where missing, shape (K, N).
        epsilon: Confidence threshold ε in [0, 1).

    Returns:
        At most K N (N - 1) / 2 comparisons, ordered by target, then by pair. Pairs without an answer are
        counted as abstained.

    Raises:
        ShapeError: If `m` is no matrix, is infinite or negative, or ε lies outside [0, 1).

    Deviations:
        The paper does not say what becomes of a pair for which the test fails in both directions. It abstains,
        as does a pair with a missing value. So does a pair of equal values at ε = 0, where the test as printed
        holds in both directions.
    """
    matrix = read_only(m, "m", (None, None), finite=False)
    if np.isinf(matrix).any() or (matrix < 0).any():
        raise ShapeError("m must be finite and >= 0, or NaN where missing", name="m")
    if not 0.0 <= epsilon < 1.0:
        raise ShapeError(f"epsilon = {epsilon} lies outside [0, 1)", epsilon=epsilon)
    first, second = np.triu_indices(matrix.shape[1], 1)
    m_first, m_second = matrix[:, first], matrix[:, second]
    smaller, larger = np.fmin(m_first, m_second), np.fmax(m_first, m_second)
    answered = (m_first != m_second) & ~np.isnan(m_first) & ~np.isnan(m_second)
    margin = np.zeros(answered.shape)
    np.divide(larger - smaller, larger, out=margin, where=answered)
    answered &= margin >= epsilon
    target, pair = np.nonzero(answered)
    first_wins = (m_first < m_second)[answered]
    return Comparisons(
        target=target,
        nearer=np.where(first_wins, first[pair], second[pair]),
        farther=np.where(first_wins, second[pair], first[pair]),
        margin=margin[answered],
        abstained=int(answered.size - target.size),
    )
